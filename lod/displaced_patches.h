// Evaluates patches of displaced cages: points, curves and normals of the limit surface with its displacement.
//
// Space    the cage's dicing frame.
// Memory   its own scratch, bounded by the largest grid that was asked for.
// Threads  one at a time, as for the dicer that owns it.
#pragma once

#include <algorithm>
#include <vector>

#include "lod/patch_pool.h"

namespace occam::lod {

/// A patch of a placed cage, and the level for whose edge length displacement is filtered (PatchRates::filter).
struct FilteredPatch {
    const PosedCage& cage;
    PatchRef patch;
    int filter;
};

/// The parameters t0 + i * step along u or v of a patch, where the other parameter is fixed; step is not 0.
struct ParameterLine {
    bool along_v;
    float fixed, t0, step;
};

class DisplacedPatches {
public:
    explicit DisplacedPatches(PatchPool& pool) noexcept : pool_(pool) {}

    /// The number of pieces of a side with which the speed of displaced curves is measured.
    static constexpr int kSpeedPieces = 16;
    /// The exponent of the most by which a displaced speed may exceed that without displacement. Displacement is filtered
    /// over the edges of each level, so it has nothing to show between vertices that are closer together than that, however
    /// steep it is; and a few texels would cost millions of quads.
    static constexpr int kSteepest = 4;
    static float most_speed(float undisplaced) noexcept { return undisplaced * float(1 << kSteepest); }
    /// Returns the speed by which a displaced curve is diced.
    static float diced_speed(float displaced, float undisplaced) noexcept
    {
        return std::clamp(displaced, undisplaced, most_speed(undisplaced));
    }
    /// Returns the level whose edges are as long as such pieces of a curve of this speed.
    static int level_of_pieces(float speed) noexcept
    {
        return std::clamp(ceil_log2(speed) - 4, kFinestLevel, kCoarsestLevel);
    }

    /// Writes points to rows of `stride` floats.
    void points(const FilteredPatch& of, const ParameterGrid& grid, float* const out[3], int stride);
    void curve(const FilteredPatch& of, const ParameterLine& line, std::span<Vec3f> out);
    /// Writes unit normals, which are 0 where the surface leaves no direction.
    void normals(const FilteredPatch& of, const ParameterGrid& grid, Vec3f* out);
    /// Raises the largest speeds of the patch along u and v to those that it has with its displacement.
    void raise_speeds(const PosedCage& cage, PatchRef patch, float& along_u, float& along_v);

private:
    /// Writes the offsets of a patch's points to rows of `stride` floats, and leaves the points and tangents in surface_.
    void offsets(const FilteredPatch& of, const ParameterGrid& grid, float* const out[3], int stride);
    /// Computes offsets at the grid's parameters shifted by `by` along an axis; a line that would leave the patch is not
    /// shifted.
    void offsets_beside(const FilteredPatch& of, const ParameterGrid& grid, int axis, float by, float* const out[3]);

    PatchPool& pool_;
    std::vector<float> surface_, beside_;
};

}  // namespace occam::lod
