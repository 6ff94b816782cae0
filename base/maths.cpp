#include "base/maths.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace occam::maths {
namespace {

constexpr double kPiD = 3.14159265358979323846;
constexpr double kLn2 = 0.693147180559945309417;

struct Reduced {
    double r;      // in [-pi/4, pi/4]
    int quadrant;  // 0..3
};

// Returns x less k times pi/2.
double remainder(float x, double k) noexcept
{
    // These are the two parts of pi/2, so that k * high is exact for k below 2^22.
    constexpr double kHigh = 1.57079632673412561417, kLow = 6.07710050650619224932e-11;
    return (double(x) - k * kHigh) - k * kLow;
}

// Returns an angle whose remainder is that of a number. From 2^30 on, where products with parts of pi/2 are rounded by more
// than a turn, full turns are taken away first.
float within_turns(float x) noexcept
{
    return std::fabs(x) < 0x1p30f ? x : static_cast<float>(std::fmod(double(x), 2 * kPiD));
}

Reduced reduce(float any) noexcept
{
    const float x = within_turns(any);
    const double k = std::floor(double(x) * (2 / kPiD) + 0.5);
    const int quadrant = x == x ? static_cast<int>(static_cast<long long>(k) & 3) : 0;
    return {remainder(x, k), quadrant};
}

// Returns the polynomial in q with these coefficients, that of the highest power first.
template <class... Rest>
double series(double q, double highest, Rest... rest) noexcept
{
    ((highest = highest * q + rest), ...);
    return highest;
}

double sin_series(double r) noexcept
{
    return series(r * r, 1 / 6227020800.0, -1 / 39916800.0, 1 / 362880.0, -1 / 5040.0, 1 / 120.0, -1 / 6.0, 1.0) * r;
}

double cos_series(double r) noexcept
{
    return series(r * r, -1 / 87178291200.0, 1 / 479001600.0, -1 / 3628800.0, 1 / 40320.0, -1 / 720.0, 1 / 24.0, -1 / 2.0,
                  1.0);
}

double sin_quadrant(Reduced x) noexcept
{
    const double s = x.quadrant & 1 ? cos_series(x.r) : sin_series(x.r);
    return x.quadrant & 2 ? -s : s;
}

double exp2_double(double x) noexcept
{
    const double k = std::floor(x + 0.5);
    const double f = (x - k) * kLn2;  // |f| <= 0.347
    double s = 1;
    for (int n = 13; n > 0; --n) s = 1 + s * f / n;
    return std::ldexp(s, static_cast<int>(k));
}

double log2_double(double x) noexcept
{
    int e;
    double m = std::frexp(x, &e);
    if (m < 0.70710678118654752) {
        m *= 2;
        --e;
    }
    const double s = (m - 1) / (m + 1), q = s * s;  // |s| <= 0.172: log m = 2 atanh s
    double a = 0;
    for (int n = 19; n > 0; n -= 2) a = a * q + 1.0 / n;
    return e + 2 * s * a / kLn2;
}

// This is written without branches, which would be taken at random.
[[gnu::always_inline]] inline double atan_double(double x) noexcept  // x >= 0
{
    constexpr double kTan = 0.57735026918962576;
    const bool complement = x > 1;
    const double inverse = 1 / x;
    x = complement ? inverse : x;
    const bool turn = x > 0.26794919243112270;  // tan(pi/12): the angle is reduced by pi/6
    const double turned = (x - kTan) / (1 + x * kTan);
    x = turn ? turned : x;
    const double base = turn ? kPiD / 6 : 0;
    const double q = x * x;
    const double s = series(-q, 1 / 21.0, 1 / 19.0, 1 / 17.0, 1 / 15.0, 1 / 13.0, 1 / 11.0, 1 / 9.0, 1 / 7.0, 1 / 5.0,
                            1 / 3.0, 1.0);
    const double angle = base + x * s;
    return complement ? kPiD / 2 - angle : angle;
}

[[gnu::always_inline]] inline float atan2_of(float y, float x) noexcept
{
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const double a = std::fabs(double(y)), b = std::fabs(double(x));
    double angle = atan_double(a / b);
    angle = a == kInfinity && b == kInfinity ? kPiD / 4 : angle;
    angle = b == 0 ? kPiD / 2 : angle;
    angle = x < 0 ? kPiD - angle : angle;
    angle = a == 0 && b == 0 ? 0 : angle;
    angle = y < 0 ? -angle : angle;
    return x != x || y != y ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(angle);
}

[[gnu::always_inline]] inline float acos_of(float x) noexcept
{
    const double c = std::clamp(double(x), -1.0, 1.0), size = std::fabs(c);
    const double s = std::sqrt((1 - c) * (1 + c));
    double angle = atan_double(s / size);
    angle = size == 0 ? kPiD / 2 : angle;
    angle = c < 0 ? kPiD - angle : angle;
    return x != x ? x : static_cast<float>(angle);
}

}  // namespace

