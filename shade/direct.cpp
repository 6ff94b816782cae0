#include "shade/direct.h"

#include <limits>

namespace occam::shade {
namespace {

ShadowTest test_of(const Surface& surface, const LightSample& sample, Tries tries) noexcept
{
    if (sample.radiance == Vec3f(0)) return {};
    const Vec3f f = scatter(surface, sample.direction);
    if (f == Vec3f(0)) return {};
    const bool is_weighed = sample.density > 0 && tries.scatter > 0;
    const float weight = is_weighed ? tries.of_light(sample.density, scatter_density(surface, sample.direction)) : 1;
    return {surface.start(sample.direction), sample.direction, sample.distance, f * sample.radiance * weight, sample.density};
}

}  // namespace

ShadowTest test_light(const Surface& surface, const WorldLight& light, LightNumbers numbers, Tries tries) noexcept
{
    return test_of(surface, light.sample(surface.position, numbers), tries);
}

ShadowTest test_meshes(const Surface& surface, const MeshLights& lights, LightNumbers numbers, Tries tries) noexcept
{
    return test_of(surface, lights.sample(surface.position, numbers), tries);
}

ShadowTest test_environment(const Surface& surface, const Environment& environment, LightNumbers numbers, Tries tries) noexcept
{
    if (!environment.has_density()) return {};
    LightSample sample;
    sample.direction = environment.sample(numbers.square);
    sample.distance = std::numeric_limits<float>::infinity();
    sample.density = environment.density(sample.direction);
    if (!(sample.density > 0)) return {};
    sample.radiance = environment.radiance(sample.direction) / sample.density;
    return test_of(surface, sample, tries);
}

}  // namespace occam::shade
