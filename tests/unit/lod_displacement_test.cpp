// Tests of what displacement does to a surface: how far it moves, that bounds hold it, and which normals it has.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "io/texture/texture_store.h"
#include "tests/support/campaign.h"
#include "tests/support/diced_mesh.h"
#include "tests/support/displaced_cages.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

Mat4d turned_and_stretched()
{
    Mat4d place(1);
    place[0] = {0, 2, 0, 0};
    place[1] = {-0.5, 0, 0.1, 0};
    place[2] = {0, 0, 1.5, 0};
    place[3] = {3, -2, 7, 1};
    return place;
}

TEST(Displacement, StaysWithinItsBoundAndItsBoxes)
{
    for (int c = 0; c < kDisplacedCases; ++c) {
        DisplacedCage displaced = displaced_case(c);
        // The displacement is now larger than the bound, and is cut off there.
        displaced.cage.displacement->scale *= 3;
        for (const bool is_turned : {false, true}) {
            if (!is_long() && is_turned != (c % 2 == 0)) continue;
            const Mat4d place = is_turned ? turned_and_stretched() : Mat4d(1);
            DicedCage smooth(displaced.cage, 0, place), moved(displaced.cage, 0, place, &displaced.textures);
            smooth.posed.level = moved.level_of_largest_exponent(5);
            const float reach = moved.posed.displacement.reach;
            ASSERT_GT(reach, 0);
            float farthest = 0;
            Box3d scene_box = transform_box(place, moved.posed.slot->bounds);
            const double rounding = 4 * 0x1p-24 * double(moved.posed.radius);
            scene_box = {scene_box.lo - rounding, scene_box.hi + rounding};
            for (const lod::TileRef& tile : moved.tiles()) {
                const lod::LevelGrid grid = moved.dicer.dice(moved.posed, tile, moved.arena);
                const lod::LevelGrid still = smooth.dicer.dice(smooth.posed, tile, smooth.arena);
                const lod::PatchScale scale = moved.dicer.scale(moved.posed, tile.patch);
                const Box3f box = moved.dicer.bounds(moved.posed, scale, {tile.patch, 0, 0, 0, 0}, lod::kCoarsestLevel);
                for (int v = 0; v < grid.vertex_count; ++v) {
                    const Vec3f p = grid.at(v);
                    farthest = std::max(farthest, glm::distance(p, still.at(v)));
                    ASSERT_TRUE(glm::all(glm::lessThanEqual(box.lo, p)) && glm::all(glm::lessThanEqual(p, box.hi)))
                        << displaced.name;
                    const Vec3d world = Vec3d(p) + moved.posed.anchor;
                    ASSERT_TRUE(glm::all(glm::lessThanEqual(scene_box.lo, world)) &&
                                glm::all(glm::lessThanEqual(world, scene_box.hi)))
                        << displaced.name;
                }
            }
            // Vertices of both meshes belong to the same parameters, and T-vertices are the same means of two.
            EXPECT_LE(farthest, reach) << displaced.name;
            EXPECT_GT(farthest, reach * 0.25f) << displaced.name;
        }
    }
}

TEST(Displacement, OfOneValueMovesEveryPointAlongItsNormal)
{
    Cage cage = torus(9, 5, false);
    add_charts(cage);
    DisplacedCage displaced("torus", cage, 0.1f, 1);
    Texture full;
    full.width = full.height = 1;
    full.pixels = {Vec4f(1)};
    full.role = TextureRole::Data;
    displaced.cage.displacement->texture.texture = displaced.scene.add(full);
    displaced.cage.displacement->scale = 0.1f;
    displaced.cage.displacement->midlevel = 0.25f;
    displaced.textures.prepare(displaced.scene);
    DicedCage smooth(displaced.cage, 0), moved(displaced.cage, 0, Mat4d(1), &displaced.textures);
    smooth.posed.level = moved.level_of_largest_exponent(4);
    for (const lod::TileRef& tile : moved.tiles()) {
        const lod::LevelGrid grid = moved.dicer.dice(moved.posed, tile, moved.arena),
                             still = smooth.dicer.dice(smooth.posed, tile, smooth.arena);
        const lod::GridAttributes before = smooth.dicer.shade(smooth.posed, tile, tile.rates, smooth.arena);
        const lod::GridAttributes after = moved.dicer.shade(moved.posed, tile, tile.rates, moved.arena);
        for (int k = 0; k < grid.width() * grid.height(); ++k) {
            const int i = k % grid.width(), j = k / grid.width();
            const bool inside = i > 0 && j > 0 && i < tile.columns && j < tile.rows;
            if (inside) {
                ASSERT_NEAR(glm::distance(grid.at(k), still.at(k) + before.normal[k] * 0.075f), 0, 1e-6f);
            }
            // A uniformly moved smooth surface keeps its normals. Normals turn by 0.08 a step here, and differences are
            // taken over a quarter of a step, on borders to one side.
            ASSERT_NEAR(glm::distance(before.normal[k], after.normal[k]), 0, 0.01f);
        }
    }
}

