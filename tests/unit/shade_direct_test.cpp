#include "shade/direct.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/campaign.h"
#include "tests/support/statistics.h"

namespace occam::shade {
namespace {

Surface matte()
{
    Surface s;
    s.diffuse = Vec3f(0.5f);
    s.f0 = Vec3f(0);
    s.f90 = s.dielectric_f0 = s.dielectric_f90 = 0;
    s.is_matte = true;
    s.self_distance = 1e-4f;
    s.to_eye = glm::normalize(Vec3f(-0.6f, 0.1f, 1));
    return s;
}

Surface glossy(float alpha, float coat = 0)
{
    Surface s = matte();
    s.is_matte = false;
    s.f0 = Vec3f(0.2f);
    s.f90 = s.dielectric_f90 = 1;
    s.dielectric_f0 = 0.04f;
    s.alpha = alpha;
    s.coat = coat;
    s.coat_alpha = 0.1f;
    return s;
}

// Returns a square light whose corners are a unit from its middle. It is `distance` away at `angle` to the normal, and
// tilted by `tilt` from facing the point.
WorldLight square_light(float distance, float angle, float tilt)
{
    WorldLight light;
    light.kind = WorldLight::Kind::Rectangle;
    light.position = Vec3d(std::sin(double(angle)), 0, std::cos(double(angle))) * double(distance);
    light.direction = {-std::sin(angle + tilt), 0, -std::cos(angle + tilt)};
    const float half = std::sqrt(0.5f);
    light.half_x = Vec3f(std::cos(angle + tilt), 0, -std::sin(angle + tilt)) * half;
    light.half_y = {0, half, 0};
    light.area = 2;
    light.strength = Vec3f(1);
    return light;
}

WorldLight ball(float distance, float angle)
{
    WorldLight light;
    light.kind = WorldLight::Kind::Sphere;
    light.position = Vec3d(std::sin(double(angle)), 0, std::cos(double(angle))) * double(distance);
    light.radius = 1;
    light.strength = Vec3f(1);
    return light;
}

bool is_left(const Surface& s, const WorldLight& light)
{
    return FrameLights::is_left_to_samples(light, s.start(s.normal_geometric), peak_density(s));
}

// Returns the light that leaves the surface, from one sample of the light and one scattered direction. They are weighed
// against each other, or as the rule says.
test::Mean radiance(const Surface& s, const WorldLight& light, bool by_rule, int count = 10'000)
{
    const FrameLights lights({light}, {});
    const float peak = by_rule ? peak_density(s) : std::numeric_limits<float>::infinity();
    const SampleCounts counts{1, by_rule && is_left(s, light) ? 0.0f : 1.0f};
    test::Numbers numbers(7);
    test::Mean mean;
    for (int i = 0; i < count; ++i) {
        double sum = double(test_of(s, light.sample(s.position, {numbers.square(), 0}), counts).radiance.x);
        const float choice = numbers.one();
        const ScatterSample d = sample_scatter(s, choice, numbers.square());
        const auto add = [&](const WorldLight&, const LightCrossing& c, float) {
            sum += double(d.weight.x * c.radiance.x * SampleCounts{1, 1}.of_scatter(d.density, c.density));
        };
        lights.for_crossings({s.start(d.direction), d.direction, 1e30f}, peak, {Receiver{}, 1}, add);
        mean.add(sum);
    }
    return mean;
}

TEST(DirectLight, TheRuleLeavesTheMeanAsItIsNearAndFar)
{
    int left = 0, shared = 0;
    for (const Surface& s : {matte(), glossy(0.5f), glossy(0.1f), glossy(0.5f, 1), glossy(0.01f)})
        for (const float distance : {1.2f, 2.0f, 3.9f, 4.2f, 10.0f, 60.0f})
            for (const WorldLight& light :
                 {square_light(distance, 0.3f, 0.2f), square_light(distance, 1.3f, -0.8f), ball(distance, 0.5f)}) {
                const test::Mean both = radiance(s, light, false), by_rule = radiance(s, light, true);
                const double error = std::hypot(both.error(), by_rule.error());
                EXPECT_NEAR(by_rule.value(), both.value(), 4 * error + 1e-6)
                    << "alpha " << s.alpha << ", distance " << distance;
                ++(is_left(s, light) ? left : shared);
            }
    EXPECT_GT(left, 20);
    EXPECT_GT(shared, 40);
}

TEST(DirectLight, LightsCloseByAndNarrowLobesAreWeighedBothWays)
{
    EXPECT_FALSE(is_left(matte(), square_light(3.9f, 0.3f, 0.2f)));
    EXPECT_TRUE(is_left(matte(), square_light(4.1f, 0.3f, 0.2f)));
    EXPECT_FALSE(is_left(matte(), square_light(0.5f, 0, 0))) << "within its sphere";
    EXPECT_FALSE(is_left(glossy(0.1f), square_light(4.1f, 0.3f, 0.2f)));
    EXPECT_FALSE(is_left(glossy(0.5f, 1), square_light(8, 0.3f, 0.2f))) << "its coat is narrow";
    EXPECT_TRUE(is_left(glossy(0.1f), square_light(100, 0.3f, 0.2f)));
    Surface glass = glossy(0.5f);
    glass.transmission = Vec3f(0.5f);
    EXPECT_FALSE(is_left(glass, square_light(1e6f, 0, 0)));
}

// A light may be so small that floats do not hold the density of its samples, or that times their number.
TEST(DirectLight, ASampleOfADensityBeyondFloatsCountsInFull)
{
    const Surface s = glossy(0.3f);
    const Vec3f up = s.normal, full = scatter(s, up);
    for (const float density : {1e38f, 3e38f, std::numeric_limits<float>::infinity()})
        for (const float count : {1.0f, 16.0f}) {
            const ShadowTest test = test_of(s, {up, 1, Vec3f(0.5f), density}, {count, 1});
            EXPECT_NEAR(test.radiance.x, 0.5f * full.x, 1e-5f * full.x) << density << ' ' << count;
        }
}

// No direction is drawn with a higher density than the rule assumes.
TEST(DirectLight, NoLobeIsDenserThanItsPeak)
{
    for (const Surface& s : {matte(), glossy(0.5f), glossy(0.1f), glossy(0.5f, 1), glossy(0.01f)}) {
        test::Numbers numbers(3);
        float most = 0;
        for (int i = 0; i < 5000; ++i) {
            const float choice = numbers.one();
            most = std::max(most, sample_scatter(s, choice, numbers.square()).density);
        }
        EXPECT_LE(most, peak_density(s) * 1.0001f) << s.alpha;
    }
}

// The light is as near as the rule allows, where both ways are nearly equally good.
TEST(DirectLight, ALightLeftToItsSamplesIsNoNoisier)
{
    test::EveryNth some(3);
    for (const Surface& s : {matte(), glossy(0.5f), glossy(0.2f), glossy(0.05f)}) {
        const float distance = 1.001f * std::sqrt(peak_density(s) * kPi / FrameLights::kLeastChance);
        for (const float angle : {0.0f, 0.54f, 0.9f, 1.2f})
            for (const float tilt : {0.0f, 0.9f, -0.9f, 1.3f}) {
                if (!some.takes()) continue;
                const WorldLight light = square_light(distance, angle, tilt);
                ASSERT_TRUE(is_left(s, light));
                const test::Mean both = radiance(s, light, false), alone = radiance(s, light, true);
                EXPECT_LT(alone.error(), 1.05 * both.error()) << s.alpha << ' ' << angle << ' ' << tilt;
            }
    }
}

}  // namespace
}  // namespace occam::shade
