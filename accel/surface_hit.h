// Holds what a tracer answers: all that shading needs of a surface point, or only where a ray ends.
//
// Space    Positions are in world axes and frame lengths (scenegraph/frame_scale.h), in double; t is the length along the
// ray.
#pragma once

#include <cstdint>
#include <limits>

#include "accel/ray.h"
#include "lod/vertex_shader.h"
#include "scenegraph/map_axes.h"
#include "scenegraph/scene.h"

namespace occam::accel {

/// Holds what phase two needs of a surface point, by value. Pointers point into the scene. The fields are in the order in
/// which accel/hit.cpp writes them: first twenty floats, four at a time, and last the values that most hits do not have.
struct alignas(64) SurfaceHit {
    float t = std::numeric_limits<float>::infinity();  ///< infinity if nothing was hit; then nothing else here is set
    /// The offset of a secondary ray's origin along start_normal, larger than rounding errors.
    float self_distance = 0;
    float uv_width[2]{};        ///< the width of the ray's footprint, in units of uv
    Vec3f normal_geometric{0};  ///< unit normal of the micropolygon, towards the ray's origin
    /// The mean curvature from the vertices' normals, in 1 / frame length. It is positive where the surface bulges
    /// towards the ray's origin.
    float curvature = 0;
    Vec3f normal_shading{0};  ///< unit length, interpolated, on the side of normal_geometric
    /// With the outward normal n (-normal_shading on the back side), tangent_sign * cross(n, tangent) is the direction
    /// in which v decreases: a normal map's +Y (glTF 2.0, sec. 3.9.3).
    float tangent_sign = 1;
    /// A unit vector in world space, perpendicular to the outward shading normal, along which u of the material's
    /// normal map grows. It is zero without a map or texture coordinates.
    Vec3f tangent{0};
    float blend = 0;        ///< the share of the coarser level of the pair, 0 at `level` to 1
    Vec2f uv[2]{};          ///< the first two sets of texture coordinates
    Vec3d position{0};      ///< on the micropolygon
    Vec3f start_normal{0};  ///< unit normal of the micropolygon of `to_start`, on the side of normal_geometric
    /// The offset from `position` to where secondary rays start: the same place of the mesh of start_level, which is
    /// the mesh that they see there. It keeps off the micropolygon's edges by more than rounding errors.
    Vec3f to_start{0};
    /// The gradients of the texture coordinates that the material's bump map uses, over the micropolygon, per world
    /// length. They are zero without a bump map.
    Vec3f u_gradient{0}, v_gradient{0};
    /// The velocity of the place on the micropolygon, at the ray's time, per shutter.
    Vec3f velocity{0};
    Vec4f color{1};                      ///< vertex colour
    const Material* material = nullptr;  ///< never null at a hit
    NodeId node;
    NodeId instance;  ///< the innermost node that shows that one by instance_of; null: none does
    CageId cage;
    LightGroups lit_by = kAllGroups;
    std::uint32_t face = 0;          ///< face index in the cage
    std::uint32_t micropolygon = 0;  ///< a hashed number of the quad, for pictures of the grid
    int level = 0;                   ///< the finer level of the pair at which the ray sees the cage, world lengths
    /// The number of VertexShader's values at the hit; if it is 0, none were made, and textures must be looked up.
    int phase_one_channels = 0;
    std::int8_t start_level = kAnyLevel;  ///< one of that pair's two levels, for Ray::start_level
    bool back_side = false;               ///< the ray came from behind the face
    SideName side = 0;                    ///< the side that the ray has met, for Ray::start_side
    /// What dP/dv, over the length of dP/du and both across the outward normal n, has along the tangent and along
    /// cross(n, tangent). It is zero unless the material has a map of directions whose coordinates are rotated.
    Vec2f v_axis{0};
    /// The same for the other set of coordinates. It is set only if the material has a map of directions that takes its
    /// axes from there (scenegraph/map_axes.h).
    MapTangent other_axes;
    float phase_one[lod::VertexShader::kMaxChannels] = {};  ///< the first phase_one_channels are valid

    bool is_hit() const noexcept { return t < std::numeric_limits<float>::infinity(); }
};

/// The largest number of hits of one ray that Tracer::nearest() finds at once.
inline constexpr int kMostNearest = 64;

struct HitCount {
    std::int16_t count = 0;
    bool is_all = true;  ///< false: there may be more hits behind these
};

/// Holds where a ray ends, without what shading needs.
struct FirstHit {
    float t = std::numeric_limits<float>::infinity();  ///< infinity if nothing was hit
    NodeId node;
    CageId cage;
    std::uint32_t face = 0;  ///< face index in the cage
    NodeId instance{};       ///< as in SurfaceHit

    bool is_hit() const noexcept { return t < std::numeric_limits<float>::infinity(); }
};

}  // namespace occam::accel
