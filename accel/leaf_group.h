// Holds eight boxes of a leaf, as rays of certain times are tested against them.
#pragma once

#include <algorithm>
#include <span>

#include "accel/keyed_boxes.h"
#include "accel/ray.h"
#include "accel/trace_counters.h"

namespace occam::accel {

/// Returns the times of rays, in the lanes of `Times`.
/// segments   of the scene's shutter
template <class Times>
Times times_of(std::span<const Ray> rays, [[maybe_unused]] int segments) noexcept
{
    if constexpr (!Times::kMoves) return {};
    else {
        using F = typename Times::Lanes;
        if constexpr (std::is_same_v<F, float>) return Times(rays.front().time, segments);
        else {
            alignas(32) float time[sizeof(F) / sizeof(float)];
            for (std::size_t i = 0; i < std::size(time); ++i) time[i] = rays[std::min(i, rays.size() - 1)].time;
            return Times(F::load(time), segments);
        }
    }
}

/// Eight boxes of a leaf that start with an entry, which stand still or move.
template <class F, class Times>
class LeafGroup {
public:
    /// has_boxes_of_nodes    whether the rays were tested against the box around the leaf
    /// has_boxes_of_igrids   whether boxes of igrids have replaced those of their items
    LeafGroup(const TreeLeaf& leaf, std::size_t first, const Times& times, bool has_boxes_of_nodes,
              bool has_boxes_of_igrids) noexcept
        : leaf_(leaf),
          boxes_(leaf.boxes + first / kBoxGroup * kBoxGroupFloats),
          times_(times),
          is_tested_(has_boxes_of_nodes && leaf.entries.size() == 1),
          has_boxes_of_igrids_(has_boxes_of_igrids)
    {
    }

    /// Returns, as bits, the boxes of the group if they had better not be tested against all rays of a packet as one: where
    /// there are so few of them, testing each by enter() costs less. Else returns 0.
    OCCAM_ALWAYS_INLINE unsigned few() const noexcept
    {
        constexpr std::size_t kFew = Times::kMoves ? 2 : 1;
        if (leaf_.entries.size() > kFew) return 0;
        if (is_tested_) return 1;
        if constexpr (Times::kMoves)
            if (leaf_.keys.segments > 0) return (1u << leaf_.entries.size()) - 1;
        return 0;
    }
    OCCAM_ALWAYS_INLINE unsigned in_boxes(const RaysAsOne<F>& as_one, float end, float* begin) const noexcept
    {
        if (is_tested_) {
            if (begin) begin[0] = -FLT_MAX;
            return 1;
        }
        if constexpr (Times::kMoves)
            if (leaf_.keys.segments > 0) return keyed().in_boxes(as_one, end, begin);
        return as_one.in_boxes(boxes_, end, begin);
    }
    /// Does the same for one ray of a packet.
    OCCAM_ALWAYS_INLINE unsigned in_boxes_of_lane(const RaysAsOne<float>& ray, [[maybe_unused]] int lane,
                                                  float end) const noexcept
    {
        if (is_tested_) return 1;
        if constexpr (Times::kMoves)
            if (leaf_.keys.segments > 0) {
                const RayTimes<float> time(times_, lane);
                return KeyedBoxes<float, true>(boxes_, leaf_.stride(), leaf_.keys, time).in_boxes(ray, end, nullptr);
            }
        return ray.in_boxes(boxes_, end);
    }
    /// Returns which rays enter a box of the group, and the bounds of its igrid, which is null if it is not made.
    template <class Enter>
    OCCAM_ALWAYS_INLINE MaskOf<F> enter(Enter&& enter, int box, const F& far, const TreeLeaf::Entry* made) const noexcept
    {
        if constexpr (Times::kMoves)
            if (leaf_.keys.segments > 0) {
                // A ray alone was tested by in_boxes(), with the same box unless the igrid's box has replaced it.
                const bool is_known = std::is_same_v<F, float> && !is_tested_;
                const bool has_slab = made && made->bounds.slab.hi != FLT_MAX;
                if (is_known || (is_tested_ && !made))
                    return !made || (has_boxes_of_igrids_ && !has_slab) ? MaskOf<F>(true) : enter(made->bounds, far);
                if (!made || has_boxes_of_igrids_)
                    return enter(Moving{keyed(), box, has_slab ? &made->bounds.slab : nullptr}, far);
                const MaskOf<F> in_moving = enter(Moving{keyed(), box, nullptr}, far), in_grid = enter(made->bounds, far);
                return in_moving & in_grid;
            }
        // The box of a node whose only igrid has no slab is all that bounds it: the rays here are in it already.
        if (is_tested_ && (!made || made->bounds.slab.hi == FLT_MAX)) return MaskOf<F>(true);
        return made ? enter(made->bounds, far) : enter(GridBounds{get_box(boxes_ + box, 0), {}}, far);
    }

private:
    /// A box as it is at each ray's own time.
    struct Moving {
        KeyedBoxes<F, true> group;
        int box;
        const Slab* slab;  ///< of the igrid, for all times; null if it has none
        void clip_to(const TreeRay<F>& ray, F& t_near, F& t_far) const noexcept { group.clip_to(ray, box, t_near, t_far); }
    };
    auto keyed() const noexcept { return KeyedBoxes<F, true>(boxes_, leaf_.stride(), leaf_.keys, times_); }

    const TreeLeaf& leaf_;
    const float* boxes_;
    const Times& times_;
    const bool is_tested_, has_boxes_of_igrids_;
};

}  // namespace occam::accel
