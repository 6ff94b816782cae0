#include "shade/surface_lanes.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "tests/support/statistics.h"

namespace occam::shade {
namespace {

std::uint32_t word(float x) { return std::bit_cast<std::uint32_t>(x); }

bool is_same(Vec3f a, Vec3f b) { return word(a.x) == word(b.x) && word(a.y) == word(b.y) && word(a.z) == word(b.z); }

Vec3f direction(test::Numbers& numbers)
{
    const float z = 2 * numbers.one() - 1, angle = 2 * kPi * numbers.one(), r = std::sqrt(std::max(0.0f, 1 - z * z));
    return {r * maths::cos(angle), r * maths::sin(angle), z};
}

Vec3f colour(test::Numbers& numbers)
{
    Vec3f c;
    for (int i = 0; i < 3; ++i) c[i] = numbers.one();
    return c;
}

// Returns a surface of a metal, a dielectric, a mirror, a matte, a black or a coated one, whose shading normal may lean away
// from everything. Every eleventh has axes with zeros of either sign.
Surface surface(test::Numbers& numbers, int number)
{
    Surface s;
    s.to_eye = direction(numbers);
    s.normal_geometric = direction(numbers);
    if (glm::dot(s.normal_geometric, s.to_eye) < 0) s.normal_geometric = -s.normal_geometric;
    s.normal = glm::normalize(s.normal_geometric + direction(numbers) * (number % 3 == 0 ? 0.0f : 0.9f * numbers.one()));
    if (number % 11 == 0)
        s.normal = s.normal_geometric = {number % 2 == 0 ? 1.0f : -1.0f, 0.0f, number % 4 < 2 ? 0.0f : -0.0f};
    const float metallic = number % 5 == 0 ? 1 : numbers.one();
    s.base_color = colour(numbers);
    s.diffuse = s.base_color * (1 - metallic);
    s.f0 = Vec3f(0.04f * (1 - metallic)) + s.base_color * metallic;
    s.is_mixed = metallic < 1;
    s.dielectric_share = 1 - metallic;
    s.metal_share = metallic;
    s.alpha = number % 7 == 0 ? kMinAlpha : std::max(kMinAlpha, numbers.one() * numbers.one());
    if (number % 4 == 0) {  // matte
        s.f0 = Vec3f(0);
        s.f90 = s.dielectric_f0 = s.dielectric_f90 = 0;
        s.is_mixed = false;
        s.diffuse = number % 8 == 0 ? Vec3f(0) : s.base_color;
        s.is_matte = true;
    }
    if (number % 6 < 2 && number % 48 >= 24) {  // coated, in some blocks
        s.coat = number % 6 == 0 ? 1 : numbers.one();
        s.coat_alpha = number % 9 == 0 ? kMinAlpha : std::max(kMinAlpha, numbers.one() * 0.5f);
        s.coat_normal = number % 12 == 0 ? s.normal : glm::normalize(s.normal_geometric + direction(numbers) * 0.5f);
        s.is_matte = false;
    }
    return s;
}

struct Block {
    std::vector<Surface> surfaces;
    SurfaceLanes lanes;

