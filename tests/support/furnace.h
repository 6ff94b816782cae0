// The white furnace: how much of the light of a uniform sky a surface sends to the eye.
#pragma once

#include <cmath>

#include "shade/bsdf.h"

namespace occam::test {

/// Returns a unit vector by its cosine to z and its angle around z.
inline Vec3f direction(float cosine, float angle = 0)
{
    const float sine = std::sqrt(1 - cosine * cosine);
    return {sine * std::cos(angle), sine * std::sin(angle), cosine};
}

/// Returns the radiance towards the eye under a uniform sky of radiance 1: the mean over evenly distributed samples (a
/// lattice with the generators of Roberts' R3 sequence). A share of `grazing` / 8 of the directions lies near the two
/// horizons, where light of several bounces between microfacets goes.
inline double furnace(const shade::Surface& s, int samples, int grazing)
{
    const shade::SurfaceForEye eye(s);
    double sum = 0;
    for (int i = 0; i < samples; ++i) {
        const auto number = [&](double generator) {
            const double x = 0.5 + generator * (i / 8);
            return static_cast<float>(x + 0.125 * (i % 8) - std::floor(x + 0.125 * (i % 8))) * 0.9999999f;
        };
        const Vec2f square(number(0.6710436067037893), number(0.5497004779019703));
        const float choice = number(0.8191725133961645);
        Vec3f d = direction(square.x * square.x, 2 * shade::kPi * square.y) * Vec3f(1, 1, choice < 0.5f ? -1 : 1);
        if (i % 8 >= grazing) d = sample_scatter(eye, choice, square).direction;
        if (d == Vec3f(0)) continue;
        const double about_horizons = 0.125 / double(shade::kPi) / std::sqrt(std::max(1e-12, double(std::fabs(d.z))));
        sum += double(scatter(eye, d).x) * 8 / ((8 - grazing) * double(scatter_density(eye, d)) + grazing * about_horizons);
    }
    return sum / samples;
}

/// Every white surface reflects or transmits all light to within this error, for every lobe, angle, width and index.
inline constexpr double kWhite = 3e-3;

/// Returns the result of a furnace test with as many samples as it needs.
inline double furnace(const shade::Surface& s)
{
    for (const int samples : {2'000, 16'000, 64'000}) {
        const double white = furnace(s, samples, 0);
        if (std::fabs(white - 1) < kWhite) return white;
    }
    return furnace(s, 1'000'000, 1);
}

}  // namespace occam::test
