// Computes what phase one of shading needs at the vertices of a tile: normals and texture coordinates; and whether patches
// overlap there, on which the starts of secondary rays depend.
//
// Space    normals are in the cage's dicing frame, which has world axes.
// Memory   results lie in the given arena.
// Threads  one at a time, as for the dicer that owns it.
#pragma once

#include <vector>

#include "base/arena.h"
#include "lod/level_grid.h"
#include "lod/patch_surface.h"

namespace occam::lod {

class TileAttributes {
public:
    explicit TileAttributes(PatchSurface& surface) noexcept : surface_(surface) {}

    /// Computes normals and texture coordinates from the patch itself; neighbouring patches do not share them (creases,
    /// seams). A cage that moves has normals at each of its keys.
    /// coarser   the rates of the next coarser level, or the tile's own; a displaced cage has normals there too
    GridAttributes make(const PosedCage& cage, const TileRef& tile, const PatchRates& coarser, Arena& arena);

    /// The number of vertices so far, one at several keys counted at each.
    std::uint64_t vertices = 0;

private:
    /// Computes normals of the next coarser level of a displaced cage: an odd vertex lies between two that the level has.
    void coarse_normals(const PosedCage& cage, const TileRef& tile, const PatchRates& coarser, Vec3f* out);

    /// Returns GridAttributes::overlaps_in_plane.
    bool overlaps_in_plane(const PosedCage& cage, const TileRef& tile);
    bool is_flat(const PosedCage& cage, const TileRef& tile);

    PatchSurface& surface_;
    std::vector<Vec3f> normals_, at_key_;
    std::vector<float> uvs_, points_;
};

}  // namespace occam::lod
