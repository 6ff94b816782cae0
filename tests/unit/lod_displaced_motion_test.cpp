// Tests of displaced cages that move: how their textures are filtered, and how many keys they need.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "lod/cage_motion.h"
#include "lod/pose_cage.h"
#include "scenegraph/shutter.h"
#include "tests/support/diced_mesh.h"
#include "tests/support/displaced_cages.h"
#include "tests/support/motions.h"
#include "tests/support/random_directions.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

struct Growth {
    const char* name;
    Vec3d from, to;
    bool is_written;  ///< vertices are written at keys, in place of a node that scales

    // It is not linear, so that all keys are needed.
    Vec3d at(double tau) const { return glm::mix(from, to, tau * tau); }
};
const Growth kGrowths[] = {
    {"grows", Vec3d(0.05), Vec3d(1), false},
    {"shrinks", Vec3d(1), Vec3d(0.05), false},
    {"grows from a point", Vec3d(0), Vec3d(1), false},
    {"grows by a large factor", Vec3d(1e-4), Vec3d(1), false},
    {"grows through its mirror image", Vec3d(-0.2), Vec3d(1), false},
    {"has vertices that grow", Vec3d(0.05), Vec3d(1), true},
};

// Poses a displaced cage at all keys, and dices it there.
class DisplacedMotion {
public:
    DisplacedMotion(DisplacedCage& displaced, const Growth& growth, int segments) : scene_(displaced.scene)
    {
        const auto scale = [growth](double tau) { return growth.at(tau); };
        Motion motion{growth.name, segments, {}, {}, {}, {}};
        if (growth.is_written) motion.vertex = [=](Vec3f p, double tau) { return Vec3f(Vec3d(p) * scale(tau)); };
        else motion.matrix = [=](double tau) { return scaled_by(scale(tau)); };
        const NodeId id = add_moving(scene_, displaced.cage, motion);
        scene_.refit();
        const Node& node = scene_.node(id);
        const CageSlot& slot = scene_.cage(node.cages.front());
        matrices_ = scene_.world_from_node_keys(id);
        if (matrices_.empty()) matrices_ = {scene_.world_from_node(id)};
        lod::LevelSettings levels;
        levels.motion_edges = 0;
        posed = &lod::pose_cage({slot, node, id, nullptr, matrices_, segments}, levels,
                                {topologies_.get(slot), &displaced.textures, arena_, counters_});
    }
    // Returns by how much displacement moves the vertices of a tile in a pose, in lengths of the object.
    std::vector<Vec3d> offsets(const lod::PosedCage& pose, const lod::TileRef& tile, double scale)
    {
        lod::PosedCage moved = pose;
        moved.keys = nullptr;
        moved.segments = 0;
        lod::PosedCage smooth = moved;
        smooth.displacement.of = nullptr;
        lod::Dicer with, without;
        const lod::LevelGrid a = with.dice(moved, tile, arena_), b = without.dice(smooth, tile, arena_);
        std::vector<Vec3d> all;
        for (int v = 0; v < (tile.columns + 1) * (tile.rows + 1); ++v) all.push_back(Vec3d(a.at(v) - b.at(v)) / scale);
        return all;
    }
    lod::TileRef tile_of(std::uint32_t face, int level)
    {
        const lod::PatchRates rates = lod::Dicer().scale(*posed, {face, 0}).rates(level);
        const auto side = [](int exponent) {
            return static_cast<std::uint16_t>(std::min(1 << exponent, int(lod::TileRef::kMaxSide)));
        };
        return {{face, 0}, rates, 0, 0, side(rates.u), side(rates.v)};
    }

    lod::PosedCage* posed;

private:
    Scene& scene_;
    std::vector<Mat4d> matrices_;
    lod::TopologyCache topologies_;
    lod::DeformCounters counters_;
    Arena arena_;
};

double farthest(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b)
{
    double most = 0;
    for (std::size_t v = 0; v < a.size(); ++v) most = std::max(most, glm::distance(a[v], b[v]));
    return most;
}

