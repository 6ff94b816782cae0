// A point to be shaded: what phase two knows of a hit, whoever has found it.
#pragma once

#include "lod/vertex_shader.h"
#include "scenegraph/map_axes.h"

namespace occam::shade {

struct ShadePoint {
    Vec3d position{0};                   ///< world
    Vec3f to_eye{0, 0, 1};               ///< unit, towards the ray's origin
    Vec3f normal_geometric{0, 0, 1};     ///< unit, on the side of to_eye
    Vec3f normal_shading{0, 0, 1};       ///< unit, on the side of normal_geometric
    bool back_side = false;              ///< the eye is behind the face: its outward normal is -normal_geometric
    Vec3f to_start{0};                   ///< offset from `position` to the point where secondary rays start
    Vec3f start_normal{0, 0, 1};         ///< normal of the micropolygon there, unit, on the side of normal_geometric
    float self_distance = 0;             ///< a secondary ray starts this far along start_normal, to the side it leaves by
    MapTangent axes, other_axes;         ///< of the set axes_set_of(*material), and of the other one
    Vec3f u_gradient{0}, v_gradient{0};  ///< gradients of the bump map's coordinates, per world length; zero: no bump map
    lod::VertexToShade texture;          ///< where textures are looked up, over the footprint of the ray
    const float* phase_one = nullptr;    ///< what PhaseOne made at the vertices about the hit, interpolated; null: nothing
    Vec4f color{1};                      ///< vertex colour, linear
    const Material* material = nullptr;  ///< never null
};

}  // namespace occam::shade
