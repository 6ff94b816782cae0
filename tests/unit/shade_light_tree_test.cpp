// The tree of lights draws what matters without bias, and finds what rays cross: beside sums over all lights.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <vector>

#include "base/maths.h"
#include "shade/frame_lights.h"
#include "tests/support/statistics.h"

namespace occam::shade {
namespace {

Vec3f unit(test::Numbers& n)
{
    const float z = 2 * n.one() - 1, angle = 2 * maths::kPi * n.one(), r = std::sqrt(std::max(0.0f, 1 - z * z));
    return {r * maths::cos(angle), r * maths::sin(angle), z};
}

// Lights of every kind, of very different powers, within a box of 20 units about `middle`.
std::vector<WorldLight> random_lights(std::size_t count, std::uint64_t seed, Vec3d middle = Vec3d(0))
{
    test::Numbers n(seed);
    std::vector<WorldLight> lights(count);
    for (WorldLight& light : lights) {
        using Kind = WorldLight::Kind;
        constexpr Kind kKinds[] = {Kind::Point, Kind::Point, Kind::Rectangle, Kind::Disc, Kind::Sphere};
        light.kind = kKinds[std::min(4, int(n.one() * 5))];
        light.position = middle + Vec3d(n.one() - 0.5f, n.one() - 0.5f, n.one() - 0.5f) * 20.0;
        light.direction = unit(n);
        light.strength = Vec3f(maths::exp2(10 * n.one() - 5)) * Vec3f(1, n.one(), n.one());
        light.groups = n.one() < 0.2f ? LightGroups(2) : kAllGroups;
        light.two_sided = n.one() < 0.3f;
        if (light.kind == Kind::Point && n.one() < 0.3f) light.range = 3 + 5 * n.one();
        if (light.kind == Kind::Point && n.one() < 0.5f) {
            const float cos_outer = maths::cos(0.3f + 1.5f * n.one());
            light.spot_scale = 1 / (0.05f + n.one() * (1 - cos_outer));
            light.spot_offset = -cos_outer * light.spot_scale;
        }
        light.half_x = glm::normalize(glm::cross(light.direction, unit(n))) * (0.05f + 0.4f * n.one());
        light.half_y = glm::normalize(glm::cross(light.direction, light.half_x)) * (0.05f + 0.4f * n.one());
        light.area = 4 * glm::length(light.half_x) * glm::length(light.half_y);
        if (light.kind == Kind::Disc) {
            light.half_y *= glm::length(light.half_x) / glm::length(light.half_y);
            light.area = maths::kPi * glm::dot(light.half_x, light.half_x);
        }
        light.radius = glm::length(light.half_x);
    }
    return lights;
}

struct Place {
    Vec3d point;
    Vec3f normal;
};
Place random_place(test::Numbers& n, Vec3d middle = Vec3d(0))
{
    return {middle + Vec3d(n.one() - 0.5f, n.one() - 0.5f, n.one() - 0.5f) * 30.0, unit(n)};
}

// Light that a matte surface gets from one sample of a light.
double given(const WorldLight& light, const Place& at, const Receiver& receiver, Vec2f square)
{
    if ((light.groups & receiver.groups) == 0) return 0;
    const LightSample s = light.sample(at.point, {square});
    const float cosine = glm::dot(s.direction, at.normal);
    return double(s.radiance.x) * double(receiver.is_two_sided ? std::fabs(cosine) : std::max(cosine, 0.0f));
}

Receiver receiver_at(const LightTree& tree, const Place& at, test::Numbers& n)
{
    return {tree.relative(at.point), at.normal, n.one() < 0.5f ? LightGroups(1) : kAllGroups, n.one() < 0.3f};
}

TEST(LightTree, ProbabilitiesAreThoseOfItsDraws)
{
    const std::vector<WorldLight> lights = random_lights(60, 3);
    const LightTree tree(lights, 0);
    test::Numbers n(4);
    for (int place = 0; place < 6; ++place) {
        const Receiver receiver = receiver_at(tree, random_place(n), n);
        constexpr int kDraws = 20'000;
        std::vector<double> found(lights.size() + 1), wanted(lights.size() + 1);
        double sum = 0;
        for (std::uint32_t i = 0; i < lights.size(); ++i) {
            const double p = double(tree.expected(i, receiver, 1));
            wanted[i] = p * kDraws;
            sum += p;
        }
        EXPECT_LE(sum, 1 + 1e-5);
        wanted.back() = (1 - sum) * kDraws;
        for (int i = 0; i < kDraws; ++i) {
            LightTree::Pick pick[1];
            if (tree.draw(receiver, n.one(), pick) == 0) {
                ++found.back();
                continue;
            }
            ++found[pick[0].light];
            ASSERT_FLOAT_EQ(pick[0].expected, tree.expected(pick[0].light, receiver, 1));
        }
        EXPECT_LT(test::chi_square_excess(found, wanted), 4.5) << place;
    }
}

TEST(LightTree, PicksAreAsManyAsAreExpected)
{
    const std::vector<WorldLight> lights = random_lights(200, 23);
    const LightTree tree(lights, 0);
    test::Numbers n(24);
    for (const int draws : {2, 5, 16}) {
        const Receiver receiver = receiver_at(tree, random_place(n), n);
        constexpr int kTimes = 4000;
        std::vector<int> found(lights.size());
        for (int i = 0; i < kTimes; ++i) {
            LightTree::Pick picks[16];
            const int count = tree.draw(receiver, n.one(), std::span(picks, std::size_t(draws)));
            ASSERT_LE(count, draws);
            for (int k = 0; k < count; ++k) {
                ++found[picks[k].light];
                ASSERT_FLOAT_EQ(picks[k].expected, tree.expected(picks[k].light, receiver, draws));
            }
        }
        for (std::uint32_t i = 0; i < lights.size(); ++i) {
            const double wanted = kTimes * double(tree.expected(i, receiver, draws));
            EXPECT_NEAR(found[i], wanted, 5 * std::sqrt(wanted) + 1) << draws << " draws, light " << i;
        }
    }
}

// Ten lights near the origin and 9,990 more over the same field, far away.
std::vector<WorldLight> field_of_lights()
{
    std::vector<WorldLight> lights(10'000);
    for (std::size_t i = 0; i < lights.size(); ++i) {
        lights[i].strength = Vec3f(3);
        lights[i].position = i < 10 ? Vec3d(3.0 * (double(i % 5) - 2), 2.5, 3.0 * double(i / 5) - 1.5)
                                    : Vec3d(8.0 * (double(i % 100) - 50), 3, -60 - 8.0 * double(i / 100));
    }
    return lights;
}

// Lights that give a good part of the light are sampled without any choice among them, however many others there are.
TEST(LightTree, LightsNearbyAreDrawnForSure)
{
    const std::vector<WorldLight> lights = field_of_lights();
    const LightTree tree(lights, 0);
    for (const Vec3d point : {Vec3d(0, -0.5, 0), Vec3d(5, -0.5, 4), Vec3d(-6, 1, 0.5)}) {
        const Place at{point, {0, 1, 0}};
        const Receiver receiver{tree.relative(point), at.normal};
        double all = 0, far_away = 0;
        for (const WorldLight& light : lights) all += given(light, at, receiver, Vec2f(0.5f));
        for (std::uint32_t i = 0; i < lights.size(); ++i) {
            const double expected = double(tree.expected(i, receiver, 16));
            if (i < 10) EXPECT_GE(expected, std::min(1.0, 10 * given(lights[i], at, receiver, Vec2f(0.5f)) / all)) << i;
            else far_away += expected;
        }
        EXPECT_LT(far_away, 5) << "they give less than a hundredth of the light";
    }
}

// The strong one may be hidden, so the others need draws of their own.
TEST(LightTree, OthersAreDrawnBesideOneThatOutshinesThem)
{
    std::vector<WorldLight> lights(41);
    for (std::size_t i = 0; i < lights.size(); ++i) {
        const float angle = 2 * maths::kPi * float(i) / 40;
        lights[i].position = {1.5 * double(maths::cos(angle)), 1, 1.5 * double(maths::sin(angle))};
        lights[i].strength = Vec3f(1);
    }
    lights.back().position = {6, 3, 0};
    for (const float strength : {1.0f, 1e3f, 1e6f, 1e9f, 1e18f}) {
        lights.back().strength = Vec3f(strength);
        const LightTree tree(lights, 0);
        for (const int draws : {16, 4, 2}) {
            const Receiver receiver{tree.relative(Vec3d(0.3, 0, 0.2)), {0, 1, 0}, kAllGroups, false};
            double others = 0;
            for (std::uint32_t i = 0; i < 40; ++i) others += double(tree.expected(i, receiver, draws));
            EXPECT_GE(others, 0.99 * draws / 8) << strength;
            EXPECT_LE(others + double(tree.expected(40, receiver, draws)), draws * 1.00001) << strength;
        }
    }
}

// The variance that the choice adds to the sum of all light, if lights were drawn independently of each other.
TEST(LightTree, TheChoiceOfLightsAddsLittleNoise)
{
    const std::vector<WorldLight> lights = field_of_lights();
    const LightTree tree(lights, 0);
    const Place places[] = {{{0, -0.5, 0}, {0, 1, 0}},        {{5, -0.5, 4}, {0, 1, 0}},
                            {{0, 0.3, 1.4}, {0, 0.6f, 0.8f}}, {{1.2, 0.2, 0}, {0.8f, 0.6f, 0}},
                            {{-6, -0.5, -8}, {0, 1, 0}},      {{1, 0.3, -0.6}, {0, 0.6f, -0.8f}},
                            {{-40, 1, -300}, {0.6f, 0.8f, 0}}};
    for (const Place& at : places)
        for (const auto& [draws, most] : {std::pair(16, 0.02), std::pair(4, 0.25)}) {
            const Receiver receiver{tree.relative(at.point), at.normal};
            double sum = 0, variance = 0;
            for (std::uint32_t i = 0; i < lights.size(); ++i) {
                const double light = given(lights[i], at, receiver, Vec2f(0.5f));
                if (!(light > 0)) continue;
                sum += light;
                variance += light * light * (1 / double(tree.expected(i, receiver, draws)) - 1);
            }
            EXPECT_LT(variance, most * sum * sum) << at.point.x << ", " << at.point.z << ", " << draws << " draws";
        }
}

TEST(LightTree, LightsBelowTheHorizonAreNotDrawn)
{
    // A wide plane of lamps that shine up and down.
    std::vector<WorldLight> lights(10'000);
    for (std::size_t i = 0; i < lights.size(); ++i) {
        lights[i].strength = Vec3f(1);
        lights[i].position = Vec3d(double(i % 100) - 50, 3, double(i / 100) - 50);
    }
    const LightTree tree(lights, 0);
    test::Numbers n(31);
    for (int k = 0; k < 100; ++k) {
        const Vec3d above(60 * n.one() - 30, 3.2 + double(n.one()), 60 * n.one() - 30);
        LightTree::Pick picks[16];
        for (const std::size_t places : {1, 4, 16}) {
            EXPECT_EQ(tree.draw({tree.relative(above), {0, 1, 0}}, n.one(), std::span(picks, places)), 0);
            EXPECT_GT(tree.draw({tree.relative(above), {0, -1, 0}}, n.one(), std::span(picks, places)), 0);
            EXPECT_GT(tree.draw({tree.relative(above), {0, 1, 0}, kAllGroups, true}, n.one(), std::span(picks, places)), 0);
        }
    }
}

TEST(LightTree, WhatGivesLightHasAProbability)
{
    for (const Vec3d middle : {Vec3d(0), Vec3d(1e6, -2e6, 3e5)}) {
        const std::vector<WorldLight> lights = random_lights(300, 5, middle);
        const LightTree tree(lights, 0);
        test::Numbers n(6);
        for (int i = 0; i < 300; ++i) {
            const Place at = random_place(n, middle);
            const Receiver receiver = receiver_at(tree, at, n);
            for (std::uint32_t light = 0; light < lights.size(); ++light) {
                if (!(given(lights[light], at, receiver, n.square()) > 0)) continue;
                for (const int draws : {1, 16}) ASSERT_GT(tree.expected(light, receiver, draws), 0) << "of light " << light;
            }
        }
    }
}

TEST(LightTree, SumsOfSamplesAreThoseOfAllLights)
{
    const std::vector<WorldLight> lights = random_lights(400, 7);
    const LightTree tree(lights, 0);
    test::Numbers n(8);
    for (int place = 0; place < 8; ++place) {
        const Place at = random_place(n);
        const Receiver receiver = receiver_at(tree, at, n);
        test::Mean all, drawn;
        for (int i = 0; i < 400; ++i) {
            double sum = 0;
            for (const WorldLight& light : lights) sum += given(light, at, receiver, n.square());
            all.add(sum);
        }
        for (int i = 0; i < 4000; ++i) {
            LightTree::Pick picks[16];
            const int count = tree.draw(receiver, n.one(), picks);
            double sum = 0;
            for (int k = 0; k < count; ++k)
                sum += given(lights[picks[k].light], at, receiver, n.square()) / double(picks[k].expected);
            drawn.add(sum);
        }
        EXPECT_NEAR(drawn.value(), all.value(), 4.5 * std::hypot(drawn.error(), all.error())) << place;
    }
}

TEST(LightTree, FindsTheLightsThatARayCrosses)
{
    for (const Vec3d middle : {Vec3d(0), Vec3d(0, 3e5, -2e5)}) {
        const std::vector<WorldLight> lights = random_lights(500, 9, middle);
        const LightTree tree(lights, 0);
        test::Numbers n(10);
        std::size_t crossings = 0, visits = 0;
        for (int i = 0; i < 1000; ++i) {
            const Vec3d origin = random_place(n, middle).point;
            // Half of the rays aim at a light, and some run along an axis.
            Vec3f direction = unit(n);
            if (i % 2 == 0) direction = glm::normalize(Vec3f(lights[std::size_t(i) % 500].position - origin));
            if (i % 7 == 0) direction = Vec3f(0, i % 2 ? 1 : -1, 0);
            std::set<std::uint32_t> visited;
            tree.for_crossed(origin, direction, [&](std::uint32_t light) { visited.insert(light); });
            visits += visited.size();
            for (std::uint32_t light = 0; light < lights.size(); ++light) {
                if (!(lights[light].crossing(origin, direction).density > 0)) continue;
                ++crossings;
                EXPECT_TRUE(visited.contains(light)) << "ray " << i;
            }
        }
        EXPECT_GT(crossings, 200u);
        EXPECT_LT(visits, 1000u * 60) << "few of the 500";
    }
}

TEST(LightTree, KnowsWhetherAnyLightIsLarge)
{
    const std::vector<WorldLight> lights = random_lights(200, 11);
    const LightTree tree(lights, 0);
    test::Numbers n(12);
    int found = 0;
    for (int i = 0; i < 300; ++i) {
        const Vec3d at = random_place(n).point;
        const float share = maths::exp2(-12 * n.one());
        const auto is_large = [&](std::uint32_t light) {
            return lights[light].has_area() && lights[light].sine2_subtended(at) >= share;
        };
        bool expected = false;
        for (std::uint32_t light = 0; light < lights.size(); ++light) expected |= is_large(light);
        EXPECT_EQ(tree.any_covering(at, share, is_large), expected) << i;
        found += expected;
    }
    EXPECT_TRUE(found > 30 && found < 270) << found;
}

// Lights in one place, black lights, lights without limits, one light alone.
TEST(LightTree, HoldsAnyLights)
{
    std::vector<WorldLight> lights(100);
    for (WorldLight& light : lights) light.strength = Vec3f(1);
    lights[3].strength = Vec3f(0);
    lights[4].strength = Vec3f(1e12f);
    lights[5].strength = Vec3f(1e-30f);
    const LightTree tree(lights, 0);
    for (const Vec3f point : {Vec3f(0), Vec3f(1e-20f), Vec3f(0, 1, 0), Vec3f(1e18f)}) {
        double sum = 0;
        const Receiver receiver{point, {0, 1, 0}, kAllGroups, true};
        for (std::uint32_t i = 0; i < lights.size(); ++i) sum += double(tree.expected(i, receiver, 1));
        EXPECT_NEAR(sum, 1, 1e-4);
        LightTree::Pick picks[16];
        const int count = tree.draw(receiver, 0.3f, picks);
        EXPECT_TRUE(count >= 1 && count <= 16) << count;
    }
    EXPECT_EQ(tree.expected(3, {}, 4), 0);
    const LightTree one(std::span<const WorldLight>(lights).first(3), 2),
        none(std::span<const WorldLight>(lights).first(4), 3);
    EXPECT_EQ(one.expected(2, {}, 4), 1);
    EXPECT_TRUE(none.is_empty());
    lights.resize(100'000, lights.front());
    const LightTree many(lights, 0);
    EXPECT_GT(many.expected(99'999, {}, 1), 0) << "as deep as a tree of halves";
}

// A few suns and few other lights stay outside the tree.
TEST(FrameLights, ScenesWithManyLightsHaveATree)
{
    std::vector<WorldLight> lights = random_lights(16, 13);
    EXPECT_TRUE(FrameLights(lights, {}).tree().is_empty());
    EXPECT_EQ(FrameLights(lights, {}).lights_outside_tree(), 16u);
    WorldLight sun;
    sun.kind = WorldLight::Kind::Sun;
    sun.strength = Vec3f(1);
    lights.push_back(sun);
    const FrameLights many(lights, {});
    EXPECT_FALSE(many.tree().is_empty());
    EXPECT_EQ(many.lights_outside_tree(), 1u);
    EXPECT_EQ(many.lights().front().kind, WorldLight::Kind::Sun);
    EXPECT_TRUE(FrameLights(std::vector<WorldLight>(100, sun), {}).tree().is_empty());
}

}  // namespace
}  // namespace occam::shade
