#include "shade/bump.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace occam::shade {
namespace {

// Values beyond a lattice's border are extrapolated from inside. So a slope on the border equals that of the neighbour's
// lattice up to the second order of a step, and does not depend on where tiles end, which differs between the pairs that
// show a level.
template <class Of>
auto beyond(int i, int j, int columns, int rows, Of&& of) noexcept
{
    const int in_i = std::clamp(i, 0, columns - 1), in_j = std::clamp(j, 0, rows - 1);
    const auto at = [&](int c, int r) { return of(static_cast<std::size_t>(r * columns + c)); };
    const auto here = at(in_i, in_j);
    return in_i == i && in_j == j ? here : here * 2.0f - at(2 * in_i - i, 2 * in_j - j);
}

}  // namespace

BumpLattice::BumpLattice(const Material& material, const lod::LatticeToShade& lattice, const TextureStore& textures) noexcept
    : lattice_(lattice),
      has_map_(bool(material.bump_texture)),
      set_(coordinates_of(material.bump_texture)),
      scale_(double(material.bump_scale)),
      rows_(static_cast<int>(lattice.vertices.size()) / lattice.columns)
{
    if (!has_map_) return;
    const TextureUse& use = material.bump_texture;
    for (int j = -1; j <= rows_; ++j)
        for (int i = -1; i <= lattice.columns; ++i) {
            const Vec2f uv = beyond(i, j, lattice.columns, rows_,
                                    [&](std::size_t k) { return lattice.vertices[k].uv[set_]; });
            const float width = beyond(i, j, lattice.columns, rows_,
                                       [&](std::size_t k) { return lattice.vertices[k].uv_width[set_]; });
            heights_[index(i, j)] = textures.sample(use, uv, std::max(width, 0.0f)).x;
        }
}

Vec2f BumpLattice::rise(int i, int j) const noexcept
{
    if (!has_map_) return Vec2f(0);
    const auto place = [&](int c, int r) {
        return Vec2d(beyond(c, r, lattice_.columns, rows_, [&](std::size_t k) { return lattice_.vertices[k].uv[set_]; }));
    };
    const auto height = [&](int c, int r) { return double(heights_[index(c, r)]); };
    const Vec2d along_i = place(i + 1, j) - place(i - 1, j), along_j = place(i, j + 1) - place(i, j - 1);
    const double area = along_i.x * along_j.y - along_i.y * along_j.x;
    if (area == 0) return Vec2f(0);
    const double rise_i = height(i + 1, j) - height(i - 1, j), rise_j = height(i, j + 1) - height(i, j - 1);
    const Vec2d rise = Vec2d(rise_i * along_j.y - rise_j * along_i.y, rise_j * along_i.x - rise_i * along_j.x) *
                       (scale_ / area);
    const auto is_float = [](double x) { return std::abs(x) <= double(std::numeric_limits<float>::max()); };
    return is_float(rise.x) && is_float(rise.y) ? Vec2f(rise) : Vec2f(0);
}

Vec3f bump_slope(const ShadePoint& point, const TextureStore& textures) noexcept
{
    const TextureUse& use = point.material->bump_texture;
    if (!use) return Vec3f(0);
    const int set = coordinates_of(use);
    const float width = point.texture.uv_width[set], step = 0.5f * std::max(width, textures.texel_width(use));
    if (!(step > 0)) return Vec3f(0);
    const auto height = [&](Vec2f by) { return textures.sample(use, point.texture.uv[set] + by, width).x; };
    const float rise_u = height({step, 0}) - height({-step, 0}), rise_v = height({0, step}) - height({0, -step});
    return (point.u_gradient * rise_u + point.v_gradient * rise_v) * (point.material->bump_scale / (2 * step));
}

// A slope that would turn the normal away is shortened so that a tenth of its cosine is left: a visible point has a
// normal that faces the eye.
Vec3f bumped_normal(Vec3f normal, Vec3f slope, const ShadePoint& point) noexcept
{
    constexpr float kLeast = 0.1f;
    if (point.back_side) slope = -slope;
    slope -= normal * glm::dot(normal, slope);
    for (const Vec3f towards : {point.to_eye, point.normal_geometric}) {
        const float cosine = glm::dot(normal, towards), lost = glm::dot(slope, towards);
        if (cosine > 0 && lost > (1 - kLeast) * cosine) slope *= (1 - kLeast) * cosine / lost;
    }
    const Vec3f n = normal - slope;
    const float length = glm::length(n);
    return length < std::numeric_limits<float>::infinity() ? n / length : normal;
}

}  // namespace occam::shade