// Before, the texture was filtered by the size at each key, or at the middle one, although levels are about the largest.
TEST(DisplacedMotion, ACageThatGrowsIsDisplacedByThePartOfItsSizeThatItHasWhereItIsLargest)
{
    constexpr int kLevel = -5;
    for (const Growth& growth : kGrowths)
        for (const int segments : {1, 4}) {
            DisplacedCage displaced = displaced_case(0);
            DisplacedMotion motion(displaced, growth, segments);
            ASSERT_EQ(motion.posed->segments, segments);
            const bool grows = growth.to.x > growth.from.x;
            const lod::PosedCage& largest = motion.posed->keys[grows ? segments : 0];
            const bool has_still = motion.posed->still_pose != nullptr;
            EXPECT_EQ(has_still, !growth.is_written && std::string(growth.name).find("grows ") == std::string::npos);
            for (std::uint32_t face = 0; face < 12; face += 3) {
                const lod::TileRef tile = motion.tile_of(face, kLevel);
                const std::vector<Vec3d> full = motion.offsets(largest, tile, 1);
                EXPECT_GT(farthest(full, std::vector<Vec3d>(full.size())), 0.1 * double(displaced.cage.displacement->bound));
                for (int key = 0; key <= segments; ++key) {
                    const double size = growth.at(double(key) / segments).x;
                    if (std::abs(size) < 0.01) continue;
                    const std::vector<Vec3d> there = motion.offsets(motion.posed->keys[key], tile,
                                                                    growth.is_written ? 1 : size);
                    EXPECT_LT(farthest(there, full), 0.03 * double(displaced.cage.displacement->bound))
                        << growth.name << " at key " << key;
                }
                if (!has_still) continue;
                EXPECT_LT(farthest(motion.offsets(*motion.posed->still_pose, tile, 1), full),
                          0.03 * double(displaced.cage.displacement->bound))
                    << growth.name;
            }
        }
}

// A sheet of 4 x 4 faces that stands up along straight lines while its weight, or tau, goes from 0 to 1.
Cage sheet(bool is_displaced)
{
    Cage cage;
    UvSet set;
    for (int i = 0; i < 5; ++i)
        for (int k = 0; k < 5; ++k) {
            cage.positions.push_back({0.5f * float(i) - 1, 0, 0.5f * float(k) - 1});
            set.values.push_back({0.25f * float(i), 0.25f * float(k)});
        }
    for (std::uint32_t i = 0; i < 4; ++i)
        for (std::uint32_t k = 0; k < 4; ++k) {
            for (const std::uint32_t v : {i * 5 + k, i * 5 + k + 1, i * 5 + k + 6, i * 5 + k + 5})
                cage.face_vertices.push_back(v);
            cage.face_sizes.push_back(4);
        }
    cage.uv_sets = {set};
    if (!is_displaced) return cage;
    cage.displacement = Displacement{};
    cage.displacement->scale = cage.displacement->bound = 0.8f;
    return cage;
}
Vec3f stood_up(Vec3f p) { return {0, p.x, p.z}; }

// Before, no path but those of control points was looked at, which are straight.
TEST(DisplacedMotion, WhatTurnsWhileItsVerticesGoStraightNeedsKeysForItsNormals)
{
    const PathTolerance tolerance{{0, 0, 100}, 0.01, 0};
    for (const bool is_written : {false, true})
        for (const bool is_displaced : {false, true}) {
            Scene scene;
            Cage cage = sheet(is_displaced);
            const std::vector<Vec3f> rest = cage.positions;
            MorphTarget target;
            for (const Vec3f p : rest) target.positions.push_back(stood_up(p) - p);
            if (!is_written) cage.morph_targets = {target};
            const CageId id = scene.add(cage);
            const NodeId node = scene.add_node(scene.root(), {.cages = {id}});
            scene.record_shutter(32, [&](double tau) {
                std::vector<Vec3f> moved;
                for (const Vec3f p : rest) moved.push_back(glm::mix(p, stood_up(p), float(tau)));
                if (is_written) scene.write_vertices(id, moved);
                else scene.set_morph_weights(node, {float(tau)});
            });
            scene.refit();
            const Mat4d place(1);
            const int measured = lod::CageMotion(scene.cage(id), scene.node(node), nullptr, {&place, 1}, 32).segments(0.01);
            EXPECT_EQ(needed_segments(scene, tolerance) > 4, is_displaced) << is_written;
            EXPECT_EQ(measured > 4, is_displaced) << is_written;
            EXPECT_EQ(measured == 1, !is_displaced) << is_written;
        }
}

}  // namespace
}  // namespace occam::test
