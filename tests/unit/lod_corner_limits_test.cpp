// Tests of limit points beside corners for which the oracle of limit points has no rules.
#include <gtest/gtest.h>

#include <cmath>

#include "lod/patch_surface.h"
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

}  // namespace
}  // namespace occam::test
