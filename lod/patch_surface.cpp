#include "lod/patch_surface.h"

#include "base/cross_product.h"

namespace occam::lod {

void PatchSurface::speeds(const PosedCage& cage, PatchRef patch, float& along_u, float& along_v)
{
    posed(cage, patch).speeds(along_u, along_v);
    if (cage.is_displaced()) displaced_.raise_speeds(cage, patch, along_u, along_v);
}

void PatchSurface::points(const FilteredPatch& of, const ParameterGrid& grid, float* const out[3], int stride)
{
    if (of.cage.is_displaced()) displaced_.points(of, grid, out, stride);
    else posed(of.cage, of.patch).points(grid, out[0], out[1], out[2], stride);
}

void PatchSurface::curve(const FilteredPatch& of, const ParameterLine& line, std::span<Vec3f> out)
{
    if (of.cage.is_displaced()) displaced_.curve(of, line, out);
    else posed(of.cage, of.patch).curve(line.along_v, line.fixed, line.t0, line.step, out);
}

Vec3f PatchSurface::point(const PosedCage& cage, const PatchPoint& at, int filter)
{
    Vec3f p;
    curve({cage, at.patch, filter}, {false, at.v, at.u, 1}, {&p, 1});
    return p;
}

void PatchSurface::normals(const FilteredPatch& of, const ParameterGrid& grid, Vec3f* out)
{
    if (of.cage.is_displaced()) {
        displaced_.normals(of, grid, out);
        return;
    }
    const auto count = static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows);
    tangents_.resize(9 * count);
    float* at[9];
    for (std::size_t a = 0; a < 9; ++a) at[a] = &tangents_[a * count];
    posed(of.cage, of.patch).points_and_tangents(grid, at, grid.columns);
    const float sense = of.cage.is_mirrored ? -1.0f : 1.0f;
    for (std::size_t k = 0; k < count; ++k)
        out[k] = unit_normal({at[3][k], at[4][k], at[5][k]}, {at[6][k], at[7][k], at[8][k]}, sense);
}

}  // namespace occam::lod
