#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>

#include "arguments.h"
#include "interrupt.h"
#include "progress.h"

namespace occam::command {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr float kRadians = 3.14159265f / 180;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

std::string list_of(const std::vector<std::string>& names)
{
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
    return text.empty() ? "it has none" : "it has " + text;
}

Camera choose_camera(Scene& scene, const RenderArguments& a)
{
    const float aspect = float(a.settings.width) / float(a.settings.height);
    Camera camera;
    if (a.look_at) {
        if (a.look_at->eye == a.look_at->target) throw Error("", "eye and target are the same point", "--look-at");
        if (glm::length(glm::cross(a.look_at->target - a.look_at->eye, a.up)) == 0)
            throw Error("", "up is parallel to the view", "--up");
        camera = Camera::look_at(a.look_at->eye, a.look_at->target, a.up, CameraLens{}.fov);
    } else if (const auto found = scene.camera(a.camera)) {
        camera = *found;
    } else if (!a.camera.empty()) {
        throw Error(a.scene.string(), "has no camera of that name; " + list_of(scene.camera_names()), a.camera);
    } else {
        camera = Camera::framing(scene.bounds(), aspect);
    }
    if (a.fov_deg > 0) {
        camera.lens.fov = a.fov_deg * kRadians;
        camera.lens.orthographic = false;
    }
    if (a.lens_radius > 0) {
        camera.lens.radius = a.lens_radius;
        camera.lens.focus = a.focus;
        camera.lens.blades = a.blades;
    }
    return camera;
}

// Without --size a camera that knows its aspect keeps the width and chooses the height.
void fit_height(Settings& settings, const Camera& camera)
{
    const float aspect = camera.lens.aspect;
    if (!(aspect > 0)) return;
    settings.height = std::clamp(static_cast<int>(std::lround(float(settings.width) / aspect)), 1, render::kMaxSide);
}

// The frame, watched; true if it was interrupted.
bool wait_for(Job& job, ProgressDisplay& display)
{
    bool cancelled = false;
    while (!job.wait_for(100ms)) {
        display.show(job.progress());
        if (is_interrupted() && !cancelled) {
            job.cancel();
            cancelled = true;
        }
    }
    return is_interrupted();
}

void write_stats(const std::string& file, const FrameStats& stats)
{
    const std::string text = render::to_json(stats);
    if (file == "-") {
        if (std::fputs(text.c_str(), stdout) < 0 || std::fflush(stdout) != 0)
            throw Error("", "standard output cannot be written", {}, Error::Kind::Output);
        return;
    }
    std::ofstream out(file, std::ios::binary);
    out << text;
    out.close();
    if (!out) throw Error(file, "cannot be written", {}, Error::Kind::Output);
}

void report(const FrameStats& stats, bool quiet, bool verbose)
{
    if (!stats.warnings.empty() && !verbose && !quiet && isatty(STDERR_FILENO))
        std::fprintf(stderr, "occam: %zu warnings; -v shows them\n", stats.warnings.size());
    if (!verbose) return;
    for (const std::string& warning : stats.warnings) std::fprintf(stderr, "occam: warning: %s\n", warning.c_str());
    std::fprintf(stderr, "occam: %dx%d, %d samples a pixel, %.2f s, %.2f million rays a second, checksum %016llx\n",
                 stats.image.width, stats.image.height, stats.image.spp, stats.seconds.total, stats.rays.per_second * 1e-6,
                 static_cast<unsigned long long>(stats.image.checksum));
}

}  // namespace

int run(const RenderArguments& a)
{
    catch_interrupts();
    Image::check_writable(a.output);  // before minutes of work
    ProgressDisplay display(a.progress, a.quiet);

    display.say("reading " + (a.scene.empty() ? "the built-in scene" : a.scene.string()));
    const auto load_start = Clock::now();
    Scene scene = open_scene(a);
    const double load_seconds = seconds_since(load_start);

    Settings settings = a.settings;
    const Camera camera = choose_camera(scene, a);
    if (!a.size_given) fit_height(settings, camera);
    if (is_interrupted()) return 130;

    Renderer renderer(a.resources);
    Job job = renderer.start(scene, camera, settings);
    const bool interrupted = wait_for(job, display);
    FrameStats stats = job.stats();
    stats.seconds.load = load_seconds;
    stats.seconds.total += load_seconds;

    display.say("writing " + a.output.string());
    const auto write_start = Clock::now();
    job.image().write(a.output, a.write);
    stats.seconds.write = seconds_since(write_start);
    stats.seconds.total += stats.seconds.write;
    display.end();

    if (!a.stats.empty()) write_stats(a.stats, stats);
    report(stats, a.quiet, a.verbose);
    return interrupted ? 130 : 0;
}

}  // namespace occam::command
