// Holds a ray as it is asked about.
//
// Space    world axes and frame lengths (scenegraph/frame_scale.h).
#pragma once

#include <cstdint>
#include <limits>

#include "base/vec.h"
#include "lod/footprint.h"
#include "scenegraph/scene.h"

namespace occam::accel {

using occam::RayKind;

/// Names one side of the faces of a placed cage, by an odd number if it is the back; 0 names none. Two cages may have the
/// same name by chance, one pair in 32,767.
using SideName = std::uint16_t;
inline SideName side_name(std::uint32_t hash_of_cage, bool is_back) noexcept
{
    return static_cast<SideName>((hash_of_cage % 0x7fff + 1) << 1 | unsigned(is_back));
}
inline SideName other_side(SideName side) noexcept { return side != 0 ? static_cast<SideName>(side ^ 1u) : side; }

/// The start level of a ray that may start anywhere.
inline constexpr std::int8_t kAnyLevel = std::numeric_limits<std::int8_t>::min();

struct Ray {
    Vec3d origin{0};
    Vec3f direction{0, 0, -1};  ///< unit length
    float t_near = 0;
    float t_far = std::numeric_limits<float>::infinity();
    /// The full width of the beam along the ray. If it is not set, the camera's footprint at the origin is used.
    lod::Footprint footprint;
    /// The purposes of the ray; surfaces that none of these kinds may see are not hit.
    std::uint8_t kinds = RayKind::All;
    /// The ray sees cages at this level around its origin, and then goes over to the level that its footprint asks for.
    /// A secondary ray has the level of the mesh on which its origin lies: SurfaceHit::start_level.
    std::int8_t start_level = kAnyLevel;
    /// The side of a cage on which the ray starts (SurfaceHit::side). It decides which side of the same cage a ray with a
    /// t_near of 0 has met first, where blending has turned a micropolygon over.
    SideName start_side = 0;
    /// The moment at which the ray sees the scene: 0 when the shutter opens, 1 when it closes.
    float time = 0;
    /// If this is above 0, start_level holds not around the ray's origin but around the place at this distance, at which the
    /// ray starts or ends: the focus of a lens, where its beam is thinnest. `footprint.a` may then be below 0.
    float focus = 0;
};

/// Returns the t_near of the rest of a ray behind a hit. The interval of a ray is open at its near end, so rounding of t
/// cannot find the hit again.
inline float behind(float t) noexcept { return t * (1 + 4 * std::numeric_limits<float>::epsilon()); }

}  // namespace occam::accel
