// Tests of a ray's table of transitions, and of pairs of levels as meshes (watertightness rules 10 to 15).
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>

#include "lod/ray_levels.h"
#include "tests/support/beams.h"
#include "tests/support/campaign.h"
#include "tests/support/diced_mesh.h"
#include "tests/support/displaced_cages.h"
#include "tests/support/shape_builders.h"
#include "tests/support/shapes.h"

namespace occam::test {
namespace {

TEST(RayLevels, CoverARayWithoutAGapAndOverlapAsAsked)
{
    const lod::LevelSettings settings;
    for (const Beam& beam : beams(2000)) {
        const lod::RayLevels<float> table = table_of(beam, settings);
        ASSERT_LE(table.coarsest - table.finest, lod::RayLevels<float>::kMostOfRay - 1);
        // The loop goes from the ray's start to its end, along the pairs in the order in which the ray sees them.
        const bool grows = beam.b >= 0;
        float reached = -kFar;
        for (int n = 0; n <= table.coarsest - table.finest; ++n) {
            const int pair = grows ? table.finest + n : table.coarsest - n;
            const float begin = table.begin(pair), end = table.end(pair);
            if (begin > end || end < 0 || begin > beam.t_end) continue;
            EXPECT_LE(begin, reached) << "a gap before pair " << pair << " of " << beam.a << " + " << beam.b << " t";
            if (reached > -kFar / 2 && reached < beam.t_end) {
                // The comparison allows for the rounding of both ends.
                EXPECT_GE(reached - begin, 2 * std::min(table.overlap(pair), table.overlap(pair + 1)) - reached * 3e-7f);
            }
            reached = end;
        }
        EXPECT_GE(reached, beam.t_end);
    }
}

// Where it enters the scene, a ray begins with the pair that it asks for there. Finer pairs would only cost time.
TEST(RayLevels, BeginWhereTheRayEntersTheScene)
{
    const lod::LevelSettings settings;
    for (Beam beam : beams(2000)) {
        const lod::RayLevels<float> whole = table_of(beam, settings);
        beam.t_in = beam.t_end * 0.75f;
        const lod::RayLevels<float> late = table_of(beam, settings);
        EXPECT_EQ(late.coarsest, whole.coarsest);
        const float width = beam.a + beam.b * beam.t_in;
        if (beam.b < 0 || !(width > 0)) {
            EXPECT_EQ(late.finest, whole.finest);
            continue;
        }
        EXPECT_GE(late.finest, whole.finest);
        const int wanted = std::clamp(std::ilogb(width), lod::kFinestLevel, lod::kCoarsestLevel);
        EXPECT_GE(late.finest, wanted) << beam.a << " + " << beam.b << " t";
        EXPECT_LE(late.finest, std::max(wanted, whole.finest));
        EXPECT_EQ(late.begin(late.finest), -kFar);
    }
}

TEST(RayLevels, AreNeverCoarserThanAskedAndKeepTheirLeastLength)
{
    lod::LevelSettings settings;
    settings.overlap_edges = 0;
    settings.overlap_ulps = 0;
    for (const Beam& beam : beams(2000)) {
        const lod::RayLevels<float> table = table_of(beam, settings);
        for (int pair = table.finest; pair <= table.coarsest; ++pair) {
            const float begin = table.begin(pair), end = table.end(pair), d = lod::edge_length(pair);
            if (begin >= end) continue;
            for (const float t : {std::max(begin, 0.0f), std::min(end, beam.t_end)}) {
                if (t < begin || t > end || pair == table.finest) continue;
                EXPECT_LE(d, (beam.a + beam.b * t) * 1.0001f + beam.a * 3e-7f)
                    << "pair " << pair << " at " << t << " of " << beam.a << " + " << beam.b << " t";
            }
            const bool has_both_ends = begin > 0 && end < beam.t_end;
            if (has_both_ends) {
                EXPECT_GE(end - begin, 4 * d * 0.9999f);
            }
        }
    }
}

TEST(RayLevels, WeightsAreExactlyFineAndCoarseInTheMargins)
{
    const lod::LevelSettings settings;
    for (const Beam& beam : beams(2000)) {
        const lod::RayLevels<float> table = table_of(beam, settings);
        for (int pair = table.finest; pair <= table.coarsest; ++pair) {
            const float begin = table.begin(pair), end = table.end(pair), margin = 2 * lod::edge_length(pair);
            if (begin >= end) continue;
            const lod::Blend<float> blend = table.blend(pair);
            const float near = beam.b >= 0 ? 0.0f : 1.0f;
            for (const float share : {0.0f, 0.5f, 1.0f}) {
                if (begin > 0) {
                    EXPECT_EQ(blend.weight(begin + share * margin), near) << "pair " << pair;
                }
                if (end < beam.t_end) {
                    EXPECT_EQ(blend.weight(end - share * margin), 1 - near) << "pair " << pair;
                }
            }
        }
    }
}

TEST(RayLevels, OfAConstantWidthHaveOneWeightThatGrowsWithIt)
{
    const lod::LevelSettings settings;
    float before = -1;
    for (int step = 0; step < 64; ++step) {
        const float width = 1 + float(step) / 64;
        const lod::RayLevels<float> table = table_of({width, 0, 100}, settings);
        ASSERT_EQ(table.finest, 0);
        ASSERT_EQ(table.coarsest, 0);
        const lod::Blend<float> blend = table.blend(0);
        const float x = width - 1, expected = x * x * (3 - 2 * x);
        EXPECT_NEAR(blend.weight(0), expected, 1e-5f);
        EXPECT_NEAR(blend.weight(100), expected, 1e-5f);
        EXPECT_GT(blend.weight(50), before);
        before = blend.weight(50);
    }
}

// A secondary ray sees only the mesh on which its origin lies within a margin of the origin, and anywhere behind it.
TEST(RayLevels, StartOnTheMeshOfTheirStart)
{
    const lod::LevelSettings settings;
    for (const Beam& beam : beams_with_starts(2000)) {
        const lod::RayLevels<float> table = table_of(beam, settings);
        ASSERT_LE(table.coarsest - table.finest, lod::RayLevels<float>::kMostOfRay - 1);
        const int start = std::ilogb(beam.start);
        const bool grows = beam.b >= 0;
        float reached = -kFar;
        for (int n = 0; n <= table.coarsest - table.finest; ++n) {
            const int pair = grows ? table.finest + n : table.coarsest - n;
            const float begin = table.begin(pair), end = table.end(pair), margin = 2 * lod::edge_length(start - 1);
            if (begin > end || begin > beam.t_end) continue;
            EXPECT_LE(begin, reached) << "a gap before pair " << pair << " of " << beam.a << " + " << beam.b << " t";
            reached = end;
            for (const float t : {-beam.t_end, -margin, 0.0f, margin}) {
                if (t < begin || t > end) continue;
                ASSERT_TRUE(pair == start || (!grows && pair == start - 1)) << "pair " << pair << " instead of " << start;
                EXPECT_EQ(table.blend(pair).weight(t), pair == start ? 0 : 1) << "pair " << pair << " at " << t;
            }
        }
        EXPECT_GE(reached, beam.t_end);
    }
}

// Both pieces of a ray through a lens see one mesh within a margin of the focus, in the same pair, and no finer mesh
// anywhere. Away from the focus neither is coarser than its width asks for.
TEST(RayLevels, SeeOneMeshAtTheFocus)
{
    const lod::LevelSettings settings;
    for (const Beam& beam : beams_with_a_focus(2000)) {
        const lod::RayLevels<float> table = table_of(beam, settings);
        ASSERT_LE(table.coarsest - table.finest, lod::RayLevels<float>::kMostOfRay - 1);
        const int start = std::ilogb(beam.start);
        ASSERT_EQ(table.finest, start);
        const float margin = 2 * beam.start, first = beam.b < 0 ? 0 : beam.focus,
                    last = beam.b < 0 ? beam.focus : beam.t_end;
        for (const float t : {beam.focus - margin, beam.focus, beam.focus + margin}) {
            EXPECT_TRUE(t < 0 || (table.begin(start) <= t && t <= table.end(start)));
            EXPECT_EQ(table.blend(start).weight(t), 0) << "at " << t - beam.focus;
        }
        float reached = beam.focus;
        for (int pair = start; pair <= table.coarsest; ++pair) {
            const float begin = table.begin(pair), end = table.end(pair), d = lod::edge_length(pair);
            if (begin > end) continue;
            // From the focus on outwards there is no gap.
            if (begin <= last && end >= first) {
                EXPECT_LE(beam.b < 0 ? reached : begin, beam.b < 0 ? end : reached) << "pair " << pair;
            }
            reached = beam.b < 0 ? begin : end;
            if (pair == start) continue;
            const float nearest = std::clamp(beam.b < 0 ? end - table.overlap(pair) : begin + table.overlap(pair), first,
                                             last);
            EXPECT_LE(d, (beam.a + beam.b * nearest) * 1.001f + std::fabs(beam.a) * 3e-7f) << "pair " << pair;
        }
        EXPECT_TRUE(beam.b < 0 ? reached <= 0 : reached >= beam.t_end);
    }
}

/// Where two pairs overlap, both show the mesh of their common level.
TEST(RayLevels, TellTheNearestLevelOfEachPlace)
{
    const lod::LevelSettings settings;
    std::vector<Beam> all = beams(400);
    for (const auto& more : {beams_with_starts(400), beams_with_a_focus(200)})
        all.insert(all.end(), more.begin(), more.end());
    std::mt19937_64 random(5);
    for (const Beam& beam : all) {
        lod::RayLevels<float> table = table_of(beam, settings);
        for (int k = 0; k < 50; ++k) {
            const float t = beam.t_end * static_cast<float>(random() >> 40) * 0x1p-24f;
            for (int pair = table.finest; pair <= table.coarsest; ++pair)
                if (table.begin(pair) <= t && t <= table.end(pair)) {
                    EXPECT_EQ(table.nearest_level(t), pair + (table.blend(pair).weight(t) >= 0.5f)) << "at " << t;
                }
        }
    }
}

TEST(RayLevels, HaveTheSameBitsInLanesAndAlone)
{
    const lod::LevelSettings settings;
    std::vector<Beam> all = beams(400);
    for (const auto& more : {beams_with_starts(400), beams_with_a_focus(200)})
        all.insert(all.end(), more.begin(), more.end());
    for (std::size_t i = 0; i < all.size(); ++i) {
        lod::RayLevels<vfloat> lanes;
        ASSERT_TRUE(
            lanes.set({all[i].a, all[i].b, all[i].start, all[i].focus}, all[i].t_in, all[i].t_end, all[i].t_end, settings));
        lanes.make();
        lod::RayLevels<float> alone = table_of(all[i], settings);
        ASSERT_EQ(lanes.finest, alone.finest);
        ASSERT_EQ(lanes.coarsest, alone.coarsest);
        const auto same = [&](vfloat x, float y) {
            float out[kLanes];
            x.store(out);
            return std::bit_cast<std::uint32_t>(out[kLanes - 1]) == std::bit_cast<std::uint32_t>(y);
        };
        for (int pair = alone.finest; pair <= alone.coarsest; ++pair) {
            const float end = std::min(alone.end(pair), all[i].t_end);
            EXPECT_TRUE(same(lanes.nearest_level(end), alone.nearest_level(end)));
            EXPECT_TRUE(same(lanes.begin(pair), alone.begin(pair)));
            EXPECT_TRUE(same(lanes.end(pair), alone.end(pair)));
            EXPECT_TRUE(same(lanes.blend(pair).start, alone.blend(pair).start));
            EXPECT_TRUE(same(lanes.blend(pair).scale, alone.blend(pair).scale));
        }
    }
}

/// The other lanes see finer and coarser pairs, which must not change where a ray's own begin and end.
TEST(RayLevels, HaveTheSameBitsWhateverTheOtherLanesSee)
{
    const lod::LevelSettings settings;
    std::vector<Beam> all = beams_with_ends_at_levels(2000);
    for (const auto& more : {beams(400), beams_with_starts(400), beams_with_a_focus(200)})
        all.insert(all.end(), more.begin(), more.end());
    std::size_t compared = 0;
    for (const Beam& beam : all) {
        lod::RayLevels<float> alone = table_of(beam, settings);
        float a[kLanes], b[kLanes], end[kLanes], start[kLanes], focus[kLanes], in[kLanes];
        for (int lane = 0; lane < kLanes; ++lane) {
            const float width = lod::edge_length(lane % 2 ? alone.finest - 2 : alone.coarsest + 3);
            a[lane] = lane == 0 ? beam.a : width;
            b[lane] = lane == 0 ? beam.b : 0.25f * width / beam.t_end;
            start[lane] = lane == 0 ? beam.start : 0;
            focus[lane] = lane == 0 ? beam.focus : 0;
            in[lane] = lane == 0 ? beam.t_in : 0;
            end[lane] = beam.t_end;
        }
        lod::RayLevels<vfloat> lanes;
        if (alone.finest < lod::kFinestLevel + 3 || alone.coarsest > lod::kCoarsestLevel - 4 ||
            !lanes.set({vfloat::load(a), vfloat::load(b), vfloat::load(start), vfloat::load(focus)}, vfloat::load(in),
                       vfloat::load(end), vfloat::load(end), settings))
            continue;
        lanes.make();
        ++compared;
        const auto same = [&](vfloat x, float y) {
            float out[kLanes];
            x.store(out);
            return std::bit_cast<std::uint32_t>(out[0]) == std::bit_cast<std::uint32_t>(y);
        };
        for (int k = 0; k <= 16; ++k) {
            const float t = beam.t_in + (beam.t_end - beam.t_in) * static_cast<float>(k) / 16;
            EXPECT_TRUE(same(lanes.nearest_level(t), alone.nearest_level(t))) << "at " << t << " of " << beam.t_end;
        }
        for (int pair = alone.finest; pair <= alone.coarsest; ++pair) {
            EXPECT_TRUE(same(lanes.begin(pair), alone.begin(pair))) << beam.a << ' ' << beam.b << ' ' << beam.t_end;
            EXPECT_TRUE(same(lanes.end(pair), alone.end(pair))) << beam.a << ' ' << beam.b << ' ' << beam.t_end;
            EXPECT_TRUE(same(lanes.blend(pair).start, alone.blend(pair).start));
            EXPECT_TRUE(same(lanes.blend(pair).scale, alone.blend(pair).scale));
        }
        for (const int pair : {alone.finest - 1, alone.coarsest + 1}) {
            if (pair < lanes.finest || pair > lanes.coarsest) continue;
            float begin[kLanes], stop[kLanes];
            lanes.begin(pair).store(begin);
            lanes.end(pair).store(stop);
            EXPECT_TRUE(begin[0] > beam.t_end || stop[0] < 0 || begin[0] > stop[0])
                << "a ray has a pair that it does not have alone: " << beam.a << ' ' << beam.b << ' ' << beam.t_end;
        }
    }
    EXPECT_GT(compared, 2000u);
}

/// Checks that every fully coarse vertex of pair l is where its parameter lies in the mesh of level l + 1, by comparing it
/// with that mesh.
void expect_nested(const Cage& cage, int largest_exponent, const TextureStore* textures = nullptr,
                   std::span<const Mat4d> joints = {})
{
    DicedCage diced(cage, 0, Mat4d(1), textures, joints);
    const int finest = diced.level_of_largest_exponent(largest_exponent);
    std::size_t compared = 0;
    for (int level = finest; level <= finest + largest_exponent + 1; ++level) {
        diced.posed.level = level;
        for (const lod::TileRef& tile : diced.tiles()) {
            const lod::PatchScale scale = diced.dicer.scale(diced.posed, tile.patch);
            const lod::LevelGrid pair = diced.dicer.dice_pair(diced.posed, tile, scale.rates(level + 1), diced.arena);
            // This is the tile of level l + 1 over the same part of the patch.
            const int half = pair.is_halved ? 2 : 1;
            const lod::TileRef over = lod::Dicer::tile(tile.patch, scale, level + 1, tile.i0 / std::uint32_t(half),
                                                       tile.j0 / std::uint32_t(half));
            const lod::LevelGrid coarse = diced.dicer.dice(diced.posed, over, diced.arena);
            const int i0 = static_cast<int>(tile.i0) / half - static_cast<int>(over.i0),
                      j0 = static_cast<int>(tile.j0) / half - static_cast<int>(over.j0);
            for (int j = 0; j <= tile.rows; ++j)
                for (int i = 0; i <= tile.columns; ++i) {
                    const Vec3f low = coarse.vertex(i0 + i / half, j0 + j / half);
                    const Vec3f high = coarse.vertex(i0 + (i + half - 1) / half, j0 + (j + half - 1) / half);
                    ASSERT_EQ(pair.coarse_at(pair.index(i, j)), low == high ? low : (low + high) * 0.5f)
                        << "face " << tile.patch.face << " level " << level << " vertex " << i << ", " << j;
                    ++compared;
                }
            // T-vertices are compared as a ray that sees only the coarser level blends them.
            for (const lod::Hanging& h : pair.hanging) {
                if (!h.is_inside) continue;
                const Vec3f middle =
                    h.on(pair.coarse_at(static_cast<int>(h.a)), pair.coarse_at(static_cast<int>(h.c))).middle;
                ASSERT_EQ(middle, pair.coarse_at(pair.index(h.i, h.j))) << "face " << tile.patch.face << " level " << level;
            }
        }
        diced.arena.reset();
    }
    EXPECT_GT(compared, 100u);
}

class Pairs : public testing::TestWithParam<std::string> {};
TEST_P(Pairs, FullyCoarseAreTheNextLevelFullyFine)
{
    const Cage cage = load_cage(GetParam());
    expect_nested(cage, cage.face_count() > 2000 ? 1 : cage.face_count() > 150 && !is_long() ? 2 : 4);
}
INSTANTIATE_TEST_SUITE_P(Shapes, Pairs, testing::ValuesIn(closed_shapes()), shape_test_name);

TEST(PairsOfTorus, FullyCoarseAreTheNextLevelFullyFine) { expect_nested(torus(), 5); }
TEST(PairsOfPrism, FullyCoarseAreTheNextLevelFullyFine) { expect_nested(prism(7), 5); }
TEST(PairsOfDisplacedCages, FullyCoarseAreTheNextLevelFullyFine)
{
    for (int c = 0; c < kDisplacedCases; ++c) {
        const DisplacedCage displaced = displaced_case(c);
        SCOPED_TRACE(displaced.name);
        expect_nested(displaced.cage, is_long() ? 5 : 4, &displaced.textures);
    }
}
TEST(PairsOfDisplacedCages, FullyCoarseAreTheNextLevelFullyFineWhenPosed)
{
    for (int c = 0; c < kDisplacedCases; ++c) {
        DisplacedCage displaced = displaced_case(c);
        add_skin(displaced.cage);
        SCOPED_TRACE(displaced.name);
        expect_nested(displaced.cage, is_long() ? 4 : 3, &displaced.textures, bent_joints());
    }
}
/// The kd-tree splits a patch until it is one tile, so a patch of any size must be one at the coarsest level.
TEST(Rates, APatchOfAnySizeIsOneTileAtTheCoarsestLevel)
{
    for (const double size : {1e-30, 1.0, 1e12, 1e20, 1e25, 1e30, 1e36}) {
        Mat4d scaled(size);
        scaled[3][3] = 1;
        DicedCage diced(prism(5), 0, scaled);
        diced.posed.level = lod::kCoarsestLevel;
        for (const lod::TileRef& tile : diced.tiles()) {
            const lod::PatchScale scale = diced.dicer.scale(diced.posed, tile.patch);
            for (const int axis : {0, 1})
                EXPECT_LE(scale.inside(axis, lod::kCoarsestLevel), lod::TileRef::kSideExponent) << size;
        }
    }
}

TEST(PairsOfSpindle, FullyCoarseAreTheNextLevelFullyFine) { expect_nested(spindle(9), 5); }

}  // namespace
}  // namespace occam::test
