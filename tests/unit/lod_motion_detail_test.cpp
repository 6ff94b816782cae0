// Tests of the detail of cages that move (lod/cage_motion.h): what motion makes coarser, how displaced ones are filtered,
// and how many keys those need.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <span>
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

constexpr Vec3d kEye{0, 0, 40};

lod::LevelSettings seen_from_afar(int strata)
{
    lod::LevelSettings levels;
    levels.eye = kEye;
    levels.pixel = {0, 0.01f};  // a pixel is 0.4 wide where the cage is
    levels.strata = strata;
    return levels;
}

int level_seen_from_afar(int strata, const lod::CageMotion& motion)
{
    return lod::level_of_motion(seen_from_afar(strata), motion, lod::CageCurvature());
}

// Calls what(motion) for a cage that moves so.
template <class What>
auto of_cage(Scene& scene, const Cage& cage, const Motion& motion, What&& what)
{
    const NodeId id = add_moving(scene, cage, motion);
    scene.refit();
    const Node& node = scene.node(id);
    const std::vector<Mat4d> moving = scene.world_from_node_keys(id);
    const Mat4d placed = scene.world_from_node(id);
    const std::span<const Mat4d> matrices = moving.empty() ? std::span(&placed, 1) : std::span(moving);
    const CageSlot& slot = scene.cage(node.cages.front());
    return what(lod::CageMotion(slot, node, scene.find(node.skin), matrices, scene.shutter_segments()));
}

template <class What>
auto of_torus(const Motion& motion, What&& what)
{
    Scene scene;
    return of_cage(scene, torus(), motion, what);
}

Motion sliding(Vec3d by, bool is_written)
{
    Motion motion{"sliding", 1, {}, {}, {}, {}};
    if (is_written) motion.vertex = [by](Vec3f p, double tau) { return p + Vec3f(by * tau); };
    else motion.matrix = [by](double tau) { return moved_by(by * tau); };
    return motion;
}

// Boxes of nodes are grown by this bound, so that they hold cages below that follow fewer segments.
TEST(MotionTolerance, OfABoxIsNotLargerThanTheBoundOfABoxAroundIt)
{
    Random random(17);
    const auto point = [&] {
        const double x = random(), y = random();
        return Vec3d(x, y, random());
    };
    double least = 1, most = 0;
    for (int i = 0; i < 2000; ++i) {
        lod::LevelSettings levels;
        levels.eye = point() * 4.0 - 1.5;
        levels.pixel = {i % 3 ? 0 : 0.02f, i % 3 ? 0.01f : 0};
        if (i % 3 == 2) levels.motion_edges = 0;  // only rounding is left
        Box3d around, inside;
        for (int corner = 0; corner < 2; ++corner) around.add(point());
        for (int corner = 0; corner < 2; ++corner) inside.add(glm::mix(around.lo, around.hi, point()));
        const double bound = lod::largest_motion_tolerance(levels, around);
        const double share = lod::motion_tolerance(levels, inside) / bound;
        EXPECT_LE(share, 1) << i;
        least = std::min(least, share);
        most = std::max(most, share);
    }
    EXPECT_LT(least, 0.3);
    EXPECT_GT(most, 0.9) << "no loose bound";
}

TEST(MotionTolerance, IsThatOfTheEyeWhereItIsNearestWhileTheShutterIsOpen)
{
    const Box3d box{Vec3d(-1), Vec3d(1)};
    lod::LevelSettings levels = seen_from_afar(0), nearer = levels;
    nearer.eye.z = 5;
    levels.eye_moves = 35;
    EXPECT_DOUBLE_EQ(lod::motion_tolerance(levels, box), lod::motion_tolerance(nearer, box));
    EXPECT_LT(lod::motion_tolerance(levels, box), 0.2 * lod::motion_tolerance(seen_from_afar(0), box));
}

TEST(MotionDetail, FollowsTheDistanceMovedAcrossTheLineOfSight)
{
    Cage square;  // flat, so that long edges cut nothing off
    square.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    square.face_vertices = {0, 1, 2, 3};
    square.face_sizes = {4};
    for (const bool is_written : {false, true}) {
        const auto of_square = [&](auto&& what) {
            Scene scene;
            return of_cage(scene, square, sliding({10, 0, 0}, is_written), what);
        };
        const double across = of_square([](const lod::CageMotion& m) { return m.least_distance_across(kEye); });
        EXPECT_LE(across, 10);
        EXPECT_GT(across, 7);  // the lines of sight differ by up to a sixth
        const int level = of_square([](const lod::CageMotion& m) { return level_seen_from_afar(16, m); });
        const double longest = lod::LevelSettings::kLongestEdge * across / 16;
        EXPECT_LE(lod::edge_length(level), longest);
        EXPECT_GT(lod::edge_length(level + 1), longest);
    }
}

