// Tests of faces with very many corners.
#include <gtest/gtest.h>

#include <set>

#include "lod/extent.h"
#include "lod/posed_patch.h"
#include "scenegraph/large_parts.h"
#include "tests/support/diced_mesh.h"
#include "tests/support/limit_oracle.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

TEST(LargeFaces, HaveOneClassForAllPartsThatAreAlike)
{
    constexpr std::uint32_t kCorners = 130;
    const DicedCage diced(prism(kCorners), 0);
    const lod::Topology& topology = diced.topology();
    const auto kind = [&](std::uint32_t face, std::uint32_t sub) { return topology.controls({face, sub}).kind; };
    for (std::uint32_t sub = 0; sub < kCorners; ++sub) {
        EXPECT_EQ(kind(0, sub), kind(0, 0)) << "part " << sub << " of the lower face, which has no creases";
        EXPECT_EQ(kind(1, sub), kind(1, sub % 2)) << "part " << sub << " of the upper face, with two kinds in turn";
    }
}

TEST(LargeFaces, AreAsRoundAsTheirCage)
{
    constexpr std::uint32_t kCorners = 130;
    const DicedCage diced(prism(kCorners), 0);
    lod::PosedPatch patch;
    patch.set(diced.posed, {0, 0});
    const Vec3f first = patch.point(0.3f, 0.6f), middle = patch.point(1, 1);
    for (const std::uint32_t sub : {1u, 37u, 64u, 129u}) {
        patch.set(diced.posed, {0, sub});
        EXPECT_LT(glm::distance(patch.point(1, 1), middle), 1e-5f);
        // The lower face's corners run the other way round.
        const double turn = -6.283185307 * sub / kCorners, c = std::cos(turn), s = std::sin(turn);
        const Vec3d at(patch.point(0.3f, 0.6f));
        const Vec3d back{c * at.x + s * at.z, at.y, c * at.z - s * at.x};
        const Vec3d forth{c * at.x - s * at.z, at.y, c * at.z + s * at.x};
        EXPECT_LT(std::min(glm::distance(back, Vec3d(first)), glm::distance(forth, Vec3d(first))), 1e-5) << "part " << sub;
    }
}

/// The number of control points of a patch, and of classes, does not grow with the number of corners.
TEST(LargeFaces, CostAsMuchACornerHoweverManyThereAre)
{
    for (const std::uint32_t corners : {130u, 1000u, 3000u})
        for (const Cage& cage : {prism(corners), spindle(corners)}) {
            const DicedCage diced(cage, 0);
            const lod::Topology& topology = diced.topology();
            EXPECT_LE(topology.derived_count(), 12 * std::size_t(corners) + 100);
            std::set<const lod::PatchClass*> kinds;
            for (std::uint32_t face = 0; face < topology.face_count(); face += 1 + face / 4)
                for (std::uint32_t sub = 0; sub < topology.patches_of(face); sub += 1 + sub / 4) {
                    const lod::PatchControls& controls = topology.controls({face, sub});
                    EXPECT_LE(controls.indices.size(), 160u) << corners << " corners, face " << face;
                    kinds.insert(controls.kind);
                }
            EXPECT_LE(kinds.size(), 12u) << corners << " corners";
        }
}

/// Returns n x n polygons of 4 k corners each, whose vertices have up to four faces.
Cage polygon_grid(std::uint32_t n, std::uint32_t k)
{
    Cage cage;
    const std::uint32_t side = n * k + 1;
    for (std::uint32_t y = 0; y < side; ++y)
        for (std::uint32_t x = 0; x < side; ++x) cage.positions.push_back({float(x), float(y), 0});
    for (std::uint32_t y = 0; y < n; ++y)
        for (std::uint32_t x = 0; x < n; ++x) {
            const std::uint32_t first = y * k * side + x * k;
            for (std::uint32_t i = 0; i < k; ++i) cage.face_vertices.push_back(first + i);
            for (std::uint32_t i = 0; i < k; ++i) cage.face_vertices.push_back(first + k + i * side);
            for (std::uint32_t i = 0; i < k; ++i) cage.face_vertices.push_back(first + k * side + k - i);
            for (std::uint32_t i = 0; i < k; ++i) cage.face_vertices.push_back(first + (k - i) * side);
            cage.face_sizes.push_back(4 * k);
        }
    return cage;
}

// Memory floors count with this bound.
TEST(LargeFaces, HaveNoMoreDerivedPointsThanTheirBound)
{
    std::vector<Cage> cages{torus(), polygon_grid(4, 2), polygon_grid(4, 10), polygon_grid(4, 15), polygon_grid(4, 17)};
    for (const std::uint32_t corners : {5u, 32u, 64u, 65u, 200u}) {
        cages.push_back(prism(corners));
        cages.push_back(spindle(corners));
    }
    for (std::size_t i = cages.size(); i-- > 0;) {
        cages.push_back(cages[i]);
        cages.back().scheme = Scheme::Bilinear;
    }
    std::size_t with = 0;
    for (const Cage& cage : cages) {
        const std::size_t count = DicedCage(cage, 0).topology().derived_count(), most = most_derived_points(cage);
        EXPECT_LE(count, most);
        EXPECT_LE(most, count + 48) << "two vertices may have no moves";
        EXPECT_EQ(count > 0, most > 0);
        with += count > 0;
    }
    EXPECT_GE(with, 10u);
    EXPECT_LE(with, cages.size() - 10);
}

