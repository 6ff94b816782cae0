// Tables that are made when something first asks for them: where memory fails in the middle, the next one that asks makes
// them anew.
#include <gtest/gtest.h>

#include "lod/patch_hull.h"
#include "lod/topology.h"
#include "tests/faults/failing_allocations.h"
#include "tests/support/campaign.h"
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

}  // namespace
}  // namespace occam::test
