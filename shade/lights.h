// A light of the scene graph in world axes, and how it is sampled.
//
// Area lights have no surface in the scene: they are not seen by camera rays, but mirrors show them.
//
// Space    world; positions double, directions float.
// Threads  const after construction.
#pragma once

#include <algorithm>
#include <cmath>

#include "base/vec.h"
#include "scenegraph/light.h"

namespace occam::shade {

/// Uniform numbers in [0, 1) for one sample of one light.
struct LightNumbers {
    Vec2f square{0.5f};
    float choice = 0.5f;
};

/// What one sample of a light sends to a point.
struct LightSample {
    Vec3f direction{0};  ///< unit, towards the light
    float distance = 0;  ///< infinity for parallel light
    Vec3f radiance{0};   ///< incoming, divided by the sample's density per solid angle; zero: nothing arrives
    float density = 0;   ///< per solid angle; 0: the light has no extent, and no scattered ray can meet it
};

/// Where a ray meets a light that has no surface in the scene.
struct LightCrossing {
    float distance = 0;
    Vec3f radiance{0};  ///< zero: the ray does not meet it, or from behind
    float density = 0;  ///< that WorldLight::sample() has for this direction
};

/// A light in world axes. Which fields are read depends on `kind`.
struct WorldLight {
    enum class Kind : unsigned char { Point, Sun, Rectangle, Disc, Sphere };
    Kind kind = Kind::Point;
    Vec3d position{0};
    Vec3f direction{0, 0, -1};   ///< the node's -z: where spot, sun and flat lights shine to; unit
    Vec3f half_x{0}, half_y{0};  ///< flat lights: from the middle to the edges
    float area = 0;              ///< flat lights
    float radius = 0;            ///< sphere
    bool two_sided = false;
    LightGroups groups = kAllGroups;
    Vec3f strength{0};                      ///< intensity, irradiance or radiance, by kind
    float range = 0;                        ///< point; 0: no limit
    float spot_scale = 0, spot_offset = 1;  ///< of the cosine to `direction` (KHR_lights_punctual)
    float sun_spread = 0;                   ///< tangent of the half angle that the sun's disc covers

    /// Light is placed by its node; `light` as the scene describes it.
    static WorldLight place(const Light& light, const Mat4d& world_from_node);
    LightSample sample(Vec3d point, LightNumbers numbers) const noexcept
    {
        return sample_from(Vec3f(position - point), numbers);
    }
    /// The same from a point that is known by where it sees the light's middle: of several samples, one subtraction in
    /// double.
    LightSample sample_from(Vec3f to_middle, LightNumbers numbers) const noexcept;
    LightCrossing crossing(Vec3d origin, Vec3f direction) const noexcept;
    /// Squared sine of the angle about its middle that it covers from there, by a sphere around it: above 1 within that
    /// sphere.
    float cover(Vec3d point) const noexcept;
    /// Rays can meet it: it has an area.
    bool has_area() const noexcept { return kind == Kind::Rectangle || kind == Kind::Disc || kind == Kind::Sphere; }

private:
    /// `at` in [-1, 1]: the sides.
    LightSample sample_flat(Vec3f to_middle, Vec2f at) const noexcept;
    LightSample sample_other(Vec3f to_middle, LightNumbers numbers) const noexcept;
};

/// A light no nearer than this is finite: a point light's 1 / d^2 must not overflow.
inline constexpr float kMinDistance2 = 1e-12f;

inline LightSample WorldLight::sample_flat(Vec3f to_middle, Vec2f at) const noexcept
{
    const Vec3f to_light = to_middle + half_x * at.x + half_y * at.y;
    const float distance2 = std::max(glm::dot(to_light, to_light), kMinDistance2);
    const float distance = std::sqrt(distance2);
    const Vec3f towards = to_light * (1 / distance);
    float cosine = -glm::dot(towards, direction);
    if (two_sided) cosine = std::fabs(cosine);
    if (!(cosine > 0)) return {};
    const float solid_angle = area * cosine / distance2;
    return {towards, distance, strength * solid_angle, 1 / solid_angle};
}

// Most lights are rectangles: these are worth a place in the caller's loop.
inline LightSample WorldLight::sample_from(Vec3f to_middle, LightNumbers numbers) const noexcept
{
    return kind == Kind::Rectangle ? sample_flat(to_middle, numbers.square * 2.0f - 1.0f) : sample_other(to_middle, numbers);
}

}  // namespace occam::shade