float sin(float x) noexcept
{
    return std::isfinite(x) ? static_cast<float>(sin_quadrant(reduce(x))) : std::numeric_limits<float>::quiet_NaN();
}

float cos(float x) noexcept
{
    if (!std::isfinite(x)) return std::numeric_limits<float>::quiet_NaN();
    Reduced r = reduce(x);
    r.quadrant = (r.quadrant + 1) & 3;
    return static_cast<float>(sin_quadrant(r));
}

SinCos sin_cos(float x) noexcept
{
    if (!std::isfinite(x)) return {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::quiet_NaN()};
    const Reduced r = reduce(x);
    // Quadrants are as good as random to the processor, so nothing branches on them.
    const double both[2] = {sin_series(r.r), cos_series(r.r)};
    const int even = (r.quadrant & 1) ^ 1, sine_sign = 1 - (r.quadrant & 2), cosine_sign = 1 - ((r.quadrant + 1) & 2);
    return {static_cast<float>(both[even ^ 1] * sine_sign), static_cast<float>(both[even] * cosine_sign)};
}

float tan(float x) noexcept
{
    if (!std::isfinite(x)) return std::numeric_limits<float>::quiet_NaN();
    const Reduced r = reduce(x);
    return static_cast<float>(sin_quadrant(r) / sin_quadrant({r.r, (r.quadrant + 1) & 3}));
}

float exp2(float x) noexcept
{
    if (!(x > -150)) return x != x ? x : 0;
    if (x >= 128) return std::numeric_limits<float>::infinity();
    return static_cast<float>(exp2_double(x));
}

float exp(float x) noexcept
{
    if (!(x > -104)) return x != x ? x : 0;
    if (x >= 89) return std::numeric_limits<float>::infinity();
    return static_cast<float>(exp2_double(double(x) / kLn2));
}

float log2(float x) noexcept
{
    if (x == 0) return -std::numeric_limits<float>::infinity();
    if (!(x > 0)) return std::numeric_limits<float>::quiet_NaN();
    if (std::isinf(x)) return x;
    return static_cast<float>(log2_double(x));
}

float log(float x) noexcept
{
    if (!(x > 0) || std::isinf(x)) return log2(x);
    return static_cast<float>(log2_double(x) * kLn2);
}

float pow(float x, float y) noexcept
{
    if (y == 0) return 1;
    if (x == 0) return y > 0 ? 0 : std::numeric_limits<float>::infinity();
    if (!(x > 0)) return std::numeric_limits<float>::quiet_NaN();
    if (std::isinf(x)) return y > 0 ? x : 0;
    const double e = log2_double(x) * y;
    if (!(e > -150)) return e != e ? static_cast<float>(e) : 0;
    if (e >= 128) return std::numeric_limits<float>::infinity();
    return static_cast<float>(exp2_double(e));
}

float atan2(float y, float x) noexcept { return atan2_of(y, x); }

float acos(float x) noexcept { return acos_of(x); }

float asin(float x) noexcept
{
    if (x != x) return x;
    const double c = x < -1 ? -1 : x > 1 ? 1 : double(x);
    const double d = std::sqrt((1 - c) * (1 + c));
    const double a = d == 0 ? kPiD / 2 : atan_double(std::fabs(c) / d);
    return static_cast<float>(c < 0 ? -a : a);
}

void sin_cos(const float* x, std::size_t count, float* sin, float* cos) noexcept
{
    for (std::size_t i = 0; i < count; ++i) {
        const double k = std::floor(double(x[i]) * (2 / kPiD) + 0.5);
        const int quadrant = static_cast<int>(k);
        const double r = remainder(x[i], k), s = sin_series(r), c = cos_series(r);
        const bool is_odd = (quadrant & 1) != 0;
        const double sine = is_odd ? c : s, cosine = is_odd ? s : c;
        sin[i] = static_cast<float>((quadrant & 2) != 0 ? -sine : sine);
        cos[i] = static_cast<float>(((quadrant + 1) & 2) != 0 ? -cosine : cosine);
    }
}

void atan2(const float* y, const float* x, std::size_t count, float* to) noexcept
{
    for (std::size_t i = 0; i < count; ++i) to[i] = atan2_of(y[i], x[i]);
}

void acos(const float* x, std::size_t count, float* to) noexcept
{
    for (std::size_t i = 0; i < count; ++i) to[i] = acos_of(x[i]);
}

}  // namespace occam::maths
