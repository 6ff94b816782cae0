// Tests that no ray leaves the closed cages of the built-in scene. They have creases, poles, n-gons and vertices of high
// valence, and need no shared data.
#include <gtest/gtest.h>

#include "io/builtin/pieces.h"
#include "tests/support/campaign.h"
#include "tests/support/escapes.h"

namespace occam::test {
namespace {

class BuiltinPieces : public testing::TestWithParam<Cage> {};

TEST_P(BuiltinPieces, LetNoRayOut)
{
    // The placement is far out and rotated. Floats of the world are 1/128 apart there, a two-hundredth of a chess piece.
    const Camera turned = Camera::look_at({98'000, 1'200, -71'000}, {98'001, 1'203, -71'002}, {0, 1, 0}, 1);
    for (const Mat4d& place : {Mat4d(1), turned.world_from_camera}) {
        if (!is_long() && place == Mat4d(1)) continue;  // the other placement has the larger errors
        const EscapeCount count = count_escapes(GetParam(), place, 3, rays_per_cage(), 1);
        EXPECT_GT(count.starts, 0u) << "no point inside was found";
        EXPECT_EQ(count.escaped, 0u) << "of " << count.rays << '\n' << count.replay;
        EXPECT_EQ(count.not_finite, 0u);
    }
}

INSTANTIATE_TEST_SUITE_P(Closed, BuiltinPieces, testing::ValuesIn(builtin::closed_pieces()), [](const auto& test) {
    std::string name = test.param.name;
    std::replace(name.begin(), name.end(), ' ', '_');
    return name;
});

}  // namespace
}  // namespace occam::test
