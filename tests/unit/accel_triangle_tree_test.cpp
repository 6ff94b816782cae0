// Tests of the trees over the triangles of mesh igrids.

#include "accel/triangle_tree.h"

#include <cmath>
#include <random>

#include "accel/frame.h"
#include "accel/tracer.h"
#include "lod/clusters.h"
#include "lod/key_time.h"

#include <gtest/gtest.h>

namespace occam::accel {
namespace {

constexpr std::uint32_t kFirstFace = 100;

struct Triangles {
    std::vector<Vec3f> corners;  // three each, at each key, one key after the other
    int keys = 1;

    std::size_t count() const { return corners.size() / 3 / static_cast<std::size_t>(keys); }
    TriangleTree build(Arena& arena, std::uint32_t first_face, bool may_cut) const
    {
        std::vector<std::uint32_t> faces(count());
        for (std::uint32_t f = 0; f < count(); ++f) faces[f] = first_face + f;
        TriangleTreeBuilder builder;
        builder.splits_in_space = may_cut;
        return builder.build(faces, corners, keys, arena);
    }
};

// Returns the deepest node below a child, and expects its boxes to hold those below them at all keys and, unless triangles
// may be cut, its triangles. Counts each face.
int check(const TriangleTree& tree, std::uint32_t at, int keys, bool may_cut, std::vector<int>& seen,
          std::vector<Box3f>& bounds)
{
    int deepest = 0;
    bounds.assign(static_cast<std::size_t>(keys), {});
    for (int i = 0; i < TriangleNode::kWidth; ++i) {
        const auto box_at = [&](std::size_t key) {
            const TriangleNode& node = tree.nodes[key * tree.node_count + at];
            Box3f box;
            for (int a = 0; a < 3; ++a) {
                box.lo[a] = node.boxes[a * TriangleNode::kWidth + i];
                box.hi[a] = node.boxes[(a + 3) * TriangleNode::kWidth + i];
            }
            return box;
        };
        if (box_at(0).is_empty()) {
            // It is empty between keys, too.
            const Box3f first = box_at(0), last = box_at(static_cast<std::size_t>(keys) - 1);
            for (int a = 0; a < 3; ++a)
                EXPECT_GT(lod::between_keys(0.5f, first.lo[a], last.lo[a]),
                          lod::between_keys(0.5f, first.hi[a], last.hi[a]));
            continue;
        }
        const std::uint32_t child = tree.nodes[at].children[i];
        std::vector<Box3f> below(static_cast<std::size_t>(keys));
        if (TriangleNode::is_block(child)) {
            const std::uint32_t first = TriangleNode::block_of(child) * 8;
            for (std::uint32_t k = first; k < first + 8; ++k) {
                if (std::isnan(tree.corner(k, 0).x)) {
                    EXPECT_GT(k, first) << "a block has a triangle";
                    EXPECT_EQ(tree.faces[k], tree.faces[k - 1]);
                    continue;
                }
                ++seen[tree.faces[k] - kFirstFace];
                for (int key = 0; key < keys && !may_cut; ++key)
                    for (int p = 0; p < 3; ++p) below[std::size_t(key)].add(tree.corner(k, p, key));
            }
        } else {
            deepest = std::max(deepest, 1 + check(tree, child, keys, may_cut, seen, below));
        }
        for (std::size_t key = 0; key < std::size_t(keys); ++key) {
            const Box3f box = box_at(key);
            for (int a = 0; a < 3 && !below[key].is_empty(); ++a) {
                EXPECT_LE(box.lo[a], below[key].lo[a]);
                EXPECT_GE(box.hi[a], below[key].hi[a]);
            }
            bounds[key].add(box);
        }
    }
    return deepest;
}

void expect_sound(const Triangles& triangles, std::size_t most_blocks)
{
    for (const bool may_cut : {false, true}) {
        Arena arena;
        const TriangleTree tree = triangles.build(arena, kFirstFace, may_cut);
        std::vector<int> seen(triangles.count());
        std::vector<Box3f> bounds;
        EXPECT_LT(check(tree, 0, triangles.keys, may_cut, seen, bounds), TriangleTree::kMostDepth);
        for (const int count : seen) {
            EXPECT_GE(count, 1);
            EXPECT_TRUE(may_cut || count == 1);
        }
        for (int key = 0; key < triangles.keys; ++key) {
            EXPECT_EQ(tree.bounds(key).lo, bounds[std::size_t(key)].lo);
            EXPECT_EQ(tree.bounds(key).hi, bounds[std::size_t(key)].hi);
        }
        EXPECT_LE(tree.block_count, may_cut ? 2 * most_blocks : most_blocks);
    }
}

TEST(TriangleTree, HoldsEachTriangleOnceUnlessItIsCut)
{
    std::mt19937 random(1);
    const auto number = [&] { return static_cast<float>(random() % 10001) * 1e-4f; };
    for (const std::size_t count : {1u, 2u, 7u, 8u, 9u, 65u, 2048u})
        for (const int keys : {1, 3}) {
            Triangles some{{}, keys};
            for (std::size_t i = 0; i < count * std::size_t(keys); ++i) {
                const Vec3f at(10 * number(), number(), 5 * number());
                const float size = i % 50 == 0 ? 3.0f : 0.05f;
                some.corners.insert(some.corners.end(), {at, at + Vec3f(size, 0, 0), at + Vec3f(0, size, size * number())});
            }
            expect_sound(some, count / 2 + 8);  // a node may have eight blocks of one triangle
        }
}

TEST(TriangleTree, IsShallowWhereNoPlaneDividesTheTriangles)
{
    constexpr std::size_t kMany = lod::ClusterTree::kMeshFaces;
    Triangles same, growing;
    for (std::size_t i = 0; i < kMany; ++i) {
        same.corners.insert(same.corners.end(), {Vec3f(0, 0, 0), Vec3f(1, 0, 0), Vec3f(0, 1, 0)});
        const float at = std::exp2(float(i) * 0.1f - 100);
        growing.corners.insert(growing.corners.end(), {Vec3f(at, 0, 0), Vec3f(at * 1.01f, 0, 0), Vec3f(at, at, 0)});
    }
    expect_sound(same, kMany / 8);
    expect_sound(growing, kMany);
}

// A mesh may hold a triangle twice, or two that share an edge: rays meet the one with the lower number at equal distance, in
// any batch and either tree.
TEST(TriangleTree, TiesGoToTheLowerFace)
{
    Cage mesh;
    mesh.scheme = Scheme::Triangles;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    for (int i = 0; i < 3000; ++i) mesh.face_vertices.insert(mesh.face_vertices.end(), {0, 1, 2});
    Scene scene;
    NodeDesc desc;
    desc.cages = {scene.add(std::move(mesh))};
    scene.add_node(scene.root(), std::move(desc));
    scene.refit();
    lod::TopologyCache topologies;
    std::vector<Ray> rays(20);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        rays[i].origin = {0.02 + 0.02 * double(i), 0.3, 1};
        rays[i].direction = {0, 0, -1};
    }
    for (const TreeKind kind : {TreeKind::Kd, TreeKind::Bvh}) {
        const Frame frame(scene, topologies, {}, {.tree = kind});
        Tracer tracer(frame, std::size_t(1) << 26);
        std::vector<SurfaceHit> hits(rays.size());
        tracer.closest(rays, hits);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            EXPECT_EQ(hits[i].t, 1.0f);
            EXPECT_EQ(hits[i].face, 0u);
            SurfaceHit one;
            tracer.closest({&rays[i], 1}, {&one, 1});
            EXPECT_EQ(one.face, 0u);
        }
    }
}

}  // namespace
}  // namespace occam::accel
