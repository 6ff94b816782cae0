#include "shade/direct.h"

#include <limits>

namespace occam::shade {

ShadowTest test_meshes(const Surface& surface, const MeshLights& lights, LightNumbers numbers, SampleCounts counts) noexcept
{
    return test_of(surface, lights.sample(surface.position, numbers), counts);
}

ShadowTest test_environment(const Surface& surface, const Environment& environment, LightNumbers numbers,
                            SampleCounts counts) noexcept
{
    if (!environment.has_density()) return {};
    LightSample sample;
    sample.direction = environment.sample(numbers.square);
    sample.distance = std::numeric_limits<float>::infinity();
    sample.density = environment.density(sample.direction);
    if (!(sample.density > 0)) return {};
    sample.radiance = environment.radiance(sample.direction) / sample.density;
    return test_of(surface, sample, counts);
}

}  // namespace occam::shade
