// The lengths that no edge of a level exceeds.
//
// The rates of a patch follow from speeds between points that are a sixteenth of its side apart. Closer to a pole
// (scenegraph/poles.h) a curve is faster: its distance from the pole grows as the parameter to the power of -log2 of the
// subdominant eigenvalue, which is less than 1 (Peters and Reif 2008, ch. 5). So the first piece of n is longer than d_l
// by (n / 16)^a, where 2^a is twice the eigenvalue, and n is at most twice the length of the side over d_l.
#pragma once

#include <array>

#include "lod/rates.h"
#include "scenegraph/poles.h"

namespace occam::lod {

/// A cage has no edges shorter than this part of the longest edges at its poles, which bounds how much longer than d_l its
/// edges become there. The chords of such short edges are within 10^-6 of a face's side of the surface.
inline constexpr int kFinestAtPoles = 1024;

/// The lengths for all levels of a frame.
class LongestEdges {
public:
    /// There are no poles.
    LongestEdges() noexcept : LongestEdges(Poles()) {}
    /// poles   those of all cages, in the frame's length
    explicit LongestEdges(const Poles& poles) noexcept;

    /// Returns a length that edges of this level do not exceed, but for displacement: d_l, or more where the scene has poles
    /// among faces whose sides are longer than four edges of this level.
    float at(int level) const noexcept { return lengths_[static_cast<std::size_t>(level - kFinest)]; }

private:
    static constexpr int kFinest = kFinestLevel - 1;  ///< margins are asked for one level beyond either end

    std::array<float, kCoarsestLevel + 2 - kFinest> lengths_;
};

}  // namespace occam::lod
