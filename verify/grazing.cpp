#include "verify/grazing.h"

#include <cmath>

namespace occam {

GrazingRays::GrazingRays(const Scene& scene, lod::TopologyCache& topologies, const lod::LevelSettings& levels,
                         const TextureStore* textures, float radius)
    : frame_(scene, topologies, levels, {.textures = textures}), tracer_(frame_, std::size_t(1) << 30), radius_(radius)
{
}

bool GrazingRays::explain(const accel::Ray& ray, const lod::RayLevels<float>& table)
{
    // A vertex, the middle of two others, a blend and a ray's origin are each off by half an ulp of a coordinate at most.
    const double rounding = 4 * 0x1p-24 * double(radius_);
    accel::SurfaceHit hit;
    tracer_.closest({&ray, 1}, {&hit, 1});
    if (!hit.is_hit()) return false;
    const double sine = std::abs(double(glm::dot(hit.normal_geometric, ray.direction)));
    if (!(sine > 0)) return false;
    const double reach = rounding / sine;
    for (int pair = table.finest; pair < table.coarsest; ++pair) {
        // Each of the two segments reaches a little beyond their transition.
        const double ends[4] = {table.begin(pair), table.end(pair), table.begin(pair + 1), table.end(pair + 1)};
        for (const double end : ends)
            if (std::abs(double(hit.t) - end) <= reach) return true;
    }
    return false;
}

}  // namespace occam
