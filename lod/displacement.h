// How far a texture moves a cage's limit surface, where one node shows the cage.
//
// A point of M_l is P + h_l N: P and N of the limit surface, h_l the texture's value over a square of d_l about it, clamped
// to the cage's bound. All three are the owner's on curves and corners between patches (topology.h), so that neither creases
// nor seams of the coordinates open; T-vertices are middles of what was moved. N and h are the object's: a placement that
// stretches the cage stretches the displacement with it. A skinned cage moves along its posed normal, as far as its node's
// own place says.
//
// Or it is P + v_l, a vector of three channels, shortened to the bound:
// - in the object's axes at rest, which need no coordinates to be smooth. Where skin or morph targets pose the cage, v turns
// as they
//   turned the surface: by the rotation between rest and pose that takes normal to normal and, in the surface, is nearest to
//   what the pose did (polar decomposition). It is a function of the owner's patch at rest and posed, so it closes as P
//   does, and does not depend on how the patch is parametrized: so neighbours agree over smooth edges. How far v goes is not
//   the pose's but the node's own place's.
// - in tangent space: along dP/du of the coordinates, across it, and along the normal. On a seam of the coordinates these
// are the owner's,
//   with its texel: closed, and without a jump if the texture gives both charts the same vector there. Where coordinates
//   have no area there is no tangent, and the normal's part alone is left.
//
// Threads  read only.
#pragma once

#include "io/texture/texture_store.h"
#include "scenegraph/cage.h"

namespace occam::lod {

/// The largest factor by which the linear map can lengthen a vector; exact for rotations with one scale, never too small.
double largest_stretch(const double (&map)[3][4]) noexcept;

/// A limit point that is displaced, with its derivatives with respect to the patch's parameter.
struct PointToDisplace {
    Vec3f du, dv;                  ///< of the place, dicing frame
    Vec2f uv, uv_du, uv_dv;        ///< coordinates
    Vec3f rest_du{0}, rest_dv{0};  ///< of the place at rest, object axes; read if PosedDisplacement::turns
};

struct PosedDisplacement {
    PosedDisplacement() = default;
    /// deformed   by skin or morph targets; `mirrored` is then the pose's
    /// radius     of the posed cage, world length
    PosedDisplacement(const Cage& cage, const TextureStore& store, const double (&frame_from_object)[3][4], bool mirrored,
                      bool deformed, float radius) noexcept;

    const Displacement* of = nullptr;  ///< null: none
    const TextureStore* textures = nullptr;
    const double (*map)[4] = nullptr;  ///< of the cage: object axes to the dicing frame
    float sense = 1;                   ///< -1: the map mirrors
    float reach = 0;                   ///< no point moves farther: world length
    int stops = 0;                     ///< from this level on it is the same
    bool turns = false;                ///< vectors in the object's axes, of a cage that is posed

    int uv_set() const noexcept { return of->texture.uv_set; }
    /// Where the limit point goes from its place: dicing frame.
    Vec3f offset(const PointToDisplace& at, int level) const noexcept;

private:
    Vec3d from_object(Vec3d v) const noexcept;
    Vec3d to_object(Vec3d v) const noexcept;
    Vec3d texel_vector(const Vec4f& texel) const noexcept;
    Vec3d along_normal(const PointToDisplace& at, double height) const noexcept;
    Vec3d turned(const PointToDisplace& at, Vec3d v) const noexcept;
    Vec3d in_tangents(const PointToDisplace& at, Vec3d v) const noexcept;
};

}  // namespace occam::lod
