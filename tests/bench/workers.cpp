// The suite compares workers that have trees of their own with workers that share one: their time, their memory, and how
// much work is done more than once.
//
// Two workers and one render frames in turns, measured by the wall clock, and by CPU seconds, which do not depend on what
// else the machine does. With more workers than processors the frame is rendered all the same, and the work of each worker
// is counted. On as many processors the frame would take at most as long as its busiest worker, and at least as long as the
// mean worker, since workers take tiles from one another.
#include <algorithm>

#include "tests/bench/crowd_occam.h"
#include "tests/bench/subjects.h"
#include "tests/bench/suites.h"

namespace occam::bench {
namespace {

constexpr int kRounds = 7, kPixels = 512;

class Team {
public:
    Team(const Crowd& crowd, int threads, int workers_a_tree)
        : crowd_(crowd, {.threads = threads, .workers_a_tree = workers_a_tree})
    {
    }

    void render(const Recipe& recipe, bool counts)
    {
        const double cpu_start = process_seconds();
        const double seconds = crowd_.render(0, recipe, kPixels);
        if (!counts) return;
        wall.push_back(seconds);
        cpu.push_back(process_seconds() - cpu_start);
        double most = 0, sum = 0;
        for (const FrameStats::Worker& worker : stats().workers) {
            most = std::max(most, worker.cpu_seconds);
            sum += worker.cpu_seconds;
        }
        busiest.push_back(most);
        mean.push_back(sum / stats().threads);
        arena.push_back(double(stats().memory.arena_peak_bytes));
        kd_nodes.push_back(double(stats().built.kd_nodes));
        micropolygons.push_back(double(stats().built.micropolygons));
    }
    const FrameStats& stats() const { return crowd_.stats(); }

    std::vector<double> wall{}, cpu{}, busiest{}, mean{}, arena{}, kd_nodes{}, micropolygons{};

private:
    OccamCrowd crowd_;
};

void run_crowd(Report& report, const Crowd& crowd, const Recipe& recipe)
{
    const std::string name = crowd.name + " x " + std::to_string(crowd.copies) + " " + recipe.name;
    struct Case {
        const char* name;
        int threads, workers_a_tree;
    };
    constexpr Case kCases[] = {{"1 worker", 1, 1},
                               {"2 workers", 2, 1},
                               {"2 workers, one tree", 2, 2},
                               {"8 workers", 8, 1},
                               {"8 workers, one tree", 8, 8},
                               {"8 workers, trees for four", 8, 4},
                               {"32 workers", 32, 1},
                               {"32 workers, trees for eight", 32, 8}};
    if (!report.wants(name)) return;
    std::vector<std::unique_ptr<Team>> teams;
    for (const Case& c : kCases) teams.push_back(std::make_unique<Team>(crowd, c.threads, c.workers_a_tree));
    for (int round = 0; round <= kRounds; ++round)
        for (const auto& team : teams) team->render(recipe, round > 0);  // the first round makes what is kept
    const Team& one = *teams.front();
    for (std::size_t i = 0; i < teams.size(); ++i) {
        const Team& team = *teams[i];
        Row row{"workers", name + ", " + kCases[i].name};
        row.add("wall_seconds", team.wall).add("cpu_seconds", team.cpu).add("times_as_fast", ratios(one.wall, team.wall));
        row.add("busiest_worker_cpu_seconds", team.busiest).add("mean_worker_cpu_seconds", team.mean);
        row.add("times_as_fast_by_the_busiest_worker", ratios(one.busiest, team.busiest));
        row.add("times_as_fast_by_the_mean_worker", ratios(one.mean, team.mean));
        row.add("memory_ratio", ratios(team.arena, one.arena)).add("kd_nodes_ratio", ratios(team.kd_nodes, one.kd_nodes));
        row.add("micropolygons_ratio", ratios(team.micropolygons, one.micropolygons));
        row.add("picture_differs", double(team.stats().image.checksum != one.stats().image.checksum));
        report.add(std::move(row));
    }
}

}  // namespace

void run_workers(Report& report)
{
    const std::optional<Cage> cage = shared_cage("subdiv/suzanne.obj");
    if (!cage) return report.add({"workers", "suzanne", {}, "skipped: no shared data (set OCCAM_SHARED)"});
    run_crowd(report, Crowd("suzanne", *cage, 64, 1), kRecipes[1]);
    run_crowd(report, Crowd("suzanne", *cage, 1210, 0.3), kRecipes[0]);
}

}  // namespace occam::bench