// The tube of the torus is thinner than a pixel, and a chord of a pixel would cut off much of it.
TEST(MotionDetail, OfThinCagesIsThatOfStillOnes)
{
    const double pixel_edge = lod::LevelSettings::kLongestEdge * 0.01 * 40;
    const auto edge = [](const lod::CageMotion& m) { return lod::edge_length(level_seen_from_afar(1, m)); };
    EXPECT_LT(of_torus(sliding({10, 0, 0}, false), edge), 0.5 * pixel_edge);
    Cage large = torus();
    for (Vec3f& p : large.positions) p *= 8.0f;
    Scene scene;
    EXPECT_GE(of_cage(scene, large, sliding({10, 0, 0}, false), edge), 4 * of_torus(sliding({10, 0, 0}, false), edge))
        << "but not that of thick ones";
}

TEST(MotionDetail, FollowsTheCageWhereItsVerticesAreWritten)
{
    Scene scene;
    const CageSlot& slot = scene.cage(scene.add(torus()));
    lod::TopologyCache topologies;
    const auto radius = [&] { return topologies.get(slot).curvature.least_radius(slot.cage); };
    const double before = radius();
    EXPECT_EQ(before, lod::least_radius_of_curvature(slot.cage));
    std::vector<Vec3f> larger = slot.cage.positions;
    for (Vec3f& p : larger) p *= 8.0f;
    scene.write_vertices(slot.id, larger);
    EXPECT_NEAR(radius(), 8 * before, 1e-9 * before);
}

TEST(MotionDetail, IsFullWhereAPointMayStandStillInThePicture)
{
    std::vector<Motion> all;
    all.push_back(sliding({0, 0, 10}, false));  // towards the eye
    for (Motion& motion : motions())
        if (motion.name == "rotating_in_four" || motion.name == "scaling" || motion.name == "morphed" ||
            motion.name == "bending" || motion.name == "inverting" || motion.name == "skinned")
            all.push_back(std::move(motion));
    EXPECT_EQ(all.size(), 7u);
    for (const Motion& motion : all)
        of_torus(motion,
                 [&](const lod::CageMotion& m) { EXPECT_EQ(level_seen_from_afar(1, m), lod::kFinestLevel) << motion.name; });
}

// A displacement that is longer than its cage is wide turns with the normals: some points go back by as much as the cage
// goes on.
TEST(MotionDetail, IsFullWhereADisplacedPointMayStandStill)
{
    Cage small = torus();
    for (Vec3f& p : small.positions) p *= 0.01f;
    add_charts(small);
    DisplacedCage displaced("small", small, 1, 3);
    const auto turned = [](Vec3f p, double tau) {
        const double c = std::cos(tau), s = std::sin(tau);
        return Vec3f(Vec3d(c * p.x - s * p.y + 0.8 * tau, s * p.x + c * p.y, p.z));
    };
    const Motion motion{"turning", 1, {}, turned, {}, {}};
    const auto least = [](const lod::CageMotion& m) { return m.least_distance_across(kEye); };
    EXPECT_GT(of_torus({"turning", 1, {}, [&](Vec3f p, double tau) { return turned(p * 0.01f, tau); }, {}, {}}, least), 0.5);
    EXPECT_LE(of_cage(displaced.scene, displaced.cage, motion, least), 0.1);
}

TEST(MotionDetail, IsNoCoarserThanFourPixelsAndNeedsToKnowTheSamples)
{
    const auto level = [&](int strata) {
        return of_torus(sliding({500, 0, 0}, false), [&](const lod::CageMotion& m) {
            EXPECT_EQ(m.least_distance_across(Vec3d(0, 0, 1)), 0) << "the eye is too near";
            return level_seen_from_afar(strata, m);
        });
    };
    EXPECT_EQ(level(0), lod::kFinestLevel);
    EXPECT_LE(lod::edge_length(level(1)), 4 * lod::LevelSettings::kLongestEdge * 0.01 * 40);
}

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
    DisplacedMotion(DisplacedCage& displaced, const Growth& growth, int segments)
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
    Scene scene_;
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
