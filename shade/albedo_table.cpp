#include "shade/albedo_table.h"

#include "shade/microfacet.h"

namespace occam::shade {
namespace {

constexpr int kRings = 24, kAngles = 12;

// With visible normals, only the masking of the integrand is left. The normals come from the unit disc: rings that get
// finer towards its rim, where the long tail of GGX is, and half a turn of angles (the other half is its mirror image).
LayerAlbedo integrate(float cosine, float alpha) noexcept
{
    const Vec3f eye(std::sqrt(std::max(0.0f, 1 - cosine * cosine)), 0, cosine);
    double a = 0, b = 0, whole = 0;
    for (int ring = 0; ring < kRings; ++ring) {
        const float x = (static_cast<float>(ring) + 0.5f) / kRings;
        const float radius = std::sqrt(1 - x * x * x);
        const double area = double(x) * double(x);  // weight of the ring, because 1 - radius^2 = x^3
        whole += area * kAngles;
        for (int i = 0; i < kAngles; ++i) {
            // The disc's second axis lies in the plane of the eye, so the mirror images differ in the sign of the first
            // one.
            const float angle = (static_cast<float>(i) + 0.5f) / kAngles * kPi - kPi / 2;
            const Vec3f h = visible_normal_of(eye, alpha, radius * Vec2f(maths::cos(angle), maths::sin(angle)));
            const float v_h = glm::dot(eye, h);
            const float n_l = 2 * v_h * h.z - eye.z;
            if (!(n_l > 0) || !(v_h > 0)) continue;
            // The weight is f cos / density = 4 n_l visibility / (G1 / n_v).
            const double w = double(4 * n_l * ggx_visibility(n_l, cosine, alpha) / ggx_masking_over_cosine(cosine, alpha));
            const double out = std::max(0.0, 1 - double(v_h));
            const double g = out * out * out * out * out;
            a += area * w * (1 - g);
            b += area * w * g;
        }
    }
    return {static_cast<float>(a / whole), static_cast<float>(b / whole)};
}

struct Place {
    int below;
    float share;  // weight of the node above
};

Place place_of(float x, int nodes) noexcept
{
    const float at = std::clamp(x, 0.0f, 1.0f) * static_cast<float>(nodes - 1);
    const int below = std::min(static_cast<int>(at), nodes - 2);
    return {below, at - static_cast<float>(below)};
}

LayerAlbedo mix(LayerAlbedo a, LayerAlbedo b, float share) noexcept
{
    return {a.f0 + (b.f0 - a.f0) * share, a.f90 + (b.f90 - a.f90) * share};
}

float row_root(float alpha) noexcept { return std::sqrt(std::sqrt(std::max(0.0f, alpha))); }
const float kLeastRoot = row_root(kMinAlpha);

Place row_of(float alpha, int rows) noexcept { return place_of((row_root(alpha) - kLeastRoot) / (1 - kLeastRoot), rows); }

template <class Row>
LayerAlbedo in_row(const Row& row, float root_of_cosine) noexcept
{
    const Place p = place_of(root_of_cosine, static_cast<int>(row.size()));
    const auto i = static_cast<std::size_t>(p.below);
    return mix(row[i], row[i + 1], p.share);
}

}  // namespace

const AlbedoTable& AlbedoTable::instance()
{
    static const AlbedoTable table;
    return table;
}

AlbedoTable::AlbedoTable()
{
    for (int r = 0; r < kRoughnesses; ++r) {
        const float root = kLeastRoot + (1 - kLeastRoot) * static_cast<float>(r) / (kRoughnesses - 1);
        const float alpha = root * root * root * root;
        auto& row = rows_[static_cast<std::size_t>(r)];
        for (int c = 0; c < kCosines; ++c) {
            const float root_of_cosine = std::max(static_cast<float>(c), 0.05f) / (kCosines - 1);
            row[static_cast<std::size_t>(c)] = integrate(root_of_cosine * root_of_cosine, alpha);
        }
        // The mean is that of the interpolated row, so that lobes made of both neither lose nor gain light.
        double f0 = 0, f90 = 0;
        constexpr int kSteps = 16 * (kCosines - 1);
        for (int i = 0; i < kSteps; ++i) {
            const double of_cosine = (i + 0.5) / kSteps;
            const LayerAlbedo e = in_row(row, static_cast<float>(of_cosine));
            const double weight = 4 * of_cosine * of_cosine * of_cosine / kSteps;  // 2 cos d(cos), cos = root^2
            f0 += weight * double(e.f0);
            f90 += weight * double(e.f90);
        }
        means_[static_cast<std::size_t>(r)] = {static_cast<float>(f0), static_cast<float>(f90)};
    }
}

LayerAlbedo AlbedoTable::at(float cosine, float alpha) const noexcept
{
    const Place r = row_of(alpha, kRoughnesses);
    const float root = std::sqrt(std::max(0.0f, cosine));
    const auto i = static_cast<std::size_t>(r.below);
    return mix(in_row(rows_[i], root), in_row(rows_[i + 1], root), r.share);
}

LayerAlbedo AlbedoTable::mean(float alpha) const noexcept
{
    const Place r = row_of(alpha, kRoughnesses);
    const auto i = static_cast<std::size_t>(r.below);
    return mix(means_[i], means_[i + 1], r.share);
}

}  // namespace occam::shade
