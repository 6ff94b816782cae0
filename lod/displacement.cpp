#include "lod/displacement.h"

#include <algorithm>
#include <cmath>

#include "base/matrix.h"
#include "lod/footprint.h"
#include "lod/rates.h"

namespace occam::lod {

namespace {

/// Unit axes of a surface: along its du, across it, and outward by the orientation of its parametrization.
struct SurfaceAxes {
    Vec3d along{0}, across{0}, normal{0};
    double du, dv_along = 0, dv_across = 0;  ///< du = du * along, dv = dv_along * along + dv_across * across
    bool is_good;

    SurfaceAxes(Vec3d d_u, Vec3d d_v) noexcept
    {
        const Vec3d area = glm::cross(d_u, d_v);
        const double size = glm::length(area);
        du = glm::length(d_u);
        is_good = size > 0 && du > 0;
        if (!is_good) return;
        normal = area / size;
        along = d_u / du;
        across = glm::cross(normal, along);
        dv_along = glm::dot(d_v, along);
        dv_across = size / du;
    }
};

}  // namespace

double largest_stretch(const double (&map)[3][4]) noexcept
{
    Mat3d columns;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) columns[column][row] = map[row][column];
    return occam::largest_stretch(columns);
}

PosedDisplacement::PosedDisplacement(const Cage& cage, const TextureStore& store, const double (&frame_from_object)[3][4],
                                     bool mirrored, bool deformed, float radius) noexcept
{
    if (!cage.is_displaced()) return;
    of = &*cage.displacement;
    textures = &store;
    for (int r = 0; r < 3; ++r) std::copy_n(frame_from_object[r], 3, map[r]);
    sense = mirrored ? -1.0f : 1.0f;
    sense_in_object = glm::determinant(Mat3d(map[0][0], map[1][0], map[2][0], map[0][1], map[1][1], map[2][1], map[0][2],
                                             map[1][2], map[2][2])) < 0
                          ? -sense
                          : sense;
    turns = deformed && of->space == Displacement::Space::Object;
    // This is a little more than the bound, because offsets are rounded.
    reach = static_cast<float>(largest_stretch(frame_from_object) * double(of->bound)) * (1 + 0x1p-18f);
    stops = std::min(ceil_log2(4 * radius), kCoarsestLevel);
}

double PosedDisplacement::filter_edge(int level) const noexcept { return double(edge_length(level)) * double(filter_share); }

Vec3d PosedDisplacement::from_object(Vec3d v) const noexcept
{
    const auto row = [&](int r) { return map[r][0] * v.x + map[r][1] * v.y + map[r][2] * v.z; };
    return {row(0), row(1), row(2)};
}

// The map's cofactors give the normal, up to the size of the determinant.
Vec3d PosedDisplacement::to_object(Vec3d v) const noexcept
{
    const auto column = [&](int c) { return Vec3d(map[0][c], map[1][c], map[2][c]); };
    const Vec3d a = column(0), b = column(1), c = column(2), bc = glm::cross(b, c);
    const Vec3d u(glm::dot(bc, v), glm::dot(glm::cross(c, a), v), glm::dot(glm::cross(a, b), v));
    return glm::dot(a, bc) < 0 ? -u : u;
}

Vec3d PosedDisplacement::texel_vector(const Vec4f& texel) const noexcept
{
    const Vec3d v = double(of->scale) * (Vec3d(texel) - double(of->midlevel));
    const double far = glm::length(v);
    return far > double(of->bound) ? v * (double(of->bound) / far) : v;
}

Vec3d PosedDisplacement::along_normal(const PointToDisplace& at, double height) const noexcept
{
    // Posed areas are the cofactors of the map times the object's areas, so the transpose of the map gives the object's
    // normal.
    const Vec3d area = glm::cross(Vec3d(at.du), Vec3d(at.dv));
    Vec3d normal;
    for (int c = 0; c < 3; ++c) normal[c] = map[0][c] * area.x + map[1][c] * area.y + map[2][c] * area.z;
    const double length = glm::length(normal);
    return length > 0 ? from_object(normal * (double(sense) * height / length)) : Vec3d(0);
}

Vec3d PosedDisplacement::turned(const PointToDisplace& at, Vec3d v) const noexcept
{
    const SurfaceAxes rest(at.rest_du, at.rest_dv), pose(to_object(at.du), to_object(at.dv));
    if (!rest.is_good || !pose.is_good) return from_object(v);
    // The pose maps the surface by [a b; 0 d] in these axes, and (a + d, -b) the direction of its nearest rotation.
    const double a = pose.du / rest.du, d = pose.dv_across / rest.dv_across;
    const double b = (pose.dv_along - a * rest.dv_along) / rest.dv_across;
    const double size = std::sqrt((a + d) * (a + d) + b * b);
    const double cosine = (a + d) / size, sine = -b / size;
    const double x = glm::dot(v, rest.along), y = glm::dot(v, rest.across), z = glm::dot(v, rest.normal);
    return from_object(pose.along * (x * cosine - y * sine) + pose.across * (x * sine + y * cosine) +
                       pose.normal * (double(sense_in_object) * z));
}

