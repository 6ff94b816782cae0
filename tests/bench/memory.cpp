// The suite measures the bytes of a resident micro-triangle: all that a tracer holds once rays have touched whatever they
// can reach.

#include "tests/bench/embree_mesh.h"
#include "tests/bench/subjects.h"
#include "tests/bench/suites.h"

namespace occam::bench {

void run_memory(Report& report)
{
    for (const auto& subject : usual_subjects(288, 288)) {
        if (!report.wants(subject->name)) continue;
        const std::vector<accel::Ray> rays = subject->camera_rays();
        std::vector<accel::SurfaceHit> hits(rays.size());
        accel::Tracer tracer(*subject->frame, std::size_t(1) << 30);
        trace_closest(tracer, rays, hits);
        const std::vector<accel::Ray> diffuse = diffuse_rays(rays, hits);
        hits.resize(diffuse.size());
        trace_closest(tracer, diffuse, hits);

        const accel::TraceCounters& c = tracer.counters();
        const std::vector<Vec3f> corners = micropolygons(subject->posed);
        const EmbreeMesh mesh(corners, subject->posed.anchor);
        const double triangles = double(corners.size()) / 3;
        Row row{"memory", subject->name};
        row.add("micropolygons", double(c.micropolygons)).add("grids", double(c.grids)).add("kd_nodes", double(c.kd_nodes));
        row.add("share_of_all_micropolygons", double(c.micropolygons) / triangles);
        row.add("bytes_per_micropolygon", double(c.peak_bytes) / double(c.micropolygons));
        row.note = "Embree: triangles with vertices of their own, as in the trace suite";
        report.add(row.add("embree_bytes_per_triangle", double(mesh.bytes) / triangles));
    }
    run_budgets(report);
}

}  // namespace occam::bench
