#include "lod/displacement.h"

#include <algorithm>
#include <cmath>

#include "lod/footprint.h"
#include "lod/rates.h"

namespace occam::lod {

double largest_stretch(const double (&map)[3][4]) noexcept
{
    // The largest eigenvalue of the map's Gram matrix is at most its largest row sum.
    double largest = 0;
    for (int a = 0; a < 3; ++a) {
        double row = 0;
        for (int b = 0; b < 3; ++b) row += std::abs(map[0][a] * map[0][b] + map[1][a] * map[1][b] + map[2][a] * map[2][b]);
        largest = std::max(largest, row);
    }
    return std::sqrt(largest);
}

PosedDisplacement::PosedDisplacement(const Cage& cage, const TextureStore& store, const double (&frame_from_object)[3][4],
                                     bool mirrored, float radius) noexcept
{
    if (!cage.is_displaced()) return;
    of = &*cage.displacement;
    textures = &store;
    map = frame_from_object;
    sense = mirrored ? -1.0f : 1.0f;
    // A little more than the bound: offsets are rounded.
    reach = static_cast<float>(largest_stretch(frame_from_object) * double(of->bound)) * (1 + 0x1p-18f);
    stops = std::min(ceil_log2(4 * radius), kCoarsestLevel);
}

Vec3f PosedDisplacement::offset(Vec3f du, Vec3f dv, Vec2f uv, Vec2f uv_du, Vec2f uv_dv, int level) const noexcept
{
    const Vec3d area = glm::cross(Vec3d(du), Vec3d(dv));
    const double size = glm::length(area);
    const double uv_size = std::abs(double(uv_du.x) * uv_dv.y - double(uv_du.y) * uv_dv.x);
    const auto width = size > 0 ? static_cast<float>(double(edge_length(level)) * std::sqrt(uv_size / size)) : 0;
    const auto from_object = [&](Vec3d v) {
        Vec3f moved;
        for (int r = 0; r < 3; ++r) moved[r] = static_cast<float>(map[r][0] * v.x + map[r][1] * v.y + map[r][2] * v.z);
        return moved;
    };
    if (of->axes == Displacement::Axes::Object) {
        const Vec3d v = double(of->scale) * (Vec3d(textures->sample(of->texture, uv, width)) - double(of->midlevel));
        const double far = glm::length(v);
        return from_object(far > double(of->bound) ? v * (double(of->bound) / far) : v);
    }
    // The object's normal: posed areas are cofactors of the map times the object's, and its transpose takes them back.
    Vec3d normal;
    for (int c = 0; c < 3; ++c) normal[c] = map[0][c] * area.x + map[1][c] * area.y + map[2][c] * area.z;
    const double length = glm::length(normal);
    if (!(size > 0) || !(length > 0)) return Vec3f(0);
    const float height =
        std::clamp(of->scale * (textures->sample(of->texture, uv, width).x - of->midlevel), -of->bound, of->bound);
    return from_object(normal * (double(sense * height) / length));
}

}  // namespace occam::lod
