// Computes how far a texture moves a cage's limit surface, where one node shows the cage.
//
// A point of M_l is P + h_l N. P and N belong to the limit surface, and h_l is the texture's value over a square of d_l
// around the point, clamped to the cage's bound. On curves and corners between patches all three are the owner's
// (topology.h), so that neither creases nor seams of the coordinates open; T-vertices are middles of displaced points. N and
// h are the object's: a placement that stretches the cage stretches the displacement with it. A skinned cage moves along its
// posed normal, by the distance that its node's own transform gives. Where a cage moves while the shutter is open, the
// square is the same part of the surface at all times: that of d_l where the cage is largest.
//
// Vector displacement is P + v_l, where v_l has three channels and is shortened to the bound:
// - In the object's axes at rest, it needs no smooth coordinates. Where skin or morph targets pose the cage, v turns as they
//   turn the surface: by the rotation between rest and pose that takes normal to normal and, in the surface, is nearest to
//   the pose's map (polar decomposition). It is a function of the owner's patch at rest and posed, so it is as closed as P
//   is, and it does not depend on the patch's parametrization, so neighbours agree over smooth edges. It turns in the
//   object's axes, and the node's own transform is applied to it afterwards, so that it stays within the bound of the
//   object.
// - In tangent space, its axes are dP/du of the coordinates, the direction across it, and the normal. On a seam of the
//   coordinates the axes and the texel are the owner's, so the surface is closed there, without a jump if the texture gives
//   both charts the same vector. Where coordinates have no area there is no tangent, and only the normal's part is left.
//
// Threads  read only.
#pragma once

#include "io/texture/texture_store.h"
#include "scenegraph/cage.h"

namespace occam::lod {

/// Returns the largest factor by which the linear map can lengthen a vector. It is exact for rotations with one scale, and
/// never too small.
double largest_stretch(const double (&map)[3][4]) noexcept;

/// A limit point to be displaced, with its derivatives with respect to the patch's parameter.
struct PointToDisplace {
    Vec3f du, dv;                  ///< derivatives of the position, dicing frame
    Vec2f uv, uv_du, uv_dv;        ///< coordinates
    Vec3f rest_du{0}, rest_dv{0};  ///< derivatives of the rest position, object axes; read if PosedDisplacement::turns
};

/// The same for many points, coordinate by coordinate.
struct PointsToDisplace {
    const float *du[3], *dv[3];
    const float *uv[2], *uv_du[2], *uv_dv[2];
    int count;
};

struct PosedDisplacement {
    PosedDisplacement() = default;
    /// deformed   whether skin or morph targets deform the cage; `mirrored` then describes the pose
    /// radius     radius of the posed cage, world length
    PosedDisplacement(const Cage& cage, const TextureStore& store, const double (&frame_from_object)[3][4], bool mirrored,
                      bool deformed, float radius) noexcept;

    const Displacement* of = nullptr;  ///< null: no displacement
    const TextureStore* textures = nullptr;
    double map[3][3] = {};      ///< the linear part of the cage's map from object axes to the dicing frame, by rows
    float sense = 1;            ///< -1 if the map mirrors
    float sense_in_object = 1;  ///< -1 if the pose mirrors before the map does its part
    float reach = 0;            ///< no point moves farther, world length
    int stops = 0;              ///< from this level on the displacement is the same
    float filter_share = 1;  ///< the width of the texture's filter, in edges of a level; below 1 at keys at which the cage
                             ///< is smaller than at others, whose edges levels are about
    bool turns = false;      ///< whether vectors in object axes turn, because the cage is posed

    int uv_set() const noexcept { return of->texture.uv_set; }
    /// Returns the offset of the limit point, in the dicing frame.
    Vec3f offset(const PointToDisplace& at, int level) const noexcept;
    /// Writes the offsets of many points, with the bits of offset(); for Displacement::Space::Normal.
    void offsets_along_normal(const PointsToDisplace& at, int level, float* const out[3]) const noexcept;

private:
    double filter_edge(int level) const noexcept;
    Vec3d from_object(Vec3d v) const noexcept;
    Vec3d to_object(Vec3d v) const noexcept;
    Vec3d texel_vector(const Vec4f& texel) const noexcept;
    Vec3d along_normal(const PointToDisplace& at, double height) const noexcept;
    Vec3d turned(const PointToDisplace& at, Vec3d v) const noexcept;
    Vec3d in_tangents(const PointToDisplace& at, Vec3d v) const noexcept;
};

}  // namespace occam::lod
