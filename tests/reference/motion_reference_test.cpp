// Tests that blurred pictures of the animated reference cases are the mean of still ones (tests/support/mean_of_stills.h).
//
// Each clip of shared/reference is taken at three times, with its reference camera. By default, one time of some clips is
// tested with small pictures; OCCAM_LONG=1 tests all three times of all clips.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "tests/support/campaign.h"
#include "tests/support/mean_of_stills.h"
#include "tests/support/reference_cases.h"

namespace occam::test {
namespace {

constexpr std::size_t kOneOf = 8;             // one of so many clips is tested by default
constexpr double kTimes[] = {0.2, 0.5, 0.8};  // as parts of a clip's duration
constexpr double kOpenSeconds = 0.1;

// Returns the first case of each clip.
std::vector<ReferenceCase> animated_clips()
{
    std::vector<ReferenceCase> clips;
    std::set<std::tuple<std::filesystem::path, int>> known;
    for (ReferenceCase& c : reference_cases())
        if (c.clip >= 0 && known.insert({c.model, c.clip}).second) clips.push_back(std::move(c));
    return clips;
}

Moving moving_clip(const ReferenceCase& c, double part)
{
    Moving moving;
    moving.scene = load(c.model);
    Scene& scene = moving.scene;
    const ClipId clip = scene.clips().at(static_cast<std::size_t>(c.clip));
    const TimeRange range = time_range(scene.clip(clip));
    const double open = range.first + part * (range.last - range.first) - 0.5 * kOpenSeconds;
    moving.pose = [=](Scene& posed, double tau) { posed.pose(clip, std::max(0.0, open + tau * kOpenSeconds)); };
    moving.camera = [=](double) { return c.camera; };
    // Light that stands still: a sky and a sun.
    scene.environment.radiance = Vec3f(0.4f);
    scene.add_node(scene.root(), {.place = {.rotation = glm::normalize(Vec4d(-0.5, 0.3, 0, 0.8))},
                                  .light = scene.add(Light{"sun", SunLight{Vec3f(2)}})});
    moving.settings = {.width = 40, .height = 30, .spp = 32};
    if (is_long()) moving.settings.width = 80, moving.settings.height = 60;
    moving.settings.integrator = IntegratorKind::Direct;
    moving.settings.default_light = false;
    return moving;
}

TEST(ReferenceClips, AreBlurredAsTheMeanOfStills)
{
    const std::vector<ReferenceCase> clips = animated_clips();
    if (clips.empty()) GTEST_SKIP() << "the shared folder is absent: blurred pictures of its clips are not tested";
    int moved = 0;
    for (std::size_t i = 0; i < clips.size(); ++i)
        for (std::size_t k = 0; k < std::size(kTimes); ++k) {
            if (!is_long() && (i % kOneOf != 0 || k != i / kOneOf % std::size(kTimes))) continue;
            Moving moving = moving_clip(clips[i], kTimes[k]);
            const BlurComparison found = compare_with_stills(moving, {is_long() ? 32 : 16, moving.settings.spp});
            moved += found.blur > 1e-5;
            // One in 16,000 of normal errors is larger than four standard errors; these come from few samples and have
            // heavier tails.
            EXPECT_LE(found.exceeding, 2 + found.pixels / 1000) << clips[i].id << " at " << kTimes[k];
            EXPECT_LE(std::abs(found.difference), 4 * found.error) << clips[i].id << " at " << kTimes[k];
        }
    EXPECT_GT(moved, 0);
}

}  // namespace
}  // namespace occam::test
