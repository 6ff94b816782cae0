// Dices patches: rates, tiles of vertices, attributes. One a worker.
//
// M_l, the mesh of level l, is a function of (patch, level) alone; tiles only store it in pieces. Points between patches come
// from their owners (topology.h), T-vertices are middles of their neighbours on the owner's polyline (watertightness rule 4).
//
// Space    the cage's dicing frame.
// Memory   results in the arena given; scratch is the dicer's own, bounded by the largest ring of a cage.
// Threads  one worker's own.
#pragma once

#include <vector>

#include "lod/level_grid.h"
#include "lod/posed_patch.h"
#include "scenegraph/base/arena.h"

namespace occam::lod {

class Dicer {
public:
    Dicer();

    /// Call when posed cages die: between frames and after a flush.
    void forget();

    /// Rates of a patch at the level of the cage.
    PatchRates rates(const PosedCage& cage, PatchRef patch);

    /// A box of a tile's surface, or of a larger part of a patch.
    Box3f bounds(const PosedCage& cage, const TileRef& part);

    /// All vertices of a tile, owned borders and T-vertices included.
    LevelGrid dice(const PosedCage& cage, const TileRef& tile, Arena& arena);

    /// Normals and texture coordinates of a tile's vertices, by the patch itself: sides do not share them (creases, seams).
    GridAttributes shade(const PosedCage& cage, const TileRef& tile, Arena& arena);

    std::uint64_t vertices_diced = 0, vertices_shaded = 0;

private:
    struct PoolEntry {
        const PosedCage* cage = nullptr;
        PatchRef patch;
        PosedPatch posed;
    };
    struct CurveEntry {
        const PosedCage* cage = nullptr;
        std::uint32_t curve = 0;
        int exponent = 0;
    };
    struct OwnerSpan {
        PatchRef patch;
        bool along_v;
        float fixed, t0, dt;  ///< the owner's parameter is t0 + c * dt
    };

    PosedPatch& posed(const PosedCage& cage, PatchRef patch);
    OwnerSpan owner_span(const Topology& topology, std::uint32_t curve, float ca, float cb) const;
    /// ceil(log2) of the curve's largest speed.
    int curve_k(const PosedCage& cage, std::uint32_t curve);
    /// Points of a curve at c0 + i * dc; 0 and 1 are its ends.
    void curve_points(const PosedCage& cage, std::uint32_t curve, float c0, float dc, std::span<Vec3f> out);
    Vec3f curve_end(const PosedCage& cage, std::uint32_t curve, int end);
    void dice_side(const PosedCage& cage, int side, LevelGrid& grid);

    static constexpr std::size_t kPoolSize = 256, kCurveSize = 2048;
    std::vector<PoolEntry> pool_;     ///< direct-mapped
    std::vector<CurveEntry> curves_;  ///< direct-mapped
    PosedPatch uv_patch_;
    std::vector<Vec3f> side_points_;
    std::vector<Closer> closers_;
    std::vector<float> tangents_;
};

}  // namespace occam::lod
