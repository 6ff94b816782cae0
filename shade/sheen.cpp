#include "shade/sheen.h"

#include <algorithm>
#include <array>

#include "base/maths.h"
#include "shade/bsdf.h"
#include "shade/table_place.h"
#include "shade/transmission.h"

namespace occam::shade {
namespace {

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

// Returns f of a white sheen; both cosines are above zero.
float lobe(float n_l, float n_v, float n_h, float alpha) noexcept
{
    return density(n_h, alpha) / ((1 + lambda(n_l, alpha) + lambda(n_v, alpha)) * 4 * n_l * n_v);
}

// Integrates the albedo over cells of the light's cosine and of its angle around the normal, each by its middle. Half a turn
// suffices, because the other half is its mirror image.
float integrate(float cosine, float alpha) noexcept
{
    constexpr int kCosines = 32, kAngles = 24;
    const Vec3f eye(std::sqrt(1 - cosine * cosine), 0, cosine);
    double sum = 0;
    for (int i = 0; i < kCosines; ++i)
        for (int j = 0; j < kAngles; ++j) {
            const float n_l = (static_cast<float>(i) + 0.5f) / kCosines, sine = std::sqrt(1 - n_l * n_l);
            const float angle = (static_cast<float>(j) + 0.5f) / kAngles * kPi;
            const Vec3f light(sine * maths::cos(angle), sine * maths::sin(angle), n_l);
            sum += double(lobe(n_l, cosine, glm::normalize(eye + light).z, alpha) * n_l);
        }
    return std::min(1.0f, static_cast<float>(sum * (2 * double(kPi) / (kCosines * kAngles))));
}

class SheenTable {
public:
    static constexpr int kCosines = 32, kWidths = 24;  ///< nodes, even in the cosine and in the root of the width

    SheenTable()
    {
        for (int w = 0; w < kWidths; ++w)
            for (int c = 0; c < kCosines; ++c) {
                const float root = static_cast<float>(w) / (kWidths - 1);
                const float cosine = std::clamp(static_cast<float>(c) / (kCosines - 1), 0.01f, 1.0f);
                rows_[std::size_t(w)][std::size_t(c)] = integrate(cosine, sheen_width(root));
            }
    }
    float at(float cosine, float alpha) const noexcept
    {
        const TablePlace row = table_place(std::sqrt(alpha), kWidths), column = table_place(cosine, kCosines);
        const auto in_row = [&](int r) {
            const auto& values = rows_[std::size_t(r)];
            const float a = values[std::size_t(column.below)], b = values[std::size_t(column.below) + 1];
            return a + (b - a) * column.share;
        };
        const float a = in_row(row.below), b = in_row(row.below + 1);
        return a + (b - a) * row.share;
    }

private:
    std::array<std::array<float, kCosines>, kWidths> rows_;
};

float strongest(Vec3f c) noexcept { return std::max({c.x, c.y, c.z}); }

}  // namespace

float sheen_width(float roughness) noexcept
{
    constexpr float kLeast = 0.07f;  // narrower distributions differ only in their noise
    const float r = std::clamp(roughness, kLeast, 1.0f);
    return r * r;
}

float sheen_albedo(float cosine, float alpha) noexcept
{
    static const SheenTable table;
    return table.at(cosine, alpha);
}

float below_sheen(const Surface& s, float cosine) noexcept
{
    return std::max(0.0f, 1 - strongest(s.sheen) * sheen_albedo(cosine, s.sheen_alpha));
}

Vec3f sheened(const Surface& s, Vec3f below, Vec3f to_light) noexcept
{
    const float n_l = glm::dot(s.normal, to_light), n_v = eye_cosine(s.normal, s.to_eye);
    below *= std::min(below_sheen(s, n_v), below_sheen(s, std::min(std::fabs(n_l), 1.0f)));
    if (!(n_l > 0) || !(glm::dot(s.normal_geometric, to_light) > 0)) return below;
    const Vec3f half = s.to_eye + to_light;
    const float length = glm::length(half);
    const float n_h = length > 0 ? glm::dot(s.normal, half) / length : 1;
    return below + s.sheen * (lobe(std::max(n_l, 1e-4f), n_v, n_h, s.sheen_alpha) * n_l * terminator(s, n_l, to_light));
}

}  // namespace occam::shade
