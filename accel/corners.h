// Gathers the corners of the micropolygons that rays have hit, one lane per ray, together with their materials.
//
// Positions are blended as the ray sees them. Normals and texture coordinates come from phase one of shading, which
// runs on a patch at the first hit there.
//
// Space    Positions are in the dicing frame of the lane's cage; normals are in world space. Lanes without a hit hold
//          zeros.
#pragma once

#include <span>

#include "accel/grid_hit.h"
#include "accel/phase_one.h"
#include "accel/ray_lanes.h"

namespace occam::accel {

/// Holds up to four floats per lane, side by side.
using LaneFours = float[kLanes][4];
inline void load(const LaneFours& from, vfloat (&to)[4]) noexcept
{
    const float* lanes[kLanes];
    for (int lane = 0; lane < kLanes; ++lane) lanes[lane] = from[lane];
    load_turned(lanes, to);
}

struct HitCorners {
    alignas(32) FloatLanes position[3][3];  ///< corner, axis
    /// Holds the same micropolygon, in the lanes of has_start, in the mesh of the level at which secondary rays start.
    /// A gap triangle, which has no area, is replaced here by a triangle of the quad beside it.
    alignas(32) FloatLanes start[3][3];
    FloatLanes weight[3];  ///< the share of the coarse position at the corner
    /// The normal of each corner, of unit length, or 0 where there is none. It is valid if any lane has normals.
    LaneFours normal[3];
    LaneFours uv[2][3];                   ///< set, corner; a set is valid if any lane has it
    Vec4f color[kLanes][3];               ///< valid in the lanes of has_color
    const Material* material[kLanes];     ///< valid in lanes with a hit
    unsigned has_uv[2]{}, has_color = 0;  ///< bit masks of lanes
    unsigned has_normals = 0;             ///< lanes in which some normal may be other than 0
    unsigned has_start = 0;               ///< lanes in which `start` may differ from `position`

    /// Finds the corners of the micropolygons that up to kLanes rays have hit; `spots` says where these are.
    HitCorners(std::span<const GridHit> met, const MicropolygonPlace* spots) noexcept;
    /// Takes the rays, each in the frame of its cage. Bit i of coarse_starts says that the start level of lane i is the
    /// coarser level of the pair that the ray has hit.
    void set_positions(const vfloat (&direction)[3], const vfloat (&origin)[3], vfloat shift,
                       unsigned coarse_starts) noexcept;
    struct Corners {
        Vec3f of[3];
    };
    /// Returns the corners of a lane's micropolygon in the mesh of one level of its pair, or of the triangle that replaces a
    /// gap triangle. They are in the dicing frame of its cage, also if that is a still pose.
    Corners at_level(std::size_t lane, bool is_coarse) noexcept;
    /// Move the positions, or the normals, of a lane from a still pose to the world; positions are then relative to the
    /// anchor of `pose`.
    void move_positions(std::size_t lane, const lod::AffinePose& pose) noexcept;
    void move_normals(std::size_t lane, const lod::AffinePose& pose) noexcept;
    /// Fills in the remaining attributes and the materials. Runs phase one on patches that have their first hits here.
    void set_attributes(const PhaseOneTools& tools);
    /// Does the same where phase one has run.
    void set_attributes(const Scene& scene) noexcept;

    /// Returns the velocity of a place in a lane whose igrid moves, by the shares of the micropolygon's corners: world
    /// length per shutter.
    Vec3f velocity_of(std::size_t lane, Vec3f share) const noexcept;

    Vec3f position_of(int corner, std::size_t lane) const noexcept
    {
        return {position[corner][0][lane], position[corner][1][lane], position[corner][2][lane]};
    }

private:
    /// Holds the indices of the vertices of a lattice micropolygon.
    struct Vertices {
        std::uint32_t of[3];
        Vertices(const IGridPart& part, const MicropolygonPlace& spot) noexcept;
    };
    /// Holds what is gathered beside the fine positions. Lanes that do not blend have zeros.
    struct Gathered {
        alignas(32) FloatLanes coarse[3][3], ramp_start, scale;
        alignas(32) FloatLanes blends;      ///< 1 in lanes whose igrid blends
        unsigned blended = 0, special = 0;  ///< bit masks: lanes that blend, and lanes with a T-vertex
        Gathered() noexcept;
    };
    void gather_mesh(std::size_t lane) noexcept;
    void gather_lattice(std::size_t lane, Gathered& to) noexcept;
    /// Blends the positions of all lanes, and sets `start`.
    void blend_positions(const Gathered& of, const VertexBlend& blend, unsigned coarse_starts) noexcept;
    void set_special(std::size_t lane, const VertexBlendOf<float>& blend, bool starts_coarse) noexcept;
    /// Moves the T-vertices among a lane's corners to where the neighbouring triangles have them.
    void set_hanging(FloatLanes (&to)[3][3], std::size_t lane, const VertexBlendOf<float>& blend) noexcept;
    // Functions for lanes whose igrids move.
    void set_moving(std::size_t lane, const Vertices& vertices, FloatLanes (&coarse)[3][3]) noexcept;
    void set_moving_normals(std::size_t lane, const std::ptrdiff_t (&i)[3], const std::ptrdiff_t (&j)[3],
                            std::ptrdiff_t halved) noexcept;
    /// Sets which attributes the lanes have, and their materials.
    void note_attributes(const Scene& scene) noexcept;
    void set_attributes_of_mesh(std::size_t lane) noexcept;
    void set_attributes_of_lattice(std::size_t lane) noexcept;
    void set_normals_of_mesh(std::size_t lane) noexcept;
    void set_colors(std::size_t lane) noexcept;

    std::span<const GridHit> met_;
    const MicropolygonPlace* spots_;
    unsigned lattices_ = 0, meshes_ = 0;  ///< bit masks of lanes with a hit on either
};

}  // namespace occam::accel
