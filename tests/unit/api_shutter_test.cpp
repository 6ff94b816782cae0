// The functions that record a shutter, and what the callbacks that they call may do.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include <cmath>

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

}  // namespace
}  // namespace occam::test
