// Dices the vertices of a tile of a patch at one level: inside from the patch itself, on borders from their owners.
//
// T-vertices are the middles of their neighbours on the owner's polyline (watertightness rule 4).
//
// Space    the cage's dicing frame.
// Memory   grids lie in the given arena, and what else is known of the last tile lies here.
// Threads  one at a time, as for the dicer that owns it.
#pragma once

#include <vector>

#include "base/arena.h"
#include "lod/level_grid.h"
#include "lod/owned_curves.h"
#include "lod/patch_surface.h"

namespace occam::lod {

class TileDicer {
public:
    TileDicer(PatchSurface& surface, OwnedCurves& curves) noexcept : surface_(surface), curves_(curves) {}

    /// Dices all vertices of a tile of a level, owned borders included; LevelGrid::hanging stays empty.
    LevelGrid dice(const PosedCage& cage, const TileRef& tile, Arena& arena);

    /// An edge vertex outside the tile, at one end of a side's piece of which a part lies in the tile.
    struct OutsideVertex {
        int side;
        int piece;  ///< the piece that begins there, counted in the side's own pieces
    };
    // These describe the tile that was diced last.
    std::span<const Hanging> hanging() const noexcept { return hanging_; }
    /// They are the last vertices of the grid, in this order.
    const std::vector<OutsideVertex>& outside() const noexcept { return outside_; }

    /// The number of vertices that were diced so far, those outside of their tiles left out.
    std::uint64_t vertices = 0;

private:
    void dice_inside(const PosedCage& cage, LevelGrid& grid);
    void dice_sides(const PosedCage& cage, LevelGrid& grid);
    void dice_side(const PosedCage& cage, int side, LevelGrid& grid);

    PatchSurface& surface_;
    OwnedCurves& curves_;
    std::vector<Vec3f> side_points_;
    std::vector<Hanging> hanging_;
    std::vector<OutsideVertex> outside_;
};

}  // namespace occam::lod
