// Tables that are made when something first asks for them: where memory fails in the middle, the next one that asks makes
// them anew.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "lod/extent.h"
#include "lod/patch_hull.h"
#include "lod/posed_patch.h"
#include "lod/topology.h"
#include "tests/faults/failing_allocations.h"
#include "tests/support/campaign.h"
#include "tests/support/diced_mesh.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

/// Holds what a class of patches has made.
struct Made {
    std::vector<lod::PointStencil> corners;
    std::vector<float> hull, rows;
    std::vector<std::uint32_t> hull_controls, row_controls;
};

Made make(const lod::PatchClass& kind)
{
    Made made;
    for (int c = 0; c < 4; ++c) made.corners.push_back(kind.corner(c));
    made.hull.assign(kind.hull().weights.begin(), kind.hull().weights.end());
    made.hull_controls = kind.hull().controls;
    const lod::PatchClass::Node& leaf = kind.locate(0.3f, 0.9f);
    if (leaf.kind == lod::PatchClass::Node::Bicubic) {
        made.rows.assign(leaf.weights.get(), leaf.weights.get() + 16 * leaf.control_count);
        made.row_controls.assign(leaf.controls.get(), leaf.controls.get() + leaf.control_count);
    }
    return made;
}

/// Makes what a cage's first patch needs while one allocation fails in turn, and again afterwards. By default each of the
/// first ones fails, and then every fifth.
void expect_made_anew(const Cage& cage)
{
    const lod::PatchRef patch{0, 0};
    const Made wanted = make(*lod::Topology(cage).controls(patch).kind);
    ASSERT_FALSE(wanted.rows.empty());
    std::uint64_t failed = 1, n = 0;
    for (; failed > 0; n += is_long() || n < 20 ? 1 : 5) {
        SCOPED_TRACE(testing::Message() << "allocation " << n);
        const lod::Topology topology(cage);
        const lod::PatchClass& kind = *topology.controls(patch).kind;
        {
            const FailingAllocations failing(n, 1);
            try {
                make(kind);
            } catch (const std::bad_alloc&) {
            }
            failed = failing.failed();
        }
        const Made made = make(kind);
        for (std::size_t c = 0; c < 4; ++c) {
            EXPECT_EQ(made.corners[c].controls, wanted.corners[c].controls);
            EXPECT_EQ(made.corners[c].weights, wanted.corners[c].weights);
        }
        EXPECT_EQ(made.hull, wanted.hull);
        EXPECT_EQ(made.rows, wanted.rows);
        EXPECT_EQ(made.hull_controls, wanted.hull_controls);
        EXPECT_EQ(made.row_controls, wanted.row_controls);
    }
    EXPECT_GT(n, 20u);
}

TEST(FailingTables, AreMadeAnew)
{
    if (kIsSanitized) GTEST_SKIP() << "sanitizers have an operator new of their own";
    expect_made_anew(prism(5));
}

// The limit surface of such a patch is read from a source that is pooled.
TEST(FailingTables, OfCreasedPatchesAreMadeAnew)
{
    if (kIsSanitized) GTEST_SKIP() << "sanitizers have an operator new of their own";
    Cage cage = prism(5);
    cage.creases = {{0, 1, 2.5f}, {1, 2, 1}};
    expect_made_anew(cage);
}

/// Returns all points that a scene gives to an extent.
std::vector<Vec3d> points_of(lod::Extent& extent, const Scene& scene)
{
    std::vector<Vec3d> points;
    extent.visit_points(scene, [&](Vec3d p) { points.push_back(p); });
    return points;
}

