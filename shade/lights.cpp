#include "shade/lights.h"
#include "shade/input_limits.h"

#include <algorithm>
#include <limits>

#include "shade/frame_of.h"

namespace occam::shade {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

Vec3f axis(const Mat4d& m, int column) { return Vec3f(Vec3d(m[column])); }

Vec3f unit_or(Vec3d v, Vec3f fallback) noexcept
{
    const double length = glm::length(v);
    return length > 0 && length < std::numeric_limits<double>::infinity() ? Vec3f(v / length) : fallback;
}

// Returns the node's -z as a normal: it is perpendicular to the node's x and y also when they are sheared.
Vec3f shining_normal(const Mat4d& m) noexcept
{
    const Vec3d n = glm::cross(Vec3d(m[0]), Vec3d(m[1]));
    return unit_or(glm::dot(n, Vec3d(m[2])) < 0 ? n : -n, {0, 0, -1});
}

void place_point(WorldLight& out, const PointLight& light)
{
    out.kind = WorldLight::Kind::Point;
    out.strength = light.intensity;
    out.range = light.range;
    if (light.outer_angle < 3.1415f) {
        const float cos_outer = maths::cos(light.outer_angle);
        out.spot_scale = 1 / std::max(0.001f, maths::cos(light.inner_angle) - cos_outer);
        out.spot_offset = -cos_outer * out.spot_scale;
    }
}

void place_area(WorldLight& out, const AreaLight& light, const Mat4d& world_from_node)
{
    out.strength = light.radiance;
    out.two_sided = light.two_sided;
    out.direction = shining_normal(world_from_node);
    out.half_x = axis(world_from_node, 0) * (light.size.x * 0.5f);
    out.half_y = axis(world_from_node, 1) * (light.size.y * 0.5f);
    out.area = glm::length(glm::cross(out.half_x, out.half_y));
    switch (light.shape) {
        case AreaLight::Shape::Rectangle:
            out.kind = WorldLight::Kind::Rectangle;
            out.area *= 4;
            break;
        case AreaLight::Shape::Disc:
            out.kind = WorldLight::Kind::Disc;
            out.area *= kPi;
            break;
        case AreaLight::Shape::Sphere:
            out.kind = WorldLight::Kind::Sphere;
            out.radius = glm::length(out.half_x);
            break;
    }
}

LightSample sample_point(const WorldLight& light, Vec3f to_light) noexcept
{
    const float distance2 = std::max(glm::dot(to_light, to_light), kMinDistance2);
    const float distance = std::sqrt(distance2);
    const Vec3f direction = to_light / distance;
    const float cone = std::clamp(-glm::dot(direction, light.direction) * light.spot_scale + light.spot_offset, 0.0f, 1.0f);
    float fall = cone * cone / distance2;
    if (light.range > 0) {
        const float share = distance2 / (light.range * light.range);
        fall *= std::clamp(1 - share * share, 0.0f, 1.0f);
    }
    return {direction, distance, light.strength * fall, 0};
}

LightSample sample_sun(const WorldLight& light, LightNumbers numbers) noexcept
{
    Vec3f direction = -light.direction;
    if (light.sun_spread > 0) {
        const ShadingFrame axes(direction);
        const Vec2f d = disc_point(numbers.square) * light.sun_spread;
        direction = glm::normalize(axes.to_world({d.x, d.y, 1}));
    }
    return {direction, kInfinity, light.strength, 0};
}

LightCrossing cross_flat(const WorldLight& light, Vec3d origin, Vec3f direction) noexcept
{
    const float cosine = -glm::dot(direction, light.direction);
    if (!(light.two_sided ? cosine != 0 : cosine > 0) || !(light.area > 0)) return {};
    const Vec3f to_middle(light.position - origin);
    const float distance = glm::dot(to_middle, light.direction) / -cosine;
    if (!(distance > 0)) return {};
    const Vec3f at = direction * distance - to_middle;
    // These are coordinates along the half sides, which may be sheared.
    const float xx = glm::dot(light.half_x, light.half_x), yy = glm::dot(light.half_y, light.half_y),
                xy = glm::dot(light.half_x, light.half_y), ax = glm::dot(at, light.half_x), ay = glm::dot(at, light.half_y);
    const float determinant = xx * yy - xy * xy;
    if (!(determinant > 0)) return {};
    const float u = (ax * yy - ay * xy) / determinant, v = (ay * xx - ax * xy) / determinant;
    const bool is_inside = light.kind == WorldLight::Kind::Disc ? u * u + v * v <= 1
                                                                : std::fabs(u) <= 1 && std::fabs(v) <= 1;
    if (!is_inside) return {};
    return {distance, light.strength, distance * distance / (light.area * std::fabs(cosine))};
}

// Returns 1 - cos of the cone that a sphere subtends, without the cancellation that a small one would cause; 0 inside of
// the sphere.
float cone_height(float radius, float distance2) noexcept
{
    const float sin2 = radius * radius / distance2;
    return sin2 < 1 ? sin2 / (1 + std::sqrt(1 - sin2)) : 0;
}

LightCrossing cross_sphere(const WorldLight& light, Vec3d origin, Vec3f direction) noexcept
{
    const Vec3f to_centre(light.position - origin);
    const float height = cone_height(light.radius, glm::dot(to_centre, to_centre));
    if (!(height > 0)) return {};
    const float along = glm::dot(to_centre, direction);
    const Vec3f across = to_centre - direction * along;
    const float inside2 = light.radius * light.radius - glm::dot(across, across);
    if (!(inside2 >= 0) || !(along > 0)) return {};
    return {along - std::sqrt(inside2), light.strength, 1 / (2 * kPi * height)};
}

// Draws a direction uniformly in the cone that the sphere subtends.
LightSample sample_sphere(const WorldLight& light, Vec3f to_centre, LightNumbers numbers) noexcept
{
    const float distance2 = glm::dot(to_centre, to_centre);
    const float one_minus_cos_most = cone_height(light.radius, distance2);
    if (!(one_minus_cos_most > 0)) return {};
    const Vec2f d = disc_point(numbers.square);
    const float one_minus_cos = (d.x * d.x + d.y * d.y) * one_minus_cos_most;
    const float cosine = 1 - one_minus_cos;
    // The squared radius of a disc point is uniform, and so is 1 - cos in a cone, so the point is scaled to that ring.
    const float stretch = std::sqrt(one_minus_cos_most * (2 - one_minus_cos));
    const float distance = std::sqrt(distance2);
    const ShadingFrame axes(to_centre / distance);
    const Vec3f direction = glm::normalize(axes.to_world({d.x * stretch, d.y * stretch, cosine}));
    const float sin2_ray = one_minus_cos * (2 - one_minus_cos);
    const float inside = std::sqrt(std::max(0.0f, light.radius * light.radius - distance2 * sin2_ray));
    return {direction, distance * cosine - inside, light.strength * (2 * kPi * one_minus_cos_most),
            1 / (2 * kPi * one_minus_cos_most)};
}

}  // namespace

