// Tests of what a hit knows of the surface's shape: curvature and the axes of normal maps.
#include <gtest/gtest.h>

#include "accel/frame.h"
#include "accel/tracer.h"
#include "tests/support/shape_builders.h"
#include "tests/support/textured_floor.h"

namespace occam::test {
namespace {

constexpr double kTau = 6.283185307179586;

// Returns a unit ball about y as triangles: u runs around from +x towards -z, and v from the north pole down, as glTF's v
// does.
Cage ball(std::uint32_t around, std::uint32_t down)
{
    Cage cage;
    cage.scheme = Scheme::Triangles;
    cage.uv_sets.resize(1);
    for (std::uint32_t j = 0; j <= down; ++j)
        for (std::uint32_t i = 0; i <= around; ++i) {
            const double u = double(i) / around, v = double(j) / down;
            const double ring = std::sin(v * kTau / 2);
            cage.positions.push_back(
                {float(ring * std::cos(u * kTau)), float(std::cos(v * kTau / 2)), float(-ring * std::sin(u * kTau))});
            cage.normals.push_back(cage.positions.back());
            cage.uv_sets[0].values.push_back({float(u), float(v)});
        }
    for (std::uint32_t j = 0; j < down; ++j)
        for (std::uint32_t i = 0; i < around; ++i) {
            const std::uint32_t a = j * (around + 1) + i, b = a + around + 1;
            if (j > 0) cage.face_vertices.insert(cage.face_vertices.end(), {a, b, a + 1});
            if (j + 1 < down) cage.face_vertices.insert(cage.face_vertices.end(), {a + 1, b, b + 1});
        }
    return cage;
}

accel::SurfaceHit hit_from(Scene& scene, Vec3d origin, Vec3d direction)
{
    lod::TopologyCache topologies;
    scene.refit();
    const accel::Frame frame(scene, topologies, {.eye = Vec3d(0), .pixel = {0.05f, 0}});
    accel::Tracer tracer(frame, std::size_t(1) << 28);
    accel::Ray ray;
    ray.origin = origin;
    ray.direction = Vec3f(glm::normalize(direction));
    accel::SurfaceHit hit;
    tracer.closest({&ray, 1}, {&hit, 1});
    EXPECT_TRUE(hit.is_hit());
    return hit;
}

const Vec3d kAside = glm::normalize(Vec3d(0.7, 0.4, 0.6));

// The mean curvature of a sphere is 1 / radius. Chords of 1/64 of a turn shorten lengths by (pi / 64)^2 / 6.
TEST(Hit, CurvatureOfABallIsOneOverItsRadius)
{
    for (const double radius : {1e-4, 1.0, 1e6}) {
        Scene scene;
        place(scene, scene.add(ball(64, 32)), {0, 0, 0}, radius);
        const double tolerance = 4e-3 / radius;
        EXPECT_NEAR(hit_from(scene, kAside * (3 * radius), -kAside).curvature, 1 / radius, tolerance);
        EXPECT_NEAR(hit_from(scene, {0, 0, 0}, kAside).curvature, -1 / radius, tolerance) << "hollow from inside";
    }
}

// The position is off the ray by the rounding of its distance, and off the surface by a chord's sagitta, since it lies in
// the planes of the surface's triangles.
TEST(Hit, PositionsLieOnTheRayAndOnTheSurface)
{
    const Vec3d centre{3e5, -2e5, 1e5};
    Scene scene;
    place(scene, scene.add(torus(48, 32, false)), centre);
    for (const double away : {5.0, 5e3}) {
        const Vec3d origin = centre + Vec3d(away, 0.2, 0.1), towards{-1, 0.01 / away, -0.02 / away};
        const accel::SurfaceHit hit = hit_from(scene, origin, towards);
        const Vec3d on_ray = origin + Vec3d(Vec3f(glm::normalize(towards))) * double(hit.t);
        EXPECT_LT(glm::distance(hit.position, on_ray), 4e-7 * away);
        // The radii are 1 and 0.4 about y, except for what a cubic spline through 48 and 32 points draws in, and for the
        // sagitta of a chord of the requested length.
        const Vec3d p = hit.position - centre;
        const auto drawn_in = [](double radius, int points) { return radius * (1 - std::cos(kTau / points)) / 3; };
        const double chord = 0.05 * 0.05 / (8 * 0.4);
        EXPECT_NEAR(std::hypot(std::hypot(p.x, p.z) - 1, p.y), 0.4, drawn_in(1.4, 48) + drawn_in(0.4, 32) + chord);
    }
}

TEST(Hit, CurvatureOfASubdivisionSurfaceIsThatOfItsLimit)
{
    // The mean curvature of a round torus is (1 / r + cos b / (R + r cos b)) / 2 at the angle b of the tube.
    Scene scene;
    place(scene, scene.add(torus(48, 32, false)), {0, 0, 0});
    EXPECT_NEAR(hit_from(scene, {3, 0, 0}, {-1, 0.003, 0.002}).curvature, 0.5 * (1 / 0.4 + 1 / 1.4), 0.05);
    EXPECT_NEAR(hit_from(scene, {0, 0, 0}, {1, 0.003, 0.002}).curvature, 0.5 * (1 / 0.4 - 1 / 0.6), 0.05);
}

TEST(Hit, FacetsHaveNoCurvature)
{
    Cage cage = ball(16, 8);
    cage.normals.clear();
    Scene scene;
    place(scene, scene.add(cage), {0, 0, 0});
    EXPECT_EQ(hit_from(scene, kAside * 3.0, -kAside).curvature, 0);
}

Material with_normal_map(Scene& scene)
{
    Material m;
    m.normal_texture.texture = scene.add(waves(0));
    return m;
}

// On the ball, u grows along cross(y, n), and v falls upwards.
TEST(Hit, TangentsFollowTheTextureCoordinates)
{
    for (const Vec3d scale : {Vec3d(1), Vec3d(-1, 1, 1)}) {
        Scene scene;
        Cage cage = ball(64, 32);
        cage.materials = {scene.add(with_normal_map(scene))};
        NodeDesc desc;
        desc.place.scale = scale;
        desc.cages = {scene.add(std::move(cage))};
        scene.add_node(scene.root(), desc);
        for (const bool inside : {false, true}) {
            const accel::SurfaceHit hit = inside ? hit_from(scene, {0, 0, 0}, kAside)
                                                 : hit_from(scene, kAside * 3.0, -kAside);
            EXPECT_EQ(hit.back_side, inside);
            const Vec3d outward = Vec3d(hit.normal_shading) * (inside ? -1.0 : 1.0);
            const Vec3d along_u = glm::normalize(glm::cross(Vec3d(0, 1, 0), outward)) * scale.x;
            EXPECT_GT(glm::dot(Vec3d(hit.tangent), along_u), 0.998);
            EXPECT_NEAR(glm::dot(Vec3d(hit.tangent), outward), 0, 1e-6);
            const Vec3d up = glm::cross(outward, Vec3d(hit.tangent)) * double(hit.tangent_sign);
            EXPECT_GT(up.y, 0.5) << "a normal map's +Y points to the north pole";
        }
    }
}

TEST(Hit, WithoutCoordinatesOrANormalMapThereIsNoTangent)
{
    for (const bool has_map : {false, true}) {
        Scene scene;
        Cage cage = ball(16, 8);
        if (has_map) {
            cage.uv_sets.clear();
            cage.materials = {scene.add(with_normal_map(scene))};
        }
        place(scene, scene.add(std::move(cage)), {0, 0, 0});
        EXPECT_EQ(hit_from(scene, kAside * 3.0, -kAside).tangent, Vec3f(0));
    }
}

}  // namespace
}  // namespace occam::test
