#include "arguments.h"
#include "framing.h"
#include "interrupt.h"
#include "io/output_file.h"
#include "progress.h"

namespace occam::command {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

}  // namespace

int run(const RenderArguments& a)
{
    catch_interrupts();
    check_outputs(a, {&a.output, 1});
    ProgressDisplay display(a.progress, a.quiet);

    display.say("reading " + (a.scene.empty() ? "the built-in scene" : a.scene.string()));
    const auto load_start = Clock::now();
    Scene scene = open_scene(a);
    const double load_seconds = seconds_since(load_start);
    display.end();
    print_notes(scene);

    const auto edit_start = Clock::now();
    Framing framing(scene, a);
    if (a.frame || a.time || !a.clip.empty()) framing.fit_clip();  // as in a sequence of these frames
    framing.pose();
    const Camera camera = framing.camera();
    const double edit_seconds = seconds_since(edit_start);

    const HeldInterrupts held;
    Renderer renderer(a.resources);
    Job job = renderer.start(scene, camera, framing.settings(camera));
    const Ending ending = wait_for(job, display, true);
    if (ending == Ending::Abandoned) {
        display.end();
        end_interrupted();
    }
    FrameStats stats = job.stats();
    stats.seconds.load = load_seconds;
    stats.seconds.edit = edit_seconds;
    stats.seconds.total += load_seconds + edit_seconds;

    display.say("writing " + a.output.string());
    const auto write_start = Clock::now();
    job.image().write(a.output, a.write);
    stats.seconds.write = seconds_since(write_start);
    stats.seconds.total += stats.seconds.write;
    display.end();

    if (!a.stats.empty()) write_whole(a.stats, render::to_json(stats));
    print_warnings(stats.warnings, a.verbose);
    if (a.verbose) print_figures(stats);
    return ending == Ending::Part ? kInterruptedExit : 0;
}

}  // namespace occam::command
