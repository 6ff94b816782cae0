// Keeps the posed control points of the patches that were diced last and the texture coordinates by which they are
// displaced, and texture coordinates and rest positions of one.
//
// Space    posed patches are in the cage's dicing frame, patches at rest in object axes.
// Memory   bounded by the size of the pool; patches reuse their vectors.
// Threads  one at a time, as for the dicer that owns it.
#pragma once

#include <memory>

#include "lod/cage_table.h"
#include "lod/posed_patch.h"

namespace occam::lod {

class PatchPool {
public:
    /// Forgets all posed cages.
    void forget() noexcept;

    // What these functions return stays valid until the same function is called again.
    PosedPatch& posed(const PosedCage& cage, PatchRef patch);
    /// Returns a patch of texture coordinates, as the x and y of points.
    PosedPatch& uv(const PosedCage& cage, PatchRef patch, int set);
    /// Returns the texture coordinates by which a patch of a displaced cage is displaced. The points on its borders are
    /// asked for again where its neighbours are diced.
    PosedPatch& displaced_uv(const PosedCage& cage, PatchRef patch);
    /// Returns the patch without skin and morph targets, in object axes.
    PosedPatch& rest(const PosedCage& cage, PatchRef patch);

private:
    using Table = CageTable<PatchRef, PosedPatch, 512>;

    Table posed_;
    std::unique_ptr<Table> displaced_uv_;  ///< null until a patch is displaced
    Table::Entry uv_, rest_;
    int uv_set_ = 0;
};

}  // namespace occam::lod
