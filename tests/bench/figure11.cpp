// The suite measures how the three techniques of building multiply (Djeu et al. 2011, fig. 11). Each is switched on and off,
// with one thread and camera rays.
#include <algorithm>

#include "accel/frame.h"
#include "lod/topology_cache.h"
#include "render/camera_rays.h"
#include "tests/bench/crowd.h"
#include "tests/bench/subjects.h"
#include "tests/bench/suites.h"

namespace occam::bench {
namespace {

constexpr int kPixels = 512;
constexpr std::size_t kMemoryBytes = std::size_t(6) << 30;  // enough for all base patches at once

struct View {
    const char* name;
    Camera camera;
};

void run_view(Report& report, const Scene& scene, lod::TopologyCache& topologies, const View& view)
{
    const render::CameraRays camera(view.camera, kPixels, kPixels);
    const accel::Frame frame(scene, topologies, camera.levels(4));
    std::vector<accel::Ray> rays;
    for (int y = 0; y < kPixels; y += 16)
        for (int x = 0; x < kPixels; x += 16)
            for (int i = 0; i < 256; ++i) rays.push_back(camera.ray(x + i % 16 + 0.5, y + i / 16 + 0.5, Vec2f(0.5f)));
    std::vector<accel::SurfaceHit> hits(rays.size());
    double none = 0;
    std::vector<std::uint32_t> faces;
    for (int on = 0; on < 8; ++on) {
        const accel::BuildTechniques techniques{(on & 1) != 0, (on & 2) != 0, (on & 4) != 0};
        const std::string name = std::string(view.name) + ": " + (on == 0 ? "none" : "") + (techniques.lazy ? "lazy " : "") +
                                 (techniques.hierarchy ? "hierarchy " : "") + (techniques.scan ? "scan" : "");
        if (!report.wants(name)) continue;
        const double start = thread_seconds();
        accel::Tracer tracer(frame, kMemoryBytes, techniques);
        trace_closest(tracer, rays, hits);
        const double cold = thread_seconds() - start;
        // The rays go once more through what is built now, which times tracing alone. The rest was building, with posing and
        // dicing.
        std::vector<double> trace = repeat(5, [&] { trace_closest(tracer, rays, hits); });
        std::sort(trace.begin(), trace.end());
        const double build = cold - trace[trace.size() / 2];
        if (on == 0) none = build;
        const accel::TraceCounters& c = tracer.counters();
        std::size_t others = 0;
        for (std::size_t i = 0; i < hits.size(); ++i) {
            const std::uint32_t face = hits[i].is_hit() ? hits[i].face : ~0u;
            if (on == 0) faces.push_back(face);
            else if (!faces.empty()) others += faces[i] != face;
        }
        Row row{"figure11", name};
        row.add("build_seconds", build).add("trace_seconds", trace);
        row.add("times_faster_to_build_than_none", none > 0 ? none / build : 0).add("kd_nodes", double(c.kd_nodes));
        row.add("faces_touched", double(c.faces_touched))
            .add("bytes", double(c.peak_bytes))
            .add("hits_that_differ_from_none", double(others));
        report.add(std::move(row));
    }
}

}  // namespace

void run_figure11(Report& report)
{
    const std::optional<Cage> cage = shared_cage("subdiv/suzanne.obj");
    if (!cage) return report.add({"figure11", "suzanne", {}, "skipped: no shared data (set OCCAM_SHARED)"});
    const Crowd crowd("suzanne", *cage, 1210, 1);
    Scene scene;
    std::vector<Vec3f> positions;
    for (int i = 0; i < crowd.copies; ++i) {
        Cage copy = crowd.cage;
        crowd.twist(i, 1, positions);
        copy.positions = positions;
        NodeDesc desc;
        desc.place.translation = crowd.place(i);
        desc.cages = {scene.add(std::move(copy))};
        scene.add_node(scene.root(), std::move(desc));
    }
    scene.refit();
    // Topology survives frames, so it is made beforehand.
    lod::TopologyCache topologies;
    scene.for_each_placement([&](NodeId, const Node& node, const Mat4d&) {
        for (const CageId id : node.cages) topologies.get(*scene.find(id));
    });
    // One camera stands before one face, which hides all others, and one above all of them.
    const Vec3d one = crowd.place(crowd.copies / 2);
    const View views[] = {{"occluded", Camera::look_at(one + Vec3d(0, 0, 0.7), one, {0, 1, 0}, 0.5f)},
                          {"all visible", Camera::look_at(crowd.eye(), {0, 0, 0}, {0, 1, 0}, 0.78539816f)}};
    for (const View& view : views) run_view(report, scene, topologies, view);
}

}  // namespace occam::bench
