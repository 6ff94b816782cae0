// Tests that the tables of cages whose patches are all creased differently stay within their memory.
#include "lod/class_memory.h"

#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "base/error.h"
#include "lod/patch_hull.h"
#include "lod/topology.h"
#include "tests/support/made_cages.h"

namespace occam::lod {
namespace {

struct Constant final : LimitSource {
    explicit Constant(double v) : value(v) {}
    void evaluate(double, double, Of, LimitStencil& out) const override { out.p.assign(1, value); }
    std::size_t bytes() const noexcept override { return 1000; }
    double value;
};

TEST(ClassMemory, KeepsThePooledSourcesThatWereUsedLast)
{
    ClassMemory memory(1 << 20, 3000);
    int made = 0;
    std::vector<std::unique_ptr<const LimitSource>> sources;
    for (int i = 0; i < 5; ++i)
        sources.push_back(memory.pooled([&made, i] { return ++made, std::make_unique<const Constant>(i); }));
    EXPECT_EQ(made, 0) << "none is made before it is used";
    LimitStencil stencil;
    const auto use = [&](std::size_t i) {
        sources[i]->evaluate(0, 0, LimitSource::Of::Point, stencil);
        EXPECT_EQ(stencil.p.at(0), double(i));
    };
    for (const std::size_t i : {0, 1, 2, 0, 3}) use(i);
    EXPECT_EQ(made, 4);
    EXPECT_EQ(memory.kept(), 3u);
    for (const std::size_t i : {0, 2, 3}) use(i);
    EXPECT_EQ(made, 4) << "source 1 was dropped";
    use(1);
    EXPECT_EQ(made, 5);
    sources.clear();
    EXPECT_EQ(memory.kept(), 0u);
}

/// Returns a bent grid of n x n quads, each edge of which has a sharpness of its own.
Cage creased_grid(std::uint32_t n)
{
    std::mt19937 random(7);
    Cage cage;
    for (std::uint32_t i = 0; i <= n; ++i)
        for (std::uint32_t j = 0; j <= n; ++j) cage.positions.push_back({float(i), float(j), float(random() % 100) * 0.01f});
    const auto sharpness = [&] { return float(random() % 40 + 1) / 4; };
    for (std::uint32_t i = 0; i < n; ++i)
        for (std::uint32_t j = 0; j < n; ++j) {
            const std::uint32_t v = i * (n + 1) + j;
            cage.face_sizes.push_back(4);
            cage.face_vertices.insert(cage.face_vertices.end(), {v, v + n + 1, v + n + 2, v + 1});
            cage.creases.push_back({v, v + 1, sharpness()});
            cage.creases.push_back({v, v + n + 1, sharpness()});
        }
    return cage;
}

void look_at_all(const Topology& topology)
{
    for (std::uint32_t face = 0; face < topology.face_count(); ++face) topology.controls({face, 0}).kind->hull();
}

std::size_t allocated_bytes()
{
    const struct mallinfo2 info = mallinfo2();
    return info.uordblks + info.hblkhd;
}

/// Returns how many groups of 16 weights are zeros.
std::size_t rows_of_zeros(std::span<const float> weights)
{
    std::size_t count = 0;
    for (; !weights.empty(); weights = weights.subspan(16))
        count += std::ranges::all_of(weights.first(16), [](float w) { return w == 0; });
    return count;
}

std::size_t rows_of_zeros_below(const PatchClass& kind, const PatchClass::Node& node)
{
    kind.resolve(node);
    std::size_t count = 0;
    if (node.kind == PatchClass::Node::Bicubic)
        count = rows_of_zeros({node.weights.get(), std::size_t(16) * node.control_count});
    if (node.kind == PatchClass::Node::Split)
        for (int c = 0; c < node.child_count(); ++c) count += rows_of_zeros_below(kind, node.children[c]);
    return count;
}

// Three quarters of them would be, in the deep pieces of creased patches.
TEST(ClassMemory, TablesHaveNoRowsOfZeros)
{
    const Topology topology(creased_grid(3));
    for (std::uint32_t face = 0; face < topology.face_count(); ++face) {
        const PatchClass& kind = *topology.controls({face, 0}).kind;
        EXPECT_EQ(rows_of_zeros(kind.hull().weights), 0u);
        EXPECT_EQ(rows_of_zeros_below(kind, kind.root()), 0u);
    }
}

// The hull of a patch with creases comes from a tree of strips of its own, which does not outlive the making.
TEST(ClassMemory, HullsCountWhatTheyKeep)
{
    Cage cage = creased_grid(3);
    for (Crease& crease : cage.creases) crease.sharpness = 0.5f + std::fmod(crease.sharpness, 3.0f);
    const auto memory = std::make_shared<ClassMemory>();
    const Topology topology(cage, memory);
    for (std::uint32_t face = 0; face < topology.face_count(); ++face) {
        const PatchClass& kind = *topology.controls({face, 0}).kind;
        ASSERT_GT(kind.crease_depth(), 0);
        ASSERT_LE(kind.crease_depth(), PatchClass::kDeepest);
        const std::size_t before = memory->bytes();
        const std::size_t kept = kind.hull().bytes();
        EXPECT_EQ(memory->bytes() - before, kept) << face;
    }
}

// Each of the sources takes about a megabyte.
TEST(ClassMemory, SourcesOfCreasedPatchesAreDropped)
{
    const auto memory = std::make_shared<ClassMemory>(ClassMemory::kMostBytes, std::size_t(4) << 20);
    const std::size_t before = allocated_bytes();
    const Topology topology(creased_grid(8), memory);
    look_at_all(topology);
    EXPECT_LE(memory->kept(), 40u);
    EXPECT_GT(memory->bytes(), 64 * sizeof(PatchClass));
    // What is left is what is counted, the sources that are kept, and the cage's own tables.
    EXPECT_LE(allocated_bytes() - before, memory->bytes() + (std::size_t(24) << 20));
}

TEST(ClassMemory, RefusesClassesBeyondItsLimitAndFreesThem)
{
    const auto memory = std::make_shared<ClassMemory>(std::size_t(4) << 20);
    {
        const Topology topology(creased_grid(12), memory);
        EXPECT_THROW(look_at_all(topology), Error);
    }
    EXPECT_EQ(memory->bytes(), 0u);
    const Topology topology(test::made_cage("cube"), memory);
    EXPECT_NO_THROW(look_at_all(topology));
}

/// Returns a soup of polygons with `corners` corners, which share few vertices.
Cage soup(std::uint32_t polygons, std::uint32_t corners, std::uint32_t vertices)
{
    std::mt19937 random(3);
    Cage cage;
    for (std::uint32_t v = 0; v < vertices; ++v)
        cage.positions.push_back({float(random() % 1000), float(random() % 1000), float(random() % 1000)});
    std::vector<std::uint32_t> all(vertices);
    std::iota(all.begin(), all.end(), 0);
    for (std::uint32_t f = 0; f < polygons; ++f) {
        std::shuffle(all.begin(), all.end(), random);
        cage.face_sizes.push_back(corners);
        cage.face_vertices.insert(cage.face_vertices.end(), all.begin(), all.begin() + corners);
    }
    return cage;
}

// Each patch depends on thousands of vertices, or is near large ones: its source takes megabytes, and its lists kilobytes.
TEST(ClassMemory, CountsWhatPolygonsOfManyCornersTake)
{
    for (const std::uint32_t corners : {40u, 64u}) {
        const auto memory = std::make_shared<ClassMemory>(std::size_t(24) << 20, std::size_t(8) << 20);
        const std::size_t before = allocated_bytes();
        const Topology topology(soup(300, corners, 300), memory);
        EXPECT_THROW(look_at_all(topology), Error);
        EXPECT_LE(allocated_bytes() - before, std::size_t(96) << 20) << corners;
    }
}

// Each patch of the cone has a class of its own, since it lies otherwise to the corner at which the base begins. All
// surfaces of its sides have the same tables.
TEST(ClassMemory, CountsTablesThatSurfacesShareOnce)
{
    constexpr std::uint32_t kSides = 62;
    Cage cone;
    cone.positions.push_back({0, 0, 1});
    for (std::uint32_t k = 0; k < kSides; ++k) {
        const double angle = 6.28318530717959 * k / kSides;
        cone.positions.push_back({float(std::cos(angle)), float(std::sin(angle)), 0});
        cone.face_sizes.push_back(3);
        cone.face_vertices.insert(cone.face_vertices.end(), {0, 1 + k, 1 + (k + 1) % kSides});
    }
    cone.face_sizes.push_back(kSides);
    for (std::uint32_t k = kSides; k > 0; --k) cone.face_vertices.push_back(k);
    const auto memory = std::make_shared<ClassMemory>();
    const std::size_t before = allocated_bytes();
    const Topology topology(cone, memory);
    for (std::uint32_t face = 0; face < topology.face_count(); ++face)
        for (std::uint32_t sub = 0; sub < topology.patches_of(face); ++sub) topology.controls({face, sub}).kind->hull();
    EXPECT_LE(memory->bytes(), std::size_t(160) << 20);
    EXPECT_GE(memory->bytes(), (allocated_bytes() - before) / 2);
}

// Each sector of the poles has sharpness of its own.
TEST(ClassMemory, CountsWhatCreasedPolesTake)
{
    constexpr std::uint32_t kSpokes = 80;
    std::mt19937 random(5);
    Cage cage;
    for (std::uint32_t pole = 0; pole < 40; ++pole) {
        const auto first = static_cast<std::uint32_t>(cage.positions.size());
        cage.positions.push_back({float(4 * pole), 0, 1});
        for (std::uint32_t i = 0; i < 2 * kSpokes; ++i) {
            const double angle = 3.14159265358979 * i / kSpokes;
            cage.positions.push_back({float(4 * pole + std::cos(angle)), float(std::sin(angle)), float(i % 2) * 0.1f});
        }
        for (std::uint32_t i = 0; i < kSpokes; ++i) {
            const std::uint32_t spoke = first + 1 + 2 * i;
            cage.face_sizes.push_back(4);
            cage.face_vertices.insert(cage.face_vertices.end(),
                                      {first, spoke, spoke + 1, first + 1 + 2 * ((i + 1) % kSpokes)});
            cage.creases.push_back({first, spoke, float(random() % 900) / 100});
        }
    }
    const auto memory = std::make_shared<ClassMemory>(std::size_t(24) << 20, std::size_t(8) << 20);
    const std::size_t before = allocated_bytes();
    const auto make = [&] {
        const Topology topology(cage, memory);
        look_at_all(topology);
    };
    EXPECT_THROW(make(), Error);
    EXPECT_EQ(memory->bytes(), 0u);
    EXPECT_LE(allocated_bytes(), before + (std::size_t(8) << 20));
}

// A source that was dropped and made again has the bits of one that was kept.
TEST(ClassMemory, DoesNotChangeTheSurface)
{
    const Cage cage = creased_grid(4);
    const Topology plenty(cage), tight(cage, std::make_shared<ClassMemory>(ClassMemory::kMostBytes, 1));
    for (std::uint32_t face = 0; face < plenty.face_count(); ++face) {
        const PatchControls &a = plenty.controls({face, 0}), &b = tight.controls({face, 0});
        for (const double u : {0.0, 0.3, 0.99}) {
            constexpr auto kOf = LimitSource::Of::PointAndTangents;
            const LimitStencil x = a.kind->limit(u, 0.7, kOf), y = b.kind->limit(u, 0.7, kOf);
            EXPECT_EQ(x.p, y.p);
            EXPECT_EQ(x.p, a.kind->limit(u, 0.7).p);
            EXPECT_EQ(x.du, y.du);
        }
    }
}

}  // namespace
}  // namespace occam::lod