// The points of a cage are kept from one call to the next. Half of them would make a picture too small for its scene.
TEST(FailingTables, OfAnExtentAreMadeAnew)
{
    if (kIsSanitized) GTEST_SKIP() << "sanitizers have an operator new of their own";
    for (const bool is_deformed : {false, true}) {
        Cage cage = torus();
        if (is_deformed) {
            cage.morph_targets.emplace_back().positions = cage.positions;
            cage.morph_weights = {0.5f};
        }
        Scene scene;
        place(scene, scene.add(cage), {0, 0, 0});
        scene.refit();
        lod::Extent whole;
        const std::vector<Vec3d> wanted = points_of(whole, scene);
        ASSERT_FALSE(wanted.empty());
        std::uint64_t failed = 1;
        for (std::uint64_t n = 0; failed > 0; ++n) {
            SCOPED_TRACE(testing::Message() << "allocation " << n);
            lod::Extent extent;
            {
                const FailingAllocations failing(n, 1);
                try {
                    points_of(extent, scene);
                } catch (const std::bad_alloc&) {
                }
                failed = failing.failed();
            }
            EXPECT_EQ(points_of(extent, scene), wanted);
        }
    }
}

TEST(FailingTables, OfAPosedPatchHaveRoomForTheNextOne)
{
    if (kIsSanitized) GTEST_SKIP() << "sanitizers have an operator new of their own";
    const DicedCage few(torus(), 0), many(spindle(50), 0);
    const auto point = [&](lod::PosedPatch& patch) {
        patch.set(many.posed, {0, 0});
        return patch.point(0.25f, 0.5f);
    };
    lod::PosedPatch whole;
    const Vec3f wanted = point(whole);
    std::uint64_t failed = 1;
    for (std::uint64_t n = 0; failed > 0; ++n) {
        SCOPED_TRACE(testing::Message() << "allocation " << n);
        // What is behind its three lists is the next block of each size.
        lod::PosedPatch patch, others[3];
        for (lod::PosedPatch* p : {&patch, &others[0], &others[1], &others[2]}) p->set(few.posed, {0, 0});
        Vec3f before[3], after[3];
        for (int i = 0; i < 3; ++i) before[i] = others[i].point(0.25f, 0.5f);
        {
            const FailingAllocations failing(n, 1);
            try {
                point(patch);
            } catch (const std::bad_alloc&) {
            }
            failed = failing.failed();
        }
        EXPECT_EQ(point(patch), wanted);
        for (int i = 0; i < 3; ++i) after[i] = others[i].point(0.25f, 0.5f);
        EXPECT_TRUE(std::equal(before, before + 3, after)) << "it wrote over others";
    }
}

/// Counts bytes as the memory of all classes does.
struct Account final : lod::ClassAccount {
    void add(std::size_t bytes) noexcept override { counted += bytes; }
    void remove(std::size_t bytes) noexcept override { counted -= bytes; }
    std::size_t counted = 0;
};

/// A surface with a fold, which is cubic nowhere near it.
struct Fold final : lod::LimitSource {
    void evaluate(double u, double v, Of, lod::LimitStencil& out) const override
    {
        out.p.assign(1, std::abs(u - 0.3) + std::abs(v - 0.6));
        out.du.assign(1, 0);
        out.dv.assign(1, 0);
    }
    std::size_t bytes() const noexcept override { return sizeof *this; }
};

TEST(FailingTables, OfAHullAreNotCountedIfItIsNotMade)
{
    if (kIsSanitized) GTEST_SKIP() << "sanitizers have an operator new of their own";
    std::uint64_t failed = 1, n = 0;
    for (; failed > 0; n += n < 50 ? 1 : 1 + n / 8) {
        SCOPED_TRACE(testing::Message() << "allocation " << n);
        Account account;
        const lod::PatchClass kind(1, std::make_unique<Fold>(), 2, &account);
        const std::size_t before = account.counted;
        bool has_hull = false;
        {
            const FailingAllocations failing(n, 1);
            try {
                kind.hull();
                has_hull = true;
            } catch (const std::bad_alloc&) {
            }
            failed = failing.failed();
        }
        EXPECT_EQ(account.counted, before + (has_hull ? kind.hull().bytes() : 0));
    }
    EXPECT_GT(n, 100u);
}

}  // namespace
}  // namespace occam::test
