#include "base/maths.h"

#include <cmath>
#include <initializer_list>
#include <limits>

namespace occam::maths {
namespace {

constexpr double kPiD = 3.14159265358979323846;
constexpr double kLn2 = 0.693147180559945309417;

struct Reduced {
    double r;      // in [-pi/4, pi/4]
    int quadrant;  // 0..3
};

Reduced reduce(float x) noexcept
{
    // These are the two parts of pi/2, so that k * high is exact for k below 2^22.
    constexpr double kHigh = 1.57079632673412561417, kLow = 6.07710050650619224932e-11;
    const double k = std::floor(double(x) * (2 / kPiD) + 0.5);
    // Beyond 2^62, where k does not fit into an integer, it is a multiple of 4.
    const int quadrant = std::fabs(k) < 0x1p62 ? static_cast<int>(static_cast<long long>(k) & 3) : 0;
    return {(double(x) - k * kHigh) - k * kLow, quadrant};
}

double sin_series(double r) noexcept
{
    const double q = r * r;
    double s = 1 / 6227020800.0;
    for (const double c : {-1 / 39916800.0, 1 / 362880.0, -1 / 5040.0, 1 / 120.0, -1 / 6.0, 1.0}) s = s * q + c;
    return s * r;
}

double cos_series(double r) noexcept
{
    const double q = r * r;
    double s = -1 / 87178291200.0;
    for (const double c : {1 / 479001600.0, -1 / 3628800.0, 1 / 40320.0, -1 / 720.0, 1 / 24.0, -1 / 2.0, 1.0}) s = s * q + c;
    return s;
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

double atan_double(double x) noexcept  // x >= 0
{
    double base = 0;
    bool complement = false;
    if (x > 1) {
        x = 1 / x;
        complement = true;
    }
    if (x > 0.26794919243112270) {  // tan(pi/12): the angle is reduced by pi/6
        constexpr double kTan = 0.57735026918962576;
        x = (x - kTan) / (1 + x * kTan);
        base = kPiD / 6;
    }
    const double q = x * x;
    double s = 0;
    for (int n = 21; n > 0; n -= 2) s = 1.0 / n - q * s;
    const double angle = base + x * s;
    return complement ? kPiD / 2 - angle : angle;
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
    return {static_cast<float>(sin_quadrant(r)), static_cast<float>(sin_quadrant({r.r, (r.quadrant + 1) & 3}))};
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

float atan2(float y, float x) noexcept
{
    if (x != x || y != y) return std::numeric_limits<float>::quiet_NaN();
    if (y == 0 && x == 0) return 0;
    const double a = std::fabs(double(y)), b = std::fabs(double(x));
    double angle = b == 0 ? kPiD / 2 : std::isinf(a) && std::isinf(b) ? kPiD / 4 : atan_double(a / b);
    if (x < 0) angle = kPiD - angle;
    return static_cast<float>(y < 0 ? -angle : angle);
}

float acos(float x) noexcept
{
    if (x != x) return x;
    const double c = x < -1 ? -1 : x > 1 ? 1 : double(x);
    const double s = std::sqrt((1 - c) * (1 + c));
    const double a = std::fabs(c) == 0 ? kPiD / 2 : atan_double(s / std::fabs(c));
    return static_cast<float>(c < 0 ? kPiD - a : a);
}

float asin(float x) noexcept
{
    if (x != x) return x;
    const double c = x < -1 ? -1 : x > 1 ? 1 : double(x);
    const double d = std::sqrt((1 - c) * (1 + c));
    const double a = d == 0 ? kPiD / 2 : atan_double(std::fabs(c) / d);
    return static_cast<float>(c < 0 ? -a : a);
}

}  // namespace occam::maths
