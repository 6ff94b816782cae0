// What a ray has met, while it travels; and what of that phase two needs, by value.
#pragma once

#include <cfloat>
#include <mutex>

#include "accel/frame_state.h"
#include "accel/igrid.h"
#include "accel/ray_lanes.h"
#include "accel/tracer.h"

namespace occam::accel {

/// The order of micropolygons that a ray meets at the same distance: any order will do, if it is always the same.
bool comes_before(const IGrid& a, std::uint32_t a_id, const IGrid& b, std::uint32_t b_id) noexcept;

/// t of a lane that has no ray, or that is done: finite, so that arithmetic on it gives no NaN.
inline constexpr float kDead = -FLT_MAX;

/// Rays of the largest packet.
inline constexpr int kPacket = 2 * kLanes;

/// Nearest hits so far of up to kPacket rays.
struct Nearest {
    alignas(32) float t[kPacket];  ///< t_far of the ray, until something is met
    IGrid* grid[kPacket];
    std::uint32_t id[kPacket];

    void offer(int lane, float found, IGrid& on, std::uint32_t number) noexcept
    {
        if (found > t[lane] || (found == t[lane] && (!grid[lane] || !comes_before(on, number, *grid[lane], id[lane]))))
            return;
        t[lane] = found;
        grid[lane] = &on;
        id[lane] = number;
    }
};

/// Whether anything was met: such a ray's t becomes kDead.
struct AnyHit {
    alignas(32) float t[kPacket];

    void offer(int lane, float found, IGrid&, std::uint32_t) noexcept
    {
        if (found < t[lane]) t[lane] = kDead;
    }
};

/// What a ray has met in the end.
struct Met {
    float t;
    IGrid* grid;  ///< null: nothing
    std::uint32_t id;
    lod::Blend<float> blend;  ///< of the ray in the grid's pair, if the grid blends
};

/// The edge lengths that a ray's levels are chosen by. A ray without a width has the camera's.
inline lod::Footprint wanted_of(const Ray& ray, const lod::LevelSettings& levels) noexcept
{
    lod::Footprint f = ray.footprint;
    if (f.a <= 0 && f.b == 0)
        f = {levels.pixel.at(static_cast<float>(glm::distance(ray.origin, levels.eye))), levels.pixel.b};
    if (levels.mode == lod::LevelMode::Frozen && !(ray.kinds & RayKind::Camera)) f.b = 0;
    return levels.wanted(f);
}

/// What phase one is run with.
struct PhaseOneTools {
    const FrameState& frame;
    lod::Dicer& dicer;
    Arena& arena;
    TraceCounters& counters;
    std::mutex* building;  ///< held meanwhile; null: nobody else meets these igrids
};

/// Whether it is a T-vertex's triangle, which has no area.
inline bool is_closer(std::uint32_t id) noexcept { return (id & kCloserBit) != 0; }
inline bool is_closer(const Met& met) noexcept { return is_closer(met.id); }
/// The micropolygon, or the one that a T-vertex's triangle stands for.
inline std::uint32_t number_of(const IGrid& grid, std::uint32_t id) noexcept
{
    return is_closer(id) ? grid.hanging_quads[id & ~kCloserBit] : id;
}

/// Where the micropolygon is that a ray has met, or the one that a T-vertex's triangle stands for.
struct Spot {
    std::uint32_t number;
    std::uint32_t face;  ///< of the cage
    IGridPart* part;     ///< null: a mesh's triangle
    int i, j, triangle;  ///< as QuadRef, in the part

    void set(const Met& met) noexcept
    {
        number = face = number_of(*met.grid, met.id);
        part = nullptr;
        if (!met.grid->is_lattice) return;
        part = &met.grid->parts[part_of(number)];
        face = part->tile.patch.face;
        const QuadRef quad = quad_of(number);
        i = quad.i;
        j = quad.j;
        triangle = quad.triangle;
    }
};

/// Fills hits from the micropolygons that up to kLanes rays of a group have met. Runs phase one on their patches if they are
/// the first hits there. hits: of rays that have met something; the others' are left alone.
void resolve(std::span<const Ray> rays, const RayAxes& axes, std::span<const Met> met, const PhaseOneTools& tools,
             SurfaceHit* const* hits);

}  // namespace occam::accel
