// Tests of limit points beside corners for which the oracle of limit points has no rules.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "lod/patch_surface.h"
#include "lod/posed_patch.h"
#include "tests/support/diced_mesh.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

// A vertex of two fans stays where it is, and each fan is as if it were alone and the vertex a corner.
TEST(CornerLimits, AreTheSameBesideAVertexOfTwoFansAsBesideACorner)
{
    Cage one = spindle(3), both = one;
    one.corners = {{0, kInfiniteSharpness}};
    // The second spindle is the first one, turned around the first vertex.
    const auto number = [&](std::uint32_t v) {
        return v == 0 ? 0 : v + static_cast<std::uint32_t>(one.positions.size()) - 1;
    };
    for (std::size_t v = 1; v < one.positions.size(); ++v)
        both.positions.push_back(2.0f * one.positions[0] - one.positions[v] * Vec3f(1, 1, -1));
    for (const std::uint32_t v : one.face_vertices) both.face_vertices.push_back(number(v));
    both.face_sizes.resize(2 * one.face_sizes.size(), 3);
    DicedCage alone(one, 0), joined(both, 0);
    ASSERT_TRUE(alone.topology().is_seen(0));
    lod::PatchSurface surface;
    for (int depth = 2; depth <= 16; ++depth) {
        const float size = std::exp2(-static_cast<float>(depth));
        const lod::ParameterGrid grid{0.5f * size, size, size, size, 2, 2};
        Vec3f normals[2][4];
        for (DicedCage* cage : {&alone, &joined}) {
            surface.forget();
            surface.normals({cage->posed, {0, 0}, 0}, grid, normals[cage == &joined]);
        }
        for (int k = 0; k < 4; ++k) {
            const Vec3d a(normals[0][k]), b(normals[1][k]);
            // The weights are the same. Positions are rounded around the middle of their cage, which turns a normal by far
            // less.
            EXPECT_LE(std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * 57.29578, 0.01) << "depth " << depth;
        }
    }
}

/// Returns the largest distance in x and y between what two functions of (u, v) are close to the corners of a patch.
double largest_distance(const auto& a, const auto& b)
{
    double largest = 0;
    for (int depth = 2; depth <= 16; ++depth)
        for (int corner = 0; corner < 4; ++corner)
            for (const Vec2f beside : {Vec2f(0, 0), Vec2f(1, 0), Vec2f(0.5f, 1)}) {
                const Vec2f at = beside * std::exp2(-static_cast<float>(depth));
                const float u = corner & 1 ? 1 - at.x : at.x, v = corner & 2 ? 1 - at.y : at.y;
                largest = std::max(largest, glm::distance(Vec2d(a(u, v)), Vec2d(b(u, v))));
            }
    return largest;
}

// The texture coordinates of a chart whose values are x and y of its vertices are those of the surface of its faces alone.
TEST(CornerLimits, OfAChartAreThoseOfItsFacesAlone)
{
    Cage whole = spindle(9), half = whole;
    UvSet set;
    for (const Vec3f p : whole.positions) set.values.push_back(Vec2f(p));
    for (const Vec3f p : whole.positions) set.values.push_back(Vec2f(p) + 5.0f);
    half.face_sizes.resize(9);
    half.face_vertices.clear();
    for (std::size_t corner = 0; corner < whole.face_vertices.size(); ++corner) {
        const bool is_upper = corner / 3 % 2 == 0;
        const std::uint32_t v = whole.face_vertices[corner];
        set.indices.push_back(is_upper ? v : v + static_cast<std::uint32_t>(whole.positions.size()));
        if (is_upper) half.face_vertices.push_back(v);
    }
    whole.uv_sets = {set};
    DicedCage charts(whole, 0), alone(half, 0);
    lod::PosedPatch uv, surface;
    for (std::uint32_t sub = 0; sub < 3; ++sub) {
        uv.set_uv(charts.posed, {0, sub}, 0);
        surface.set(alone.posed, {0, sub});
        const auto of_chart = [&](float u, float v) { return uv.point(u, v); };
        const auto of_faces = [&](float u, float v) { return Vec3d(surface.point(u, v)) + alone.posed.anchor; };
        EXPECT_LE(largest_distance(of_chart, of_faces), 1e-6) << sub;
    }
}

// Where the borders of a cage are creases, it does not matter whether borders are smooth curves by the rule as well.
TEST(CornerLimits, AtABorderThatIsACreaseAreThoseOfASmoothBorder)
{
    Cage cage;
    for (int y = 0; y < 3; ++y)
        for (int x = 0; x < 3; ++x) cage.positions.push_back({float(x), float(y), 0.2f * float(x * y)});
    for (std::uint32_t y = 0; y < 2; ++y)
        for (std::uint32_t x = 0; x < 2; ++x) {
            const std::uint32_t v = 3 * y + x;
            cage.face_vertices.insert(cage.face_vertices.end(), {v, v + 1, v + 4, v + 3});
            cage.face_sizes.push_back(4);
        }
    const std::uint32_t border[] = {0, 1, 2, 5, 8, 7, 6, 3};
    for (int i = 0; i < 8; ++i) cage.creases.push_back({border[i], border[(i + 1) % 8], kInfiniteSharpness});
    cage.boundary = BoundaryRule::None;
    DicedCage creased(cage, 0);
    cage.boundary = BoundaryRule::EdgeOnly;
    DicedCage smooth(cage, 0);
    ASSERT_TRUE(creased.topology().is_seen(0));
    lod::PosedPatch a, b;
    a.set(creased.posed, {0, 0});
    b.set(smooth.posed, {0, 0});
    const auto of_creased = [&](float u, float v) { return a.point(u, v); };
    const auto of_smooth = [&](float u, float v) { return b.point(u, v); };
    EXPECT_LE(largest_distance(of_creased, of_smooth), 1e-6);
}

}  // namespace
}  // namespace occam::test
