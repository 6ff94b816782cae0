#include "shade/lights.h"
#include "shade/input_limits.h"

#include <algorithm>
#include <limits>

#include "base/cross_product.h"
#include "base/overloaded.h"
#include "shade/frame_of.h"

namespace occam::shade {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

Vec3f axis(const Mat4d& m, int column) { return Vec3f(Vec3d(m[column])); }

// A side as long as this, in frame lengths, is as good as endless: the scene is at most two long.
constexpr double kLongestSide = 1e15;

// A light counts as long if its sides differ by more than this factor.
constexpr double kLong = 64;

double largest_of(Vec3d v) noexcept { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

// Returns whether the square of a vector with this largest component is within the range of doubles. It is also true for
// vectors that have no direction at all.
bool is_in_range(double largest) noexcept
{
    return (largest > 1e-100 && largest < 1e100) || !(largest > 0) || !std::isfinite(largest);
}

// Returns a vector of the same direction whose products with two others of the kind are within the range of doubles.
Vec3d in_range(Vec3d v) noexcept
{
    const double largest = largest_of(v);
    return is_in_range(largest) ? v : v / largest;
}

// Returns the length of a vector whose square may leave the range of doubles.
double length_of(Vec3d v) noexcept
{
    const double largest = largest_of(v);
    return is_in_range(largest) ? glm::length(v) : glm::length(v / largest) * largest;
}

// Returns the vector from the middle of a flat light to the middle of an edge.
Vec3f half_side(const Mat4d& m, int column, float size) noexcept
{
    const Vec3d exact = Vec3d(m[column]) * (double(size) * 0.5);
    const double length = length_of(exact);
    return length > kLongestSide ? Vec3f(exact * (kLongestSide / length)) : axis(m, column) * (size * 0.5f);
}

Vec3f unit_or(Vec3d v, Vec3f fallback) noexcept
{
    const double length = length_of(v);
    return length > 0 && length < std::numeric_limits<double>::infinity() ? Vec3f(v / length) : fallback;
}

// Returns the node's -z as a normal: it is perpendicular to the node's x and y also when they are sheared.
Vec3f shining_normal(const Mat4d& m) noexcept
{
    const Vec3d n = glm::cross(in_range(Vec3d(m[0])), in_range(Vec3d(m[1])));
    return unit_or(glm::dot(n, in_range(Vec3d(m[2]))) < 0 ? n : -n, {0, 0, -1});
}

// Returns how far apart the cosines of a spot's two cones are. KHR_lights_punctual has them at least 0.001 apart, but with
// that much a spot whose outer cone is narrower than 2.6 degrees would be dark also within its inner cone, down to its
// middle: so an edge is made no softer than a sixteenth of the cone.
float edge_of_spot(float cos_inner, float cos_outer) noexcept
{
    constexpr float kLeast = 0x1p-20f, kSoftest = 0.001f, kShareOfCone = 1.0f / 16;
    const float least = std::clamp((1 - cos_outer) * kShareOfCone, kLeast, kSoftest);
    return std::max(least, cos_inner - cos_outer);
}

void place_point(WorldLight& out, const PointLight& light, const FrameScale& scale)
{
    out.kind = WorldLight::Kind::Point;
    out.strength = Vec3f(Vec3d(light.intensity) * (scale.to_frame() * scale.to_frame()));
    out.range = scale.to_frame(light.range);
    if (light.outer_angle < 3.1415f) {
        const float cos_outer = maths::cos(light.outer_angle);
        out.spot_scale = 1 / edge_of_spot(maths::cos(light.inner_angle), cos_outer);
        out.spot_offset = -cos_outer * out.spot_scale;
    }
}

void place_area(WorldLight& out, const AreaLight& light, const Mat4d& world_from_node)
{
    out.strength = light.radiance;
    out.two_sided = light.two_sided;
    out.direction = shining_normal(world_from_node);
    out.half_x = half_side(world_from_node, 0, light.size.x);
    out.half_y = half_side(world_from_node, 1, light.size.y);
    out.area = area_between(out.half_x, out.half_y);
    if (light.shape != AreaLight::Shape::Sphere) {
        const double x = glm::length(Vec3d(out.half_x)), y = glm::length(Vec3d(out.half_y));
        out.is_long = std::max(x, y) > kLong * std::min(x, y);
        if (out.is_long && y > x) std::swap(out.half_x, out.half_y);
    }
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
    if (!(distance2 < kInfinity)) return {};
    const float distance = std::sqrt(distance2);
    const Vec3f direction = to_light / distance;
    const float cone = std::clamp(-glm::dot(direction, light.direction) * light.spot_scale + light.spot_offset, 0.0f, 1.0f);
    float fall = cone * cone / distance2;
    if (light.range > 0) {
        const float share = distance2 / (light.range * light.range);
        fall *= std::clamp(1 - share * share, 0.0f, 1.0f);
    }
    return {direction, LightGap::end(distance), glm::min(light.strength * fall, Vec3f(kMostOfAPoint)), 0};
}

// Returns the density per solid angle at a squared distance of a place on the disc of a sun, which is a unit away.
float sun_density(const WorldLight& light, float distance2) noexcept
{
    return distance2 * std::sqrt(distance2) / (kPi * light.sun_spread * light.sun_spread);
}

// Samples are spread evenly over a disc that touches the unit sphere, so they are denser per solid angle towards its rim.
LightSample sample_sun(const WorldLight& light, LightNumbers numbers) noexcept
{
    const Vec3f middle = -light.direction;
    if (!(light.sun_spread > 0)) return {middle, kInfinity, light.strength, 0};
    const ShadingFrame axes(middle);
    const Vec2f d = disc_point(numbers.square) * light.sun_spread;
    const float distance2 = d.x * d.x + d.y * d.y + 1;
    const Vec3f direction = axes.to_world({d.x, d.y, 1}) * (1 / std::sqrt(distance2));
    return {direction, kInfinity, light.strength, sun_density(light, distance2)};
}

LightCrossing cross_sun(const WorldLight& light, Vec3f direction) noexcept
{
    const float cosine = -glm::dot(direction, light.direction);
    if (!(light.sun_spread > 0) || !(cosine > 0)) return {};
    const Vec3f across = (direction + light.direction * cosine) * (1 / cosine);  // from the middle of the disc
    const float offset2 = glm::dot(across, across);
    if (!(offset2 <= light.sun_spread * light.sun_spread)) return {};
    const float density = sun_density(light, offset2 + 1);
    return {kInfinity, light.strength * density, density};
}

// Spreads samples along a long light by equal angles, as a point sees the light's axis (Kulla and Fajardo 2012, sec. 4.1):
// evenly spread ones would nearly all be far away. A point farther away than the light is long gets even ones. Places on the
// axis are measured from the one nearest to the point, so that they are precise there.
class LongSide {
public:
    LongSide(const WorldLight& light, Vec3f to_middle) noexcept
        : is_disc_(light.kind == WorldLight::Kind::Disc), across_(light.half_y), half_(glm::length(Vec3d(light.half_x)))
    {
        axis_ = Vec3d(light.half_x) / half_;
        middle_ = glm::dot(Vec3d(to_middle), axis_);
        to_axis_ = Vec3d(to_middle) - axis_ * middle_;
        away_ = std::max(glm::length(to_axis_), glm::length(across_));
        const double beyond = std::max(std::abs(middle_) - half_, 0.0);
        is_near_ = away_ * away_ + beyond * beyond < half_ * half_;
        if (!is_near_) return;
        first_ = angle(middle_ - half_);
        range_ = angle(middle_ + half_) - first_;
    }
    bool is_near() const noexcept { return is_near_; }

    struct Place {
        Vec3f to_light;  ///< from the point
        float share;
    };
    /// Returns the place on the light for a point of the unit square.
    Place at(Vec2f square) const noexcept
    {
        const auto turned = static_cast<float>(first_ + double(square.x) * range_);
        const double along = std::clamp(away_ * double(maths::tan(turned)), middle_ - half_, middle_ + half_);
        const double rim = is_disc_ ? rim_at(along) : 1;
        return {Vec3f(to_axis_ + axis_ * along + across_ * ((2 * double(square.y) - 1) * rim)), share(along)};
    }
    /// Returns the density of the places that at() returns, relative to that of evenly spread ones.
    /// along   how far along the axis the place is
    float share(double along) const noexcept
    {
        if (!is_near_) return 1;
        const double density = 2 * half_ * away_ / (range_ * (away_ * away_ + along * along));
        return static_cast<float>(is_disc_ ? density * double(kPi) / (4 * std::max(rim_at(along), 1e-6)) : density);
    }
    /// Returns how far along the axis the place is that at() makes the one at this distance of.
    /// v   the place's coordinate along the other side, which leads along the axis, too, if the sides are sheared
    double along(Vec3f direction, float distance, double v) const noexcept
    {
        return glm::dot(Vec3d(direction), axis_) * double(distance) - v * glm::dot(across_, axis_);
    }

private:
    static double angle(double along, double away) noexcept
    {
        return double(maths::atan2(static_cast<float>(along), static_cast<float>(away)));
    }
    double angle(double along) const noexcept { return angle(along, away_); }
    /// Returns half the width of a disc at a place, as a share of half the light's width.
    double rim_at(double along) const noexcept
    {
        const double u = (along - middle_) / half_;
        return std::sqrt(std::max(1 - u * u, 0.0));
    }

    bool is_disc_, is_near_ = false;
    Vec3d axis_{0}, across_, to_axis_{0};
    double half_, middle_ = 0, away_ = 0;  ///< half the length, the middle's place on the axis, the distance from the axis
    double first_ = 0, range_ = 0;         ///< angles about the point
};

LightCrossing cross_flat(const WorldLight& light, Vec3d origin, Vec3f direction) noexcept
{
    const float cosine = -glm::dot(direction, light.direction);
    if (!(light.two_sided ? cosine != 0 : cosine > 0) || !(light.area > 0)) return {};
    const Vec3f to_middle(light.position - origin);
    const float distance = glm::dot(to_middle, light.direction) / -cosine;
    if (!(distance > 0)) return {};
    const Vec3f at = direction * distance - to_middle;
    // These are coordinates along the half sides, which may be sheared.
    // The fourth power of a long side, or of a short one, leaves the range of floats.
    const Vec3d x(light.half_x), y(light.half_y), p(at);
    const double xx = glm::dot(x, x), yy = glm::dot(y, y), xy = glm::dot(x, y), determinant = xx * yy - xy * xy;
    if (!(determinant > 0)) return {};
    const double px = glm::dot(p, x), py = glm::dot(p, y);
    const double u = (px * yy - py * xy) / determinant, v = (py * xx - px * xy) / determinant;
    const bool is_inside = light.kind == WorldLight::Kind::Disc ? u * u + v * v <= 1
                                                                : std::fabs(u) <= 1 && std::fabs(v) <= 1;
    if (!is_inside) return {};
    float share = 1;
    if (light.is_long) {
        const LongSide side(light, to_middle);
        share = side.share(side.along(direction, distance, v));
    }
    const float end = LightGap::end(distance, std::fabs(cosine), LightGap::across(light.area));
    if (!(end > 0)) return {};
    return {end, light.strength, share * distance * distance / (light.area * std::fabs(cosine))};
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

WorldLight WorldLight::place(const Light& light, const Mat4d& placement, const FrameScale& scale)
{
    const Mat4d world_from_node = scale.placed(placement);
    WorldLight out;
    out.position = Vec3d(world_from_node[3]);
    out.groups = light.groups;
    out.direction = unit_or(-Vec3d(world_from_node[2]), {0, 0, -1});
    std::visit(Overloaded{[&](const PointLight& point) { place_point(out, point, scale); },
                          [&](const SunLight& sun) {
                              out.kind = Kind::Sun;
                              out.position = Vec3d(0);  // it is infinitely far, wherever its node is
                              out.strength = sun.irradiance;
                          },
                          [&](const AreaLight& area_light) { place_area(out, area_light, world_from_node); }},
               light.kind);
    out.strength = limited(out.strength);
    return out;
}

bool WorldLight::is_in_reach(Vec3d middle) const noexcept
{
    const auto are_numbers = [](Vec3f v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); };
    return length_of(position - middle) <= kFarthestLight && are_numbers(half_x) && are_numbers(half_y);
}

LightSample WorldLight::sample_other(Vec3f to_middle, LightNumbers numbers) const noexcept
{
    if (is_long)
        if (const LongSide side(*this, to_middle); side.is_near()) {
            const LongSide::Place place = side.at(numbers.square);
            return sample_towards(place.to_light, place.share);
        }
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
            return sample_flat(to_middle, numbers.square * 2.0f - 1.0f);
    }
    return {};
}

float WorldLight::sine2_subtended(Vec3d point) const noexcept
{
    if (kind == Kind::Sun) return sun_spread * sun_spread / (1 + sun_spread * sun_spread);
    const Vec3f to_middle(position - point);
    return size2() / glm::dot(to_middle, to_middle);
}

LightCrossing WorldLight::crossing(Vec3d origin, Vec3f toward) const noexcept
{
    switch (kind) {
        case Kind::Point:
            break;
        case Kind::Sun:
            return cross_sun(*this, toward);
        case Kind::Rectangle:
        case Kind::Disc:
            return cross_flat(*this, origin, toward);
        case Kind::Sphere:
            return cross_sphere(*this, origin, toward);
    }
    return {};
}

}  // namespace occam::shade