Cage even_spindle(std::uint32_t valence)
{
    Cage cage = spindle(valence);
    for (Vec3f& p : cage.positions)
        if (std::abs(p.y) < 1) p.y = 0;
    return cage;
}

/// Returns the direction away from an even spindle, as if it were two cones.
Vec3d outward_of_spindle(Vec3d at)
{
    return glm::normalize(glm::normalize(Vec3d(at.x, 0, at.z)) + Vec3d(0, at.y > 0 ? 0.6 : -0.6, 0));
}

/// Triangles around a pole are narrow, but no micropolygon is turned over. Some gap triangles are, since all of their area
/// is rounding; their hits have the normal of the surface.
TEST(LargePoles, TurnNoMicropolygonOver)
{
    DicedCage diced(even_spindle(100), -2);
    std::size_t turned = 0, gaps = 0;
    for (const MeshTriangle& t : diced.triangles()) {
        const Vec3d a(t.v[0]), b(t.v[1]), c(t.v[2]), middle = (a + b + c) / 3.0;
        if (glm::dot(glm::cross(b - a, c - a), outward_of_spindle(middle)) < 0) ++(t.is_gap ? gaps : turned);
    }
    EXPECT_EQ(turned, 0u);
    EXPECT_GT(gaps, 0u);
}

/// Lines from pole to pole over the middles of faces bulge less than lines along edges. The more faces there are, the
/// closer together these lines are, so the limit surface has steep ridges, as subdivision in long double has.
TEST(LargePoles, HaveRidgesInTheirLimitSurface)
{
    double last = 1;
    for (const std::uint32_t valence : {100u, 500u}) {
        const Cage cage = even_spindle(valence);
        const SubdivisionMesh mesh = SubdivisionMesh(cage).refined().refined().refined();
        DicedCage diced(cage, 0);
        lod::PosedPatch patch;
        double steepest = 1, apart = 1;
        for (const SubdivisionMesh::Face& face : mesh.faces) {
            if (face.face > 1) continue;
            const SubdivisionMesh::Limit limit = mesh.limit(face.corners[0]);
            if (!limit.has_normal || limit.valence >= 65) continue;
            const Vec3d expected(glm::normalize(limit.normal));
            steepest = std::min(steepest, glm::dot(expected, outward_of_spindle(Vec3d(limit.point))));
            patch.set(diced.posed, {face.face, face.sub});
            float values[9];
            float* rows[9];
            for (int r = 0; r < 9; ++r) rows[r] = values + r;
            patch.points_and_tangents({float(face.u), float(face.v), 1, 1, 1, 1}, rows, 1);
            const Vec3d du(values[3], values[4], values[5]), dv(values[6], values[7], values[8]);
            apart = std::min(apart, glm::dot(glm::normalize(glm::cross(du, dv)), expected));
        }
        EXPECT_GT(apart, 0.999) << valence;
        EXPECT_LT(steepest, last / 1.5) << valence;
        last = steepest;
    }
    EXPECT_LT(last, 0.25);
}

/// A patch at a pole is as long as its edge, and its rates are those of one at a smaller pole.
TEST(LargePoles, HaveTheRatesOfSmallerPoles)
{
    const auto scale = [](std::uint32_t valence) {
        DicedCage diced(spindle(valence), 0);
        return diced.dicer.scale(diced.posed, {0, 0}).k;
    };
    EXPECT_EQ(scale(60), scale(66));
    EXPECT_EQ(scale(60), scale(500));
}

TEST(LargeFaces, HaveTextureCoordinatesOfTheirCorners)
{
    Cage cage = prism(80);
    UvSet set;
    for (std::size_t c = 0; c < cage.face_vertices.size(); ++c) {
        set.values.push_back(Vec2f(float(c % 7), float(c % 5)));
        set.indices.push_back(std::uint32_t(c));
    }
    cage.uv_sets = {set};
    const DicedCage diced(cage, 0);
    lod::PosedPatch uv;
    Vec2f sum(0);
    for (std::uint32_t c = 0; c < 80; ++c) sum += set.values[c];
    for (const std::uint32_t sub : {0u, 33u, 79u}) {
        uv.set_uv(diced.posed, {0, sub}, 0);
        const Vec3f own = uv.point(0, 0), along = uv.point(1, 0), middle = uv.point(1, 1), before = uv.point(0, 1);
        const Vec2f next = set.values[(sub + 1) % 80], last = set.values[(sub + 79) % 80];
        EXPECT_LT(glm::distance(Vec2f(own), set.values[sub]), 1e-5f);
        EXPECT_LT(glm::distance(Vec2f(along), (set.values[sub] + next) * 0.5f), 1e-5f);
        EXPECT_LT(glm::distance(Vec2f(before), (set.values[sub] + last) * 0.5f), 1e-5f);
        EXPECT_LT(glm::distance(Vec2f(middle), sum / 80.0f), 1e-4f);
    }
}

// All faces of such a cage share one of its two poles, so no face is left.
TEST(LargePoles, LeaveACageThatHasNoExtent)
{
    Scene scene;
    place(scene, scene.add(spindle(4200)), {0, 0, 0});
    scene.refit();
    int points = 0;
    lod::Extent().visit_points(scene, [&](Vec3d) { ++points; });
    EXPECT_EQ(points, 0);
}

}  // namespace
}  // namespace occam::test
