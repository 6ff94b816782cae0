// The suite measures what a memory budget costs (in the manner of Djeu et al. 2011, fig. 16): the same frame is rendered
// under fractions of the memory that it takes without a budget.
//
// Frames have 36 rays per pixel. All budgets take turns within a round, so that each frame has one without a budget beside
// it; the smallest and the largest ratio of six pairs enclose the median with 97 % confidence.
#include "tests/bench/crowd_occam.h"
#include "tests/bench/subjects.h"
#include "tests/bench/suites.h"

namespace occam::bench {
namespace {

constexpr int kPixels = 512, kRounds = 6;
constexpr double kParts[] = {1, 0.75, 0.5, 0.375, 0.25, 0.125};
constexpr std::size_t kNoBudget = std::size_t(1) << 40;

struct Budgeted {
    double part;
    OccamCrowd crowd;
    std::vector<double> seconds{};
    std::uint64_t differing = 0;
};

void run_crowd(Report& report, const Crowd& crowd, const Recipe& recipe, int pixels)
{
    const std::string name = crowd.name + " x " + std::to_string(crowd.copies) + " " + recipe.name;
    if (!report.wants(name)) return;
    OccamCrowd unbudgeted(crowd, {.threads = 1, .memory_bytes = kNoBudget});
    unbudgeted.render(0, recipe, pixels);
    const FrameStats::Memory all = unbudgeted.stats().memory;
    const auto used = double(all.arena_peak_bytes + all.queue_bytes);
    std::vector<Budgeted> budgets;
    for (const double part : kParts)
        budgets.push_back({part, OccamCrowd(crowd, {.threads = 1, .memory_bytes = static_cast<std::size_t>(used * part)})});
    std::vector<double> seconds;
    for (int round = 0; round <= kRounds; ++round) {
        // The first frame makes what is kept from frame to frame. All rounds render the same frame.
        const double start = process_seconds();
        unbudgeted.render(0, recipe, pixels);
        if (round > 0) seconds.push_back(process_seconds() - start);
        for (Budgeted& b : budgets) {
            const double begin = process_seconds();
            b.crowd.render(0, recipe, pixels);
            if (round > 0) b.seconds.push_back(process_seconds() - begin);
            b.differing += b.crowd.stats().image.checksum != unbudgeted.stats().image.checksum;
        }
    }
    const FrameStats& whole = unbudgeted.stats();
    for (const Budgeted& b : budgets) {
        const FrameStats& s = b.crowd.stats();
        Row row{"memory", name + ", " + std::to_string(b.part).substr(0, 5) + " of the memory"};
        row.add("bytes", double(s.memory.arena_peak_bytes + s.memory.queue_bytes))
            .add("cpu_seconds", b.seconds)
            .add("time_ratio", ratios(b.seconds, seconds));
        row.add("flushes", double(s.memory.flushes)).add("floor_bytes", double(s.memory.floor_bytes));
        row.add("micropolygons_ratio", double(s.built.micropolygons) / double(whole.built.micropolygons));
        row.add("kd_nodes_ratio", double(s.built.kd_nodes) / double(whole.built.kd_nodes));
        row.add("build_seconds", s.seconds.build + s.seconds.tessellate);
        row.add("unbudgeted_build_seconds", whole.seconds.build + whole.seconds.tessellate);
        row.add("pictures_that_differ", double(b.differing));
        report.add(std::move(row));
    }
}

}  // namespace

void run_budgets(Report& report)
{
    const std::optional<Cage> cage = shared_cage("subdiv/suzanne.obj");
    if (!cage) return report.add({"memory", "budgets", {}, "skipped: no shared data (set OCCAM_SHARED)"});
    run_crowd(report, Crowd("suzanne", *cage, 64, 1), kRecipes[1], kPixels);
}

}  // namespace occam::bench
