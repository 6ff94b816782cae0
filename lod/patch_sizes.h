// Measures patches before they are diced: the speeds from which their rates follow, and boxes of their parts.
//
// Space    the cage's dicing frame.
// Threads  one at a time, as for the dicer that owns it.
#pragma once

#include "lod/owned_curves.h"

namespace occam::lod {

/// A dyadic part of a patch: the (iu, iv)-th part of size 1 / 2^du by 1 / 2^dv.
struct PatchRegion {
    PatchRef patch;
    std::uint32_t iu = 0, iv = 0;
    int du = 0, dv = 0;
};

class PatchSizes {
public:
    PatchSizes(PatchSurface& surface, OwnedCurves& curves) noexcept : surface_(surface), curves_(curves) {}

    /// Returns the patch's size; the largest over all keys, if the cage moves, so that one rate serves them all
    /// (watertightness rule 24).
    PatchScale scale(const PosedCage& cage, PatchRef patch);
    /// Returns a box that holds the region's surface and its mesh at all levels up to `coarsest` at which the region
    /// consists of whole quads. It is that of one key, if the cage moves.
    Box3f bounds(const PosedCage& cage, const PatchScale& scale, const PatchRegion& region, int coarsest);

private:
    PatchScale scale_at_key(const PosedCage& cage, PatchRef patch);

    PatchSurface& surface_;
    OwnedCurves& curves_;
};

}  // namespace occam::lod
