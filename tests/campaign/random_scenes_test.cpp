// Tests of scenes made from seeds: every way to render one gives the same picture, and no ray leaves its closed cages.
//
// OCCAM_SEED=n tests that seed alone. With OCCAM_LONG=1 seeds follow one another for OCCAM_CAMPAIGN_SECONDS (ten minutes),
// and OCCAM_CAMPAIGN_RAYS (100,000) rays are sent from inside each closed cage.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <iostream>
#include <span>

#include "tests/support/campaign.h"
#include "tests/support/random_case.h"

namespace occam::test {
namespace {

using Clock = std::chrono::steady_clock;

/// Tests one seed; a failing case is made as small as possible before it is reported.
void expect_holds(std::uint64_t seed, const CaseCheck& of_case)
{
    const CaseCheck check = [&](const RandomCase& c) -> std::string {
        try {
            return of_case(c);
        } catch (const std::exception& e) {
            return e.what();
        }
    };
    const RandomCase c = random_case(seed);
    const std::string fault = check(c);
    if (fault.empty()) return;
    const RandomCase least = shrunk(c, check);
    ADD_FAILURE() << check(least) << "\n  smallest case: " << description(least) << "\n  of: " << description(c)
                  << "\n  replay: OCCAM_SEED=" << seed;
}

/// Seeds of scenes that are fast, and of which two or more have each feature, as a test below asks.
constexpr std::uint64_t kChosenSeeds[] = {5, 1924, 2260, 2638, 15, 1820, 2162, 2541};

/// Tests the `quick` seeds, or with OCCAM_LONG=1 as many from 1 on as a third of the campaign's time allows.
void run_campaign(std::span<const std::uint64_t> quick, const CaseCheck& check)
{
    if (const char* seed = std::getenv("OCCAM_SEED")) return expect_holds(std::strtoull(seed, nullptr, 10), check);
    if (!is_long()) {
        for (const std::uint64_t seed : quick)
            if (!testing::Test::HasFailure()) expect_holds(seed, check);
        return;
    }
    const auto end = Clock::now() + std::chrono::seconds(number_from("OCCAM_CAMPAIGN_SECONDS", 600)) / 3;
    std::uint64_t seed = 1;
    for (; Clock::now() < end && !testing::Test::HasFailure(); ++seed) expect_holds(seed, check);
    std::cout << "tested seeds 1 to " << seed - 1 << '\n';
}

TEST(RandomScenes, GiveOnePictureForAnyThreadsTreesAndMemory) { run_campaign(kChosenSeeds, check_pictures); }

/// Values of phase one are kept with igrids that several rays share, so they are where an order of rays would show first.
TEST(RandomScenes, GiveOnePictureWhenShadedAtVertices)
{
    run_campaign(kChosenSeeds, [](RandomCase c) {
        for (const SettingFeature f : {SettingFeature::AtVertices, SettingFeature::Frozen, SettingFeature::Coarse})
            c.settings |= 1u << static_cast<unsigned>(f);
        for (RandomPart& part : c.parts) part.features |= 1u << static_cast<unsigned>(PartFeature::Textured);
        return check_pictures(c);
    });
}

TEST(RandomScenes, LetNoRayOutOfClosedCages)
{
    const std::uint64_t rays = is_long() ? rays_of_a_campaign() / 10 : 4'000;
    Tested tested;
    constexpr std::uint64_t kSeeds[] = {1, 2, 3, 4, 5, 6};
    run_campaign(kSeeds, [&](const RandomCase& c) { return check_closedness(c, rays, &tested); });
    if (is_long()) std::cout << tested.cages << " cages, " << tested.rays << " rays\n";
    // What follows is known of kSeeds alone.
    if (is_long() || std::getenv("OCCAM_SEED")) return;
    EXPECT_GT(tested.cages, 8u);
    EXPECT_EQ(tested.hopeless, 0u);
}

/// Returns the settings that have an effect in the case, as bits.
unsigned effective_settings(RandomCase c)
{
    if (c.has(SettingFeature::Path)) c.remove(SettingFeature::Ao);
    else c.remove(SettingFeature::Clamped);
    if (c.has(SettingFeature::Ao))
        for (const SettingFeature f : {SettingFeature::Lamps, SettingFeature::LightSamples, SettingFeature::AtVertices})
            c.remove(f);
    if (c.has(SettingFeature::LodOff)) c.remove(SettingFeature::Frozen);
    if (c.has(SettingFeature::Coarse)) c.remove(SettingFeature::Fine);
    if (!c.has(SettingFeature::Shutter)) c.remove(SettingFeature::Swarm);
    return c.settings;
}

TEST(RandomCases, OfTheChosenSeedsHaveAllFeatures)
{
    int settings[kSettingFeatures] = {}, features[kPartFeatures] = {};
    for (const std::uint64_t seed : kChosenSeeds) {
        const RandomCase c = random_case(seed);
        RandomPart all;
        for (const RandomPart& part : c.parts) all.features |= part.features;
        if (!c.has(SettingFeature::Shutter)) all.remove(PartFeature::Moving);
        for (unsigned k = 0; k < kSettingFeatures; ++k) settings[k] += effective_settings(c) >> k & 1;
        for (unsigned k = 0; k < kPartFeatures; ++k) features[k] += all.features >> k & 1;
    }
    for (unsigned k = 0; k < kSettingFeatures; ++k) EXPECT_GE(settings[k], 2) << "setting " << k;
    for (unsigned k = 0; k < kPartFeatures; ++k) EXPECT_GE(features[k], 2) << "feature " << k;
}

TEST(RandomCases, AreTheSameForASeedAndShrinkToWhatFails)
{
    EXPECT_EQ(description(random_case(5)), description(random_case(5)));
    EXPECT_NE(description(random_case(5)), description(random_case(6)));
    // The fault needs a mirrored part and path tracing.
    const CaseCheck check = [](const RandomCase& c) {
        bool has = false;
        for (const RandomPart& part : c.parts) has |= part.has(PartFeature::Mirrored);
        return std::string(has && c.has(SettingFeature::Path) ? "fault" : "");
    };
    std::uint64_t seed = 1;
    while (check(random_case(seed)).empty()) ++seed;
    const RandomCase least = shrunk(random_case(seed), check);
    ASSERT_EQ(least.parts.size(), 1u);
    EXPECT_EQ(least.parts[0].features, 1u << static_cast<unsigned>(PartFeature::Mirrored));
    EXPECT_EQ(least.settings, 1u << static_cast<unsigned>(SettingFeature::Path));
}

}  // namespace
}  // namespace occam::test
