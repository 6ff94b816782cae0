// Dices patches into rates, tiles of vertices and attributes. Each tree has one dicer.
//
// M_l, the mesh of level l, is a function of (patch, level) alone; tiles only store it in parts. Points between patches come
// from their owners (topology.h), and T-vertices are the middles of their neighbours on the owner's polyline (watertightness
// rule 4). A *pair* of levels l and l + 1 is M_l, each vertex of which also knows where its parameter lies in M_(l+1).
//
// Space    the cage's dicing frame.
// Memory   results lie in the given arena; the dicer owns its scratch, which is bounded by the largest ring of a cage.
// Threads  one at a time: the owner of the tree, or the worker that holds the lock of a shared tree.
#pragma once

#include <vector>

#include "base/arena.h"
#include "lod/level_grid.h"
#include "lod/posed_patch.h"

namespace occam::lod {

/// A dyadic part of a patch: the (iu, iv)-th part of size 1 / 2^du by 1 / 2^dv.
struct PatchRegion {
    PatchRef patch;
    std::uint32_t iu = 0, iv = 0;
    int du = 0, dv = 0;
};

class Dicer {
public:
    Dicer();

    /// Forgets all posed cages; call it when they die: between frames and after a flush.
    void forget();

    /// Hints that scale() and bounds() of a patch are called next, so that the tables of many patches are prefetched
    /// together.
    static void ask_for(const PosedCage& cage, PatchRef patch);
    /// Returns the patch's size; the largest over all keys, if the cage moves, so that one rate serves them all.
    PatchScale scale(const PosedCage& cage, PatchRef patch);

    /// Returns a box that holds the region's surface and its mesh at all levels up to `coarsest` at which the region
    /// consists of whole quads. It is that of one key, if the cage moves.
    Box3f bounds(const PosedCage& cage, const PatchScale& scale, const PatchRegion& region, int coarsest);

    /// Returns the tile of level `level` that holds quad (i, j) of the patch's lattice at that level.
    static TileRef tile(PatchRef patch, const PatchScale& scale, int level, std::uint32_t i, std::uint32_t j);

    /// Dices all vertices of a tile of a level, owned borders and T-vertices included.
    LevelGrid dice(const PosedCage& cage, const TileRef& tile, Arena& arena);
    /// Dices a tile of level l, with its positions in the mesh of level l + 1, whose rates are `coarser`.
    LevelGrid dice_pair(const PosedCage& cage, const TileRef& tile, const PatchRates& coarser, Arena& arena);

    /// Computes normals and texture coordinates of a tile's vertices from the patch itself; neighbouring patches do not
    /// share them (creases, seams). A cage that moves has normals at each of its keys.
    /// coarser   the rates of the next coarser level, or the tile's own; a displaced cage has normals there too
    GridAttributes shade(const PosedCage& cage, const TileRef& tile, const PatchRates& coarser, Arena& arena);

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
        int k = kUnknown;
        bool has_quarters = false, has_middle = false;  ///< which of the following are known
        std::array<Vec3f, 3> p{};                       ///< points at 1/4, 1/2 and 3/4; not for displaced cages
        static constexpr int kUnknown = kMinLength - 1;
    };
    struct CornerEntry {
        const PosedCage* cage = nullptr;
        std::uint32_t vertex = 0;
        Vec3f p;
    };
    struct OwnerSpan {
        PatchRef patch;
        bool along_v;
        float fixed, t0, dt;  ///< the owner's parameter is t0 + c * dt
    };
    /// An edge vertex outside the tile.
    struct Extra {
        int side;
        int piece;  ///< piece of the side, counted in the side's own pieces
    };

