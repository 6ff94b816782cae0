// Tests of bump maps: slopes are derivatives of the height, wherever they are computed, and no normal faces away.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "render/shade_point.h"
#include "shade/bump.h"
#include "shade/surface.h"
#include "tests/support/shape_builders.h"
#include "tests/support/textured_floor.h"

namespace occam::test {
namespace {

constexpr float kAround = 6.2831853f;

/// Returns a material with a hill and a hollow across the texture. A texel has the height at its middle.
Material hilly(Scene& scene)
{
    Material m;
    m.bump_texture.texture = scene.add(texture_of([](float x, float y) {
        const float a = kAround / kTexels;
        return Vec4f(0.5f + 0.25f * std::sin(a * (x + 0.5f)) + 0.25f * std::cos(a * (y + 0.5f)), 0, 0, 1);
    }));
    m.bump_scale = 0.8f;
    return m;
}

/// Returns the derivatives of 0.8 times that height with respect to the coordinates.
Vec2f derivatives(Vec2f uv) { return Vec2f(std::cos(kAround * uv.x), -std::sin(kAround * uv.y)) * (0.8f * 0.25f * kAround); }

TEST(Bump, RisesOfALatticeAreTheHeightsDerivativesAlsoOnItsBorder)
{
    Scene scene;
    const Material m = hilly(scene);
    TextureStore textures(std::size_t(1) << 24);
    textures.prepare(scene);
    // Rows and columns are at no right angle in the plane of the coordinates.
    const Vec2f along_i(0.02f, 0.005f), along_j(-0.01f, 0.02f);
    constexpr int kColumns = 7, kRows = 5;
    std::vector<lod::VertexToShade> vertices;
    for (int j = 0; j < kRows; ++j)
        for (int i = 0; i < kColumns; ++i) {
            const Vec2f uv = Vec2f(0.3f, 0.4f) + along_i * float(i) + along_j * float(j);
            vertices.push_back({{uv, uv}, {0, 0}});
        }
    const lod::LatticeToShade lattice{vertices, kColumns};
    const shade::BumpLattice bump(m, lattice, textures);
    for (int j = 0; j < kRows; ++j)
        for (int i = 0; i < kColumns; ++i) {
            const Vec2f rise = bump.rise(i, j);
            const Vec2f expected = derivatives(vertices[std::size_t(j * kColumns + i)].uv[0]);
            // The rise comes from differences over 0.04 of a wave, and heights are linear between texels.
            EXPECT_NEAR(rise.x, expected.x, 0.03f) << i << ' ' << j;
            EXPECT_NEAR(rise.y, expected.y, 0.03f) << i << ' ' << j;
        }
}

// The floor's coordinates grow by a quarter for each unit. It is seen from straight above, from below, and in a mirrored
// placement.
TEST(Bump, HitsHaveTheNormalOfTheHillsOnCagesAndTrianglesFromBothSides)
{
    for (const Scheme scheme : {Scheme::Bilinear, Scheme::Triangles})
        for (const bool at_vertices : {false, true})
            for (const double mirror : {1.0, -1.0})
                for (const float side : {1.0f, -1.0f}) {
                    Scene scene;
                    const Material m = hilly(scene);
                    NodeDesc node;
                    node.place.scale = {mirror, 1, 1};
                    node.cages = {scene.add(floor_of(scene.add(m), scheme))};
                    scene.add_node(scene.root(), node);
                    FloorTracer floor(scene, at_vertices);
                    for (int k = 0; k < 20; ++k) {
                        accel::Ray ray;
                        ray.origin = {-1.81 + 0.183 * k, double(side) * 2, 1.73 - 0.171 * k};
                        ray.direction = {0, -side, 0};
                        ray.footprint = {0.05f, 0};
                        accel::SurfaceHit hit;
                        floor.tracer.closest({&ray, 1}, {&hit, 1});
                        ASSERT_TRUE(hit.is_hit());
                        ASSERT_EQ(hit.phase_one_channels > 0, at_vertices && scheme == Scheme::Bilinear);
                        const shade::Surface surface = shade::evaluate(render::shade_point(ray, hit, 1), floor.textures);
                        const Vec2f rise = derivatives(hit.uv[0]) * 0.25f;
                        const Vec3f expected = glm::normalize(Vec3f(-float(mirror) * rise.x, 1, -rise.y)) * side;
                        EXPECT_LT(glm::distance(surface.normal, expected), 0.03f)
                            << at_vertices << ' ' << mirror << ' ' << side << ' ' << k;
                    }
                }
}

TEST(Bump, NoSlopeTurnsANormalAwayFromTheEyeOrTheFacet)
{
    std::mt19937_64 random(5);
    const auto number = [&] { return float(random() >> 40) * 0x1p-23f - 1; };
    const auto direction = [&] {
        for (;;)
            if (const Vec3f v(number(), number(), number()); glm::dot(v, v) < 1 && glm::dot(v, v) > 0.01f)
                return glm::normalize(v);
    };
    int shortened = 0;
    for (int k = 0; k < 20000; ++k) {
        shade::ShadePoint p;
        p.normal_geometric = direction();
        const auto facing = [&](Vec3f v) { return glm::dot(v, p.normal_geometric) < 0 ? -v : v; };
        p.normal_shading = facing(direction());
        p.to_eye = facing(direction());
        if (!(glm::dot(p.normal_shading, p.to_eye) > 1e-3f) || !(glm::dot(p.normal_shading, p.normal_geometric) > 1e-3f))
            continue;
        p.back_side = k & 1;
        const Vec3f slope = direction() * std::exp2(12 * number());
        const Vec3f n = shade::bumped_normal(p.normal_shading, slope, p);
        EXPECT_NEAR(glm::length(n), 1, 1e-5f);
        EXPECT_GT(glm::dot(n, p.to_eye), 0);
        EXPECT_GT(glm::dot(n, p.normal_geometric), 0);
        const Vec3f outward = p.back_side ? -slope : slope,
                    across = outward - p.normal_shading * glm::dot(outward, p.normal_shading);
        shortened += glm::dot(p.normal_shading - across, p.to_eye) < 0;
    }
    EXPECT_GT(shortened, 1000) << "the test asks for what it tests";
    shade::ShadePoint flat;
    for (const float odd : {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN(), 3e38f})
        EXPECT_EQ(shade::bumped_normal({0, 0, 1}, {odd, 0, odd}, flat), Vec3f(0, 0, 1));
}

TEST(Bump, WithoutCoordinatesThereIsNone)
{
    Scene scene;
    Material m = hilly(scene);
    m.bump_texture.uv_set = 1;
    NodeDesc node;
    node.cages = {scene.add(floor_of(scene.add(m), Scheme::Bilinear))};
    scene.add_node(scene.root(), node);
    FloorTracer floor(scene, false);
    accel::Ray ray;
    ray.origin = {0.3, 2, 0.4};
    ray.direction = {0, -1, 0};
    ray.footprint = {0.05f, 0};
    accel::SurfaceHit hit;
    floor.tracer.closest({&ray, 1}, {&hit, 1});
    ASSERT_TRUE(hit.is_hit());
    EXPECT_EQ(shade::evaluate(render::shade_point(ray, hit, 1), floor.textures).normal, Vec3f(0, 1, 0));
}

}  // namespace
}  // namespace occam::test
