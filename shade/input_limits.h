// Limits of what a scene may ask for, so that no sum of a picture overflows. Values beyond them are clamped where they
// are read, and counted in a warning.
//
// Space    world; colours linear.
// Threads  any.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "base/vec.h"
#include "scenegraph/frame_scale.h"

namespace occam {
class Scene;
class TextureStore;
}  // namespace occam

namespace occam::shade {

/// The brightest radiance, irradiance or intensity of a light, an environment or a material. Intensities are those in the
/// frame's unit of length.
inline constexpr float kMaxRadiance = 1e12f;

/// Returns the colour with no channel above kMaxRadiance. A channel that is below 0, as texels of floats may be, or not a
/// number becomes 0.
inline Vec3f limited(Vec3f c) noexcept
{
    for (int i = 0; i < 3; ++i) c[i] = c[i] > 0 ? std::min(c[i], kMaxRadiance) : 0.0f;
    return c;
}

/// Returns a line for each kind of value that is clamped, with a count: lights, environments and emissions beyond
/// kMaxRadiance, alone or times their brightest texel, base colours above 1 of materials that reflect, and what else is
/// beyond scenegraph/material_limits.h. Another line counts the lights that are left out because they are too far away
/// (WorldLight::is_in_reach), one the nodes that reach beyond kMaxCoordinate while the shutter is open, one the nodes beyond
/// kMaxCoordinate beside which all that is nearer vanishes, and one those whose place is not finite. The scene must be
/// refitted.
/// textures   those of the scene; one that no lookup has asked for, or that is read in tiles, counts as black
/// scale      that of the frame, in whose unit the intensities of point lights are limited
std::vector<std::string> input_warnings(const Scene& scene, const TextureStore& textures, float sky_strength,
                                        const FrameScale& scale);

}  // namespace occam::shade
