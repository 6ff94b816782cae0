// Holds what a ray has hit while it is being traced, and what phase two of shading needs of the hit, by value.
#pragma once

#include <algorithm>
#include <cfloat>
#include <mutex>

#include "accel/frame_state.h"
#include "accel/igrid.h"
#include "accel/ray_lanes.h"
#include "accel/tracer.h"
#include "lod/dicer.h"

namespace occam::accel {

/// Orders micropolygons that a ray hits at the same distance. Any order will do, as long as it is always the same.
bool comes_before(const IGrid& a, std::uint32_t a_id, const IGrid& b, std::uint32_t b_id) noexcept;

/// The t of a lane that has no ray or whose ray is finished. It is finite, so that arithmetic on it gives no NaN.
inline constexpr float kDead = -FLT_MAX;

/// The number of rays in the largest packet.
inline constexpr int kPacket = 2 * kLanes;

/// Says where surfaces have holes for the rays of a query (accel/holes.h).
struct Holes;
/// Returns whether the ray in a lane passes a hole of the igrid's surface at that point.
bool passes_hole(const Holes& holes, int lane, float t, IGrid& on, std::uint32_t number) noexcept;

/// Is what all queries have: igrids that may have holes are met only if `holes` is set.
struct HoleQuery {
    const Holes* holes = nullptr;
    bool is_hole(int lane, float t, IGrid& on, std::uint32_t number) const noexcept
    {
        return on.may_have_holes && passes_hole(*holes, lane, t, on, number);
    }
};

/// Holds the nearest hits so far of up to kPacket rays.
struct Nearest : HoleQuery {
    alignas(32) float t[kPacket];  ///< t_far of the ray until a hit is found
    IGrid* grid[kPacket];
    std::uint32_t id[kPacket];

    void offer(int lane, float found, IGrid& on, std::uint32_t number) noexcept
    {
        if (found > t[lane] || (found == t[lane] && (!grid[lane] || !comes_before(on, number, *grid[lane], id[lane]))))
            return;
        if (is_hole(lane, found, on, number)) return;
        t[lane] = found;
        grid[lane] = &on;
        id[lane] = number;
    }
};

/// Records only whether anything was hit: the t of such a ray becomes kDead.
struct AnyHit : HoleQuery {
    alignas(32) float t[kPacket];

    void offer(int lane, float found, IGrid& on, std::uint32_t number) noexcept
    {
        if (found < t[lane] && !is_hole(lane, found, on, number)) t[lane] = kDead;
    }
};

/// Holds the nearest hits so far of up to kPacket rays, several of each, in order of t.
struct NearestSome : HoleQuery {
    static constexpr int kMost = kMostNearest;
    struct Hit {
        float t;
        std::uint32_t id;
        IGrid* grid;
    };
    alignas(32) float t[kPacket];  ///< t_far of the ray until `wanted` hits are found, and then the t of the last of them
    int wanted = kMost;            ///< at most kMost
    int count[kPacket];
    Hit hits[kPacket][kMost];

    void offer(int lane, float found, IGrid& on, std::uint32_t number) noexcept
    {
        if (!(found <= t[lane])) return;
        Hit* list = hits[lane];
        int& n = count[lane];
        int at = n;
        while (at > 0 && goes_before(found, on, number, list[at - 1])) --at;
        // An igrid may be met twice by a ray (accel/mailboxes.h).
        if (at > 0 && list[at - 1].grid == &on && list[at - 1].id == number) return;
        if (at == wanted || is_hole(lane, found, on, number)) return;
        n = std::min(n + 1, wanted);
        for (int i = n - 1; i > at; --i) list[i] = list[i - 1];
        list[at] = {found, number, &on};
        if (n == wanted) t[lane] = list[n - 1].t;
    }

private:
    static bool goes_before(float found, const IGrid& on, std::uint32_t number, const Hit& other) noexcept
    {
        if (found != other.t) return found < other.t;
        return comes_before(on, number, *other.grid, other.id);
    }
};

/// Holds the final hit of a ray.
struct GridHit {
    float t;
    IGrid* grid;  ///< null if nothing was hit
    std::uint32_t id;
    lod::Blend<float> blend;  ///< the ray's blend in the grid's pair, if the grid blends
    lod::KeyTime time;        ///< the ray's time among the grid's keys, if the grid moves

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

/// Returns the target edge lengths by which a ray's levels are chosen. A ray without a width takes the camera's.
inline lod::Footprint target_edge_of(const Ray& ray, const lod::LevelSettings& levels) noexcept
{
    lod::Footprint f = ray.footprint;
    if (f.a <= 0 && f.b == 0)
        f = {levels.pixel.at(static_cast<float>(glm::distance(ray.origin, levels.eye))), levels.pixel.b};
    if (levels.mode == lod::LevelMode::Frozen && !(ray.kinds & RayKind::Camera)) f.b = 0;
    return levels.target_edge(f);
}

/// Holds the inputs of phase one.
struct PhaseOneTools {
    const FrameState& frame;
    lod::Dicer& dicer;
    Arena& arena;
    TraceCounters& counters;
    std::mutex* building;  ///< locked while phase one runs; null if no other thread uses these igrids
};

/// Returns whether the micropolygon is a gap triangle, which has no area.
inline bool is_gap(std::uint32_t id) noexcept { return (id & kGapBit) != 0; }
inline bool is_gap(const GridHit& met) noexcept { return is_gap(met.id); }
/// Returns the number of the micropolygon; for a gap triangle, that of the micropolygon beside it. That of a triangle of a
/// mesh is its face.
inline std::uint32_t number_of(const IGrid& grid, std::uint32_t id) noexcept
{
    if (!grid.is_lattice) return grid.mesh().triangles.faces[id];
    return is_gap(id) ? grid.lattice().hanging_quads[id & ~kGapBit] : id;
}

/// Locates the micropolygon that a ray has hit, or the one beside the gap triangle that it has hit.
struct MicropolygonPlace {
    std::uint32_t number;
    std::uint32_t face;  ///< face index in the cage
    IGridPart* part;     ///< null for a triangle of a mesh
    int i, j, triangle;  ///< as in QuadRef, within the part

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

/// Fills `hits` from the micropolygons that up to kLanes rays of a group have hit. Runs phase one on patches that have
/// their first hits here. Hits of rays that missed are not written.
void resolve(std::span<const Ray> rays, const RayAxes& axes, std::span<const GridHit> met, const PhaseOneTools& tools,
             SurfaceHit* const* hits);

}  // namespace occam::accel
