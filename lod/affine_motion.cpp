#include "lod/affine_motion.h"

#include <algorithm>
#include <cmath>

namespace occam::lod {
namespace {

constexpr double kLeastVolume = 0x1p-10;  // the least determinant, as a part of the product of the columns' lengths
constexpr int kMostHalvings = 8;

double volume(Vec3d a, Vec3d b, Vec3d c) noexcept { return glm::dot(a, glm::cross(b, c)); }

double lerp(double a, double b, double share) noexcept { return share >= 1 ? b : a + (b - a) * share; }
Vec3d lerp(Vec3d a, Vec3d b, double share) noexcept
{
    return {lerp(a.x, b.x, share), lerp(a.y, b.y, share), lerp(a.z, b.z, share)};
}

// Returns whether all maps between two keys are invertible and keep the sign of the determinant.
bool is_invertible_between(const AffinePose& from, const AffinePose& to, double sign, int halvings) noexcept
{
    // The determinant is linear in each column, hence a cubic over the segment; it is nowhere less than the least of its
    // Bernstein coefficients. A column is longest at an end.
    const auto &a = from.columns, &b = to.columns;
    const double least = std::min(
        {sign * volume(a[0], a[1], a[2]),
         sign * (volume(b[0], a[1], a[2]) + volume(a[0], b[1], a[2]) + volume(a[0], a[1], b[2])) / 3,
         sign * (volume(a[0], b[1], b[2]) + volume(b[0], a[1], b[2]) + volume(b[0], b[1], a[2])) / 3,
         sign * volume(b[0], b[1], b[2])});
    double longest = 1;
    for (int c = 0; c < 3; ++c) longest *= std::max(glm::length(a[c]), glm::length(b[c]));
    if (least > kLeastVolume * longest) return true;
    if (halvings == 0) return false;
    AffinePose middle = from;
    for (int c = 0; c < 3; ++c) middle.columns[c] = lerp(a[c], b[c], 0.5);
    return is_invertible_between(from, middle, sign, halvings - 1) && is_invertible_between(middle, to, sign, halvings - 1);
}

}  // namespace

AffineMotion::AffineMotion(std::span<const AffinePose> keys) noexcept : keys_(keys)
{
    for (const AffinePose& key : keys_) {
        double squares = 0;
        for (const Vec3d& column : key.columns) squares += glm::dot(column, column);
        stretch_ = std::max(stretch_, std::sqrt(squares));
    }
    const bool is_fixed = std::all_of(keys_.begin(), keys_.end(), [&](const AffinePose& key) {
        return std::equal(key.columns, key.columns + 3, keys_.front().columns);
    });
    if (!is_fixed || keys_.size() < 2) return;
    // Zeros have the signs that interpolation gives them.
    const AffinePose first = at(0);
    fixed_ = Fixed{first, AffineInverse(first)};
}

AffinePose AffineMotion::at(float tau) const noexcept
{
    const KeyTime time = key_time(tau, segments());
    const AffinePose &a = key(time.key), &b = key(time.key + 1);
    const auto share = double(time.share);
    if (fixed_) {
        const Vec3d(&fixed)[3] = fixed_->pose.columns;
        return {{fixed[0], fixed[1], fixed[2]}, lerp(a.anchor, b.anchor, share)};
    }
    return {{lerp(a.columns[0], b.columns[0], share), lerp(a.columns[1], b.columns[1], share),
             lerp(a.columns[2], b.columns[2], share)},
            lerp(a.anchor, b.anchor, share)};
}

AffinePose AffineMotion::speed_at(float tau) const noexcept
{
    const int first = key_time(tau, segments()).key;
    const AffinePose &a = key(first), &b = key(first + 1);
    const double per_shutter = segments();
    return {{(b.columns[0] - a.columns[0]) * per_shutter, (b.columns[1] - a.columns[1]) * per_shutter,
             (b.columns[2] - a.columns[2]) * per_shutter},
            (b.anchor - a.anchor) * per_shutter};
}

bool AffineMotion::is_invertible() const noexcept
{
    const auto& first = key(0).columns;
    const double sign = volume(first[0], first[1], first[2]) < 0 ? -1.0 : 1.0;
    for (int k = 0; k < segments(); ++k)
        if (!is_invertible_between(key(k), key(k + 1), sign, kMostHalvings)) return false;
    return true;
}

}  // namespace occam::lod
