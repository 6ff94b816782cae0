// Lights. A light belongs to a node and is transformed with it; the environment belongs to the scene.
#pragma once

#include <string>
#include <variant>

#include "base/vec.h"
#include "scenegraph/ids.h"
#include "scenegraph/ray_kind.h"

namespace occam {

/// A point or spot light (KHR_lights_punctual). Its intensity is in candela (here W/sr a channel) and falls with the square
/// of distance.
struct PointLight {
    Vec3f intensity{1};
    float range = 0;  ///< beyond it the light fades out as KHR_lights_punctual says; 0: no limit
    /// The half angles of a spot, in radians around the node's -z axis; an outer angle of pi makes a point light.
    float inner_angle = 0, outer_angle = 3.14159265f;
};
/// A distant light along the node's -z axis; its irradiance (lux) is at normal incidence.
struct SunLight {
    Vec3f irradiance{1};
};
/// Emits constant radiance to its front side, the node's -z axis. Its size is in the node's own units.
struct AreaLight {
    enum class Shape : unsigned char { Rectangle, Disc, Sphere };
    Shape shape = Shape::Rectangle;
    Vec2f size{1};  ///< width along x and height along y; disc and sphere: diameters (sphere: x alone)
    Vec3f radiance{1};
    bool two_sided = false;
};

struct Light {
    std::string name{};
    std::variant<PointLight, SunLight, AreaLight> kind{};
    LightGroups groups = kAllGroups;  ///< it lights the surfaces that belong to one of these groups
};

/// Radiance from infinitely far: a constant, times an equirectangular image if there is one (y up, centre of the
/// image along -z before rotation).
struct Environment {
    Vec3f radiance{0};
    TextureId image;
    float rotation = 0;  ///< radians about +y
};

}  // namespace occam
