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

/// Nearest hits so far of up to kLanes rays.
struct Nearest {
    alignas(32) float t[kLanes];  ///< t_far of the ray, until something is met
    IGrid* grid[kLanes];
    std::uint32_t id[kLanes];

    void offer(int lane, float found, IGrid& on, std::uint32_t number) noexcept
    {
        if (found > t[lane] || (found == t[lane] && (!grid[lane] || !comes_before(on, number, *grid[lane], id[lane])))) return;
        t[lane] = found;
        grid[lane] = &on;
        id[lane] = number;
    }
};

/// Whether anything was met: such a ray's t becomes kDead.
struct AnyHit {
    alignas(32) float t[kLanes];

    void offer(int lane, float found, IGrid&, std::uint32_t) noexcept
    {
        if (found < t[lane]) t[lane] = kDead;
    }
};

/// What a ray has met in the end.
struct Met {
    float t;
    IGrid* grid;              ///< null: nothing
    std::uint32_t id;
    lod::Blend<float> blend;  ///< of the ray in the grid's pair, if the grid blends
};

/// What phase one is run with.
struct PhaseOneTools {
    const FrameState& frame;
    lod::Dicer& dicer;
    Arena& arena;
    TraceCounters& counters;
    std::mutex* building;  ///< held meanwhile; null: nobody else meets these igrids
};

/// Of its cage.
inline std::uint32_t face_of(const Met& met) noexcept
{
    const IGrid& grid = *met.grid;
    const std::uint32_t number = met.id & kCloserBit ? grid.hanging_quads[met.id & ~kCloserBit] : met.id;
    return grid.is_lattice ? grid.parts[part_of(number)].tile.patch.face : number;
}

/// Fills a hit from the micropolygon that was met. Runs phase one on its patch if it is the first hit there.
void resolve(const Ray& ray, const Met& met, const PhaseOneTools& tools, SurfaceHit& hit);

}  // namespace occam::accel