TEST(Displacement, ByOneVectorMovesEveryPointAsThePlacementMovesVectors)
{
    Cage cage = prism(7);
    add_charts(cage);
    DisplacedCage displaced("prism", cage, 1, 1, Displacement::Space::Object);
    Texture full;
    full.width = full.height = 1;
    full.pixels = {Vec4f(0.75f, 0.25f, 0.5f, 1)};
    full.role = TextureRole::Data;
    displaced.cage.displacement->texture.texture = displaced.scene.add(full);
    displaced.cage.displacement->scale = 0.2f;
    displaced.textures.prepare(displaced.scene);
    const Mat4d place = turned_and_stretched();
    const Vec3f moves(Mat3d(place) * Vec3d(0.05, -0.05, 0));
    DicedCage smooth(displaced.cage, 0, place), moved(displaced.cage, 0, place, &displaced.textures);
    smooth.posed.level = moved.level_of_largest_exponent(3);
    for (const lod::TileRef& tile : moved.tiles()) {
        const lod::LevelGrid grid = moved.dicer.dice(moved.posed, tile, moved.arena),
                             still = smooth.dicer.dice(smooth.posed, tile, smooth.arena);
        const lod::GridAttributes before = smooth.dicer.shade(smooth.posed, tile, tile.rates, smooth.arena);
        const lod::GridAttributes after = moved.dicer.shade(moved.posed, tile, tile.rates, moved.arena);
        for (int k = 0; k < grid.width() * grid.height(); ++k) {
            ASSERT_NEAR(glm::distance(grid.at(k), still.at(k) + moves), 0, 4e-6f);
            ASSERT_NEAR(glm::distance(before.normal[k], after.normal[k]), 0, 2e-3f)
                << "rounding of differences over a quarter step";
        }
    }
    // A vector longer than the bound is shortened, not clamped on each axis.
    displaced.cage.displacement->bound = 0.01f;
    DicedCage held(displaced.cage, 0, place, &displaced.textures);
    held.posed.level = moved.posed.level;
    const lod::TileRef tile = held.tiles().front();
    const lod::LevelGrid near = held.dicer.dice(held.posed, tile, held.arena),
                         still = smooth.dicer.dice(smooth.posed, tile, smooth.arena);
    const Vec3d expected = Vec3d(still.at(0)) + smooth.posed.anchor + Vec3d(moves) * (0.01 / std::sqrt(0.005));
    EXPECT_NEAR(glm::distance(Vec3d(near.at(0)) + held.posed.anchor, expected), 0, 4e-6);
}

