// What the corners of the micropolygons that rays have met carry, a lane for each ray's.
//
// Positions are blended as the ray sees them. Normals and coordinates are phase one's, which runs on a patch at the first hit there.
//
// Space    positions: the dicing frame of the lane's cage. Normals: world.   Lanes without a hit: zero.
#pragma once

#include "accel/hit.h"

namespace occam::accel {

using FloatLanes = float[kLanes];
inline VecLanes load(const FloatLanes (&v)[3]) noexcept { return {vfloat::load(v[0]), vfloat::load(v[1]), vfloat::load(v[2])}; }

struct Corners {
    alignas(32) FloatLanes position[3][3];  ///< corner, axis
    FloatLanes weight[3];                   ///< how far the corner has gone to its coarse position
    FloatLanes normal[3][3];                ///< unit, or of a mesh: any length
    FloatLanes uv[2][3][2];                 ///< set, corner, axis
    Vec4f color[kLanes][3];                 ///< of lanes in has_color
    unsigned has_uv[2]{}, has_color = 0;    ///< lanes

    Corners() noexcept;
    /// met   of up to kLanes rays, each in its cage's frame: direction, origin, shift
    void set_positions(std::span<const Met> met, const vfloat (&direction)[3], const vfloat (&origin)[3], vfloat shift) noexcept;
    /// The rest of a lane. Runs phase one on its patch if it is the first hit there.
    void set_attributes(std::size_t lane, const Met& met, const PhaseOneTools& tools);

    Vec3f position_of(int corner, std::size_t lane) const noexcept
    {
        return {position[corner][0][lane], position[corner][1][lane], position[corner][2][lane]};
    }
};

/// Where the corners of a quad's two triangles are, in quads.
inline constexpr int kQuadCorners[2][3][2] = {{{0, 0}, {1, 0}, {1, 1}}, {{0, 0}, {1, 1}, {0, 1}}};

}  // namespace occam::accel
