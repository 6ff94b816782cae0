#include "shade/sheen.h"

#include <algorithm>
#include <array>

#include "base/maths.h"
#include "shade/bsdf.h"
#include "shade/quadrature.h"
#include "shade/table_place.h"
#include "shade/transmission.h"

namespace occam::shade {
namespace {

constexpr float kLeastRoughness = 0.07f;  // narrower distributions differ only in their noise

// Returns the density of half vectors, a power of the sine of their angle to the normal (Estevez and Kulla 2017, eq. 2).
float density(float n_h, float alpha) noexcept
{
    const float sine = std::sqrt(std::max(0.0f, 1 - n_h * n_h)), power = 1 / alpha;
    return (2 + power) * maths::pow(sine, power) / (2 * kPi);
}

// Returns the fit of eq. 3 and table 1, whose columns are for widths of 0 and 1.
float shadowing_fit(float x, float alpha) noexcept
{
    constexpr float kOfZero[] = {25.3245f, 3.32435f, 0.16801f, -1.27393f, -4.85967f};
    constexpr float kOfOne[] = {21.5473f, 3.82987f, 0.19823f, -1.97760f, -4.32054f};
    const float share = (1 - alpha) * (1 - alpha);
    float p[5];
    for (int i = 0; i < 5; ++i) p[i] = kOfZero[i] * share + kOfOne[i] * (1 - share);
    return p[0] / (1 + p[1] * maths::pow(x, p[2])) + p[3] * x + p[4];
}

float lambda(float cosine, float alpha) noexcept
{
    return cosine < 0.5f ? maths::exp(shadowing_fit(cosine, alpha))
                         : maths::exp(2 * shadowing_fit(0.5f, alpha) - shadowing_fit(1 - cosine, alpha));
}

// Returns f of a white sheen times the light's cosine.
// light, eye   lambda() of both
// n_v          cosine of the eye; it is above zero
float lobe(float light, float eye, float n_v, float n_h, float alpha) noexcept
{
    return density(n_h, alpha) / ((1 + light + eye) * 4 * n_v);
}

// The eye counts as no lower than this cosine, since the lobe grows without bound towards the horizon.
constexpr float kLeastCosine = 0.002f;

float lambda_of_eye(float cosine, float alpha) noexcept { return lambda(std::max(cosine, kLeastCosine), alpha); }

// Tabulates the albedo of a white sheen for each cosine of the eye and width. The nodes are even in the cube root of the
// cosine, since the albedo changes fastest at grazing angles, and in the logarithm of the width.
class SheenTable {
public:
    static constexpr int kCosines = 96, kWidths = 64;
    static constexpr float kLeastWidth = kLeastRoughness * kLeastRoughness;

    SheenTable()
    {
        const auto cosines = gauss_legendre<12>();
        for (int w = 0; w < kWidths; ++w) {
            const float alpha = maths::pow(kLeastWidth, 1 - static_cast<float>(w) / (kWidths - 1));
            std::array<float, cosines.size()> lambdas;
            for (std::size_t i = 0; i < cosines.size(); ++i) lambdas[i] = lambda(light_cosine(cosines[i]), alpha);
            for (int c = 0; c < kCosines; ++c) {
                const float root = static_cast<float>(c) / (kCosines - 1);
                const float n_v = std::max(1e-4f, root * root * root);
                double sum = 0;
                for (std::size_t i = 0; i < cosines.size(); ++i)
                    sum += 3 * cosines[i].x * cosines[i].x * cosines[i].weight *
                           around_normal(n_v, light_cosine(cosines[i]), lambdas[i], alpha);
                rows_[std::size_t(w)][std::size_t(c)] = static_cast<float>(sum);
            }
        }
    }
    float at(float cosine, float alpha) const noexcept
    {
        static const float kRange = -1 / maths::log2(kLeastWidth);
        const TablePlace row = table_place(1 + maths::log2(alpha) * kRange, kWidths),
                         column = table_place(maths::pow(std::max(cosine, 0.0f), 1.0f / 3), kCosines);
        const auto in_row = [&](int r) {
            const auto& values = rows_[std::size_t(r)];
            const float a = values[std::size_t(column.below)], b = values[std::size_t(column.below) + 1];
            return a + (b - a) * column.share;
        };
        const float a = in_row(row.below), b = in_row(row.below + 1);
        return a + (b - a) * row.share;
    }

private:
    // The integral over the light's cosine is taken over its cube root.
    static float light_cosine(QuadratureNode node) noexcept { return static_cast<float>(node.x * node.x * node.x); }

    // Integrates the lobe over the light's angle around the normal. Half a turn suffices, because the other half is its
    // mirror image, and the middles of even cells integrate a smooth periodic function to many digits.
    static double around_normal(float n_v, float n_l, float lambda_of_light, float alpha) noexcept
    {
        constexpr int kAngles = 10;
        const Vec3f eye(std::sqrt(1 - n_v * n_v), 0, n_v);
        const float sine = std::sqrt(1 - n_l * n_l), of_eye = lambda_of_eye(n_v, alpha);
        double sum = 0;
        for (int j = 0; j < kAngles; ++j) {
            const float angle = (static_cast<float>(j) + 0.5f) / kAngles * kPi;
            const Vec3f light(sine * maths::cos(angle), sine * maths::sin(angle), n_l);
            sum += double(lobe(lambda_of_light, of_eye, std::max(n_v, kLeastCosine), glm::normalize(eye + light).z, alpha));
        }
        return sum * (2 * double(kPi) / kAngles);
    }

    std::array<std::array<float, kCosines>, kWidths> rows_;
};

float strongest(Vec3f c) noexcept { return std::max({c.x, c.y, c.z}); }

}  // namespace

float sheen_width(float roughness) noexcept
{
    const float r = std::clamp(roughness, kLeastRoughness, 1.0f);
    return r * r;
}

SheenForEye sheen_for_eye(const Surface& s, float cosine) noexcept
{
    static const SheenTable table;
    const float albedo = table.at(cosine, s.sheen_alpha), reflects = std::min(albedo, 1.0f);
    return {reflects, albedo > 1 ? 1 / albedo : 1.0f, std::max(0.0f, 1 - strongest(s.sheen) * reflects)};
}

Vec3f sheened(const Surface& s, const SheenForEye& eye, Vec3f below, Vec3f to_light) noexcept
{
    below *= eye.below;
    const float n_l = glm::dot(s.normal, to_light), n_v = eye_cosine(s.normal, s.to_eye);
    if (!(n_l > 0) || !(glm::dot(s.normal_geometric, to_light) > 0)) return below;
    const Vec3f half = s.to_eye + to_light;
    const float length = glm::length(half);
    const float n_h = length > 0 ? glm::dot(s.normal, half) / length : 1;
    const float white = lobe(lambda(std::min(n_l, 1.0f), s.sheen_alpha), lambda_of_eye(n_v, s.sheen_alpha),
                             std::max(n_v, kLeastCosine), n_h, s.sheen_alpha);
    return below + s.sheen * (eye.scale * white * terminator(s, n_l, to_light));
}

}  // namespace occam::shade
