// The suite starts cold. It traces a coarse set of rays over a large cage, and measures what the lazy tree builds for them.

#include "tests/bench/subjects.h"
#include "tests/bench/suites.h"

namespace occam::bench {

void run_build(Report& report)
{
    constexpr int kRuns = 5;
    constexpr std::uint32_t kAround = 400, kAcross = 250;
    const Subject subject("torus", torus(kAround, kAcross), 640, 360);
    std::vector<accel::Ray> rays = subject.camera_rays();
    std::size_t kept = 0;
    for (std::size_t i = 0; i < rays.size(); i += 16) rays[kept++] = rays[i];
    rays.resize(kept);
    std::vector<accel::SurfaceHit> hits(rays.size());

    accel::TraceCounters counters;
    std::vector<double> tree, dice;
    const std::vector<double> seconds = repeat(kRuns, [&] {
        accel::Tracer tracer(*subject.frame, std::size_t(1) << 30);
        trace_closest(tracer, rays, hits);
        counters = tracer.counters();
        tree.push_back(counters.build_seconds);
        dice.push_back(counters.dice_seconds);
    });

    Row topology{"build", "topology of 100,000 faces, once a cage"};
    report.add(topology.add("faces_per_s", kAround * kAcross / subject.topology_seconds));
    Row row{"build", "torus of 100,000 faces from cold"};
    row.note = "tree and dice seconds are wall time within the run";
    row.add("rays", double(rays.size())).add("kd_nodes", double(counters.kd_nodes)).add("grids", double(counters.grids));
    row.add("micropolygons", double(counters.micropolygons)).add("faces_touched", double(counters.faces_touched));
    row.add("whole_s", seconds).add("tree_s", tree).add("dice_s", dice);
    row.add("kd_nodes_per_s", per(double(counters.kd_nodes), tree));
    row.add("grids_per_s", per(double(counters.grids), dice));
    report.add(row.add("micropolygons_per_s", per(double(counters.micropolygons), dice)));
}

}  // namespace occam::bench
