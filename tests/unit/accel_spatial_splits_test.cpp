// Tests that triangles of meshes may be cut into parts with boxes of their own: no ray sees any of it.
#include <gtest/gtest.h>

#include <sstream>

#include "accel/spatial_split.h"
#include "accel/triangle_part.h"
#include "accel/triangle_tree.h"
#include "lod/hit_filter.h"
#include "lod/key_time.h"
#include "tests/support/textured_floor.h"
#include "tests/support/tracer_stage.h"

namespace occam::test {
namespace {

using accel::TriangleNode;
using accel::TriangleTree;

// Long slanted triangles, slivers of all widths, large ones and small ones, three corners each.
std::vector<Vec3f> soup(std::uint32_t count, std::uint64_t seed)
{
    std::mt19937_64 random(seed);
    const auto number = [&] { return static_cast<float>(random() >> 40) * 0x1p-23f - 1; };
    // The numbers are drawn one after the other, since compilers evaluate arguments in different orders.
    const auto anywhere = [&] {
        const float x = number(), y = number(), z = number();
        return Vec3f(x, y, z);
    };
    std::vector<Vec3f> corners;
    for (std::uint32_t i = 0; i < count; ++i) {
        const Vec3f at = anywhere(), along = anywhere();
        const float wide = i % 16 == 0 ? 1.0f : std::exp2(-4 - 4 * std::abs(number()) - float(i % 3) * 3);
        const float high = i % 4 == 3 ? 0.03f : 1.0f;
        corners.insert(corners.end(), {at, at + high * along, at + high * (0.9f * along + wide * anywhere())});
    }
    return corners;
}

// Where the corners are at a moment: turned, sheared and, each triangle its own way, bent.
std::vector<Vec3f> moved(std::span<const Vec3f> corners, float tau)
{
    std::vector<Vec3f> to(corners.begin(), corners.end());
    const float c = std::cos(0.9f * tau), s = std::sin(0.9f * tau);
    for (std::size_t i = 0; i < to.size(); ++i) {
        const Vec3f p = to[i];
        to[i] = Vec3f(c * p.x - s * p.y, s * p.x + c * p.y, p.z + 0.3f * tau * p.x) +
                0.1f * tau * Vec3f(std::sin(float(i)), std::cos(float(i)), std::sin(2 * float(i)));
    }
    return to;
}

TriangleTree tree_of(std::span<const Vec3f> corners, int keys, bool splits, Arena& arena)
{
    std::vector<Vec3f> at_keys;
    for (int key = 0; key < keys; ++key) {
        const std::vector<Vec3f> here = moved(corners, keys == 1 ? 0 : float(key) / float(keys - 1));
        at_keys.insert(at_keys.end(), here.begin(), here.end());
    }
    std::vector<std::uint32_t> faces(corners.size() / 3);
    for (std::uint32_t f = 0; f < faces.size(); ++f) faces[f] = f;
    accel::TriangleTreeBuilder builder;
    builder.splits_in_space = splits;
    return builder.build(faces, at_keys, keys, arena);
}

struct Place {
    const TriangleTree& tree;
    int keys;
    lod::KeyTime time;
    float between(float a, float b) const { return keys == 1 ? a : lod::between_keys(time.share, a, b); }
    const TriangleNode& node(std::uint32_t n, int key) const
    {
        return tree.nodes[std::size_t(std::min(key, keys - 1)) * tree.node_count + n];
    }
    // Returns whether the point is in the boxes over a block that has the face.
    bool is_found(std::uint32_t face, Vec3f p, std::uint32_t n = 0) const
    {
        const TriangleNode &from = node(n, time.key), &to = node(n, time.key + 1);
        for (int i = 0; i < TriangleNode::kWidth; ++i) {
            bool is_in = true;
            for (int a = 0; a < 3; ++a) {
                const int lo = a * TriangleNode::kWidth + i, hi = (a + 3) * TriangleNode::kWidth + i;
                is_in = is_in && between(from.boxes[lo], to.boxes[lo]) <= p[a] &&
                        p[a] <= between(from.boxes[hi], to.boxes[hi]);
            }
            if (!is_in) continue;
            const std::uint32_t child = from.children[i];
            if (!TriangleNode::is_block(child)) {
                if (is_found(face, p, child)) return true;
                continue;
            }
            const std::uint32_t first = TriangleNode::block_of(child) * 8;
            for (std::uint32_t k = first; k < first + 8; ++k)
                if (!tree.is_spare(k) && tree.faces[k] == face) return true;
        }
        return false;
    }
};

std::size_t references(const TriangleTree& tree)
{
    std::size_t n = 0;
    for (std::uint32_t k = 0; k < tree.block_count * 8; ++k) n += !tree.is_spare(k);
    return n;
}

TEST(SpatialSplits, ReferToEachTriangleSomewhatMoreThanOnce)
{
    for (const std::uint32_t count : {1u, 2u, 9u, 300u, 2048u})
        for (const int keys : {1, 2, 5}) {
            Arena arena;
            const std::vector<Vec3f> corners = soup(count, count);
            const TriangleTree whole = tree_of(corners, keys, false, arena), cut = tree_of(corners, keys, true, arena);
            EXPECT_EQ(references(whole), count);
            EXPECT_LE(references(cut), count * TriangleTree::kMostQuarters / 4);
            if (count >= 300) {
                EXPECT_GT(references(cut), count * 11 / 10) << "many of them are long";
            }
            for (std::uint32_t b = 0; b < cut.block_count; ++b)
                for (std::uint32_t i = 0; i < 8; ++i)
                    for (std::uint32_t j = 0; j < i && !cut.is_spare(b * 8 + i); ++j)
                        EXPECT_NE(cut.faces[b * 8 + i], cut.faces[b * 8 + j]) << "a block has a triangle once";
        }
}

TEST(SpatialSplits, LeaveNoPointOfATriangleOutsideOfItsBoxesAtAnyTime)
{
    const std::vector<Vec3f> corners = soup(1500, 5);
    std::mt19937 random(9);
    const auto number = [&] { return double(random()) * 0x1p-32; };
    for (const int keys : {1, 2, 5}) {
        Arena arena;
        const TriangleTree tree = tree_of(corners, keys, true, arena);
        std::vector<std::uint32_t> place_of(corners.size() / 3);
        for (std::uint32_t k = 0; k < tree.block_count * 8; ++k)
            if (!tree.is_spare(k)) place_of[tree.faces[k]] = k;
        for (int i = 0; i < 100'000; ++i) {
            const auto face = static_cast<std::uint32_t>(i) % static_cast<std::uint32_t>(place_of.size());
            const Place at{tree, keys, keys == 1 ? lod::KeyTime{0, 0} : lod::key_time(float(number()), keys - 1)};
            double share[3] = {number(), number(), number()};
            if (i % 3 == 0) share[i % 9 / 3] = 0;  // on an edge
            const double sum = share[0] + share[1] + share[2];
            Vec3d p(0);
            for (int c = 0; c < 3; ++c)
                for (int a = 0; a < 3; ++a) {
                    const auto corner = [&](int key) { return tree.corner(place_of[face], c, std::min(key, keys - 1))[a]; };
                    p[a] += share[c] / sum * double(at.between(corner(at.time.key), corner(at.time.key + 1)));
                }
            ASSERT_TRUE(at.is_found(face, Vec3f(p))) << "face " << face << ", keys " << keys << ", point " << i;
        }
    }
}

TEST(SpatialSplits, CutATriangleIntoPartsThatMoveWithIt)
{
    const Vec3f corners[3] = {{0, 0, 0}, {4, 0, 0}, {0, 4, 2}}, later[3] = {{0, 0, 10}, {0, 8, 10}, {8, 0, 10}};
    accel::TrianglePart part(corners);
    part.cut_above(0, 1);
    part.cut_below(1, 2);
    const Box3f box = part.box();  // of (0, 2), (1, 2), (1, 3) and (0, 4)
    for (int a = 0; a < 3; ++a) {
        EXPECT_NEAR(box.lo[a], Vec3f(0, 2, 1)[a], 1e-6f);
        EXPECT_NEAR(box.hi[a], Vec3f(1, 4, 2)[a], 1e-6f);
        EXPECT_LE(box.lo[a], Vec3f(0, 2, 1)[a]);
        EXPECT_GE(box.hi[a], Vec3f(1, 4, 2)[a]);
    }
    const Box3f then = part.box_at(later);
    for (int a = 0; a < 3; ++a) {
        EXPECT_NEAR(then.lo[a], Vec3f(4, 0, 10)[a], 1e-5f);
        EXPECT_NEAR(then.hi[a], Vec3f(8, 2, 10)[a], 1e-5f);
    }
    part.cut_above(2, 0.5);
    EXPECT_TRUE(part.is_empty());
}

TEST(SpatialSplits, AreMadeOnlyWhereTheyPay)
{
    // Small triangles side by side, none of which overlaps many others.
    std::vector<Vec3f> even;
    for (int i = 0; i < 40; ++i)
        for (int j = 0; j < 40; ++j) {
            const Vec3f at(float(i), float(j), 0.1f * float((i * 7 + j * 3) % 5));
            even.insert(even.end(), {at, at + Vec3f(1, 0, 0), at + Vec3f(0, 1, 0)});
        }
    Arena arena;
    EXPECT_EQ(references(tree_of(even, 1, true, arena)), even.size() / 3);
}

class Stripes final : public lod::HitFilter {
public:
    bool is_hole(const Material&, const lod::VertexToShade& at, Vec4f) const noexcept override
    {
        return static_cast<int>(std::floor(at.uv[0].x * 9)) % 2 != 0;
    }
};

struct Soup {
    Stage stage;
    Stripes stripes;
    Soup(bool has_holes, bool moves)
    {
        const std::vector<Vec3f> corners = soup(5000, 3);
        Cage mesh;
        mesh.scheme = Scheme::Triangles;
        mesh.positions = corners;
        for (std::uint32_t v = 0; v < corners.size(); ++v) mesh.face_vertices.push_back(v);
        Material material;
        if (has_holes) {
            material.alpha_mode = AlphaMode::Mask;
            material.alpha_texture.texture = stage.scene.add(waves(0));
            UvSet uv;
            for (const Vec3f p : corners) uv.values.push_back({p.x, p.y});
            mesh.uv_sets = {uv};
        }
        mesh.materials = {stage.scene.add(std::move(material))};
        const CageId cage = stage.scene.add(std::move(mesh));
        NodeDesc desc;
        desc.cages = {cage};
        stage.scene.add_node(stage.scene.root(), std::move(desc));
        if (moves)
            stage.scene.record_shutter(
                4, [&](double tau) { stage.scene.write_vertices(cage, moved(corners, static_cast<float>(tau))); });
        stage.scene.refit();
    }
    accel::Frame frame(accel::TreeKind tree)
    {
        return accel::Frame(stage.scene, stage.topologies, {.eye = Vec3d(0), .pixel = {0.01f, 0}},
                            {.shading = {nullptr, 1, &stripes}, .tree = tree});
    }
};

// Rays from one point, and from everywhere in all directions, at all times.
std::vector<accel::Ray> rays_at_soup()
{
    const Box3d box{Vec3d(-1), Vec3d(1)};
    std::vector<accel::Ray> rays = rays_towards({0.2, 0.1, 4}, box, 3000, 1), more = rays_towards({0, 0, 0}, box, 3000, 2);
    std::mt19937 random(3);
    for (accel::Ray& ray : more)
        for (int a = 0; a < 3; ++a) ray.origin[a] = double(random()) * 0x1p-31 - 1;
    rays.insert(rays.end(), more.begin(), more.end());
    for (std::size_t i = 0; i < rays.size(); ++i) rays[i].time = float(i % 101) / 100;
    return rays;
}

struct Answers {
    static constexpr int kMost = 4;
    std::vector<accel::SurfaceHit> hits, nearest;
    std::vector<accel::HitCount> counts;
    std::vector<std::uint8_t> occluded;

