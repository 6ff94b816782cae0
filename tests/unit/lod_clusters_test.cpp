// Tests of trees over triangle meshes: walls beside small props, and meshes that no plane divides.

#include <cmath>
#include <limits>
#include <random>

#include "accel/frame.h"
#include "accel/tracer.h"
#include "lod/clusters.h"
#include "lod/face_split.h"

#include <gtest/gtest.h>

namespace occam {
namespace {

void add_quad(Cage& mesh, Vec3f a, Vec3f b, Vec3f c, Vec3f d)
{
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), {a, b, c, d});
    for (const std::uint32_t corner : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.face_vertices.push_back(first + corner);
}

// Returns two large walls behind many small upright quads at random places.
Cage walls_and_props(std::uint32_t props)
{
    Cage mesh;
    mesh.scheme = Scheme::Triangles;
    std::mt19937 random(3);
    const auto number = [&] { return static_cast<float>(random() % 10000) * 1e-4f; };
    add_quad(mesh, {0, 0, 0}, {10, 0, 0}, {10, 10, 0}, {0, 10, 0});
    for (std::uint32_t i = 0; i < props; ++i) {
        const Vec3f at(9 * number(), 9 * number(), 9 * number());
        add_quad(mesh, at, at + Vec3f(0.2f, 0, 0.05f), at + Vec3f(0.2f, 0.2f, 0), at + Vec3f(0, 0.2f, 0));
    }
    add_quad(mesh, {0, 0, 0}, {0, 10, 0}, {0, 10, 10}, {0, 0, 10});
    return mesh;
}

void expect_each_face_once(const Cage& mesh, const lod::ClusterTree& tree)
{
    std::vector<int> seen(mesh.face_count());
    for (std::uint32_t n = 0; n < tree.node_count(); ++n) {
        const lod::ClusterTree::Node& node = tree.node(n);
        EXPECT_LT(node.begin, node.end);
        if (node.left != 0) continue;
        EXPECT_LE(node.end - node.begin, lod::ClusterTree::kMeshFaces);
        for (const std::uint32_t face : tree.faces(node)) ++seen[face];
    }
    for (const int count : seen) EXPECT_EQ(count, 1);
}

TEST(MeshClusters, WallsShareNoLeafWithSmallProps)
{
    const Cage mesh = walls_and_props(2000);
    const lod::ClusterTree tree(mesh);
    expect_each_face_once(mesh, tree);
    const auto is_wall = [&](std::uint32_t face) { return face < 2 || face >= mesh.face_count() - 2; };
    for (std::uint32_t n = 0; n < tree.node_count(); ++n) {
        if (tree.node(n).left != 0) continue;
        std::size_t walls = 0;
        for (const std::uint32_t face : tree.faces(tree.node(n))) walls += is_wall(face);
        EXPECT_TRUE(walls == 0 || walls == tree.faces(tree.node(n)).size());
    }
}

TEST(MeshClusters, FacesInOnePlaceAndFacesWithoutNumbersAreHalved)
{
    Cage same;
    same.scheme = Scheme::Triangles;
    for (int i = 0; i < 2000; ++i) add_quad(same, {1, 1, 1}, {2, 1, 1}, {2, 2, 1}, {1, 2, 1});
    expect_each_face_once(same, lod::ClusterTree(same));

    for (const float odd : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 3e38f}) {
        std::vector<lod::BoxedFace> faces(100);
        for (std::uint32_t f = 0; f < faces.size(); ++f)
            faces[f] = {{Vec3f(f % 3 == 0 ? odd : float(f)), Vec3f(f % 3 == 0 ? odd : float(f + 1))}, f};
        const lod::FaceSplit split = lod::split_faces(faces, 60);
        EXPECT_GE(split.count, 40u);
        EXPECT_LE(split.count, 60u);
    }
}

TEST(MeshClusters, EachStepGrowingTenfoldStillGivesAShallowTree)
{
    // In this mesh, each split can separate only the few farthest faces.
    Cage mesh;
    mesh.scheme = Scheme::Triangles;
    for (int i = 0; i < 4000; ++i) {
        const float at = std::exp2(float(i) * 0.05f - 100);
        add_quad(mesh, {at, 0, 0}, {at * 1.01f, 0, 0}, {at * 1.01f, at, 0}, {at, at, 0});
    }
    const lod::ClusterTree tree(mesh);
    expect_each_face_once(mesh, tree);
    std::vector<int> depth(tree.node_count());
    for (std::uint32_t n = 0; n < tree.node_count(); ++n)
        for (std::uint32_t child = tree.node(n).left; child != 0 && child < tree.node(n).left + 2; ++child)
            depth[child] = depth[n] + 1;
    for (const int d : depth) EXPECT_LE(d, 60);
}

TEST(MeshClusters, RaysAloneAndInPacketsMeetTheSameTriangles)
{
    Scene scene;
    NodeDesc desc;
    desc.cages = {scene.add(walls_and_props(1500))};
    scene.add_node(scene.root(), std::move(desc));
    scene.refit();
    lod::TopologyCache topologies;
    const accel::Frame frame(scene, topologies, {});
    std::mt19937 random(5);
    const auto number = [&] { return static_cast<float>(random() % 20001) * 1e-4f - 1; };
    std::vector<accel::Ray> rays(600);
    for (accel::Ray& ray : rays) {
        ray.origin = Vec3d(5 + 4 * number(), 5 + 4 * number(), 5 + 4 * number());
        ray.direction = glm::normalize(Vec3f(number() - 1, number(), number()));
    }
    accel::Tracer together(frame, std::size_t(1) << 26), alone(frame, std::size_t(1) << 26);
    std::vector<accel::SurfaceHit> hits(rays.size()), one(1);
    together.closest(rays, hits);
    const Cage& mesh = scene.cage(scene.node(scene.node(scene.root()).children[0]).cages[0]).cage;
    std::size_t met = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        alone.closest({&rays[i], 1}, one);
        ASSERT_EQ(hits[i].is_hit(), one[0].is_hit());
        // Tests every triangle in double, by the method of Moeller and Trumbore.
        double nearest = std::numeric_limits<double>::infinity();
        for (std::size_t f = 0; f < mesh.face_count(); ++f) {
            const auto at = [&](std::size_t c) { return Vec3d(mesh.positions[mesh.face_vertices[3 * f + c]]); };
            const Vec3d d(rays[i].direction), e = at(1) - at(0), g = at(2) - at(0), p = glm::cross(d, g);
            const double det = glm::dot(e, p);
            const Vec3d s = rays[i].origin - at(0), q = glm::cross(s, e);
            const double u = glm::dot(s, p) / det, v = glm::dot(d, q) / det, t = glm::dot(g, q) / det;
            if (u >= 0 && v >= 0 && u + v <= 1 && t > 0) nearest = std::min(nearest, t);
        }
        ASSERT_EQ(hits[i].is_hit(), std::isfinite(nearest));
        if (!hits[i].is_hit()) continue;
        ++met;
        EXPECT_EQ(hits[i].t, one[0].t);
        EXPECT_EQ(hits[i].face, one[0].face);
        EXPECT_NEAR(double(hits[i].t), nearest, 1e-4);
    }
    EXPECT_GT(met, 300u);
}

}  // namespace
}  // namespace occam
