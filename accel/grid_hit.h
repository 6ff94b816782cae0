// Holds the micropolygon that a ray has hit.
#pragma once

#include <cstdint>

#include "accel/igrid.h"
#include "lod/key_time.h"
#include "lod/ray_levels.h"

namespace occam::accel {

/// Orders micropolygons that a ray hits at the same distance: by their cages' paths in the scene graph, and within a cage by
/// number. So the scene alone decides which of them is seen.
bool comes_before(const IGrid& a, std::uint32_t a_id, const IGrid& b, std::uint32_t b_id) noexcept;

/// Holds the final hit of a ray.
struct GridHit {
    float t;
    IGrid* grid;  ///< null if nothing was hit
    std::uint32_t id;
    lod::Blend<float> blend;  ///< the ray's blend in the grid's pair, if the grid blends
    lod::KeyTime time;        ///< the ray's time among the grid's keys, if the grid moves
    /// If rays see levels and the grid does not blend: the level that the ray sees at the hit, or the nearer one of two, at
    /// which other surfaces around the hit are. It is kAnyLevel on a mesh beside everything that is diced.
    int level;

    /// Returns where the ray sees a vertex of the lattice at one of its two levels, before they are blended.
    Vec3f fine_at(std::uint32_t vertex) const noexcept
    {
        const LatticeGrid& of = grid->lattice();
        return of.segments == 0 ? of.fine_at(vertex)
                                : between(of.fine_at(vertex, time.key), of.fine_at(vertex, time.key + 1));
    }
    Vec3f coarse_at(std::uint32_t vertex) const noexcept
    {
        const LatticeGrid& of = grid->lattice();
        return of.segments == 0 ? of.coarse_at(vertex)
                                : between(of.coarse_at(vertex, time.key), of.coarse_at(vertex, time.key + 1));
    }
    /// Returns where the ray sees a corner of the triangle of a mesh that it has hit.
    Vec3f corner_at(int corner) const noexcept
    {
        const TriangleTree& mesh = grid->mesh().triangles;
        if (grid->segments == 0) return mesh.corner(id, corner);
        return between(mesh.corner(id, corner, time.key), mesh.corner(id, corner, time.key + 1));
    }
    /// Returns what lies between these values at the grid's two keys around the ray's time.
    Vec3f between(Vec3f a, Vec3f b) const noexcept
    {
        return {lod::between_keys(time.share, a.x, b.x), lod::between_keys(time.share, a.y, b.y),
                lod::between_keys(time.share, a.z, b.z)};
    }
};

/// Returns whether the micropolygon is a gap triangle, which has no area.
inline bool is_gap(std::uint32_t id) noexcept { return (id & kGapBit) != 0; }
inline bool is_gap(const GridHit& met) noexcept { return is_gap(met.id); }
/// Returns the number of the micropolygon; for a gap triangle, one with the place of its T-vertex. That of a triangle of a
/// mesh is its face.
inline std::uint32_t number_of(const IGrid& grid, std::uint32_t id) noexcept
{
    if (!grid.is_lattice) return grid.mesh().triangles.faces[id];
    return is_gap(id) ? grid.lattice().hanging_quads[id & ~kGapBit] : id;
}

/// Returns whether two ids stand for one micropolygon: a triangle of a mesh may have several places.
inline bool are_same(const IGrid& grid, std::uint32_t a, std::uint32_t b) noexcept
{
    return a == b || (!grid.is_lattice && number_of(grid, a) == number_of(grid, b));
}

/// Holds the positions of the corners of a quad's two triangles, in units of quads.
inline constexpr int kQuadCorners[2][3][2] = {{{0, 0}, {1, 0}, {1, 1}}, {{0, 0}, {1, 1}, {0, 1}}};

/// Locates the micropolygon that a ray has hit, or the T-vertex of the gap triangle that it has hit.
struct MicropolygonPlace {
    std::uint32_t number;
    std::uint32_t face;  ///< face index in the cage
    IGridPart* part;     ///< null for a triangle of a mesh
    int i, j, triangle;  ///< as in QuadRef, within the part; those of a T-vertex may be beyond its last quad

    void set(const GridHit& met) noexcept
    {
        number = face = number_of(*met.grid, met.id);
        part = nullptr;
        if (!met.grid->is_lattice) return;
        part = &met.grid->lattice().parts[part_of(number)];
        face = part->tile.patch.face;
        const QuadRef quad = quad_of(number);
        i = quad.i;
        j = quad.j;
        triangle = quad.triangle;
    }
};

}  // namespace occam::accel
