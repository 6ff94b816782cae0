// How far a texture moves a cage's limit surface, where one node shows the cage.
//
// A point of M_l is P + h_l N: P and N of the limit surface, h_l the texture's value over a square of d_l about it, clamped
// to the cage's bound. All three are the owner's on curves and corners between patches (topology.h), so that neither creases
// nor seams of the coordinates open; T-vertices are middles of what was moved. N and h are the object's: a placement that
// stretches the cage stretches the displacement with it. A skinned cage moves along its posed normal, as far as its node's
// own place says.
//
// Or it is P + v_l, a vector of three channels in the object's axes, shortened to the bound. These axes need no coordinates to be
// smooth, as tangents of a texture's would. Skins do not turn them.
//
// Threads  read only.
#pragma once

#include "scenegraph/cage.h"
#include "scenegraph/texture/texture_store.h"

namespace occam::lod {

/// The largest factor by which the linear map can lengthen a vector; exact for rotations with one scale, never too small.
double largest_stretch(const double (&map)[3][4]) noexcept;

struct PosedDisplacement {
    PosedDisplacement() = default;
    /// radius   of the posed cage, world length
    PosedDisplacement(const Cage& cage, const TextureStore& store, const double (&frame_from_object)[3][4], bool mirrored,
                      float radius) noexcept;

    const Displacement* of = nullptr;  ///< null: none
    const TextureStore* textures = nullptr;
    const double (*map)[4] = nullptr;  ///< of the cage: object axes to the dicing frame
    float sense = 1;                   ///< -1: the map mirrors
    float reach = 0;                   ///< no point moves farther: world length
    int stops = 0;                     ///< from this level on it is the same

    int uv_set() const noexcept { return of->texture.uv_set; }
    /// Where the limit point goes from its place: dicing frame.
    /// du, dv, uv_du, uv_dv   of the point and of its coordinates, with respect to the patch's parameter
    Vec3f offset(Vec3f du, Vec3f dv, Vec2f uv, Vec2f uv_du, Vec2f uv_dv, int level) const noexcept;
};

}  // namespace occam::lod
