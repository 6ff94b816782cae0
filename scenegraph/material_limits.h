// The limits of what a material may ask for. Values beyond them are clamped where they are read, and counted in a warning
// (shade/input_limits.h).
//
// Threads  any.
#pragma once

#include "scenegraph/material.h"

namespace occam {

/// The largest index of refraction. That of no dielectric is above 5; the index itself and its inverse are squared.
inline constexpr float kMaxIor = 100;
/// The largest scale of a normal map, of either sign. The map then has only slopes that are nearly vertical.
inline constexpr float kMaxNormalScale = 1e4f;
/// The largest number in the transform of a texture, of either sign. Beyond it floats do not tell a texel from its
/// neighbours; the transform is used as it is.
inline constexpr float kMaxTextureTransform = 1e6f;

/// Returns whether the base colour is within [0, 1].
bool has_base_color_within_limits(const Material& material) noexcept;
/// Returns whether the other factors of a material that reflects are within their limits: its alpha and the colours of sheen
/// and attenuation up to 1, a reflectance at normal incidence of up to 1, kMaxIor and kMaxNormalScale.
bool has_factors_within_limits(const Material& material) noexcept;
/// Returns whether the transforms of the textures that it uses are within kMaxTextureTransform.
bool has_transforms_within_limits(const Material& material) noexcept;

}  // namespace occam
