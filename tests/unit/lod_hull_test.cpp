// Tests of the bounds of a whole patch against the points that they bound.
#include <gtest/gtest.h>

#include "lod/posed_patch.h"
#include "tests/support/diced_mesh.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

constexpr int kSide = 16;  // speeds bound the pieces of rates up to this one
constexpr int kFineSide = 64;

template <int kQuads>
struct GridOf {
    Vec3f at[kQuads + 1][kQuads + 1];

    explicit GridOf(lod::PosedPatch& patch)
    {
        std::vector<float> p(3 * (kQuads + 1));
        const std::size_t room = p.size() / 3;
        const float step = 1.0f / kQuads;
        for (std::size_t j = 0; j <= kQuads; ++j)
            // Rows are evaluated in parts, since no grid is wider than 32.
            for (std::size_t first = 0; first <= kQuads; first += kQuads / 4) {
                const int count = first == kQuads ? 1 : kQuads / 4;
                patch.points({float(first) * step, float(j) * step, step, 1, count, 1}, &p[0], &p[room], &p[2 * room],
                             count);
                for (std::size_t i = 0; i < std::size_t(count); ++i) at[j][first + i] = {p[i], p[room + i], p[2 * room + i]};
            }
    }
};
using Grid = GridOf<kSide>;

class PatchHulls : public testing::TestWithParam<Cage> {
protected:
    template <class Check>
    void for_patches(Check&& check)
    {
        const DicedCage diced(GetParam(), 0);
        const lod::Topology& topology = diced.topology();
        lod::PosedPatch patch;
        for (std::uint32_t face = 0; face < topology.face_count(); ++face)
            for (std::uint32_t sub = 0; sub < topology.patches_of(face); ++sub) {
                SCOPED_TRACE(testing::Message() << "face " << face << ", part " << sub);
                patch.set(diced.posed, {face, sub});
                Box3f controls;
                // At poles some control points are derived ones, which follow the vertices.
                for (const std::uint32_t v : topology.controls({face, sub}).indices)
                    if (v < GetParam().positions.size()) controls.add(diced.posed.vertex(v));
                check(patch, Grid(patch), controls);
            }
    }
};

void expect_in_box(lod::PosedPatch& patch)
{
    const Box3f box = patch.bounds(0, 1, 0, 1);
    for (const auto& row : GridOf<kFineSide>(patch).at)
        for (const Vec3f p : row)
            for (int a = 0; a < 3; ++a) ASSERT_TRUE(box.lo[a] <= p[a] && p[a] <= box.hi[a]) << "along axis " << a;
}

TEST_P(PatchHulls, HoldThePatchAndLieInItsControlPoints)
{
    for_patches([](lod::PosedPatch& patch, const Grid&, const Box3f& controls) {
        expect_in_box(patch);
        const Box3f box = patch.bounds(0, 1, 0, 1);
        for (int a = 0; a < 3; ++a)
            ASSERT_TRUE(controls.lo[a] - 1e-4f <= box.lo[a] && box.hi[a] <= controls.hi[a] + 1e-4f) << "along axis " << a;
    });
}

TEST_P(PatchHulls, BoundSpeedsInsideAndAlongEachSide)
{
    for_patches([](lod::PosedPatch& patch, const Grid& grid, const Box3f&) {
        float u = 0, v = 0, side[4] = {};
        for (int j = 0; j <= kSide; ++j)
            for (int i = 0; i < kSide; ++i) {
                const float along_u = kSide * glm::distance(grid.at[j][i], grid.at[j][i + 1]);
                const float along_v = kSide * glm::distance(grid.at[i][j], grid.at[i + 1][j]);
                u = std::max(u, along_u);
                v = std::max(v, along_v);
                if (j == 0) side[0] = std::max(side[0], along_u), side[3] = std::max(side[3], along_v);
                if (j == kSide) side[2] = std::max(side[2], along_u), side[1] = std::max(side[1], along_v);
            }
        float bound_u, bound_v;
        patch.speeds(bound_u, bound_v);
        EXPECT_LE(u, bound_u * 1.0001f);
        EXPECT_LE(v, bound_v * 1.0001f);
        // Control points are so close to the curve that the bound is not too loose.
        EXPECT_LE(bound_u, 3 * u + 1e-4f);
        EXPECT_LE(bound_v, 3 * v + 1e-4f);
        for (int s = 0; s < 4; ++s) {
            EXPECT_LE(side[s], patch.side_speed(s) * 1.0001f) << "side " << s;
            EXPECT_LE(patch.side_speed(s), 3 * side[s] + 1e-4f) << "side " << s;
        }
    });
}