    Answers(accel::Tracer& tracer, std::span<const accel::Ray> rays, std::size_t batch)
        : hits(rays.size()), nearest(rays.size() * kMost), counts(rays.size()), occluded(rays.size())
    {
        for (std::size_t at = 0; at < rays.size(); at += batch) {
            const std::size_t n = std::min(batch, rays.size() - at);
            tracer.closest(rays.subspan(at, n), {&hits[at], n});
            tracer.nearest(rays.subspan(at, n), kMost, {&nearest[at * kMost], n * kMost}, {&counts[at], n});
            tracer.occluded(rays.subspan(at, n), {&occluded[at], n});
        }
    }
};

void expect_same(const Answers& a, const Answers& b, const std::string& what)
{
    for (std::size_t i = 0; i < a.hits.size(); ++i) {
        ASSERT_TRUE(same(a.hits[i], b.hits[i])) << what << ", ray " << i << ": " << a.hits[i].t << ", " << b.hits[i].t;
        ASSERT_EQ(a.occluded[i], b.occluded[i]) << what << ", ray " << i;
        ASSERT_EQ(a.counts[i].count, b.counts[i].count) << what << ", ray " << i;
        for (std::size_t k = 0; k < std::size_t(a.counts[i].count); ++k)
            ASSERT_TRUE(same(a.nearest[i * Answers::kMost + k], b.nearest[i * Answers::kMost + k])) << what << ", ray " << i;
    }
}

TEST(SpatialSplits, ChangeNoBitOfAnyHit)
{
    const std::vector<accel::Ray> rays = rays_at_soup();
    for (const bool has_holes : {false, true})
        for (const bool moves : {false, true}) {
            Soup of(has_holes, moves);
            const std::string what = std::string(has_holes ? "holes" : "whole") + (moves ? ", moving" : "");
            const accel::Frame kd = of.frame(accel::TreeKind::Kd), bvh = of.frame(accel::TreeKind::Bvh);
            accel::Tracer without(bvh, kPlenty, {.spatial = false}), in_bvh(bvh, kPlenty), in_kd(kd, kPlenty),
                alone(bvh, kPlenty);
            const Answers expected(without, rays, rays.size());
            EXPECT_GT(std::ranges::count_if(expected.hits, [](const auto& hit) { return hit.is_hit(); }), 3000);
            expect_same(expected, Answers(in_bvh, rays, rays.size()), what);
            expect_same(expected, Answers(in_kd, rays, rays.size()), what + ", kd-tree");
            expect_same(expected, Answers(alone, rays, 1), what + ", alone");
            EXPECT_GT(in_bvh.counters().peak_bytes, without.counters().peak_bytes) << "some triangles are cut";
            EXPECT_EQ(in_bvh.counters().micropolygons, without.counters().micropolygons);
        }
}

// The narration tests all triangles of an igrid by brute force.
TEST(SpatialSplits, HideNoTriangleFromARay)
{
    const std::vector<accel::Ray> rays = rays_at_soup();
    for (const bool moves : {false, true}) {
        Soup of(false, moves);
        const accel::Frame frame = of.frame(accel::TreeKind::Bvh);
        accel::Tracer tracer(frame, kPlenty);
        std::size_t told = 0;
        for (std::size_t i = 0; i < rays.size(); i += 61) {
            accel::SurfaceHit hit;
            std::ostringstream out;
            tracer.observe(rays[i], hit, &out);
            ASSERT_EQ(out.str().find("WAS NOT TESTED"), std::string::npos) << out.str();
            told += out.str().find(": hit at t ") != std::string::npos;
        }
        EXPECT_GT(told, 50u);
    }
}

}  // namespace
}  // namespace occam::test
