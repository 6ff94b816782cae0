// Tests that a renderer that has seen all frames before shows the scene as a new one does, whatever was edited in between.
//
// OCCAM_SEED=n tests that seed alone. With OCCAM_LONG=1 seeds follow one another for a third of OCCAM_CAMPAIGN_SECONDS (ten
// minutes).
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <iostream>
#include <optional>

#include "tests/support/campaign.h"
#include "tests/support/random_world.h"

namespace occam::test {
namespace {

/// Edits a scene and renders it in turns. After each frame the same edits are made in a new scene that was never rendered.
void expect_frames_of_new_scenes(std::uint64_t seed, int frames)
{
    RandomWorld world(seed);
    Renderer renderer({.threads = 2, .memory_bytes = std::size_t(1) << 30});
    std::vector<const char*> edits;
    for (int frame = 0; frame < frames && !testing::Test::HasFailure(); ++frame) {
        for (int k = 0; k <= frame % 3; ++k) edits.push_back(world.edit());
        RandomWorld other(seed);
        for (std::size_t k = 0; k < edits.size(); ++k) ASSERT_STREQ(other.edit(), edits[k]);
        std::string history;
        for (const char* edit : edits) history += std::string("; ") + edit;
        SCOPED_TRACE("OCCAM_SEED=" + std::to_string(seed) + ", frame " + std::to_string(frame) + history);
        const auto checksum = [](RandomWorld& of, Renderer& by) -> std::optional<std::uint64_t> {
            try {
                const Camera camera = of.camera();
                return by.render(of.scene(), camera, of.settings()).checksum();
            } catch (const Error& error) {
                ADD_FAILURE() << error.what();
                return {};
            }
        };
        Renderer fresh({.threads = 1, .memory_bytes = std::size_t(1) << 30});
        EXPECT_EQ(checksum(world, renderer), checksum(other, fresh));
    }
}

TEST(RandomEdits, ShowWhatANewRendererShowsOfANewScene)
{
    if (const char* seed = std::getenv("OCCAM_SEED"))
        return expect_frames_of_new_scenes(std::strtoull(seed, nullptr, 10), 30);
    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + std::chrono::seconds(number_from("OCCAM_CAMPAIGN_SECONDS", 600)) / 3;
    std::uint64_t seed = 1;
    for (; (is_long() ? Clock::now() < end : seed <= 4) && !HasFailure(); ++seed)
        expect_frames_of_new_scenes(seed, is_long() ? 30 : 12);
    if (is_long()) std::cout << "tested seeds 1 to " << seed - 1 << '\n';
}

}  // namespace
}  // namespace occam::test
