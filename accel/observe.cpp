// Traces one ray alone, and tells what it does.
#include <limits>
#include <sstream>

#include "accel/holes.h"
#include "accel/narration.h"
#include "accel/run_rays.h"
#include "base/stopwatch.h"

namespace occam::accel {

RayCost Tracer::observe(const Ray& ray, SurfaceHit& hit, std::ostream* out)
{
    State& s = *state_;
    RayCost cost;
    hit.t = std::numeric_limits<float>::infinity();
    s.for_groups({&ray, 1}, [&](const RayAxes& axes, std::size_t, std::size_t, std::size_t memory_bytes) {
        std::ostringstream text;
        std::optional<Narration> narration;
        if (out) narration.emplace(text, s.frame);
        SingleQuery<ObservedNearest> query;
        const Holes holes(s.frame, {&ray, 1}, axes, s.single_levels);
        s.prepare(query, {&ray, 1}, holes);
        query.narration = narration ? &*narration : nullptr;
        const std::uint64_t visited = s.counters.kd_visited, built = s.counters.grids;
        double seconds = 0;
        {
            const Stopwatch watch(seconds);
            if (!s.in_tree([&](auto way) { return s.run_single<decltype(way)>(ray, axes, memory_bytes, query); })) {
                if (out)
                    *out << "  (The memory is used up: everything that was built is dropped, and the ray starts again.)\n";
                return false;
            }
        }
        cost = query.cost;
        cost.nodes = s.counters.kd_visited - visited;
        cost.igrids_built = s.counters.grids - built;
        cost.seconds = seconds;
        GridHit met{query.t[0], query.grid[0], query.id[0], {}, {}, 0};
        if (met.grid && met.grid->blends()) met.blend = s.single_levels.blend(met.grid->pairs.finest);
        else if (met.grid && s.frame.has_levels)
            met.level = met.grid->is_lattice || s.single_levels.reaches(met.t) > 0
                            ? static_cast<int>(s.single_levels.nearest_level(met.t))
                            : kAnyLevel;
        if (met.grid && met.grid->segments > 0) met.time = lod::key_time(ray.time, met.grid->segments);
        SurfaceHit* const to = &hit;
        resolve({&ray, 1}, axes, {&met, 1}, s.lazy.phase_one(), &to);
        if (!s.is_within(memory_bytes)) return false;
        if (out) *out << text.str();
        return true;
    });
    return cost;
}

}  // namespace occam::accel
