// The functions that record a shutter, and what the callbacks that they call may do.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include <cmath>
#include <optional>
#include <utility>

#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

Camera view_at(double angle, double height)
{
    return Camera::look_at({5 * std::sin(angle), height, 5 * std::cos(angle)}, {0, 0, 0}, {0, 1, 0}, 0.7f);
}

// The application may compute the camera itself. Only what is asked for at each moment has a path.
TEST(Shutter, RecordingFollowsACameraThatTheApplicationComputes)
{
    Scene scene;
    place(scene, scene.add(torus()), {0, 0, 0});
    const NodeId dolly = scene.add_node(scene.root(), {.camera = scene.add(CameraLens{.fov = 0.7f})});
    Camera now;
    const auto fly = [&](double tau) {
        now = view_at(0.4 * tau, 1 + tau);
        scene.set_transform(dolly, now.world_from_camera);
    };
    for (const int segments : {0, 1, 4}) {
        const auto carries = [&] { return scene.camera().value(); };
        const auto computes = [&] { return now; };
        const Camera computed = record_shutter(scene, fly, computes, 100, segments),
                     carried = record_shutter(scene, fly, carries, 100, segments);
        ASSERT_EQ(computed.keys.size(), segments == 0 ? 33u : std::size_t(segments) + 1);
        EXPECT_EQ(computed.world_from_camera, now.world_from_camera);
        ASSERT_EQ(carried.keys.size(), computed.keys.size());
        for (std::size_t k = 0; k < computed.keys.size(); ++k) {
            const double tau = double(k) / double(computed.keys.size() - 1);
            EXPECT_EQ(computed.keys[k], view_at(0.4 * tau, 1 + tau).world_from_camera);
            for (int column = 0; column < 4; ++column)
                EXPECT_LE(glm::distance(computed.keys[k][column], carried.keys[k][column]), 1e-12);
        }
    }
    const auto shaken = [&] {  // a camera of a node that the application moves once more
        Camera camera = scene.camera().value();
        camera.world_from_camera[3] += Vec4d(now.eye().x, 0, 0, 0);
        return camera;
    };
    const Camera camera = record_shutter(scene, fly, shaken, 100, 2);
    ASSERT_EQ(camera.keys.size(), 3u);
    EXPECT_EQ(camera.keys[2][3].x, 2 * view_at(0.4, 2).eye().x);
    const auto with_keys = [&] {
        Camera own = view_at(0, 1);
        own.keys = {own.world_from_camera, view_at(1, 1).world_from_camera};
        return own;
    };
    EXPECT_EQ(record_shutter(scene, fly, with_keys, 100).keys, with_keys().keys);
    const auto stands = [] { return view_at(0, 1); };
    EXPECT_TRUE(record_shutter(scene, fly, stands, 100).keys.empty());
    EXPECT_THROW(record_shutter(scene, nullptr, stands, 100), Error);
}

// The scene's content would be gone while its keys are taken.
TEST(Shutter, ASceneThatIsAssignedToWhileItIsRecordedIsRefused)
{
    for (const double when : {0.0, 0.5, 1.0}) {
        Scene scene, other;
        NodeId node = place(scene, scene.add(torus()), {0, 0, 0});
        const auto assigns = [&](double tau) {
            if (tau < when) scene.set_transform(node, Trs{.translation = {tau, 0, 0}});
            else if (tau == when) scene = Scene();
        };
        EXPECT_THROW(scene.record_shutter(2, assigns), Error) << when;
        EXPECT_EQ(scene.shutter_segments(), 0);
        EXPECT_TRUE(scene.add_node(scene.root(), {})) << "the new scene can be used";

        node = place(scene, scene.add(torus()), {0, 0, 0});
        const auto moves = [&](double tau) {
            if (tau < when) scene.set_transform(node, Trs{.translation = {tau, 0, 0}});
            else if (tau == when) other = std::move(scene);
        };
        EXPECT_THROW(scene.record_shutter(2, moves), Error) << when;
        EXPECT_EQ(other.shutter_segments(), 0);
        EXPECT_NO_THROW(other.remove(node)) << "no recording is left";

        std::optional<Scene> kept;
        kept.emplace();
        node = place(*kept, kept->add(torus()), {0, 0, 0});
        const auto ends = [&](double tau) {
            if (tau < when) kept->set_transform(node, Trs{.translation = {tau, 0, 0}});
            else if (tau == when) kept.reset();
        };
        EXPECT_THROW(kept->record_shutter(2, ends), Error) << when;
    }
}

// A scene that has its content again when `pose` returns is recorded as if it had never lost it.
TEST(Shutter, ASceneMayBeSwappedAwayAndBackWhileItIsRecorded)
{
    Scene scene, other;
    const NodeId node = place(scene, scene.add(torus()), {0, 0, 0});
    scene.record_shutter(2, [&](double tau) {
        scene.set_transform(node, Trs{.translation = {tau, 0, 0}});
        std::swap(scene, other);
        scene.add_node(scene.root(), {});
        std::swap(scene, other);
    });
    EXPECT_EQ(scene.shutter_segments(), 2);
}

}  // namespace
}  // namespace occam::test