// A node that is longer along one axis than along others: the box of a node is grown in the object's axes.
TEST(Displacement, OfAPosedCageStaysWithinItsBoundInTheAxesOfTheObject)
{
    DisplacedCage displaced = displaced_case(6);
    set_texel(displaced, {1, 0, 0.7f});  // longer than the bound
    const double bound = double(displaced.cage.displacement->bound);
    std::mt19937_64 random(5);
    const auto any = [&] { return double(random() >> 40) * 0x1p-23 - 1; };
    const auto any_vector = [&] {
        const double x = any(), y = any();
        return Vec3d(x, y, any());
    };
    for (int i = 0; i < 1000; ++i) {
        const Vec3d sizes = any_vector() * Vec3d(1, 4, 20);
        const Mat3d place = Mat3d(turned_and_stretched()) * Mat3d(sizes.x, 0, 0, 0, sizes.y, 0, 0, 0, sizes.z);
        double map[3][4] = {};
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c) map[r][c] = place[c][r];
        const bool is_mirrored = glm::determinant(place) < 0;
        const lod::PosedDisplacement posed(displaced.cage, displaced.textures, map, is_mirrored, true, 1),
            still(displaced.cage, displaced.textures, map, is_mirrored, false, 1);
        lod::PointToDisplace at{};
        at.rest_du = Vec3f(any_vector());
        at.rest_dv = Vec3f(any_vector());
        at.du = Vec3f(any_vector());
        at.dv = Vec3f(any_vector());
        const Vec3d in_object = glm::inverse(place) * Vec3d(posed.offset(at, 0));
        EXPECT_LE(glm::length(in_object), bound * (1 + 1e-4)) << i;
        // In its pose at rest a cage is displaced as if it had none.
        at.du = Vec3f(place * Vec3d(at.rest_du));
        at.dv = Vec3f(place * Vec3d(at.rest_dv));
        const Vec3d expected(still.offset(at, 0));
        EXPECT_NEAR(glm::distance(Vec3d(posed.offset(at, 0)), expected), 0, 1e-3 * glm::length(expected)) << i;
    }
}

// The speeds of a displaced patch come from hundreds of points, which are computed several at a time.
TEST(Displacement, OfManyPointsHasTheBitsOfEachAlone)
{
    constexpr std::size_t kPoints = 77;
    DisplacedCage displaced = displaced_case(1);
    for (const Mat4d& place : {Mat4d(1), turned_and_stretched()}) {
        DicedCage moved(displaced.cage, 0, place, &displaced.textures);
        const lod::PosedDisplacement& displacement = moved.posed.displacement;
        std::mt19937_64 random(7);
        std::array<std::array<float, kPoints>, 12> values;
        for (auto& row : values)
            for (float& x : row) x = float(random() >> 40) * 0x1p-23f - 1;
        // Some points have parallel tangents, one that is 0, or coordinates without area.
        for (std::size_t k = 0; k < kPoints; k += 7) {
            for (std::size_t a = 0; a < 3; ++a) values[3 + a][k] = k % 2 ? values[a][k] : 0;
            values[10][k + 3] = values[11][k + 3] = 0;
        }
        const auto row = [&](std::size_t i) { return values[i].data(); };
        const lod::PointsToDisplace all{{row(0), row(1), row(2)}, {row(3), row(4), row(5)}, {row(6), row(7)},
                                        {row(8), row(9)},         {row(10), row(11)},       kPoints};
        std::array<std::array<float, kPoints>, 3> found;
        float* const out[3] = {found[0].data(), found[1].data(), found[2].data()};
        for (const int level : {-8, -3, 2}) {
            displacement.offsets_along_normal(all, level, out);
            for (std::size_t k = 0; k < kPoints; ++k) {
                const auto triple = [&](std::size_t i) { return Vec3f(values[i][k], values[i + 1][k], values[i + 2][k]); };
                const auto pair = [&](std::size_t i) { return Vec2f(values[i][k], values[i + 1][k]); };
                const Vec3f alone = displacement.offset({triple(0), triple(3), pair(6), pair(8), pair(10)}, level);
                EXPECT_EQ(alone, Vec3f(found[0][k], found[1][k], found[2][k])) << k;
            }
        }
    }
}

