// Tests of the one level of a placement, if all rays of a frame share it (lod/level_choice.h), while the shutter is open.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "lod/pose_cage.h"
#include "lod/topology_cache.h"
#include "render/camera_rays.h"
#include "scenegraph/scene.h"
#include "tests/support/motions.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

/// A cage and the places of an eye, both at evenly spaced moments of a shutter.
struct Flight {
    std::string name;
    std::vector<Vec3d> eyes, cages;
};

Vec3d place_at(const std::vector<Vec3d>& keys, double tau)
{
    const double at = tau * static_cast<double>(keys.size() - 1);
    const std::size_t k = std::min(static_cast<std::size_t>(at), keys.size() - 1), next = std::min(k + 1, keys.size() - 1);
    return glm::mix(keys[k], keys[next], at - static_cast<double>(k));
}

class OneLevel {
public:
    OneLevel()
    {
        place(scene_, scene_.add(torus(12, 8, false)), {0, 0, 0});
        scene_.refit();
        scene_.for_each_placement([&](NodeId id, const Node& node, const Mat4d&) {
            if (!node.cages.empty()) node_ = id;
            return true;
        });
    }
    int level(const std::vector<Vec3d>& eyes, const std::vector<Vec3d>& cages, lod::LevelSettings levels = {})
    {
        levels.mode = lod::LevelMode::PerInstance;
        levels.pixel = {0, 0.001f};
        levels.eye = place_at(eyes, 0.5);
        if (eyes.size() > 1) levels.eyes = eyes;
        for (const Vec3d eye : eyes) levels.eye_moves = std::max(levels.eye_moves, glm::distance(eye, levels.eye));
        std::vector<Mat4d> matrices;
        for (const Vec3d cage : cages) matrices.push_back(moved_by(cage));
        const Node& node = scene_.node(node_);
        const CageSlot& slot = scene_.cage(node.cages.front());
        Arena arena;
        lod::DeformCounters counters;
        const int segments = static_cast<int>(cages.size()) - 1;
        return lod::pose_cage({slot, node, node_, nullptr, matrices, segments}, levels,
                              {topologies_.get(slot), nullptr, arena, counters})
            .level;
    }
    int level_at(const Flight& flight, double tau)
    {
        return level({place_at(flight.eyes, tau)}, {place_at(flight.cages, tau)});
    }

private:
    Scene scene_;
    NodeId node_;
    lod::TopologyCache topologies_;
};

TEST(OneLevel, IsTheFinestThatAPlacementNeedsAtAnyMoment)
{
    const std::vector<Flight> flights{
        {"nothing moves", {{0, 0, 9}}, {{0, 0, 0}}},
        {"the eye comes near", {{0, 0, 40}, {0, 0, 3}}, {{0, 0, 0}}},
        {"the eye passes by", {{-50, 0, 3}, {60, 0, 3}}, {{0, 0, 0}}},
        {"the eye comes and goes", {{0, 0, 90}, {0, 0, 40}, {0, 0, 3}, {0, 0, 50}, {0, 0, 100}}, {{0, 0, 0}}},
        {"the eye passes in three steps", {{-50, 0, 3}, {-20, 0, 3}, {30, 0, 3}, {60, 0, 3}}, {{0, 0, 0}}},
        {"the cage comes near", {{0, 0, 40}}, {{0, 0, 0}, {0, 0, 37}}},
        {"the cage passes by", {{0, 0, 4}}, {{-50, 0, 0}, {60, 0, 0}}},
        {"the cage passes by in four steps", {{0, 0, 4}}, {{-50, 0, 0}, {-20, 0, 0}, {20, 0, 0}, {30, 0, 0}, {90, 0, 0}}},
        {"both fly together", {{0, 0, 9}, {200, 0, 9}}, {{0, 0, 0}, {200, 0, 0}}},
        {"the eye overtakes the cage", {{-60, 2, 4}, {90, 2, 4}}, {{0, 0, 0}, {20, 0, 0}, {40, 0, 0}}},
        {"they meet", {{-60, 0, 4}, {0, 0, 4}, {10, 0, 4}, {60, 0, 4}}, {{70, 0, 0}, {-50, 0, 0}}},
    };
    constexpr int kMoments = 480;  // a multiple of all numbers of segments, so that each key is one
    OneLevel one;
    int differing = 0;
    for (const Flight& flight : flights) {
        int finest = lod::kCoarsestLevel;
        for (int i = 0; i <= kMoments; ++i) finest = std::min(finest, one.level_at(flight, i / double(kMoments)));
        EXPECT_EQ(one.level(flight.eyes, flight.cages), finest) << flight.name;
        differing += finest != one.level_at(flight, 0.5);
    }
    EXPECT_GE(differing, 5) << "most flights have another level in the middle";
}

// The cage is close behind the camera, leaves sideways, flies to where the camera looks, and comes into view far away.
TEST(OneLevel, IsThatOfTheTimesAtWhichThePlacementIsInView)
{
    const Camera camera = Camera::look_at({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 0.8f);
    const lod::LevelSettings view = render::CameraRays(camera, 64, 48).levels(1);
    ASSERT_EQ(view.plane_count, 4);
    const Vec3d behind{0, 0, 3}, aside{60, 0, 3}, ahead{60, 0, -57}, in_view{0, 0, -57};
    OneLevel one;
    const int of_the_end = one.level({Vec3d(0)}, {in_view}, view);
    EXPECT_EQ(one.level({Vec3d(0)}, {behind, aside, ahead, in_view, in_view}, view), of_the_end);
    EXPECT_LT(one.level({Vec3d(0)}, {behind, aside}, view), of_the_end) << "nothing is in view, so the nearest time counts";
}

TEST(OneLevel, KnowsWhereTheKeysOfACameraAre)
{
    Camera camera = Camera::look_at({0, 0, 21}, {0, 0, 0}, {0, 1, 0}, 0.6f);
    EXPECT_TRUE(render::CameraRays(camera, 64, 48).levels(1).eyes.empty());
    for (const double z : {40.0, 7.0, 3.0})
        camera.keys.push_back(Camera::look_at({0, 0, z}, {0, 0, 0}, {0, 1, 0}, 0.6f).world_from_camera);
    const lod::LevelSettings levels = render::CameraRays(camera, 64, 48).levels(1);
    EXPECT_EQ(levels.eyes, (std::vector<Vec3d>{{0, 0, 40}, {0, 0, 7}, {0, 0, 3}}));
}

}  // namespace
}  // namespace occam::test
