#include "shade/direct.h"

#include <algorithm>
#include <limits>

namespace occam::shade {

ShadowTest sample_light(const Surface& surface, const WorldLight& light, LightNumbers numbers) noexcept
{
    const LightSample sample = light.sample(surface.origin, numbers);
    if (sample.radiance == Vec3f(0)) return {};
    return {surface.origin, sample.direction, sample.distance, reflect(surface, sample.direction) * sample.radiance};
}

// Two ways to choose a direction are weighted by both densities (one-sample balance heuristic, Veach and Guibas
// 1995, sec. 3).
ShadowTest sample_environment(const Surface& surface, const Environment& environment, LightNumbers numbers) noexcept
{
    const bool two_ways = environment.has_density();
    Vec3f direction;
    if (two_ways && numbers.choice < 0.5f) {
        direction = environment.sample(numbers.square);
    } else {
        const float lobe = two_ways ? std::max(0.0f, numbers.choice * 2 - 1) : numbers.choice;
        direction = sample_direction(surface, lobe, numbers.square);
    }
    float density = direction_density(surface, direction);
    if (two_ways) density = 0.5f * (density + environment.density(direction));
    if (!(density > 0)) return {};
    return {surface.origin, direction, std::numeric_limits<float>::infinity(),
            reflect(surface, direction) * environment.radiance(direction) / density};
}

}  // namespace occam::shade