TEST(Displacement, MakesSpeedsThoseOfAllSixteenthsUpToTheMost)
{
    constexpr int kWidth = lod::DisplacedPatches::kSpeedPieces + 1;
    int full = 0, less = 0;
    for (const float factor : {1.0f, 10.0f, 100.0f}) {
        DisplacedCage displaced = displaced_case(0);
        displaced.cage.displacement->scale *= factor;
        displaced.cage.displacement->bound *= factor;
        DicedCage moved(displaced.cage, 0, Mat4d(1), &displaced.textures);
        lod::PatchPool pool;
        lod::DisplacedPatches patches(pool);
        for (std::uint32_t face = 0; face < displaced.cage.face_sizes.size(); ++face) {
            float still[2], speed[2];
            pool.posed(moved.posed, {face, 0}).speeds(still[0], still[1]);
            std::copy_n(still, 2, speed);
            patches.raise_speeds(moved.posed, {face, 0}, speed[0], speed[1]);
            std::vector<float> x(kWidth * kWidth), y(x), z(x);
            float* const out[3] = {x.data(), y.data(), z.data()};
            const int filter = lod::DisplacedPatches::level_of_pieces(std::max(still[0], still[1]));
            patches.points({moved.posed, {face, 0}, filter}, {0, 0, 1.0f / 16, 1.0f / 16, kWidth, kWidth}, out, kWidth);
            const auto point = [&](int i, int j) {
                const auto k = static_cast<std::size_t>(j * kWidth + i);
                return Vec3f(x[k], y[k], z[k]);
            };
            float longest[2] = {0, 0};
            for (int j = 0; j < kWidth; ++j)
                for (int i = 1; i < kWidth; ++i) {
                    longest[0] = std::max(longest[0], glm::length(point(i - 1, j) - point(i, j)));
                    longest[1] = std::max(longest[1], glm::length(point(j, i - 1) - point(j, i)));
                }
            for (int axis : {0, 1}) {
                EXPECT_EQ(speed[axis], lod::DisplacedPatches::diced_speed(16 * longest[axis], still[axis])) << face;
                ++(speed[axis] == lod::DisplacedPatches::most_speed(still[axis]) ? full : less);
            }
        }
    }
    EXPECT_GT(full, 0);
    EXPECT_GT(less, 0);
}

TEST(Displacement, HasTheNormalsOfItsMeshWhereThatIsFine)
{
    DisplacedCage displaced = displaced_case(0);
    // The texture has rolling hills instead of noise, so that an edge is short beside them.
    Texture hills;
    hills.width = hills.height = 256;
    hills.role = TextureRole::Data;
    for (int y = 0; y < 256; ++y)
        for (int x = 0; x < 256; ++x)
            hills.pixels.push_back(
                Vec4f(0.5f + 0.25f * std::sin(6.2831853f * float(x) / 256) + 0.25f * std::cos(6.2831853f * float(y) / 256)));
    displaced.cage.displacement->texture.texture = displaced.scene.add(hills);
    displaced.textures.prepare(displaced.scene);
    DicedCage diced(displaced.cage, 0, Mat4d(1), &displaced.textures);
    diced.level_of_largest_exponent(7);
    double worst = 0, undisplaced = 0;
    for (const lod::TileRef& tile : diced.tiles()) {
        if (std::min(tile.rates.u, tile.rates.v) < 5) continue;
        const lod::LevelGrid grid = diced.dicer.dice(diced.posed, tile, diced.arena);
        const lod::GridAttributes made = diced.dicer.shade(diced.posed, tile, tile.rates, diced.arena);
        diced.posed.displacement.of = nullptr;
        const lod::GridAttributes smooth = diced.dicer.shade(diced.posed, tile, tile.rates, diced.arena);
        diced.posed.displacement.of = &*diced.posed.slot->cage.displacement;
        // Borders are left out, since on seams they have their owners' coordinates.
        for (int j = 2; j < tile.rows - 1; ++j)
            for (int i = 2; i < tile.columns - 1; ++i) {
                const Vec3f n = glm::normalize(glm::cross(grid.vertex(i + 1, j) - grid.vertex(i - 1, j),
                                                          grid.vertex(i, j + 1) - grid.vertex(i, j - 1)));
                worst = std::max(worst, double(glm::distance(n, made.normal[grid.index(i, j)])));
                undisplaced = std::max(undisplaced, double(glm::distance(n, smooth.normal[grid.index(i, j)])));
            }
    }
    EXPECT_LT(worst, 0.1);
    EXPECT_GT(undisplaced, 3 * worst);
}

}  // namespace
}  // namespace occam::test
