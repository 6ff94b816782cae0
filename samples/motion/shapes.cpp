#include "shapes.h"

#include <cmath>

namespace sample {

using namespace occam;

namespace {

constexpr float kTurn = 6.28318531f;

}  // namespace

Cage turned(const std::vector<Vec2f>& profile, int around, MaterialId material)
{
    Cage cage;
    cage.materials = {material};
    const auto rings = static_cast<std::uint32_t>(profile.size()), n = static_cast<std::uint32_t>(around);
    for (const Vec2f p : profile)
        for (int k = 0; k < around; ++k) {
            const float angle = kTurn * float(k) / float(around);
            cage.positions.push_back({p.x * std::cos(angle), p.y, -p.x * std::sin(angle)});
        }
    for (std::uint32_t r = 0; r + 1 < rings; ++r)
        for (std::uint32_t k = 0; k < n; ++k) {
            const std::uint32_t next = (k + 1) % n;
            cage.face_sizes.push_back(4);
            for (const std::uint32_t v : {r * n + k, r * n + next, (r + 1) * n + next, (r + 1) * n + k})
                cage.face_vertices.push_back(v);
        }
    for (const std::uint32_t last : {0u, rings - 1}) {
        cage.face_sizes.push_back(n);
        for (std::uint32_t k = 0; k < n; ++k) cage.face_vertices.push_back(last == 0 ? n - 1 - k : last * n + k);
    }
    return cage;
}

Cage limb(float length, float top_radius, float bottom_radius, MaterialId material)
{
    return turned({{0.6f * bottom_radius, -length - 0.8f * bottom_radius},
                   {bottom_radius, -length},
                   {0.5f * (top_radius + bottom_radius), -0.5f * length},
                   {top_radius, 0},
                   {0.6f * top_radius, 0.8f * top_radius}},
                  8, material);
}

Cage ring(float radius, float thickness, MaterialId material)
{
    constexpr std::uint32_t kAround = 24, kAcross = 6;
    Cage cage;
    cage.materials = {material};
    for (std::uint32_t i = 0; i < kAround; ++i)
        for (std::uint32_t j = 0; j < kAcross; ++j) {
            const float a = kTurn * float(i) / kAround, b = kTurn * float(j) / kAcross;
            const float r = radius + thickness * std::cos(b);
            cage.positions.push_back({r * std::cos(a), r * std::sin(a), 1.4f * thickness * std::sin(b)});
            const std::uint32_t i1 = (i + 1) % kAround, j1 = (j + 1) % kAcross;
            cage.face_sizes.push_back(4);
            for (const std::uint32_t v : {i * kAcross + j, i1 * kAcross + j, i1 * kAcross + j1, i * kAcross + j1})
                cage.face_vertices.push_back(v);
        }
    return cage;
}

Cage rounded_box(Vec3f size, MaterialId material)
{
    Cage cage;
    cage.materials = {material};
    for (int corner = 0; corner < 8; ++corner)
        cage.positions.push_back(0.5f * size * Vec3f(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1));
    cage.face_sizes.assign(6, 4);
    cage.face_vertices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
    constexpr float kSharpness = 2.5f;
    for (std::uint32_t a = 0; a < 8; ++a)
        for (const std::uint32_t bit : {1u, 2u, 4u})
            if ((a & bit) == 0) cage.creases.push_back({a, a | bit, kSharpness});
    return cage;
}

}  // namespace sample
