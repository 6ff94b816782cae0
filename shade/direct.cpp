#include "shade/direct.h"

#include <limits>

namespace occam::shade {

ShadowTest test_meshes(const SurfaceForEye& surface, const MeshLights& lights, const Receiver& receiver,
                       LightNumbers numbers, SampleCounts counts) noexcept
{
    return test_of(surface, lights.sample(surface.surface.position, receiver, numbers), counts);
}

ShadowTest test_environment(const SurfaceForEye& surface, const Environment& environment, LightNumbers numbers,
                            SampleCounts counts) noexcept
{
    if (!environment.has_density()) return {};
    const Environment::Light light = environment.draw(numbers.square);
    if (!(light.density > 0)) return {};
    const LightSample sample{light.direction, std::numeric_limits<float>::infinity(), light.radiance / light.density,
                             light.density};
    return test_of(surface, sample, counts);
}

}  // namespace occam::shade
