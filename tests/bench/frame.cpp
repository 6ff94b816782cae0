// The suite renders whole frames through the public interface, with the error of few samples against many beside the time.

#include "api/include/occam/occam.h"
#include "render/compare.h"
#include "tests/bench/subjects.h"
#include "tests/bench/suites.h"

namespace occam::bench {
namespace {

constexpr int kRuns = 3, kSamples = 4, kReferenceSamples = 64;

void run_scene(Report& report, const std::string& name, Scene& scene, const Camera& camera)
{
    Renderer renderer;
    Settings settings{.width = 640, .height = 360, .spp = kSamples, .integrator = IntegratorKind::Direct};
    std::vector<double> wall, cpu;
    Image few;
    for (int i = 0; i < kRuns; ++i) {
        const double wall_start = wall_seconds(), cpu_start = process_seconds();
        few = renderer.render(scene, camera, settings);
        wall.push_back(wall_seconds() - wall_start);
        cpu.push_back(process_seconds() - cpu_start);
    }
    const FrameStats stats = renderer.stats();
    settings.spp = kReferenceSamples;
    const Image many = renderer.render(scene, camera, settings);
    const render::Difference error = render::compare(few, many, "beauty");

    Row row{"frame", name + ", 640 x 360, 4 samples"};
    row.add("wall_s", wall)
        .add("cpu_s", cpu)
        .add("threads", stats.threads)
        .add("rmse_against_64", error.rmse)
        .add("rel_mse_against_64", error.rel_mse);
    const FrameStats::Seconds& s = stats.seconds;
    row.add("build_s", s.build)
        .add("tessellate_s", s.tessellate)
        .add("trace_s", s.trace)
        .add("shade_s", s.shade)
        .add("film_s", s.film);
    row.add("rays", double(stats.rays.total())).add("micropolygons", double(stats.built.micropolygons));
    row.add("arena_peak_mb", 1e-6 * double(stats.memory.arena_peak_bytes)).add("flushes", double(stats.memory.flushes));
    row.note = "stages are the workers' summed, of the last run; the first run also makes what is kept from frame to frame";
    report.add(std::move(row));
}

}  // namespace

void run_frame(Report& report)
{
    Scene still_life = builtin_scene();
    run_scene(report, "built-in scene", still_life, still_life.camera().value_or(Camera::framing(still_life.bounds())));

    std::optional<Cage> cage = suzanne();
    if (!cage) {
        report.add({"frame", "suzanne x 64", {}, "skipped: no shared data (set OCCAM_SHARED)"});
        return;
    }
    constexpr int kSide = 8;
    Scene many;
    const CageId id = many.add(std::move(*cage));
    for (int i = 0; i < kSide * kSide; ++i) {
        NodeDesc desc;
        desc.place.translation = {3.0 * (i % kSide), 0, 3.0 * (i / kSide)};
        desc.cages = {id};
        many.add_node(many.root(), std::move(desc));
    }
    run_scene(report, "suzanne x 64", many, Camera::framing(many.bounds()));
}

}  // namespace occam::bench
