// Positions that a file gives with more digits than floats hold, as those of surveys, which are far from the origin.
#pragma once

#include <vector>

#include "base/maths.h"
#include "scenegraph/cage.h"

namespace occam::import {

/// Keeps the positions of a file in double precision as long as floats may lose much of the shape, which means that they
/// round positions by more than a 2^20th of its largest side. Those of most files are forgotten after a few of them.
class FarPositions {
public:
    bool needs_more() const noexcept { return is_kept_; }
    /// Adds the next position; one that is not finite, or that is left out for its size, does not count.
    void add(Vec3d position);
    /// Forgets the positions, because floats are enough or because not all of them are known.
    void drop() noexcept { is_kept_ = false, all_.clear(); }

    bool loses_shape() const noexcept;
    /// If floats lose much of the shape, makes `positions` relative to the middle of their box, and returns that; else 0.
    Vec3d move(std::vector<Vec3f>& positions);

private:
    std::vector<Vec3d> all_;
    Box3d box_;
    double loss_ = 0;  ///< the largest difference that rounding makes
    bool is_kept_ = true;
};

}  // namespace occam::import
