// Tests of nodes whose matrices flatten space but for rounding: the sign of their determinant, and their inverse, are noise.
#include <gtest/gtest.h>

#include <glm/ext/matrix_transform.hpp>

#include "accel/frame.h"
#include "accel/tracer.h"
#include "scenegraph/scene.h"
#include "tests/support/motions.h"
#include "tests/support/random_directions.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

Mat4d turned_about(Vec3d axis, double angle) { return glm::rotate(Mat4d(1), angle, axis); }

// Returns a map that takes all of space to the plane across a unit vector.
Mat4d flattened_along(Vec3d d)
{
    Mat4d m(1);
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) m[c][r] -= d[c] * d[r];
    return m;
}

TEST(FlattenedNodes, ThatMoveHaveTheNormalsOfTheirPlane)
{
    Random random(3);
    int hits = 0, is_negative = 0;
    for (int k = 0; k < 60; ++k) {
        const Vec3d d = random.direction();
        const Vec3d axis = random.direction();
        const Mat4d flat = flattened_along(d);
        Motion motion{"turns", 1 + 3 * (k % 2), {}, {}, {}, {}};
        motion.matrix = [&](double tau) { return turned_about(axis, 0.8 * tau) * flat; };
        is_negative += glm::determinant(Mat3d(motion.matrix(1))) < 0;
        Scene scene;
        Cage square = unit_square();
        square.scheme = Scheme::Bilinear;
        for (Vec3f& p : square.positions) p = (p - 0.5f) * 4.0f;
        add_moving(scene, square, motion);
        scene.refit();
        lod::TopologyCache topologies;
        const accel::Frame frame(scene, topologies, {.pixel = {0, 0.01f}});
        accel::Tracer tracer(frame, std::size_t(1) << 28);
        for (int at = 0; at < 9; ++at) {
            accel::Ray ray;
            ray.time = 0.1f + 0.1f * float(at);
            const Vec3d normal = glm::normalize(Vec3d(turned_about(axis, 0.8 * double(ray.time)) * Vec4d(d, 0)));
            ray.origin = normal * 5.0;
            ray.direction = Vec3f(-normal);
            accel::SurfaceHit hit;
            tracer.closest({&ray, 1}, {&hit, 1});
            if (!hit.is_hit()) continue;
            ++hits;
            EXPECT_GT(glm::dot(hit.normal_shading, hit.normal_geometric), 0.99f) << k << ' ' << at;
        }
    }
    EXPECT_GT(hits, 100);
    EXPECT_GT(is_negative, 10) << "rounding gives either sign";
    EXPECT_LT(is_negative, 50);
}

// Scene::skin() says that what such a node wears is not seen.
TEST(FlattenedNodes, ShowNothingOfWhatTheyWear)
{
    Random random(8);
    for (int k = 0; k < 60; ++k) {
        Scene scene;
        NodeDesc above, wearer;
        above.matrix = turned_about(random.direction(), 1 + k) * scaled_by({1, k % 3 == 2 ? 1e-17 : 0, 1});
        wearer.matrix = turned_about(random.direction(), 2 + k);
        const NodeId joint = scene.add_node(scene.root(), {});
        Cage cage = triangle_box();
        cage.skin.sets = 1;
        for (std::size_t v = 0; v < cage.positions.size(); ++v) {
            cage.skin.joints.push_back({0, 0, 0, 0});
            cage.skin.weights.push_back({1, 0, 0, 0});
        }
        wearer.cages = {scene.add(cage)};
        wearer.skin = scene.add(Skin{"", {joint}, {}});
        scene.add_node(scene.add_node(scene.root(), above), wearer);
        scene.refit();
        const Vec3d extent = scene.bounds().extent();
        EXPECT_LT(glm::length(extent), 1e-6) << k;
    }
}

TEST(FlattenedNodes, KeepTheDirectionOfTheirCameras)
{
    for (int axis = 0; axis < 3; ++axis) {
        Scene scene;
        const auto camera_at = [&](double scale) {
            NodeDesc node;
            Vec3d by(1);
            by[axis] = scale;
            node.matrix = turned_about(glm::normalize(Vec3d(1, 2, 3)), 0.9) * scaled_by(by);
            node.camera = scene.add(CameraLens());
            return scene.camera_of(scene.add_node(scene.root(), node))->world_from_camera;
        };
        const Mat4d whole = camera_at(1), thin = camera_at(1e-9), flat = camera_at(0);
        for (int c = 0; c < 3; ++c) {
            EXPECT_LT(glm::distance(Vec3d(flat[c]), Vec3d(whole[c])), 1e-9) << axis << ' ' << c;
            EXPECT_LT(glm::distance(Vec3d(thin[c]), Vec3d(whole[c])), 1e-6) << axis << ' ' << c;
        }
    }
}

}  // namespace
}  // namespace occam::test
