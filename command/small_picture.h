// What is chosen for a picture before it is made, from small pictures of the same scene.
#pragma once

#include "arguments.h"

namespace occam::command {

/// The limit of light that was scattered twice or more, for display formats: as a multiple of the radiance that a screen
/// shows as middle white (1 after exposure).
inline constexpr float kDisplayClamp = 2;

/// Holds what small pictures ask for.
struct Measured {
    float exposure = 0;         ///< stops of render::automatic_exposure()
    bool has_default = false;   ///< the default light was added
    bool has_emitters = false;  ///< some surface of the scene is emissive
};

/// Renders the whole frame with few pixels and samples, and without limits.
Measured measure_small(const Settings& settings, const Camera& camera, Scene& scene, Renderer& renderer);

/// Returns true if the limit of scattered light is to follow from the exposure: for display formats without --clamp.
bool wants_display_clamp(const RenderArguments& arguments);
/// Returns that limit for a picture that is shown with `stops` of exposure.
float display_clamp(float stops) noexcept;

}  // namespace occam::command
