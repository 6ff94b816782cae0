#include "shade/stroke_albedo.h"

#include "base/maths.h"
#include "shade/table_place.h"

namespace occam::shade {
namespace {

constexpr int kRings = 16, kAngles = 24;

// Integrates as albedo_table.cpp does, over the whole disc: the lobe has no mirror image about the plane of the eye.
LayerAlbedo integrate(Vec3f eye, Widths widths) noexcept
{
    const float stretched_length = glm::length(widths.stretched(eye));
    const Vec3f stretched = widths.stretched(eye) / stretched_length;
    const float masking_over_cosine = 2 / (eye.z + stretched_length);
    double a = 0, b = 0, whole = 0;
    for (int ring = 0; ring < kRings; ++ring) {
        const float x = (static_cast<float>(ring) + 0.5f) / kRings;
        const float radius = std::sqrt(1 - x * x * x);
        const double area = double(x) * double(x);  // of 1 - radius^2 = x^3
        whole += area * kAngles;
        for (int i = 0; i < kAngles; ++i) {
            const float angle = (static_cast<float>(i) + 0.5f) / kAngles * 2 * kPi;
            const Vec3f n = visible_normal_of(stretched, 1, radius * Vec2f(maths::cos(angle), maths::sin(angle)));
            const Vec3f h = glm::normalize(Vec3f(widths.x * n.x, widths.y * n.y, std::max(1e-6f, n.z)));
            const float v_h = glm::dot(eye, h);
            const Vec3f light = h * (2 * v_h) - eye;
            if (!(light.z > 0) || !(v_h > 0)) continue;
            const double w = double(4 * light.z * ggx_visibility(light, eye, widths) / masking_over_cosine);
            const double out = std::max(0.0, 1 - double(v_h));
            const double g = out * out * out * out * out;
            a += area * w * (1 - g);
            b += area * w * g;
        }
    }
    return {static_cast<float>(a / whole), static_cast<float>(b / whole)};
}

LayerAlbedo sum(LayerAlbedo a, LayerAlbedo b) noexcept { return {a.f0 + b.f0, a.f90 + b.f90}; }
LayerAlbedo scaled(LayerAlbedo a, float factor) noexcept { return {a.f0 * factor, a.f90 * factor}; }
LayerAlbedo mix(LayerAlbedo a, LayerAlbedo b, float share) noexcept { return sum(scaled(a, 1 - share), scaled(b, share)); }

struct Place {
    std::size_t below;
    float share;  // of the node above
};

Place place_of(float x, std::size_t nodes) noexcept
{
    const TablePlace place = table_place(x, static_cast<int>(nodes));
    return {static_cast<std::size_t>(place.below), place.share};
}

float fourth_root(float x) noexcept { return std::sqrt(std::sqrt(std::max(0.0f, x))); }
const float kLeastRoot = fourth_root(kMinAlpha);

float square_of(float x) noexcept { return x * x; }

}  // namespace

const StrokeAlbedo& StrokeAlbedo::instance()
{
    static const StrokeAlbedo table;
    return table;
}

StrokeAlbedo::StrokeAlbedo()
{
    const AlbedoTable& round = AlbedoTable::instance();
    for (std::size_t a = 0; a < kAcross; ++a)
        for (std::size_t s = 0; s < kStrengths; ++s) {
            const float across = square_of(square_of(kLeastRoot + (1 - kLeastRoot) * static_cast<float>(a) / (kAcross - 1)));
            const Widths widths{across + (1 - across) * square_of(static_cast<float>(s) / (kStrengths - 1)), across};
            const float alpha = std::sqrt(widths.x * widths.y);
            Directions& table = rows_[a][s];
            for (std::size_t t = 0; t < kAzimuths; ++t)
                for (std::size_t c = 0; c < kCosines; ++c) {
                    table[t][c] = {0, 0};
                    if (s == 0) continue;  // The widths are equal.
                    const float turn = static_cast<float>(t) / (kAzimuths - 1);
                    const float cosine = square_of(std::max(static_cast<float>(c), 0.05f) / (kCosines - 1));
                    const Vec2f along = glm::normalize(Vec2f(1 - turn, turn)) *
                                        std::sqrt(std::max(0.0f, 1 - cosine * cosine));
                    table[t][c] = sum(integrate({along.x, along.y, cosine}, widths), scaled(round.at(cosine, alpha), -1));
                }
            means_[a][s] = mean_of(table);
        }
}

LayerAlbedo StrokeAlbedo::in(const Directions& table, Vec3f direction) noexcept
{
    const float x = std::abs(direction.x), y = std::abs(direction.y);
    const Place t = place_of(x + y > 0 ? y / (x + y) : 0, kAzimuths);
    const Place c = place_of(std::sqrt(std::max(0.0f, direction.z)), kCosines);
    const auto row = [&](std::size_t at) { return mix(table[at][c.below], table[at][c.below + 1], c.share); };
    return mix(row(t.below), row(t.below + 1), t.share);
}

// The mean is that of the interpolated table, so that lobes made of both neither lose nor gain light.
LayerAlbedo StrokeAlbedo::mean_of(const Directions& table) noexcept
{
    constexpr int kTurns = 16, kSteps = 8 * (kCosines - 1);
    LayerAlbedo all{0, 0};
    for (int i = 0; i < kTurns; ++i)
        for (int j = 0; j < kSteps; ++j) {
            const float angle = (static_cast<float>(i) + 0.5f) / kTurns * kPi / 2;
            const float root = (static_cast<float>(j) + 0.5f) / kSteps, cosine = root * root;
            const float sine = std::sqrt(1 - cosine * cosine);
            const float weight = 4 * cosine * root / (kTurns * kSteps);  // 2 cos d(cos), cos = root^2
            all = sum(all, scaled(in(table, {sine * maths::cos(angle), sine * maths::sin(angle), cosine}), weight));
        }
    return all;
}

template <class Get>
LayerAlbedo StrokeAlbedo::between(Widths widths, Get&& get) noexcept
{
    const Place a = place_of((fourth_root(widths.y) - kLeastRoot) / (1 - kLeastRoot), kAcross);
    const float range = 1 - widths.y;
    const Place s = place_of(range > 0 ? std::sqrt(std::max(0.0f, (widths.x - widths.y) / range)) : 0, kStrengths);
    const auto row = [&](std::size_t at) { return mix(get(at, s.below), get(at, s.below + 1), s.share); };
    return mix(row(a.below), row(a.below + 1), a.share);
}

LayerAlbedo StrokeAlbedo::at(Vec3f direction, Widths widths, float alpha) const noexcept
{
    return sum(AlbedoTable::instance().at(direction.z, alpha),
               between(widths, [&](std::size_t a, std::size_t s) { return in(rows_[a][s], direction); }));
}

LayerAlbedo StrokeAlbedo::mean(Widths widths, float alpha) const noexcept
{
    return sum(AlbedoTable::instance().mean(alpha),
               between(widths, [&](std::size_t a, std::size_t s) { return means_[a][s]; }));
}

}  // namespace occam::shade
