#include "shade/direct.h"

#include <limits>

namespace occam::shade {

LightSample sample_of(const Environment::Light& light) noexcept
{
    if (!(light.density > 0)) return {};
    return {light.direction, std::numeric_limits<float>::infinity(), light.radiance / light.density, light.density};
}

ShadowTest test_meshes(const SurfaceForEye& surface, const MeshLights& lights, const Receiver& receiver,
                       LightNumbers numbers, SampleCounts counts) noexcept
{
    return test_of(surface, lights.sample(surface.surface.front_start(), receiver, numbers), counts);
}

ShadowTest test_environment(const SurfaceForEye& surface, const Environment& environment, LightNumbers numbers,
                            SampleCounts counts) noexcept
{
    if (!environment.has_density()) return {};
    return test_of(surface, sample_of(environment.draw(numbers.square)), counts);
}

}  // namespace occam::shade
