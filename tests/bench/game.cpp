// The suite plays the game of the samples: a long sequence of small frames, each of which is new. One game keeps its
// renderer from frame to frame, as the samples do; a second one beside it makes a renderer for each frame, so the ratio is
// what is gained by keeping one.
#include <sys/resource.h>

#include <optional>

#include "samples/game/game.h"
#include "tests/bench/suites.h"

namespace occam::bench {
namespace {

constexpr int kFrames = 60;

long page_faults()
{
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_minflt;
}

// One game, and what its frames took.
struct Play {
    sample::Game game{};
    std::optional<Renderer> renderer{};
    std::vector<double> seconds{}, faults{};
    std::uint64_t picture = 0;  ///< the checksum of the last frame

    void frame(int number, const Settings& settings, int threads, bool anew)
    {
        const double clock = number / 30.0, start = process_seconds();
        const long faults_before = page_faults();
        game.step(clock);
        if (anew || !renderer) renderer.emplace(Resources{.threads = threads});
        const Image image = renderer->render(game.scene(), game.camera(clock), settings);
        seconds.push_back(process_seconds() - start);
        faults.push_back(double(page_faults() - faults_before));
        picture = image.checksum();
    }
};

}  // namespace

void run_game(Report& report)
{
    for (const int threads : {1, 2}) {
        const std::string name = threads == 1 ? "320 x 180, one thread" : "320 x 180, two threads";
        if (!report.wants(name)) continue;
        // These are the settings of samples/game/main.cpp.
        const Settings settings{
            .width = 320, .height = 180, .spp = 4, .integrator = IntegratorKind::Direct, .shading_rate = 2};
        Play kept, anew;
        for (int frame = 0; frame < kFrames; ++frame) {
            kept.frame(frame, settings, threads, false);
            anew.frame(frame, settings, threads, true);
        }
        Row row{"game", name};
        row.add("first_frame_cpu_ms", 1e3 * kept.seconds.front());
        for (Play* play : {&kept, &anew}) {  // the first frame makes the tables of the cages
            play->seconds.erase(play->seconds.begin());
            play->faults.erase(play->faults.begin());
        }
        row.add("frame_cpu_ms", times(kept.seconds, 1e3))
            .add("over_a_renderer_each_frame", ratios(kept.seconds, anew.seconds))
            .add("page_faults", kept.faults)
            .add("pictures_that_differ", kept.picture == anew.picture ? 0 : 1);
        row.note = "the median of the frames after the first, and the quickest and the slowest of them";
        report.add(std::move(row));
    }
}

}  // namespace occam::bench