WorldLight WorldLight::place(const Light& light, const Mat4d& world_from_node)
{
    WorldLight out;
    out.position = Vec3d(world_from_node[3]);
    out.groups = light.groups;
    out.direction = unit_or(-Vec3d(world_from_node[2]), {0, 0, -1});
    if (const auto* point = std::get_if<PointLight>(&light.kind)) {
        place_point(out, *point);
    } else if (const auto* sun = std::get_if<SunLight>(&light.kind)) {
        out.kind = Kind::Sun;
        out.strength = sun->irradiance;
    } else if (const auto* area_light = std::get_if<AreaLight>(&light.kind)) {
        place_area(out, *area_light, world_from_node);
    }
    out.strength = limited(out.strength);
    return out;
}

LightSample WorldLight::sample_other(Vec3f to_middle, LightNumbers numbers) const noexcept
{
    switch (kind) {
        case Kind::Point:
            return sample_point(*this, to_middle);
        case Kind::Sun:
            return sample_sun(*this, numbers);
        case Kind::Disc:
            return sample_flat(to_middle, disc_point(numbers.square));
        case Kind::Sphere:
            return sample_sphere(*this, to_middle, numbers);
        case Kind::Rectangle:
            break;  // sample_from() samples rectangles
    }
    return {};
}

float WorldLight::sine2_subtended(Vec3d point) const noexcept
{
    // No point of a parallelogram, sheared or not, is farther from its middle than its corners are.
    const float flat2 = glm::dot(half_x, half_x) + glm::dot(half_y, half_y) + 2 * std::fabs(glm::dot(half_x, half_y));
    const Vec3f to_middle(position - point);
    return (kind == Kind::Sphere ? radius * radius : flat2) / glm::dot(to_middle, to_middle);
}

LightCrossing WorldLight::crossing(Vec3d origin, Vec3f toward) const noexcept
{
    switch (kind) {
        case Kind::Point:
        case Kind::Sun:
            break;
        case Kind::Rectangle:
        case Kind::Disc:
            return cross_flat(*this, origin, toward);
        case Kind::Sphere:
            return cross_sphere(*this, origin, toward);
    }
    return {};
}

}  // namespace occam::shade