    Block(test::Numbers& numbers, int first)
    {
        for (int k = 0; k < kLanes; ++k) {
            surfaces.push_back(surface(numbers, first + k));
            EXPECT_TRUE(SurfaceLanes::takes(surfaces.back()));
            lanes.set(k, surfaces.back());
        }
        lanes.complete();
    }
};

TEST(SurfaceLanes, HaveTheBitsOfOneSurfaceAtATime)
{
    test::Numbers numbers(3);
    for (int first = 0; first < 20'000; first += kLanes) {
        const Block block(numbers, first);
        LaneVectors to_light, radiance;
        LaneFloats density, distance, light_count, scatter_count;
        for (int k = 0; k < kLanes; ++k) {
            to_light.set(k, (first + k) % 13 == 0 ? -block.surfaces[std::size_t(k)].to_eye : direction(numbers));
            radiance.set(k, (first + k) % 17 == 0 ? Vec3f(0) : colour(numbers));
            density.of[k] = (first + k) % 3 == 0 ? 0 : 10 * numbers.one();
            if ((first + k) % 23 == 0) density.of[k] = std::numeric_limits<float>::infinity();
            distance.of[k] = numbers.one();
            light_count.of[k] = (first + k) % 2 == 0 ? 1 : 0.25f;
            scatter_count.of[k] = (first + k) % 5 == 0 ? 0 : 1;
        }
        const SurfaceLanes::Scattering found = block.lanes.scatter_with_density(to_light.lanes());
        LaneFloats peak;
        peak = block.lanes.peak_density();
        LaneVectors light, leaves;
        LaneFloats found_density;
        light = found.light;
        found_density = found.density;
        leaves = block.lanes
                     .test_of({to_light.lanes(), distance.lanes(), radiance.lanes(), density.lanes()}, light_count.lanes(),
                              scatter_count.lanes())
                     .radiance;
        for (int k = 0; k < kLanes; ++k) {
            ASSERT_EQ(word(peak.of[k]), word(peak_density(block.surfaces[std::size_t(k)]))) << first + k;
            const SurfaceForEye one(block.surfaces[std::size_t(k)]);
            const ScatterWithDensity both = shade::scatter_with_density(one, to_light.at(k));
            ASSERT_TRUE(is_same(light.at(k), both.light)) << first + k;
            ASSERT_EQ(word(found_density.of[k] + 0.0f), word(both.density + 0.0f)) << first + k;
            const ShadowTest test = shade::test_of(one, {to_light.at(k), distance.of[k], radiance.at(k), density.of[k]},
                                                   SampleCounts{light_count.of[k], scatter_count.of[k]});
            ASSERT_TRUE(is_same(leaves.at(k), test.radiance)) << first + k;
        }
    }
}

TEST(SurfaceLanes, DrawTheDirectionsOfOneSurfaceAtATime)
{
    test::Numbers numbers(4);
    int of_layer = 0, of_coat = 0, lost = 0;
    for (int first = 0; first < 20'000; first += kLanes) {
        const Block block(numbers, first);
        LaneFloats choice, u, v;
        for (int k = 0; k < kLanes; ++k) {
            const bool is_middle = (first + k) % 19 == 0;
            choice.of[k] = numbers.one();
            u.of[k] = is_middle ? 0.5f : numbers.one();
            v.of[k] = is_middle ? 0.5f : numbers.one();
        }
        const SurfaceLanes::Samples samples = block.lanes.sample_scatter(choice.lanes(), u.lanes(), v.lanes());
        for (int k = 0; k < kLanes; ++k) {
            const Surface& s = block.surfaces[std::size_t(k)];
            const ScatterSample own = shade::sample_scatter(SurfaceForEye(s), choice.of[k], Vec2f(u.of[k], v.of[k]));
            const ScatterSample found = samples.at(k, s);
            ASSERT_TRUE(is_same(own.direction, found.direction)) << first + k;
            ASSERT_TRUE(is_same(own.weight, found.weight)) << first + k;
            ASSERT_EQ(word(own.density + 0.0f), word(found.density + 0.0f)) << first + k;
            ASSERT_EQ(own.lobe, found.lobe) << first + k;
            ASSERT_EQ(own.alpha, found.alpha) << first + k;
            of_layer += found.lobe == Lobe::Layer;
            of_coat += found.lobe == Lobe::Coat;
            lost += own.weight == Vec3f(0);
        }
    }
    EXPECT_GT(of_layer, 2000);
    EXPECT_GT(of_coat, 200);
    EXPECT_GT(lost, 100);
}

TEST(SurfaceLanes, LeaveWhatHasMoreLobesToOthers)
{
    Surface s;
    EXPECT_TRUE(SurfaceLanes::takes(s));
    s.coat = 0.5f;
    EXPECT_TRUE(SurfaceLanes::takes(s));
    s.sheen = Vec3f(0.1f);
    EXPECT_FALSE(SurfaceLanes::takes(s));
    s.sheen = Vec3f(0);
    s.tangent = {1, 0, 0};
    EXPECT_FALSE(SurfaceLanes::takes(s));
    s.tangent = Vec3f(0);
    s.transmission = Vec3f(1);
    EXPECT_FALSE(SurfaceLanes::takes(s));
    s.is_solid = true;
    EXPECT_FALSE(SurfaceLanes::takes(s));
}

}  // namespace
}  // namespace occam::shade
