// A light of the scene graph in world axes, and how it is sampled.
//
// Area lights have no surface in the scene: camera rays do not see them, but mirrors show them.
//
// Space    world axes, frame lengths (scenegraph/frame_scale.h); positions are double, directions are float.
// Threads  const after construction.
#pragma once

#include <algorithm>
#include <cmath>

#include "base/vec.h"
#include "scenegraph/frame_scale.h"
#include "scenegraph/light.h"
#include "scenegraph/ray_kind.h"

namespace occam::shade {

/// Holds the uniform numbers in [0, 1) for one sample of one light.
struct LightNumbers {
    Vec2f square{0.5f};
    float choice = 0.5f;
};

/// Describes what one sample of a light sends to a point.
struct LightSample {
    Vec3f direction{0};  ///< unit, towards the light
    float distance = 0;  ///< at which a shadow ray ends, a little before the light; infinity for parallel light
    Vec3f radiance{0};   ///< incoming, divided by the density of the sample per solid angle; zero: nothing arrives
    float density = 0;   ///< per solid angle; 0: the light has no extent, and no scattered ray can find it
    std::uint8_t kinds = RayKind::Shadow;  ///< of the ray that decides whether it arrives
};

/// Describes where a ray crosses a light that has no surface in the scene.
struct LightCrossing {
    float distance = 0;  ///< as in LightSample: a surface that is met from here on does not hide the light
    Vec3f radiance{0};   ///< zero: the ray does not cross the light, or crosses it from behind
    float density = 0;   ///< density with which WorldLight::sample() draws this direction
};

/// A light in world axes. `kind` decides which fields are read.
struct WorldLight {
    enum class Kind : unsigned char { Point, Sun, Rectangle, Disc, Sphere };
    Kind kind = Kind::Point;
    Vec3d position{0};
    Vec3f direction{0, 0, -1};   ///< the node's -z: where spot lights, suns and flat lights shine to; unit
    Vec3f half_x{0}, half_y{0};  ///< flat lights: from the middle to the edges
    float area = 0;              ///< flat lights only
    float radius = 0;            ///< spheres only
    bool two_sided = false;
    bool is_long = false;  ///< flat lights: half_x is many times as long as half_y
    LightGroups groups = kAllGroups;
    Vec3f strength{0};                      ///< intensity, irradiance or radiance, depending on the kind
    float range = 0;                        ///< point lights only; 0: no limit
    float spot_scale = 0, spot_offset = 1;  ///< applied to the cosine to `direction` (KHR_lights_punctual)
    float sun_spread = 0;                   ///< tangent of the half angle that the sun's disc subtends

