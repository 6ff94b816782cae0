// The kinds of rays, as bits. They let parts of a scene be hidden from some kinds of rays only.
#pragma once

#include <cstdint>

namespace occam {

struct RayKind {
    static constexpr std::uint8_t Camera = 1;      ///< from the camera, also beyond surfaces that it passes straight through
    static constexpr std::uint8_t Shadow = 2;      ///< towards a light, or for ambient occlusion
    static constexpr std::uint8_t Reflection = 4;  ///< from a mirror, a glossy layer or a coat
    static constexpr std::uint8_t Transmission = 8;  ///< refracted or scattered through a surface
    static constexpr std::uint8_t Diffuse = 16;
    static constexpr std::uint8_t All = 31;
};

/// Light groups, as bits. For a light they are the groups it belongs to; for a node they are the groups that light it.
using LightGroups = std::uint32_t;
inline constexpr LightGroups kAllGroups = ~LightGroups(0);

}  // namespace occam
