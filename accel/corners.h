// What the corners of the micropolygons that rays have met carry, a lane for each ray's; and their materials.
//
// Positions are blended as the ray sees them. Normals and coordinates are phase one's, which runs on a patch at the first
// hit there.
//
// Space    positions: the dicing frame of the lane's cage. Normals: world.   Lanes without a hit: zero.
#pragma once

#include "accel/hit.h"

namespace occam::accel {

using FloatLanes = float[kLanes];
inline VecLanes load(const FloatLanes (&v)[3]) noexcept
{
    return {vfloat::load(v[0]), vfloat::load(v[1]), vfloat::load(v[2])};
}

/// Up to four floats a lane, side by side.
using LaneFours = float[kLanes][4];
inline void load(const LaneFours& from, vfloat (&to)[4]) noexcept
{
    const float* lanes[kLanes];
    for (int lane = 0; lane < kLanes; ++lane) lanes[lane] = from[lane];
    load_turned(lanes, to);
}

struct Corners {
    alignas(32) FloatLanes position[3][3];  ///< corner, axis
    /// The same micropolygon, in lanes of has_start, in the mesh of the level that secondary rays start at. A T-vertex's
    /// triangle, which has no area, leaves this to a triangle of the quad beside it.
    alignas(32) FloatLanes start[3][3];
    FloatLanes weight[3];                 ///< how far the corner has gone to its coarse position
    LaneFours normal[3];                  ///< of each corner: unit, or of a mesh: any length
    LaneFours uv[2][3];                   ///< set, corner
    Vec4f color[kLanes][3];               ///< of lanes in has_color
    const Material* material[kLanes];     ///< of lanes with a hit
    unsigned has_uv[2]{}, has_color = 0;  ///< lanes
    unsigned has_start = 0;               ///< lanes in which `start` may differ from `position`

    /// Corners of what up to kLanes rays have met, and where.
    Corners(std::span<const Met> met, const Spot* spots) noexcept;
    /// Takes the rays, each in its cage's frame. Bit i of coarse_starts says that the start level of lane i is the coarser
    /// one of the pair that it has met.
    void set_positions(const vfloat (&direction)[3], const vfloat (&origin)[3], vfloat shift,
                       unsigned coarse_starts) noexcept;
    /// The rest, and materials. Runs phase one on patches if these are the first hits there.
    void set_attributes(const PhaseOneTools& tools);

    Vec3f position_of(int corner, std::size_t lane) const noexcept
    {
        return {position[corner][0][lane], position[corner][1][lane], position[corner][2][lane]};
    }

private:
    /// The numbers of a lattice micropolygon's vertices.
    struct Vertices {
        std::uint32_t of[3];
        Vertices(const IGridPart& part, const Spot& spot) noexcept;
    };
    void set_special(std::size_t lane, const VertexBlendOf<float>& blend, bool starts_coarse) noexcept;
    /// Puts the T-vertices among a lane's corners where the triangles beside them have them.
    void set_hanging(FloatLanes (&to)[3][3], std::size_t lane, const VertexBlendOf<float>& blend) noexcept;
    void set_attributes_of_mesh(std::size_t lane, const Scene& scene) noexcept;
    void set_colors(std::size_t lane) noexcept;

    std::span<const Met> met_;
    const Spot* spots_;
};

/// Where the corners of a quad's two triangles are, in quads.
inline constexpr int kQuadCorners[2][3][2] = {{{0, 0}, {1, 0}, {1, 1}}, {{0, 0}, {1, 1}, {0, 1}}};

}  // namespace occam::accel
