// Which of a material's maps hold directions, and by which texture coordinates these are turned on a surface.
#pragma once

#include <algorithm>

#include "base/vec.h"
#include "scenegraph/material.h"

namespace occam {

/// Holds the directions in which texture coordinates grow at a point, across the outward shading normal n.
struct MapTangent {
    Vec3f along{0};   ///< unit, where u grows; zero: unknown
    float sign = 1;   ///< of cross(n, along), along which v decreases
    Vec2f v_axis{0};  ///< dP/dv over the length of dP/du: along `along`, and along cross(n, along)
};

inline int coordinates_of(const TextureUse& use) noexcept { return std::clamp(use.uv_set, 0, 1); }

/// Returns the set of coordinates that gives a material's directions their axes, or -1 if it has none: that of the normal
/// map, else of the coat's, else of the brush strokes.
inline int axes_set_of(const Material& m) noexcept
{
    const TextureUse& use = m.normal_texture ? m.normal_texture : m.clearcoat_normal_texture;
    if (use) return coordinates_of(use);
    return m.anisotropy > 0 ? coordinates_of(m.anisotropy_texture) : -1;
}
/// Returns whether a map takes its axes from the other set than axes_set_of().
inline bool has_other_axes(const Material& m, const TextureUse& use) noexcept
{
    return use && coordinates_of(use) != axes_set_of(m);
}
/// Returns whether any of its maps of directions does.
inline bool any_has_other_axes(const Material& m) noexcept
{
    return (m.clearcoat > 0 && has_other_axes(m, m.clearcoat_normal_texture)) ||
           (m.anisotropy > 0 && has_other_axes(m, m.anisotropy_texture));
}
/// Returns whether the coordinates of any of its maps of directions are rotated.
inline bool turns_axes(const Material& m) noexcept
{
    return m.normal_texture.rotation != 0 || m.clearcoat_normal_texture.rotation != 0 || m.anisotropy_texture.rotation != 0;
}

}  // namespace occam
