// Evaluates the surface of placed cages patch by patch, displaced or not.
//
// Space    the cage's dicing frame; parameters of the patch, [0, 1].
// Memory   its own scratch, and a pool of posed patches.
// Threads  one at a time, as for the dicer that owns it.
#pragma once

#include "lod/displaced_patches.h"

namespace occam::lod {

class PatchSurface {
public:
    PatchSurface() = default;
    PatchSurface(const PatchSurface&) = delete;

    /// Forgets all posed cages.
    void forget() noexcept { pool_.forget(); }

    /// Returns the patch without displacement.
    PosedPatch& posed(const PosedCage& cage, PatchRef patch) { return pool_.posed(cage, patch); }
    /// Returns the patch's texture coordinates, as the x and y of points.
    PosedPatch& uv(const PosedCage& cage, PatchRef patch, int set) { return pool_.uv(cage, patch, set); }
    /// Computes the largest speeds of the patch's inner curves along u and along v, displacement included.
    void speeds(const PosedCage& cage, PatchRef patch, float& along_u, float& along_v);

    /// Writes points to rows of `stride` floats.
    void points(const FilteredPatch& of, const ParameterGrid& grid, float* const out[3], int stride);
    void curve(const FilteredPatch& of, const ParameterLine& line, std::span<Vec3f> out);
    Vec3f point(const PosedCage& cage, const PatchPoint& at, int filter);
    /// Writes unit normals that point outside. They are 0 where the tangents are parallel, as in a corner whose sides have
    /// one direction; hits take the geometric normal there (accel/hit.cpp).
    void normals(const FilteredPatch& of, const ParameterGrid& grid, Vec3f* out);

private:
    PatchPool pool_;
    DisplacedPatches displaced_{pool_};
    std::vector<float> tangents_;
};

}  // namespace occam::lod