Vec3d PosedDisplacement::in_tangents(const PointToDisplace& at, Vec3d v) const noexcept
{
    const Vec2f st_du = scaled_and_rotated(of->texture, at.uv_du), st_dv = scaled_and_rotated(of->texture, at.uv_dv);
    const double turn = double(st_du.x) * st_dv.y - double(st_du.y) * st_dv.x;
    const Vec3d du = to_object(at.du), dv = to_object(at.dv);
    const Vec3d along_u = (du * double(st_dv.y) - dv * double(st_du.y)) * (turn < 0 ? -1.0 : 1.0);
    const double size = glm::length(along_u);
    if (turn == 0 || !(size > 0)) return along_normal(at, v.z);
    const Vec3d area = glm::cross(du, dv), tangent = along_u / size;
    // The direction in which v falls is perpendicular to the tangent. On which side depends on whether the coordinates are
    // mirrored.
    const Vec3d across = glm::cross(area, tangent);
    const double length = glm::length(across);
    if (!(length > 0)) return Vec3d(0);
    return from_object(tangent * v.x + across * ((turn < 0 ? v.y : -v.y) / length)) + along_normal(at, v.z);
}

Vec3f PosedDisplacement::offset(const PointToDisplace& at, int level) const noexcept
{
    const double size = glm::length(glm::cross(Vec3d(at.du), Vec3d(at.dv)));
    const double uv_size = std::abs(double(at.uv_du.x) * at.uv_dv.y - double(at.uv_du.y) * at.uv_dv.x);
    const auto width = size > 0 ? static_cast<float>(filter_edge(level) * std::sqrt(uv_size / size)) : 0;
    const Vec4f texel = textures->sample(of->texture, at.uv, width);
    switch (of->space) {
        case Displacement::Space::Normal: {
            const float height = std::clamp(of->scale * (texel.x - of->midlevel), -of->bound, of->bound);
            return Vec3f(size > 0 ? along_normal(at, double(height)) : Vec3d(0));
        }
        case Displacement::Space::Object:
            return Vec3f(turns ? turned(at, texel_vector(texel)) : from_object(texel_vector(texel)));
        case Displacement::Space::Tangent:
            return Vec3f(size > 0 ? in_tangents(at, texel_vector(texel)) : Vec3d(0));
    }
    return Vec3f(0);
}

// The steps are those of offset() in the same order, over arrays, so that the compiler computes several points at a time.
void PosedDisplacement::offsets_along_normal(const PointsToDisplace& at, int level, float* const out[3]) const noexcept
{
    // What has no area is told apart in loops of its own, since conditions would keep the others from several points at a
    // time.
    constexpr int kAtOnce = 32;
    double area[3][kAtOnce], size[kAtOnce], filter[kAtOnce], height[kAtOnce], length[kAtOnce];
    float moved[3][kAtOnce];
    const double edge = filter_edge(level), turned = double(sense);
    for (int first = 0; first < at.count; first += kAtOnce) {
        const int n = std::min(kAtOnce, at.count - first);
        const auto from = [&](const float* values) { return values + first; };
        const float *ux = from(at.du[0]), *uy = from(at.du[1]), *uz = from(at.du[2]);
        const float *vx = from(at.dv[0]), *vy = from(at.dv[1]), *vz = from(at.dv[2]);
        const float *sx = from(at.uv_du[0]), *sy = from(at.uv_du[1]), *tx = from(at.uv_dv[0]), *ty = from(at.uv_dv[1]);
        for (int k = 0; k < n; ++k) {
            const double u[3] = {ux[k], uy[k], uz[k]}, v[3] = {vx[k], vy[k], vz[k]};
            const double x = u[1] * v[2] - v[1] * u[2], y = u[2] * v[0] - v[2] * u[0], z = u[0] * v[1] - v[0] * u[1];
            const double uv_size = std::abs(double(sx[k]) * double(ty[k]) - double(sy[k]) * double(tx[k]));
            area[0][k] = x, area[1][k] = y, area[2][k] = z;
            size[k] = std::sqrt(x * x + y * y + z * z);
            filter[k] = edge * std::sqrt(uv_size / size[k]);
        }
        for (int k = 0; k < n; ++k) {
            const float width = size[k] > 0 ? static_cast<float>(filter[k]) : 0;
            const Vec4f texel = textures->sample(of->texture, {at.uv[0][first + k], at.uv[1][first + k]}, width);
            height[k] = double(std::clamp(of->scale * (texel.x - of->midlevel), -of->bound, of->bound));
        }
        for (int k = 0; k < n; ++k) {
            double normal[3];
            for (int c = 0; c < 3; ++c) normal[c] = map[0][c] * area[0][k] + map[1][c] * area[1][k] + map[2][c] * area[2][k];
            length[k] = std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
            const double factor = turned * height[k] / length[k];
            for (int r = 0; r < 3; ++r)
                moved[r][k] = static_cast<float>(map[r][0] * (normal[0] * factor) + map[r][1] * (normal[1] * factor) +
                                                 map[r][2] * (normal[2] * factor));
        }
        for (int r = 0; r < 3; ++r)
            for (int k = 0; k < n; ++k) out[r][first + k] = size[k] > 0 && length[k] > 0 ? moved[r][k] : 0;
    }
}

}  // namespace occam::lod