    /// Places a light by its node; `light` is as the scene describes it. The intensity of a point light is converted with
    /// the square of the unit of length, so that the irradiance at a distance stays the same.
    static WorldLight place(const Light& light, const Mat4d& world_from_node, const FrameScale& scale = {});
    LightSample sample(Vec3d point, LightNumbers numbers) const noexcept
    {
        return sample_from(Vec3f(position - point), numbers);
    }
    /// Samples the light like sample(), from a point that is given by the vector to the middle of the light. Several
    /// samples then need one subtraction in double.
    LightSample sample_from(Vec3f to_middle, LightNumbers numbers) const noexcept;
    LightCrossing crossing(Vec3d origin, Vec3f direction) const noexcept;
    /// Returns the squared sine of the half angle that a sphere around the light subtends at the point, or that the disc of
    /// a sun does anywhere; the result is above 1 within that sphere.
    float sine2_subtended(Vec3d point) const noexcept;
    /// Returns whether floats hold the squares of all distances between the light and the surfaces of a scene. The frame
    /// leaves out a light that is farther away than kFarthestLight, or whose place is not a number.
    /// middle   that of the scene
    bool is_in_reach(Vec3d middle) const noexcept;
    /// Returns the square of the radius of that sphere.
    float size2() const noexcept
    {
        // No point of a parallelogram, sheared or not, is farther from its middle than its corners are.
        return kind == Kind::Sphere
                   ? radius * radius
                   : glm::dot(half_x, half_x) + glm::dot(half_y, half_y) + 2 * std::fabs(glm::dot(half_x, half_y));
    }
    /// Returns whether the light subtends a solid angle: sample() depends on its numbers, and rays can cross the light.
    bool has_extent() const noexcept { return kind != Kind::Point && !(kind == Kind::Sun && !(sun_spread > 0)); }
    /// Returns whether the light has an area at a finite distance.
    bool has_area() const noexcept { return kind == Kind::Rectangle || kind == Kind::Disc || kind == Kind::Sphere; }

private:
    /// Samples a flat light; `at` is in [-1, 1] from side to side.
    LightSample sample_flat(Vec3f to_middle, Vec2f at) const noexcept
    {
        return sample_towards(to_middle + half_x * at.x + half_y * at.y, 1);
    }
    /// Samples the point of a flat light that `to_light` leads to.
    /// share   the density of samples there, relative to evenly spread ones
    LightSample sample_towards(Vec3f to_light, float share) const noexcept;
    LightSample sample_other(Vec3f to_middle, LightNumbers numbers) const noexcept;
};

/// The largest distance of a light from the middle of the scene, frame lengths. A point light of kMaxRadiance there gives an
/// irradiance of 1e-18.
inline constexpr double kFarthestLight = 1e15;

/// The smallest squared distance to a light, frame lengths: 1 / d^2 must not overflow. A scene may be 1e16 times as large as
/// what is near a lamp.
inline constexpr float kMinDistance2 = 1e-36f;
/// The most that a light without a surface gives, in units of the frame.
inline constexpr float kMostOfAPoint = 1e30f;

/// A surface in the plane of a light, such as a ceiling, does not hide it, although rounding may put that surface before the
/// light. So a ray to a light ends before it by what rounding may move either: so many ulps of the distance and of the
/// largest coordinate of a scene. But where the scene is so large that this would reach past a screen close before the
/// light, it is a small share of the size of the light, or, for a light without one, of the distance.
struct LightGap {
    static constexpr float kUlps = 16 * 0x1p-23f, kOfScene = 2 * kUlps, kShare = 0x1p-10f;
    /// Surfaces about a light without an extent may be seen at this cosine.
    static constexpr float kLeastCosine = 1.0f / 8;

    /// Returns the gap that is there at any distance, across the plane of a flat light.
    static float across(float area) noexcept { return std::min(kOfScene, kShare * std::sqrt(area)); }
    /// Returns where a ray to a flat light ends.
    /// least   across() of the light
    template <class T>
    static T end(T distance, T cosine, T least) noexcept
    {
        return distance - (distance * T(kUlps) + least) / cosine;
    }
    /// Returns where a ray to a light without an extent ends.
    template <class T>
    static T end(T distance) noexcept
    {
        using std::min;
        const T most = T(kShare) * distance;
        return distance - min((distance * T(kUlps) + T(kOfScene)) * T(1 / kLeastCosine), most);
    }
};

inline LightSample WorldLight::sample_towards(Vec3f to_light, float share) const noexcept
{
    const float distance2 = std::max(glm::dot(to_light, to_light), kMinDistance2);
    const float distance = std::sqrt(distance2);
    const Vec3f towards = to_light * (1 / distance);
    float cosine = -glm::dot(towards, direction);
    if (two_sided) cosine = std::fabs(cosine);
    if (!(cosine > 0)) return {};
    const float solid_angle = area * cosine / (distance2 * share);
    if (!(solid_angle > 0)) return {};  // it has no area, or is too far away for floats
    const float end = LightGap::end(distance, cosine, LightGap::across(area));
    if (!(end > 0)) return {};  // the point is in the light's plane
    return {towards, end, strength * solid_angle, 1 / solid_angle};
}

// Most lights are rectangles, so they are inlined into the caller's loop.
inline LightSample WorldLight::sample_from(Vec3f to_middle, LightNumbers numbers) const noexcept
{
    return kind == Kind::Rectangle && !is_long ? sample_flat(to_middle, numbers.square * 2.0f - 1.0f)
                                               : sample_other(to_middle, numbers);
}

}  // namespace occam::shade