// At poles the lattice reaches beyond its control points, but it still bounds the surface.
class HullsAtPoles : public PatchHulls {};
TEST_P(HullsAtPoles, HoldThePatch)
{
    for_patches([](lod::PosedPatch& patch, const Grid&, const Box3f&) { expect_in_box(patch); });
}
INSTANTIATE_TEST_SUITE_P(Cages, HullsAtPoles, testing::Values(spindle(30), spindle(360)));

// The vertices at corners and on sides come from their owners, and each is a sum of hundreds of control points. With its
// rounding error it still lies in the boxes of all patches around it.
TEST(Bounds, HoldVerticesThatNeighboursOwn)
{
    const Cage cage = spindle(360);
    const double size = 2 * cage.bounds().radius();
    Mat4d far(1);
    far[3] = Vec4d(0.7e5 * size, 0.1e5 * size, -0.7e5 * size, 1);
    DicedCage diced(cage, 0, far);
    diced.level_of_largest_exponent(3);
    for (const lod::TileRef& tile : diced.tiles()) {
        SCOPED_TRACE(testing::Message() << "face " << tile.patch.face << ", part " << tile.patch.sub);
        const Box3f box = diced.dicer.bounds(diced.posed, diced.dicer.scale(diced.posed, tile.patch),
                                             {tile.patch, 0, 0, 0, 0}, lod::kCoarsestLevel);
        const lod::LevelGrid grid = diced.dicer.dice(diced.posed, tile, diced.arena);
        for (int v = 0; v < grid.vertex_count; ++v)
            for (int a = 0; a < 3; ++a)
                ASSERT_TRUE(box.lo[a] <= grid.fine[a][v] && grid.fine[a][v] <= box.hi[a])
                    << "vertex " << v << " along axis " << a;
    }
}

INSTANTIATE_TEST_SUITE_P(Cages, PatchHulls, testing::Values(torus(), prism(3), prism(5), spindle(7)));
INSTANTIATE_TEST_SUITE_P(CreasedCubes, PatchHulls,
                         testing::Values(creased_cube(0.75f), creased_cube(2), creased_cube(4.5f), creased_cube(5.25f),
                                         creased_cube(6), creased_cube(7.75f), creased_cube(9.75f)));

// Points everywhere on a creased patch, and above all within the width of the crease from its edges, equal those of the
// patch's limit stencils. A tree that misses a narrow crease would not agree with the corners that patches share.
class CreasedPatches : public testing::TestWithParam<int> {};
TEST_P(CreasedPatches, AreWhereTheirLimitStencilsAre)
{
    const float sharpness = 0.25f * float(GetParam());
    const DicedCage diced(creased_cube(sharpness), 0);
    const lod::PatchControls& controls = diced.topology().controls({0, 0});
    lod::PosedPatch patch;
    patch.set(diced.posed, {0, 0});
    const std::array<float, 9> near_edges{0, 0x1p-11f, 0x1p-10f, 0x1p-8f, 0x1p-6f, 3 * 0x1p-7f, 0x1p-4f, 0.5f, 1 - 0x1p-9f};
    for (const float u : near_edges)
        for (const float v : near_edges) {
            const lod::LimitStencil stencil = controls.kind->limit(u, v);
            Vec3d expected(0);
            for (std::size_t k = 0; k < stencil.p.size(); ++k)
                expected += stencil.p[k] * Vec3d(diced.posed.vertex(controls.indices[k]));
            EXPECT_LT(glm::distance(expected, Vec3d(patch.point(u, v))), 2e-6) << "at " << u << ", " << v;
        }
}
INSTANTIATE_TEST_SUITE_P(QuartersOfSharpness, CreasedPatches, testing::Range(0, 45));

}  // namespace
}  // namespace occam::test
