#include "scenegraph/animation.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <limits>

#include "scenegraph/interpolation.h"

namespace occam {
namespace {

Vec4d normalised(Vec4d q) noexcept
{
    const double length = std::sqrt(glm::dot(q, q));
    return length > 0 ? q / length : Vec4d(0, 0, 0, 1);
}

// Returns sin(t x) / sin(x), for an x of at most a quarter of a turn, from its series in 1 - cos(x) (Eberly 2011). Sines of
// floats would be too coarse: what turns slowly would move in steps, which motion layers of short shutters show.
// versine   1 - cos(x)
double ratio_of_sines(double t, double versine) noexcept
{
    double sum = t, term = t;
    // Each term is at most half of the one before it.
    for (int i = 1; std::abs(term) > 0x1p-56 * std::abs(sum); ++i) {
        term *= (i * i - t * t) * versine / (i * (2 * i + 1));
        sum += term;
    }
    return sum;
}

// Names the parts of a CUBICSPLINE key.
enum KeyElement : std::size_t { InTangent, Value, OutTangent };

class Keys {
public:
    explicit Keys(const Channel& channel) noexcept : channel_(channel), parts_(row_of(channel.interpolation).values_a_key) {}
    double at(std::size_t key, std::size_t component, KeyElement part = Value) const noexcept
    {
        const std::size_t offset = parts_ == 3 ? std::size_t(part) : 0;
        return double(channel_.values[(key * parts_ + offset) * static_cast<std::size_t>(channel_.width) + component]);
    }
    Vec4d rotation(std::size_t key) const noexcept { return normalised({at(key, 0), at(key, 1), at(key, 2), at(key, 3)}); }

private:
    const Channel& channel_;
    std::size_t parts_;
};

// Follows Hermite's cubic; tangents are changes per second (glTF 2.0, appendix C, "cubic spline interpolation").
void follow_spline(const Keys& keys, std::size_t k, double t, double duration, std::span<double> values) noexcept
{
    const double t2 = t * t, t3 = t2 * t;
    for (std::size_t c = 0; c < values.size(); ++c)
        values[c] = (2 * t3 - 3 * t2 + 1) * keys.at(k, c) + duration * (t3 - 2 * t2 + t) * keys.at(k, c, OutTangent) +
                    (3 * t2 - 2 * t3) * keys.at(k + 1, c) + duration * (t3 - t2) * keys.at(k + 1, c, InTangent);
}

}  // namespace

// The transform scales first, then rotates, then translates (glTF 2.0, sec. 3.5.3).
Mat4d Trs::matrix() const noexcept
{
    const double x = rotation.x, y = rotation.y, z = rotation.z, w = rotation.w;
    const Vec3d right(1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w));
    const Vec3d up(2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w));
    const Vec3d back(2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y));
    return {Vec4d(right * scale.x, 0), Vec4d(up * scale.y, 0), Vec4d(back * scale.z, 0), Vec4d(translation, 1)};
}

Vec4d slerp(Vec4d a, Vec4d b, double t) noexcept
{
    if (glm::dot(a, b) < 0) b = -b;
    const Vec4d across = a - b;
    const double versine = glm::dot(across, across) / 2;
    return normalised(a * ratio_of_sines(1 - t, versine) + b * ratio_of_sines(t, versine));
}

namespace {

/// Returns the vector with a length of 1; 0 if it has none.
Vec3d unit_or_zero(Vec3d v) noexcept
{
    const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    return largest > 0 ? glm::normalize(v / largest) : Vec3d(0);
}

/// Returns a unit vector across this one.
Vec3d any_across(Vec3d v) noexcept
{
    const Vec3d to_z = unit_or_zero(glm::cross(Vec3d(0, 0, 1), v));
    return to_z == Vec3d(0) ? Vec3d(1, 0, 0) : to_z;
}

/// Returns the length of a vector whose square may be too large, or too small, for a double.
double length_of(Vec3d v) noexcept
{
    const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    return largest > 0 ? glm::length(v / largest) * largest : 0;
}

}  // namespace

