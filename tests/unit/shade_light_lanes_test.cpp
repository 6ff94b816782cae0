#include "shade/light_lanes.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <glm/ext/matrix_transform.hpp>
#include <vector>

#include "tests/support/statistics.h"

namespace occam::shade {
namespace {

std::uint32_t word(float x) { return std::bit_cast<std::uint32_t>(x); }
bool is_same(Vec3f a, Vec3f b) { return word(a.x) == word(b.x) && word(a.y) == word(b.y) && word(a.z) == word(b.z); }

// Returns lights of all kinds: rectangles of one and of two sides, long ones, discs, spheres, points, spots, and suns with a
// disc and without.
std::vector<WorldLight> lights()
{
    const Mat4d at = glm::rotate(glm::translate(Mat4d(1), Vec3d(0.3, -0.2, 2)), 0.4, Vec3d(1, 2, 3));
    std::vector<WorldLight> all;
    for (const AreaLight::Shape shape : {AreaLight::Shape::Rectangle, AreaLight::Shape::Disc, AreaLight::Shape::Sphere})
        for (const Vec2f size : {Vec2f(1), Vec2f(0.5f, 40)})
            for (const bool two_sided : {false, true})
                all.push_back(WorldLight::place({"", AreaLight{shape, size, Vec3f(1, 2, 3), two_sided}}, at));
    PointLight spot;
    spot.outer_angle = 0.9f;
    spot.range = 3;
    all.push_back(WorldLight::place({"", PointLight{}}, at));
    all.push_back(WorldLight::place({"", spot}, at));
    all.push_back(WorldLight::place({"", SunLight{}}, at));
    all.back().sun_spread = 0.3f;
    all.push_back(WorldLight::place({"", SunLight{}}, at));
    return all;
}

TEST(LightLanes, HaveTheBitsOfOneSampleAtATime)
{
    test::Numbers numbers(2);
    int left = 0;
    for (const WorldLight& light : lights()) {
        int shining = 0;
        for (int repeat = 0; repeat < 1600 / kLanes; ++repeat) {
            LanePoints points;
            LaneFloats u, v, peak;
            Vec3d place[kLanes];
            for (int k = 0; k < kLanes; ++k) {
                const Vec2f square = numbers.square(), at = numbers.square();
                place[k] = Vec3d(square.x - 0.5, square.y - 0.5, numbers.one() - 0.5) * (repeat % 2 == 0 ? 3.0 : 30.0);
                points.set(k, place[k]);
                u.of[k] = at.x;
                v.of[k] = at.y;
                peak.of[k] = 1 + 100 * numbers.one();
            }
            const LaneVectors to_middle = points.to(light.position);
            LightSamples samples;
            samples = sample_from(light, to_middle, u, v);
            const unsigned is_left = bits(is_left_to_samples(light, to_middle.lanes(), peak.lanes()));
            for (int k = 0; k < kLanes; ++k) {
                const LightSample own = light.sample(place[k], {Vec2f(u.of[k], v.of[k])});
                ASSERT_TRUE(is_same(samples.radiance.at(k), own.radiance));
                EXPECT_EQ((is_left >> k & 1) != 0, FrameLights::is_left_to_samples(light, place[k], peak.of[k]));
                left += (is_left >> k & 1) != 0;
                if (own.radiance == Vec3f(0)) continue;
                ++shining;
                EXPECT_TRUE(is_same(samples.direction.at(k), own.direction));
                EXPECT_EQ(word(samples.distance.of[k]), word(own.distance));
                EXPECT_EQ(word(samples.density.of[k]), word(own.density));
            }
        }
        EXPECT_GT(shining, 20);
    }
    EXPECT_GT(left, 1000);
}

}  // namespace
}  // namespace occam::shade
