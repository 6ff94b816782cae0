// Lets rays pass the holes that alpha masks cut into surfaces, and the backs that a frame hides, in the middle of a
// traversal. Both are called holes here.
//
// A point that is nearer than the hit so far is asked about before it counts as a hit. The answer depends on the ray and on
// the point alone, so it is the same in a packet, alone, in any tree and at any number of lanes.
#pragma once

#include "accel/hit.h"
#include "lod/hit_filter.h"
#include "lod/ray_levels.h"

namespace occam::accel {

struct Holes {
    /// by_lane       the rays of the query, which share their axes
    /// shared_axes   must live as long as this object, like the table
    /// table         the table of transitions with which these rays are traced
    template <class F>
    Holes(const FrameState& of_frame, std::span<const Ray> by_lane, const RayAxes& shared_axes,
          const lod::RayLevels<F>& table) noexcept
        : frame(of_frame), rays(by_lane), axes(shared_axes), levels(&table), blend(&blend_of<F>)
    {
    }

    const FrameState& frame;
    std::span<const Ray> rays;
    const RayAxes& axes;
    const void* levels;
    /// Returns how the ray in a lane blends in a pair, as `levels` has it.
    lod::Blend<float> (*blend)(const void* levels, int pair, std::size_t lane) noexcept;

private:
    template <class F>
    static lod::Blend<float> blend_of(const void* levels, int pair, std::size_t lane) noexcept
    {
        const lod::Blend<F> all = static_cast<const lod::RayLevels<F>*>(levels)->blend(pair);
        if constexpr (std::is_same_v<F, float>) return all;
        else {
            float start[sizeof(F) / sizeof(float)], scale[sizeof(F) / sizeof(float)];
            all.start.store(start);
            all.scale.store(scale);
            return {start[lane], scale[lane]};
        }
    }
};

}  // namespace occam::accel