    PosedPatch& posed(const PosedCage& cage, PatchRef patch);
    PatchScale scale_at_key(const PosedCage& cage, PatchRef patch);
    /// Computes normals of a tile's vertices, and coarse normals where coarse_normal is not null.
    void shade_normals(const PosedCage& cage, const TileRef& tile, const PatchRates& coarser, Vec3f* normal,
                       Vec3f* coarse_normal);
    CurveEntry& curve_entry(const PosedCage& cage, std::uint32_t curve);
    OwnerSpan owner_span(const Topology& topology, std::uint32_t curve, float ca, float cb) const;
    /// Returns ceil(log2) of the curve's largest speed.
    int curve_k(const PosedCage& cage, std::uint32_t curve);
    // The parameter `filter` is PatchRates::filter of the level.
    /// Computes points of a curve at c0 + i * dc; the parameters 0 and 1 are its ends.
    void curve_points(const PosedCage& cage, std::uint32_t curve, int filter, float c0, float dc, std::span<Vec3f> out);
    /// Computes points of a part of a curve that has one owner, except at ends and knots.
    void owned_points(const PosedCage& cage, std::uint32_t curve, int filter, float c0, float dc, std::span<Vec3f> out);
    Vec3f curve_end(const PosedCage& cage, std::uint32_t curve, int filter, int end);
    /// Returns the surface's point at a vertex of the cage.
    Vec3f vertex_point(const PosedCage& cage, std::uint32_t vertex, int filter);
    /// Computes points as PosedPatch::curve() does, displaced.
    void patch_curve(const PosedCage& cage, PatchRef patch, int filter, bool along_v, float fixed, float t0, float step,
                     std::span<Vec3f> out);
    Vec3f patch_point(const PosedCage& cage, PatchPoint at, int filter);

    PosedPatch& uv_patch(const PosedCage& cage, PatchRef patch, int set);
    /// Returns the patch without skin and morph targets, in object axes.
    PosedPatch& rest_patch(const PosedCage& cage, PatchRef patch);

    // Functions for displaced cages (dicer_displaced.cpp).
    /// Writes the offsets of a patch's points to rows of `stride` floats, and leaves the points and tangents in surface_.
    void offsets(const PosedCage& cage, PatchRef patch, int filter, const ParameterGrid& grid, float* const out[3],
                 int stride);
    void displaced_points(const PosedCage& cage, PatchRef patch, int filter, const ParameterGrid& grid, float* const out[3],
                          int stride);
    void displaced_curve(const PosedCage& cage, PatchRef patch, int filter, bool along_v, float fixed, float t0, float step,
                         std::span<Vec3f> out);
    /// Computes offsets at the grid's parameters shifted by `by` along an axis; a line that would leave the patch is not
    /// shifted.
    void offsets_beside(const PosedCage& cage, PatchRef patch, int filter, const ParameterGrid& grid, int axis, float by,
                        float* const out[3]);
    void displaced_normals(const PosedCage& cage, PatchRef patch, int filter, const ParameterGrid& grid, Vec3f* out);
    /// Computes normals of the next coarser level at a tile's vertices: an odd vertex lies between two that the level has.
    void displaced_coarse_normals(const PosedCage& cage, const TileRef& tile, const PatchRates& coarser, Vec3f* out);
    /// Returns the length of the longest displaced piece of sixteen, per unit of the parameter.
    float displaced_speed(const PosedCage& cage, std::uint32_t curve, float undisplaced);
    void displaced_speeds(const PosedCage& cage, PatchRef patch, float& along_u, float& along_v);
    /// Computes the ends of the pieces [first, first + out.size()) of a side.
    void side_points(const PosedCage& cage, const TileRef& tile, int side, int first, std::span<Vec3f> out);
    void dice_side(const PosedCage& cage, int side, LevelGrid& grid);
    LevelGrid dice_vertices(const PosedCage& cage, const TileRef& tile, Arena& arena);

    static constexpr std::size_t kPoolSize = 512, kCurveSize = 4096, kCornerSize = 4096;
    std::vector<PoolEntry> pool_;       ///< direct-mapped
    std::vector<CurveEntry> curves_;    ///< direct-mapped
    std::vector<CornerEntry> corners_;  ///< direct-mapped: limit points that all levels of several patches share
    PoolEntry uv_, rest_;
    int uv_set_ = 0;
    std::vector<Vec3f> side_points_;
    std::vector<Hanging> hanging_;
    std::vector<Extra> extras_;  ///< for the tile diced last
    std::vector<float> tangents_, surface_, beside_;
    std::vector<Vec3f> coarse_normals_;
    Arena scratch_;
};

}  // namespace occam::lod