Trs decomposed(const Mat4d& m) noexcept
{
    Trs trs;
    trs.translation = Vec3d(m[3]);
    trs.scale = {length_of(Vec3d(m[0])), length_of(Vec3d(m[1])), length_of(Vec3d(m[2]))};
    Vec3d x = unit_or_zero(Vec3d(m[0])), y = unit_or_zero(Vec3d(m[1]));
    const Vec3d z = unit_or_zero(Vec3d(m[2]));
    if (glm::dot(glm::cross(x, y), z) < 0) x = -x, trs.scale.x = -trs.scale.x;
    // An axis without a length may have any direction that is across the others.
    if (x == Vec3d(0)) x = unit_or_zero(glm::cross(y, z));
    if (x == Vec3d(0)) x = y != Vec3d(0) ? any_across(y) : z != Vec3d(0) ? any_across(z) : Vec3d(1, 0, 0);
    const Vec3d across = y - x * glm::dot(x, y);
    y = glm::length(across) > 0x1p-40 ? glm::normalize(across) : Vec3d(0);
    if (y == Vec3d(0)) y = unit_or_zero(glm::cross(z, x));
    if (y == Vec3d(0)) y = any_across(x);
    const glm::dquat q = glm::quat_cast(Mat3d(x, y, glm::cross(x, y)));
    trs.rotation = glm::normalize(Vec4d(q.x, q.y, q.z, q.w));
    return trs;
}

TimeRange time_range(const Clip& clip) noexcept
{
    TimeRange range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    for (const Channel& channel : clip.channels) {
        if (channel.times.empty()) continue;
        range.first = std::min(range.first, double(channel.times.front()));
        range.last = std::max(range.last, double(channel.times.back()));
    }
    return range.first <= range.last ? range : TimeRange{};
}

double looped(TimeRange range, double seconds) noexcept
{
    const double length = range.last - range.first;
    if (!(length > 0) || !std::isfinite(seconds)) return range.first;
    double since = std::fmod(seconds - range.first, length);
    if (since < 0) since += length;
    if (since >= length) since = 0;  // a moment just before the first one, whose distance from it is lost in rounding
    return range.first + since;
}

void evaluate(const Channel& channel, double seconds, std::span<double> values) noexcept
{
    const Keys keys(channel);
    const std::vector<float>& times = channel.times;
    if (times.empty()) return;
    const bool is_rotation = channel.path == Channel::Path::Rotation;
    const auto store = [&](Vec4d q) { std::copy_n(&q[0], values.size(), values.begin()); };
    const auto hold = [&](std::size_t key) {
        if (is_rotation) return store(keys.rotation(key));
        for (std::size_t c = 0; c < values.size(); ++c) values[c] = keys.at(key, c);
    };
    if (!(seconds > double(times.front()))) return hold(0);
    if (!(seconds < double(times.back()))) return hold(times.size() - 1);

    const auto after = std::upper_bound(times.begin(), times.end(), seconds,
                                        [](double s, float key) { return s < double(key); });
    const auto k = static_cast<std::size_t>(after - times.begin()) - 1;
    const double duration = double(times[k + 1]) - double(times[k]), t = (seconds - double(times[k])) / duration;
    switch (channel.interpolation) {
        case Channel::Interpolation::Step:
            hold(k);
            break;
        case Channel::Interpolation::Linear:
            if (is_rotation) return store(slerp(keys.rotation(k), keys.rotation(k + 1), t));
            for (std::size_t c = 0; c < values.size(); ++c) values[c] = keys.at(k, c) * (1 - t) + keys.at(k + 1, c) * t;
            break;
        case Channel::Interpolation::CubicSpline:
            follow_spline(keys, k, t, duration, values);
            if (is_rotation) store(normalised({values[0], values[1], values[2], values[3]}));
            break;
    }
}

}  // namespace occam
