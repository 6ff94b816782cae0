// Tests of M_l as a mesh: it is closed bit for bit, no edge is longer than d_l, and rates halve exactly from level to level
// (watertightness rules 1 to 4).
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <map>

#include "lod/footprint.h"
#include "tests/support/campaign.h"
#include "tests/support/diced_mesh.h"
#include "tests/support/displaced_cages.h"
#include "tests/support/shapes.h"

namespace occam::test {
namespace {

class ClosedCages : public testing::TestWithParam<std::string> {};

TEST_P(ClosedCages, AreClosedBitForBitAtEveryLevel)
{
    DicedCage diced(load_cage(GetParam()), 0);
    const int coarse = diced.level_of_largest_exponent(0), faces = static_cast<int>(diced.posed.topology->face_count()),
              fine = faces > 2000                ? 1
                     : !is_long() && faces > 150 ? 2
                                                 : 4;
    for (int exponent = 0; exponent <= fine; ++exponent) {
        diced.posed.level = coarse - exponent;
        diced.dicer.forget();
        EXPECT_EQ(open_edges(diced.triangles()), 0u) << "at exponent " << exponent;
        diced.arena.reset();
    }
}

TEST_P(ClosedCages, HaveNoGridEdgeLongerThanTheLevelAsks)
{
    DicedCage diced(load_cage(GetParam()), 0);
    const int exponent = diced.posed.topology->face_count() > 2000 ? 1 : 4;
    diced.level_of_largest_exponent(exponent);
    const float wanted = lod::edge_length(diced.posed.level) * (1 + 1e-5f);
    for (const lod::TileRef& tile : diced.tiles()) {
        const lod::LevelGrid grid = diced.dicer.dice(diced.posed, tile, diced.arena);
        for (int j = 0; j <= tile.rows; ++j)
            for (int i = 0; i <= tile.columns; ++i) {
                const Vec3f right = grid.vertex(std::min<int>(i + 1, tile.columns), j),
                            up = grid.vertex(i, std::min<int>(j + 1, tile.rows));
                ASSERT_LE(glm::distance(grid.vertex(i, j), right), wanted) << "face " << tile.patch.face;
                ASSERT_LE(glm::distance(grid.vertex(i, j), up), wanted) << "face " << tile.patch.face;
            }
    }
}

// Of a large cage, about a thousand faces are compared.
TEST_P(ClosedCages, GiveAPointTheSameBitsAtEveryLevel)
{
    DicedCage diced(load_cage(GetParam()), 0);
    const std::uint32_t step = 1 + diced.posed.topology->face_count() / 1000;
    const int fine = diced.level_of_largest_exponent(3);
    std::vector<lod::TileRef> tiles = diced.tiles();
    std::map<std::array<std::uint32_t, 2>, lod::LevelGrid> grids;
    for (const lod::TileRef& t : tiles)
        if (t.patch.face % step == 0) grids[{t.patch.face, t.patch.sub}] = diced.dicer.dice(diced.posed, t, diced.arena);
    diced.posed.level = fine + 1;
    diced.dicer.forget();
    for (const lod::TileRef& t : diced.tiles()) {
        if (t.patch.face % step != 0) continue;
        const lod::LevelGrid coarse = diced.dicer.dice(diced.posed, t, diced.arena);
        const lod::LevelGrid& fine_grid = grids[{t.patch.face, t.patch.sub}];
        const int su = fine_grid.tile.columns / t.columns, sv = fine_grid.tile.rows / t.rows;
        for (int j = 1; j < t.rows; ++j)
            for (int i = 1; i < t.columns; ++i)
                ASSERT_EQ(bits_of(coarse.vertex(i, j)), bits_of(fine_grid.vertex(i * su, j * sv)))
                    << "face " << t.patch.face;
    }
}

TEST(ClosedDisplacedCages, AreClosedBitForBitAtEveryLevel)
{
    for (const bool is_posed : {false, true})
        for (int c = 0; c < kDisplacedCases; ++c) {
            DisplacedCage displaced = displaced_case(c);
            std::vector<Mat4d> joints;
            if (is_posed) add_skin(displaced.cage), joints = bent_joints();
            DicedCage diced(displaced.cage, 0, Mat4d(1), &displaced.textures, joints);
            const int coarse = diced.level_of_largest_exponent(0);
            for (int exponent = -2; exponent <= (is_posed ? 5 : 6) - !is_long(); ++exponent) {
                diced.posed.level = coarse - exponent;
                diced.dicer.forget();
                EXPECT_EQ(open_edges(diced.triangles()), 0u)
                    << displaced.name << " at exponent " << exponent << (is_posed ? ", posed" : "");
                diced.arena.reset();
            }
        }
}

INSTANTIATE_TEST_SUITE_P(Shapes, ClosedCages, testing::ValuesIn(closed_shapes()), shape_test_name);

TEST(Rates, HalveExactlyAtAndAroundPowersOfTwo)
{
    for (int e = -20; e <= 20; ++e)
        for (const float s : {std::ldexp(1.0f, e), std::nextafterf(std::ldexp(1.0f, e), 0.0f),
                              std::nextafterf(std::ldexp(1.0f, e), 1e30f)}) {
            const int k = lod::ceil_log2(s);
            EXPECT_LE(s, std::ldexp(1.0f, k));
            EXPECT_GT(s, std::ldexp(1.0f, k - 1));
            for (int level = e - 11; level < e + 3; ++level) {
                const int fine = 1 << lod::curve_exponent(k, 0, level), coarse = 1 << lod::curve_exponent(k, 0, level + 1);
                if (fine == 1 << lod::kMaxExponent) continue;
                EXPECT_EQ(coarse, std::max(1, fine / 2)) << s << " at level " << level;
            }
        }
}

TEST(Rates, OfBothAxesHalveAndStopTogether)
{
    lod::PatchScale scale;
    scale.k = {7, 4};
    scale.least = {0, 1};
    for (int level = 0; level < 10; ++level) {
        const lod::PatchRates rates = scale.rates(level), next = scale.rates(level + 1);
        EXPECT_EQ(rates.u - next.u, rates.v - next.v) << "level " << level;
        EXPECT_GE(rates.v, 1);
    }
}

TEST(Rates, OfAThinPatchAreNotThoseOfItsLengthAlone)
{
    lod::PatchScale scale;
    scale.k = {lod::kMinLength, 5};
    scale.limit_aspect();
    EXPECT_EQ(scale.rates(lod::kCoarsestLevel).v, lod::kMaxAspect);
    EXPECT_EQ(scale.rates(0).u, 5 - lod::kMaxAspect);
}

}  // namespace
}  // namespace occam::test
