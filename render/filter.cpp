#include "render/filter.h"

#include <algorithm>
#include <cmath>

#include "base/maths.h"

namespace occam::render {
namespace {

// Returns the filter of Mitchell and Netravali 1988 with B = C = 1/3; x is in half widths of its four pixels.
float mitchell(float x) noexcept
{
    x = std::fabs(2 * x);
    constexpr float b = 1 / 3.0f, c = 1 / 3.0f;
    if (x <= 1) return ((12 - 9 * b - 6 * c) * x * x * x + (-18 + 12 * b + 6 * c) * x * x + (6 - 2 * b)) / 6;
    if (x <= 2) return ((-b - 6 * c) * x * x * x + (6 * b + 30 * c) * x * x + (-12 * b - 48 * c) * x + (8 * b + 24 * c)) / 6;
    return 0;
}

// Returns the window of four terms (Harris 1978).
float blackman_harris(float x) noexcept
{
    const float a = maths::kPi * (x + 1);
    return 0.35875f - 0.48829f * maths::cos(a) + 0.14128f * maths::cos(2 * a) - 0.01168f * maths::cos(3 * a);
}

// Returns a Gaussian whose sigma is a third of the radius, lowered so that it ends at zero.
float gaussian(float x) noexcept { return std::max(0.0f, maths::exp(-4.5f * x * x) - maths::exp(-4.5f)); }

}  // namespace

PixelFilter::PixelFilter(FilterKind kind, float radius) : kind_(kind), radius_(radius > 0 ? radius : row_of(kind).radius)
{
    double sum = 0;
    std::array<double, kSteps + 1> running{};
    for (std::size_t i = 0; i < kSteps; ++i) {
        const float middle = (2 * (static_cast<float>(i) + 0.5f) / kSteps - 1) * radius_;
        sum += std::fabs(double(value(middle)));
        running[i + 1] = sum;
    }
    for (std::size_t i = 0; i <= kSteps; ++i) sums_[i] = static_cast<float>(running[i] / sum);
}

float PixelFilter::value(float x) const noexcept
{
    const float share = x / radius_;
    if (!(std::fabs(share) <= 1)) return 0;
    switch (kind_) {
        case FilterKind::Box:
            return 1;
        case FilterKind::Tent:
            return 1 - std::fabs(share);
        case FilterKind::Gaussian:
            return gaussian(share);
        case FilterKind::BlackmanHarris:
            return blackman_harris(share);
        case FilterKind::Mitchell:
            return mitchell(share);
    }
    return 0;
}

float PixelFilter::place_on_axis(float u) const noexcept
{
    if (kind_ == FilterKind::Box) return 2 * u - 1;
    if (kind_ == FilterKind::Tent) return u < 0.5f ? std::sqrt(2 * u) - 1 : 1 - std::sqrt(2 - 2 * u);
    const auto above = std::upper_bound(sums_.begin() + 1, sums_.end() - 1, u);
    const auto i = static_cast<std::size_t>(above - sums_.begin()) - 1;
    const float step = sums_[i + 1] - sums_[i];
    const float within = step > 0 ? std::clamp((u - sums_[i]) / step, 0.0f, 1.0f) : 0.5f;
    return 2 * (static_cast<float>(i) + within) / kSteps - 1;
}

PixelFilter::Place PixelFilter::place(Vec2f square) const noexcept
{
    const Vec2f offset(place_on_axis(square.x) * radius_, place_on_axis(square.y) * radius_);
    const bool is_positive = kind_ == FilterKind::Box || kind_ == FilterKind::Tent ||
                             (value(offset.x) < 0) == (value(offset.y) < 0);
    return {offset, is_positive ? 1.0f : -1.0f};
}

}  // namespace occam::render
