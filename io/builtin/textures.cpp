#include "io/builtin/textures.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/hash.h"
#include "base/maths.h"

namespace occam::builtin {
namespace {

using maths::kPi;

float smooth(float t) noexcept
{
    t = std::clamp(t, 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}
/// Returns 0 below a, 1 above b, and a smooth transition in between.
float step(float a, float b, float x) noexcept { return smooth((x - a) / (b - a)); }

float hashed(int x, int y, std::uint64_t seed) noexcept
{
    const std::uint64_t key = std::uint64_t(std::uint32_t(x)) << 32 | std::uint32_t(y);
    return float(mix_bits(mix_bits(key) + seed) >> 40) * 0x1p-24f;
}

// Returns value noise in [0, 1] over a lattice that repeats after `period` cells, a power of two.
float noise(Vec2f p, int period, std::uint64_t seed) noexcept
{
    const float fx = std::floor(p.x), fy = std::floor(p.y);
    const int x = int(fx), y = int(fy);
    const auto at = [&](int i, int j) { return hashed((x + i) & (period - 1), (y + j) & (period - 1), seed); };
    const float u = smooth(p.x - fx), v = smooth(p.y - fy);
    return (at(0, 0) * (1 - u) + at(1, 0) * u) * (1 - v) + (at(0, 1) * (1 - u) + at(1, 1) * u) * v;
}

// Returns a sum of octaves in [0, 1]; `p` is measured in cells of the first octave.
float octaves(Vec2f p, int period, int count, std::uint64_t seed) noexcept
{
    float sum = 0, weight = 0.5f, total = 0;
    for (int o = 0; o < count; ++o) {
        sum += weight * noise(p, period, seed + std::uint64_t(o));
        total += weight;
        p = p * 2.0f;
        period *= 2;
        weight *= 0.5f;
    }
    return sum / total;
}

/// Returns a texture of width x height whose pixel is color(u, v), with u and v in (0, 1) from the top left.
template <class Color>
Texture painted(std::string name, int width, int height, Color&& color)
{
    Texture t;
    t.name = std::move(name);
    t.width = width;
    t.height = height;
    t.pixels.reserve(std::size_t(width) * std::size_t(height));
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            t.pixels.emplace_back(color((float(x) + 0.5f) / float(width), (float(y) + 0.5f) / float(height)), 1.0f);
    return t;
}

}  // namespace

Texture tiles()
{
    return painted("tiles", 512, 512, [](float u, float v) {
        const Vec2f p = Vec2f(u, v) * float(kTilesAcross);
        const int i = int(p.x), j = int(p.y);
        const Vec2f in_tile = p - Vec2f(float(i), float(j));
        // Each tile is cut from another part of the stone.
        const Vec2f stone = p * 1.0f + Vec2f(hashed(i, j, 11), hashed(i, j, 12)) * 4.0f;
        const float cloud = octaves(stone * 2.0f, 64, 5, 1);
        const float warped = octaves(stone + Vec2f(cloud * 1.5f), 64, 4, 2);
        const float vein = 1 - step(0.0f, 0.05f, std::fabs(warped - 0.5f));
        const bool is_dark = ((i + j) & 1) != 0;
        const Vec3f light = Vec3f(0.63f, 0.58f, 0.50f) * (0.85f + 0.3f * cloud) - Vec3f(0.16f, 0.17f, 0.17f) * vein;
        const Vec3f dark = Vec3f(0.135f, 0.16f, 0.165f) * (0.7f + 0.6f * cloud) + Vec3f(0.14f) * vein;
        const float edge = std::min({in_tile.x, in_tile.y, 1 - in_tile.x, 1 - in_tile.y});
        return glm::mix(Vec3f(0.23f, 0.215f, 0.195f), is_dark ? dark : light, step(0.006f, 0.016f, edge));
    });
}

Texture wood()
{
    return painted("wood", 512, 512, [](float u, float v) {
        // The rings lie about an axis that runs nearly along u, a little beside the board.
        const float bend = octaves({u * 2, v * 2}, 2, 4, 21) - 0.5f;
        const float across = v - 0.42f + 0.10f * bend + 0.05f * u, depth = 0.22f + 0.08f * u;
        const float radius = std::sqrt(across * across + depth * depth) * 26;
        const float ring = radius - std::floor(radius);
        const float late = step(0.35f, 0.92f, ring) * (1 - step(0.94f, 1.0f, ring));
        const float fibre = octaves({u * 8, v * 128}, 128, 2, 22);
        const Vec3f pale(0.62f, 0.40f, 0.21f), brown(0.36f, 0.185f, 0.075f);
        return glm::mix(pale, brown, 0.75f * late) * (0.82f + 0.36f * fibre);
    });
}

Texture glaze()
{
    return painted("glaze", 768, 512, [](float u, float v) {
        const Vec3f blue(0.012f, 0.052f, 0.155f), cream(0.74f, 0.67f, 0.53f), rust(0.42f, 0.115f, 0.035f);
        const float cloud = octaves({u * 12, v * 8}, 4, 4, 31);
        Vec3f color = blue * (0.65f + 0.9f * cloud);
        const auto band = [&](float middle, float half, Vec3f with) {
            color = glm::mix(color, with * (0.88f + 0.24f * cloud),
                             1 - step(half - 0.002f, half + 0.002f, std::fabs(v - middle)));
        };
        band(0.30f, 0.055f, cream);
        band(0.222f, 0.006f, cream);
        band(0.378f, 0.006f, cream);
        band(0.47f, 0.008f, rust);
        // A row of sixteen drops runs around the wide band.
        const float cell = u * 16, x = (cell - std::floor(cell) - 0.5f) * 2, y = (v - 0.30f) / 0.055f;
        const float drop = x * x * (1.6f + 0.9f * y) + y * y * 1.25f;
        return glm::mix(rust, color, step(0.52f, 0.64f, drop));
    });
}

Texture studio()
{
    Texture t = painted("studio", 256, 128, [](float u, float v) {
        // The angles are measured around from -z and up from the horizon.
        const float around = (u - 0.5f) * 2 * kPi, up = (0.5f - v) * kPi;
        const Vec3f ground(0.10f, 0.09f, 0.08f), wall(0.30f, 0.31f, 0.33f), ceiling(0.50f, 0.53f, 0.58f);
        Vec3f c = glm::mix(glm::mix(ground, wall, step(-0.15f, 0.05f, up)), ceiling, step(0.2f, 1.4f, up));
        const auto window = [&](float middle, float height, float half_width, float half_height, Vec3f light) {
            float away = around - middle;
            away -= 2 * kPi * std::floor(away / (2 * kPi) + 0.5f);
            const float x = (half_width - std::fabs(away)) / 0.06f, y = (half_height - std::fabs(up - height)) / 0.06f;
            c += light * (smooth(x) * smooth(y));
        };
        window(-1.9f, 0.62f, 0.42f, 0.36f, {6.0f, 5.6f, 5.0f});  // left, warm
        window(1.75f, 0.45f, 0.16f, 0.50f, {2.6f, 3.1f, 4.0f});  // right, cool and narrow
        window(2.95f, 1.0f, 0.7f, 0.09f, {2.2f, 2.2f, 2.2f});    // behind the camera, a strip
        return c;
    });
    t.role = TextureRole::Data;
    return t;
}

}  // namespace occam::builtin
