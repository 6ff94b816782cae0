// Tests of which recordings of a shutter are refused, and of how many segments a recording needs.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "base/error.h"
#include "scenegraph/content_rules.h"
#include "scenegraph/scene.h"
#include "scenegraph/shutter.h"
#include "tests/support/bent_strip.h"
#include "tests/support/shape_builders.h"

namespace occam {
namespace {

using namespace test;

TEST(Shutter, BadRecordingsAreRefusedAndLeaveNoKeys)
{
    Scene scene;
    const CageId square = scene.add(unit_square());
    const NodeId node = scene.add_node(scene.root(), {.cages = {square}});
    const auto move = [&](double tau) { scene.set_transform(node, moved(tau, 0, 0)); };
    for (const int segments : {-1, 0, 3, 33, 64, 5000, std::numeric_limits<int>::max()})
        EXPECT_THROW(scene.record_shutter(segments, move), Error) << segments;
    EXPECT_THROW(scene.record_shutter(2, nullptr), Error);
    EXPECT_THROW(scene.record_shutter(2,
                                      [&](double tau) {
                                          move(tau);
                                          if (tau == 1) scene.set_transform(node, moved(std::nan(""), 0, 0));
                                      }),
                 Error);
    EXPECT_EQ(scene.shutter_segments(), 0);
    EXPECT_TRUE(scene.node(node).keys.empty());
    // What would change more than poses is refused while the shutter is recorded.
    const std::function<void()> edits[] = {
        [&] { scene.remove(node); },
        [&] { scene.add_node(scene.root(), {}); },
        [&] { scene.remove(square); },
        [&] { scene.replace(square, unit_square()); },
        [&] { scene.copy(node, scene.root()); },
        [&] { scene.clear_shutter(); },
        [&] { scene.record_shutter(2, move); },
    };
    for (const auto& edit : edits) EXPECT_THROW(scene.record_shutter(2, [&](double) { edit(); }), Error);
    scene.record_shutter(2, move);
    EXPECT_EQ(scene.shutter_segments(), 2) << "a refused recording leaves the scene usable";
    {
        const Scene::FrameLock lock(scene);
        EXPECT_THROW(scene.record_shutter(2, move), Error);
        EXPECT_THROW(scene.clear_shutter(), Error);
    }
    Bent bent;
    std::vector<Vec3f> positions = bent.scene.cage(bent.cage).cage.positions;
    EXPECT_THROW(bent.scene.record_shutter(2, [&](double) { bent.scene.write_vertices(bent.cage, positions); }), Error);
}

TEST(Shutter, SegmentsFollowHowFarChordsStray)
{
    Scene scene;
    const CageId square = scene.add(unit_square());
    const NodeId node = scene.add_node(scene.root(), {.cages = {square}});
    const PathTolerance tolerance{{0, 0, 100}, 0.01, 0};
    scene.record_shutter(32, [&](double tau) { scene.set_transform(node, moved(50 * tau, 0, 0)); });
    EXPECT_EQ(needed_segments(scene, tolerance), 1) << "a straight path at constant speed";
    // A corner at radius sqrt(2) that turns by `a` in n segments strays by sqrt(2) (1 - cos(a / 2n)).
    const double angle = 1.5;
    scene.record_shutter(32, [&](double tau) { scene.set_transform(node, turned(angle * tau)); });
    int expected = 1;
    while (std::sqrt(2.0) * (1 - std::cos(angle / (2 * expected))) > 0.01) expected *= 2;
    EXPECT_EQ(expected, 8);
    EXPECT_EQ(needed_segments(scene, tolerance), expected);
    EXPECT_EQ(needed_segments(scene, {{0, 0, 100}, 1e-9, 0}), 32) << "no more than were recorded";
    EXPECT_EQ(needed_segments(scene, {{0, 0, 100}, 0, 1}), 1) << "far from the eye";
    // From the middle of the last half on the eye is where a corner is at that moment, which is a key of four segments.
    const Vec3d corner = transform_point(turned(angle * 0.75), {1, 1, 0});
    EXPECT_EQ(needed_segments(scene, {{0, 0, 100}, 0, 0.3}), 1);
    EXPECT_EQ(needed_segments(scene, {{0, 0, 100}, 0, 0.3, {{0, 0, 200}, {0, 0, 100}, corner}}), 4);
    scene.clear_shutter();
    EXPECT_EQ(needed_segments(scene, tolerance), 0);
}

TEST(Shutter, SegmentsFollowJointsMorphsAndWrittenVerticesToo)
{
    const PathTolerance tolerance{{0, 0, 100}, 0.01, 0};
    Bent bent;
    bent.scene.record_shutter(32,
                              [&](double tau) { bent.scene.set_transform(bent.tip_joint, moved(2, 0, 0) * turned(tau)); });
    const int by_joints = needed_segments(bent.scene, tolerance);
    EXPECT_GE(by_joints, 4);
    EXPECT_LE(by_joints, 8);

    Scene scene;
    Cage cage = unit_square();
    cage.morph_targets = {{"up", std::vector<Vec3f>(4, Vec3f(0, 0, 1)), {}}};
    const NodeId node = scene.add_node(scene.root(), {.cages = {scene.add(cage)}});
    // The chord of tau^2 over a segment of length h strays by h^2 / 4.
    scene.record_shutter(32, [&](double tau) { scene.set_morph_weights(node, {float(tau * tau)}); });
    EXPECT_EQ(needed_segments(scene, tolerance), 8);
    scene.clear_shutter();

    const CageId cloth = scene.add(unit_square());
    scene.add_node(scene.root(), {.cages = {cloth}});
    scene.record_shutter(32, [&](double tau) {
        std::vector<Vec3f> positions = unit_square().positions;
        positions[3].z = float(tau * tau);
        scene.write_vertices(cloth, positions);
    });
    EXPECT_EQ(needed_segments(scene, tolerance), 8);
}

// A roof is flattened along straight lines. Half-way its normals are not half-way between those at both ends.
TEST(Shutter, SegmentsFollowNormalsThatTurn)
{
    const PathTolerance tolerance{{0, 0, 100}, 0.01, 0};
    for (const Scheme scheme : {Scheme::CatmullClark, Scheme::Bilinear, Scheme::Triangles}) {
        Cage roof = unit_square();
        roof.scheme = scheme;
        for (Vec3f& p : roof.positions) p.z = 4 * p.x;
        if (scheme == Scheme::Triangles) {
            roof.face_sizes.clear();
            roof.face_vertices = {0, 1, 2};
        }
        Cage with_target = roof;
        std::vector<Vec3f> down;
        for (const Vec3f p : roof.positions) down.push_back({0, 0, -0.98f * p.z});
        with_target.morph_targets = {{"flat", down, {}}};
        Scene scene;
        const CageId written = scene.add(roof);
        const NodeId morphed = scene.add_node(scene.root(), {.cages = {scene.add(with_target)}});
        scene.add_node(scene.root(), {.cages = {written}});
        const int expected = scheme == Scheme::Triangles
                                 ? 1
                                 : 8;  // in one segment they are off by 0.48, in 4 by 0.07, in 8 by 0.02
        scene.record_shutter(32, [&](double tau) { scene.set_morph_weights(morphed, {float(tau)}); });
        EXPECT_EQ(needed_segments(scene, tolerance), expected);
        scene.clear_shutter();
        scene.record_shutter(32, [&](double tau) {
            std::vector<Vec3f> positions = roof.positions;
            for (Vec3f& p : positions) p.z *= 1 - 0.98f * static_cast<float>(tau);
            scene.write_vertices(written, positions);
        });
        EXPECT_EQ(needed_segments(scene, tolerance), expected);
    }
}

TEST(Shutter, SegmentsFollowVisibility)
{
    const PathTolerance tolerance{{0, 0, 100}, 0.01, 0};
    Scene scene;
    const NodeId group = scene.add_node(scene.root(), {});
    scene.add_node(group, {.cages = {scene.add(unit_square())}});
    const NodeId lamp = scene.add_node(scene.root(), {.light = scene.add(Light{})});
    struct Case {
        double moment;
        int segments;
    };
    for (const Case& c : {Case{0.5, 2}, {0.25, 4}, {0.375, 8}, {0.03125, 32}, {1, 1}})
        for (const bool comes : {false, true}) {
            scene.record_shutter(32, [&](double tau) {
                scene.set_visible(group, (tau >= c.moment) == comes);
                scene.set_visible(lamp, tau >= 0.3);
            });
            scene.refit();
            const bool is_never_seen = c.moment == 1 && comes;
            EXPECT_EQ(needed_segments(scene, tolerance), is_never_seen ? 1 : c.segments)
                << c.moment << (comes ? ": on" : ": off");
        }
}

int segments_of(Scene& scene, const std::function<void(double tau)>& pose)
{
    scene.record_shutter(32, pose);
    scene.refit();
    return needed_segments(scene, {{0, 0, 100}, 0.01, 0});
}

double up_and_back(double tau) { return 1 - std::abs(2 * tau - 1); }

TEST(Shutter, SegmentsFollowMorphsWhereJointsAndNodesCarryThem)
{
    // Neither the rest positions, which are small, nor the scale at the first key tell how far a weight moves the surface.
    for (const bool is_skinned : {false, true}) {
        Scene scene;
        Cage cage = unit_square();
        for (Vec3f& p : cage.positions) p *= 1e-4f;
        cage.morph_targets = {{"aside", std::vector<Vec3f>(4, Vec3f(0.02f, 0, 0)), {}}};
        if (is_skinned) {
            cage.skin.sets = 1;
            cage.skin.joints.assign(4, {0, 0, 0, 0});
            cage.skin.weights.assign(4, Vec4f(1, 0, 0, 0));
        }
        const NodeId carrier = scene.add_node(scene.root(), {});
        const NodeId node = scene.add_node(is_skinned ? scene.root() : carrier, {.cages = {scene.add(cage)}});
        if (is_skinned) scene.set_skin(node, scene.add(Skin{{}, {carrier}, {}}));
        const Mat4d large = Trs{.scale = Vec3d(100)}.matrix();

        scene.set_transform(carrier, large);
        EXPECT_EQ(segments_of(scene, [&](double tau) { scene.set_morph_weights(node, {float(up_and_back(tau))}); }), 2);
        scene.set_morph_weights(node, {1});
        EXPECT_GE(segments_of(scene, [&](double tau) { scene.set_transform(carrier, turned(6 * tau) * large); }), 16);
        EXPECT_GE(segments_of(scene,
                              [&](double tau) {
                                  scene.set_morph_weights(node, {float(up_and_back(tau))});
                                  scene.set_transform(carrier, Trs{.scale = Vec3d(100 * tau)}.matrix());
                              }),
                  8);
        // The product of a scale and a weight is a parabola, even though both go straight.
        EXPECT_GE(segments_of(scene,
                              [&](double tau) {
                                  scene.set_morph_weights(node, {float(tau)});
                                  scene.set_transform(carrier, Trs{.scale = Vec3d(100 * tau)}.matrix());
                              }),
                  4);
    }
}

TEST(Shutter, SegmentsFollowThePlacementThatMovesAmongMany)
{
    Scene scene;
    const NodeId library = scene.add_node(scene.root(), {.visible = false});
    scene.add_node(library, {.place = {.translation = {1, 0, 0}}, .cages = {scene.add(unit_square())}});
    const NodeId first = scene.add_node(scene.root(), {.instance_of = library});
    for (int i = 0; i < 2 * kMostPlacements; ++i)
        scene.add_node(scene.root(), {.place = {.translation = {9.0 + i, 0, 0}}, .instance_of = library});
    const NodeId last = scene.add_node(scene.root(), {.instance_of = library});
    for (const NodeId turns : {first, last})
        EXPECT_GE(segments_of(scene, [&](double tau) { scene.set_transform(turns, turned(6 * tau)); }), 16);
    // All of them move straight but one, whichever comes first.
    const std::vector<NodeId> children = scene.node(scene.root()).children;
    for (const NodeId turns : {first, last})
        EXPECT_GE(segments_of(scene,
                              [&](double tau) {
                                  for (const NodeId child : children)
                                      if (child != library) scene.set_transform(child, moved(tau, 0, 0));
                                  scene.set_transform(turns, turned(6 * tau));
                              }),
                  16);
}

// A node with many children has a tree over them, in which what moves is looked for by what the children hold.
TEST(Shutter, MotionIsFoundAmongVeryManyChildren)
{
    constexpr int kMany = 600;
    Scene scene;
    Cage triangle;
    triangle.scheme = Scheme::Triangles;
    triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    triangle.face_vertices = {0, 1, 2};
    const CageId shape = scene.add(triangle);
    Material glow;
    glow.emission = Vec3f(1);
    const MaterialId light = scene.add(glow);
    const NodeId group = scene.add_node(scene.root(), {});
    std::vector<NodeId> dark, lamps, shown;
    for (int i = 0; i < kMany; ++i) {
        const Trs place{.translation = {i, 0, 0}};
        dark.push_back(scene.add_node(group, {.place = place, .cages = {shape}}));
        lamps.push_back(scene.add_node(group, {.place = place, .cages = {shape}, .materials = {light}}));
        shown.push_back(scene.add_node(scene.root(), {.place = place, .instance_of = lamps[std::size_t(i / 2)]}));
    }
    EXPECT_GE(segments_of(scene, [&](double tau) { scene.set_transform(dark[400], moved(400, 0, 0) * turned(6 * tau)); }),
              16);
    EXPECT_TRUE(moving_nodes(scene, Contents::Emitters).empty());
    EXPECT_GE(segments_of(scene, [&](double tau) { scene.set_transform(group, turned(6 * tau)); }), 16);
    EXPECT_EQ(moving_nodes(scene, Contents::Emitters).size(), std::size_t(kMany + 1)) << "the lamps and their group";
    // A lamp moves that is shown elsewhere, and something that shows another lamp.
    const auto move_two = [&](double tau) {
        scene.set_transform(lamps[250], moved(tau, 0, 0));
        scene.set_transform(shown[30], moved(tau, 0, 0));
    };
    EXPECT_EQ(segments_of(scene, move_two), 1);
    const std::unordered_set<NodeId> expected{lamps[250], shown[30], lamps[15]};
    EXPECT_EQ(moving_nodes(scene, Contents::Emitters), expected);
    scene.set_transform(dark[0], moved(0, 1, 0));
    EXPECT_EQ(moving_nodes(scene, Contents::Emitters), expected) << "before the scene is refitted";
}

// The scene is left as it is at mid-shutter, which is no key if there is but one segment.
TEST(Shutter, WhatIsOtherwiseAtMidShutterAloneIsAsItsKeysAre)
{
    Scene scene;
    const CageId square = scene.add(unit_square()), written = scene.add(unit_square());
    const NodeId hidden = scene.add_node(scene.root(), {.cages = {square}});
    const NodeId away = scene.add_node(scene.root(), {.cages = {square}});
    const NodeId lifted = scene.add_node(scene.root(), {.cages = {written}});
    const std::vector<Vec3f> positions = scene.cage(written).cage.positions;
    const auto is_middle = [](double tau) { return tau == 0.5; };
    scene.record_shutter(1, [&](double tau) {
        scene.set_visible(hidden, !is_middle(tau));
        scene.set_transform(away, moved(is_middle(tau) ? 100 : 0, 0, 0));
        std::vector<Vec3f> lifts = positions;
        for (Vec3f& p : lifts) p.y += is_middle(tau) ? 50.0f : 0.0f;
        scene.write_vertices(written, lifts);
    });
    EXPECT_EQ(scene.shutter_segments(), 1);
    EXPECT_TRUE(scene.node(hidden).is_visible_in_shutter());
    EXPECT_EQ(scene.world_from_node_keys(away), (std::vector<Mat4d>{moved(0, 0, 0), moved(0, 0, 0)}));
    EXPECT_EQ(scene.cage(written).key_positions, (std::vector<std::vector<Vec3f>>{positions, positions}));
    const Box3d box = scene.bounds();
    EXPECT_LT(box.hi.x, 2);
    EXPECT_LT(box.hi.y, 2);
    EXPECT_FALSE(box.is_empty());
    EXPECT_TRUE(scene.node(lifted).keys.empty());
}

// The keys of the skin are the poses that its joints have at theirs.
TEST(Shutter, AJointThatIsOtherwiseAtMidShutterAlonePosesItsSkinAsItsKeysAre)
{
    Scene scene;
    Cage cage = unit_square();
    cage.skin.sets = 1;
    cage.skin.joints.assign(cage.positions.size(), {0, 0, 0, 0});
    cage.skin.weights.assign(cage.positions.size(), Vec4f(1, 0, 0, 0));
    const NodeId joint = scene.add_node(scene.add_node(scene.root(), {}), {});
    const SkinId skin = scene.add(Skin{.joints = {joint}});
    scene.add_node(scene.root(), {.cages = {scene.add(std::move(cage))}, .skin = skin});
    scene.record_shutter(1, [&](double tau) { scene.set_transform(joint, moved(tau == 0.5 ? 100 : 0, 0, 0)); });
    EXPECT_LT(scene.bounds().hi.x, 2);
    EXPECT_EQ(scene.find(skin)->key_poses.size(), 2u);
}

TEST(Shutter, MomentsAreChecked)
{
    const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
    EXPECT_NO_THROW(check(Shutter{-0.25, 0.25}));
    EXPECT_NO_THROW(check(Shutter{0.5, 0.5}));
    for (const Shutter bad : {Shutter{0.25, -0.25}, {nan, 1}, {0, nan}, {-infinity, 0}, {0, infinity}, {0, 2e6}})
        EXPECT_THROW(check(bad), Error) << bad.open << ", " << bad.close;
}

}  // namespace
}  // namespace occam
