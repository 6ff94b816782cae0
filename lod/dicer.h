// Dices patches into rates, tiles of vertices and attributes. Each tree has one dicer.
//
// M_l, the mesh of level l, is a function of (patch, level) alone; tiles only store it in parts. A *pair* of levels l and
// l + 1 is M_l, each vertex of which also knows where its parameter lies in M_(l+1).
//
// The work is divided: PatchSurface evaluates a patch, OwnedCurves the points that patches share, PatchSizes measures
// patches, TileDicer dices a tile at one level, and TileAttributes makes normals and coordinates. The dicer joins them, and
// makes pairs of levels.
//
// Space    the cage's dicing frame.
// Memory   results lie in the given arena; the dicer owns its scratch, which is bounded by the largest ring of a cage.
// Threads  one at a time: the owner of the tree, or the worker that holds the lock of a shared tree.
#pragma once

#include "lod/patch_sizes.h"
#include "lod/tile_attributes.h"
#include "lod/tile_dicer.h"

namespace occam::lod {

class Dicer {
public:
    Dicer() = default;
    Dicer(const Dicer&) = delete;

    /// Forgets all posed cages; call it when they die: between frames and after a flush.
    void forget() noexcept;

    /// Hints that scale() and bounds() of a patch are called next, so that the tables of many patches are prefetched
    /// together.
    static void ask_for(const PosedCage& cage, PatchRef patch);
    /// Returns the patch's size, as PatchSizes::scale() does.
    PatchScale scale(const PosedCage& cage, PatchRef patch) { return sizes_.scale(cage, patch); }
    /// Returns a box of a part of a patch, as PatchSizes::bounds() does.
    Box3f bounds(const PosedCage& cage, const PatchScale& scale, const PatchRegion& region, int coarsest)
    {
        return sizes_.bounds(cage, scale, region, coarsest);
    }

    /// Returns the tile of level `level` that holds quad (i, j) of the patch's lattice at that level.
    static TileRef tile(PatchRef patch, const PatchScale& scale, int level, std::uint32_t i, std::uint32_t j);

    /// Dices all vertices of a tile of a level, owned borders and T-vertices included.
    LevelGrid dice(const PosedCage& cage, const TileRef& tile, Arena& arena);
    /// Dices a tile of level l, with its positions in the mesh of level l + 1, whose rates are `coarser`.
    LevelGrid dice_pair(const PosedCage& cage, const TileRef& tile, const PatchRates& coarser, Arena& arena);

    /// Computes normals and texture coordinates of a tile's vertices, as TileAttributes::make() does.
    GridAttributes shade(const PosedCage& cage, const TileRef& tile, const PatchRates& coarser, Arena& arena)
    {
        return attributes_.make(cage, tile, coarser, arena);
    }

    std::uint64_t vertices_diced() const noexcept { return tiles_.vertices; }
    std::uint64_t vertices_shaded() const noexcept { return attributes_.vertices; }

private:
    /// Returns where an edge vertex outside the tile, which is at `fine`, lies in the next coarser level.
    Vec3f coarse_outside(const PosedCage& cage, const TileRef& coarse_tile, const PatchRates& rates,
                         const TileDicer::OutsideVertex& vertex, Vec3f fine);

    PatchSurface surface_;
    OwnedCurves curves_{surface_};
    PatchSizes sizes_{surface_, curves_};
    TileDicer tiles_{surface_, curves_};
    TileAttributes attributes_{surface_};
    Arena coarse_;  ///< holds the coarser level of the pair that is made
};

}  // namespace occam::lod
