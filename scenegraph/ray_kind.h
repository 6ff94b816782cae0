// What a ray is for, as bits: by them parts of a scene are hidden from some rays alone.
#pragma once

#include <cstdint>

namespace occam {

struct RayKind {
    static constexpr std::uint8_t Camera = 1;        ///< also behind surfaces that let it pass straight on
    static constexpr std::uint8_t Shadow = 2;        ///< towards a light, or of ambient occlusion
    static constexpr std::uint8_t Reflection = 4;    ///< from a mirror, a glossy layer or a coat
    static constexpr std::uint8_t Transmission = 8;  ///< bent or scattered through a surface
    static constexpr std::uint8_t Diffuse = 16;
    static constexpr std::uint8_t All = 31;
};

/// Light groups, as bits. Of a light: those it belongs to. Of a node: those it is lit by.
using LightGroups = std::uint32_t;
inline constexpr LightGroups kAllGroups = ~LightGroups(0);

}  // namespace occam
