// Tests that a cage whose faces share vertices and edges in any way has a surface, and that no memory is overwritten for it.
//
// OCCAM_SEED=n tests that seed alone. OpenSubdiv is not built with sanitizers, so only valgrind sees all that it reads and
// writes: OCCAM_SEED=n valgrind occam_hostile_tests --gtest_filter=RandomSoups.*
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>

#include "lod/posed_patch.h"
#include "tests/support/campaign.h"
#include "tests/support/case_random.h"
#include "tests/support/diced_mesh.h"
#include "tests/support/displaced_cages.h"

namespace occam::test {
namespace {

/// Returns the vertices of one more face. It often shares edges in a row with an earlier face, mostly in the other
/// direction, so that two faces close around vertices and edges have one, two or more faces.
std::vector<std::uint32_t> any_face(CaseRandom& random, const Cage& cage)
{
    std::vector<std::uint32_t> face;
    const std::size_t size = 3 + random.index(random.number() < 0.3 ? 4 : 2);
    if (!cage.face_sizes.empty() && random.number() < 0.5) {
        const std::size_t which = random.index(cage.face_sizes.size());
        std::size_t at = 0;
        for (std::size_t f = 0; f < which; ++f) at += cage.face_sizes[f];
        const std::size_t there = cage.face_sizes[which], from = random.index(there);
        for (std::size_t k = 2 + random.index(2); k > 0; --k) face.push_back(cage.face_vertices[at + (from + k) % there]);
        if (random.number() < 0.2) std::reverse(face.begin(), face.end());
    }
    while (face.size() < size && face.size() < cage.positions.size()) {
        const auto v = static_cast<std::uint32_t>(random.index(cage.positions.size()));
        if (std::ranges::find(face, v) == face.end()) face.push_back(v);
    }
    return face;
}

void add_tags(Cage& cage, CaseRandom& random)
{
    const double share = random.number();
    const bool is_mostly_infinite = random.number() < 0.3;
    std::size_t at = 0;
    for (const std::uint32_t size : cage.face_sizes) {
        for (std::uint32_t i = 0; i < size; ++i) {
            if (random.number() > share) continue;
            const float steps = float(1 + random.index(40));
            const float sharpness = is_mostly_infinite && random.number() < 0.7 ? kInfiniteSharpness : 0.25f * steps;
            cage.creases.push_back({cage.face_vertices[at + i], cage.face_vertices[at + (i + 1) % size], sharpness});
        }
        at += size;
    }
    if (random.number() < 0.3)
        cage.corners = {{static_cast<std::uint32_t>(random.index(cage.positions.size())), float(random.between(0, 10))}};
    if (random.number() < 0.2) cage.holes = {static_cast<std::uint32_t>(random.index(cage.face_sizes.size()))};
    cage.boundary = BoundaryRule(random.index(3));
    cage.face_varying = FaceVaryingRule(random.index(6));
}

/// Adds texture coordinates with no, few or many seams.
void add_seams(Cage& cage, CaseRandom& random)
{
    UvSet uv;
    for (int k = 0; k < 12; ++k) {
        const double u = random.number();
        uv.values.push_back(Vec2f(u, random.number()));
    }
    double seams = random.number();
    seams *= random.number();
    for (const std::uint32_t v : cage.face_vertices)
        uv.indices.push_back(random.number() < seams ? static_cast<std::uint32_t>(random.index(12)) : v % 12);
    cage.uv_sets = {std::move(uv)};
}

Cage random_soup(std::uint64_t seed)
{
    CaseRandom random(seed, 0, 900);
    Cage cage;
    for (std::size_t n = 4 + random.index(7); n > 0; --n) cage.positions.push_back(Vec3f(random.inside_cube()));
    for (std::size_t n = 2 + random.index(9); n > 0; --n) {
        const std::vector<std::uint32_t> face = any_face(random, cage);
        cage.face_sizes.push_back(static_cast<std::uint32_t>(face.size()));
        cage.face_vertices.insert(cage.face_vertices.end(), face.begin(), face.end());
    }
    add_tags(cage, random);
    if (random.number() < 0.5) add_seams(cage, random);
    sanitize(cage);
    return cage;
}

/// Expects that all patches along an edge of the cage have the middle of that edge in one place.
void expect_one_middle_of_each_edge(const DicedCage& diced)
{
    const lod::Topology& topology = diced.topology();
    const double most = 1e-5 * double(diced.posed.radius);
    std::map<std::uint32_t, Vec3f> middles;
    lod::PosedPatch patch;
    for (std::uint32_t face = 0; face < topology.face_count(); ++face)
        for (std::uint32_t sub = 0; topology.is_seen(face) && sub < topology.patches_of(face); ++sub)
            for (int side = 0; side < 4; ++side) {
                const lod::SideCurve on = topology.side({face, sub}, side);
                if (topology.is_inner(on.curve)) continue;
                // Lattices run with rising parameters. A side of an n-gon's part is one half of its edge.
                const bool is_whole = topology.face_size(face) == 4;
                const float t = is_whole ? 0.5f : 1.0f;
                patch.set(diced.posed, {face, sub});
                const Vec3f here = side == 0   ? patch.point(t, 0)
                                   : side == 1 ? patch.point(1, t)
                                   : side == 2 ? patch.point(t, 1)
                                               : patch.point(0, t);
                const Vec3f there = middles.emplace(on.curve, here).first->second;
                EXPECT_LE(glm::distance(here, there), most) << "face " << face << ", part " << sub << ", side " << side;
            }
}

void expect_surface(std::uint64_t seed)
{
    SCOPED_TRACE("OCCAM_SEED=" + std::to_string(seed));
    const Cage cage = random_soup(seed);
    if (cage.face_sizes.empty()) return;
    const DicedCage diced(cage, 0);
    EXPECT_TRUE(has_finite_surface(diced));
    expect_one_middle_of_each_edge(diced);
}

// OpenSubdiv takes the ends of a fan for one place where a tetrahedron or a pyramid has a further face at an edge.
TEST(RandomSoups, HaveASurfaceWhereATetrahedronOrAPyramidHasAFin)
{
    for (const std::uint32_t sides : {3u, 4u, 5u}) {
        Cage cage;
        for (std::uint32_t k = 0; k < sides; ++k) {
            const float angle = 6.2831853f * float(k) / float(sides);
            cage.positions.push_back({std::cos(angle), std::sin(angle), 0});
            cage.face_vertices.push_back(sides - 1 - k);
        }
        const std::uint32_t tip = sides, fin = sides + 1;
        cage.positions.insert(cage.positions.end(), {{0, 0, 1}, {2, 0, 1}});
        cage.face_sizes = {sides};
        for (std::uint32_t k = 0; k < sides; ++k) {
            cage.face_sizes.push_back(3);
            cage.face_vertices.insert(cage.face_vertices.end(), {k, (k + 1) % sides, tip});
        }
        cage.face_sizes.push_back(3);
        cage.face_vertices.insert(cage.face_vertices.end(), {0, tip, fin});
        add_charts(cage);
        SCOPED_TRACE(sides);
        ASSERT_TRUE(sanitize(cage).empty());
        expect_one_middle_of_each_edge(DicedCage(cage, 0));
    }
}

// OpenSubdiv takes surfaces for alike whose vertices coincide in different places.
TEST(RandomSoups, HaveASurfaceWhereTwoFacesCloseAroundAVertexOfOthers)
{
    for (const std::uint64_t seed : {912u, 1138u}) expect_surface(seed);
}

TEST(RandomSoups, HaveASurface)
{
    if (const char* seed = std::getenv("OCCAM_SEED")) return expect_surface(std::strtoull(seed, nullptr, 10));
    for (std::uint64_t seed = 1; seed <= (is_long() ? 40'000u : 300u) && !HasFailure(); ++seed) expect_surface(seed);
}

}  // namespace
}  // namespace occam::test
