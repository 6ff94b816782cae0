// Fixed weights that bound a patch of one class, whatever its control points are: its box and its speeds cost one pass over
// a table instead of a walk through the class's quadtree, which near an extraordinary vertex has dozens of squares.
//
// Memory   64 n bytes for each group of 16 results, n control points: 7 groups for a regular patch, some 45 for one with an
//          extraordinary corner.
// Threads  const once made.
#pragma once

#include <cmath>
#include <vector>

#include "lod/patch_class.h"

namespace occam::lod {

/// Results linear in the control points, in groups of 16: of group g, control point k, result i at (g * n + k) * 16 + i.
class WeightRows {
public:
    static constexpr std::size_t kGroup = 16;

    explicit WeightRows(int control_count) : control_count_(static_cast<std::size_t>(control_count)) {}

    /// One more result; `weight(k)` is that of control point k.
    template <class Weight>
    void add(Weight&& weight)
    {
        if (count_ % kGroup == 0) weights_.resize(weights_.size() + kGroup * control_count_);
        for (std::size_t k = 0; k < control_count_; ++k) weights_[at(count_, k)] = static_cast<float>(weight(k));
        ++count_;
    }
    /// The same, left out if there is such a result already: neighbouring squares share control points.
    template <class Weight>
    void add_new(Weight&& weight)
    {
        add(weight);
        for (std::size_t other = 0; other + 1 < count_; ++other)
            if (are_alike(other, count_ - 1)) {
                --count_;
                weights_.resize((count_ + kGroup - 1) / kGroup * kGroup * control_count_);
                return;
            }
    }
    /// Fills the last group up with the last result.
    void finish()
    {
        for (const std::size_t last = count_ - 1; count_ % kGroup != 0;)
            add([&](std::size_t k) { return weights_[at(last, k)]; });
    }
    std::size_t group_count() const noexcept { return count_ / kGroup; }
    const float* group(std::size_t g) const noexcept { return weights_.data() + g * control_count_ * kGroup; }

private:
    std::size_t at(std::size_t result, std::size_t k) const noexcept
    {
        return (result / kGroup * control_count_ + k) * kGroup + result % kGroup;
    }
    /// But for rounding, which is far below what boxes are padded by.
    bool are_alike(std::size_t a, std::size_t b) const noexcept
    {
        for (std::size_t k = 0; k < control_count_; ++k)
            if (std::fabs(weights_[at(a, k)] - weights_[at(b, k)]) > 2e-7f * (1 + std::fabs(weights_[at(a, k)])))
                return false;
        return true;
    }

    std::size_t control_count_, count_ = 0;
    std::vector<float> weights_;
};

struct PatchHull {
    explicit PatchHull(const PatchClass& kind);

    WeightRows points;                   ///< Bezier points of all bicubic squares: their hull holds these squares
    WeightRows corners;                  ///< of squares that only have stencils, four each, four squares a group
    WeightRows speed_u, speed_v;         ///< differences of control points, whose largest bounds the speed along u and v
    std::vector<WeightRows> side_speed;  ///< the same of each side's curve: 0: v = 0, 1: u = 1, 2: v = 1, 3: u = 0

private:
    void add_points(const PatchClass& kind, const PatchClass::Node& node);
    void add_speeds(const PatchClass& kind, const PatchClass::Node& node);
    void add_side_speeds(const PatchClass& kind, const PatchClass::Node& node, int side);
};

}  // namespace occam::lod
