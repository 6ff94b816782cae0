// Whole frames in the kd-tree and in the tree of boxes, in turns: the built-in scene, crowds, and scenes of the shared data.
//
// One thread renders at default settings but for size and number of samples, and the CPU time of the process is measured.
// Both trees make the same picture.

#include "api/include/occam/occam.h"
#include "render/setting_rows.h"
#include "tests/bench/crowd_occam.h"
#include "tests/bench/subjects.h"
#include "tests/bench/suites.h"

namespace occam::bench {
namespace {

constexpr int kRuns = 5;

/// render(tree)   renders a frame in that tree and returns its statistics
template <class Render>
void add_row(Report& report, const std::string& name, Render&& render)
{
    if (!report.wants(name)) return;
    std::vector<double> kd, bvh;
    FrameStats in_kd, in_bvh;
    for (int run = 0; run < kRuns; ++run)
        for (const TreeKind tree : {TreeKind::Kd, TreeKind::Bvh}) {
            const double start = process_seconds();
            (tree == TreeKind::Kd ? in_kd : in_bvh) = render(tree);
            (tree == TreeKind::Kd ? kd : bvh).push_back(process_seconds() - start);
        }
    Row row{"trees", name};
    row.add("kd_cpu_s", kd).add("bvh_cpu_s", bvh).add("bvh_over_kd", ratios(kd, bvh));
    row.add("kd_trace_s", in_kd.seconds.trace).add("bvh_trace_s", in_bvh.seconds.trace);
    row.add("kd_build_s", in_kd.seconds.build).add("bvh_build_s", in_bvh.seconds.build);
    row.add("kd_arena_mb", 1e-6 * double(in_kd.memory.arena_peak_bytes));
    report.add(row.add("bvh_arena_mb", 1e-6 * double(in_bvh.memory.arena_peak_bytes)));
}

void run_scene(Report& report, const std::string& name, Scene& scene, const Camera& camera)
{
    for (const IntegratorKind kind : {IntegratorKind::Path, IntegratorKind::Ao, IntegratorKind::Direct}) {
        Renderer kd({.threads = 1, .tree = TreeKind::Kd}), bvh({.threads = 1, .tree = TreeKind::Bvh});
        const Settings settings{.width = 240, .height = 135, .spp = 4, .integrator = kind, .bounces = 6};
        add_row(report, name + ", " + std::string(render::name_of(kind)), [&](TreeKind tree) {
            Renderer& renderer = tree == TreeKind::Kd ? kd : bvh;
            renderer.render(scene, camera, settings);
            return renderer.stats();
        });
    }
}

}  // namespace

void run_trees(Report& report)
{
    Scene still_life = builtin_scene();
    run_scene(report, "built-in scene", still_life, still_life.camera().value());
    const Cage cage = suzanne().value_or(torus(24, 12));
    const Crowd crowd("crowd", cage, 64, 1), near_crowd("near crowd", cage, 1210, 0.3);
    for (const Crowd* of : {&crowd, &near_crowd}) {
        OccamCrowd kd(*of, {.threads = 1, .tree = TreeKind::Kd}), bvh(*of, {.threads = 1, .tree = TreeKind::Bvh});
        add_row(report, of->name + " of " + std::to_string(of->copies), [&](TreeKind tree) {
            OccamCrowd& with = tree == TreeKind::Kd ? kd : bvh;
            with.render(0, kRecipes[0], 256);
            return with.stats();
        });
    }
    for (const char* file : {"gltf/static/Suzanne/Suzanne.gltf", "gltf/skinned/CesiumMan/CesiumMan.glb",
                             "gltf/scenes/dutch_ship/dutch_ship_medium_1k.gltf", "gltf/scenes/room/room.glb"}) {
        if (!std::filesystem::exists(shared_folder() / file)) continue;
        Scene scene = load(shared_folder() / file);
        run_scene(report, std::filesystem::path(file).stem().string(), scene, scene.camera().value_or(framing(scene)));
    }
}

}  // namespace occam::bench
