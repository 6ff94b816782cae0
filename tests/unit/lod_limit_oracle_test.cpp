// Tests of limit points and normals at creases of every sharpness, against subdivision in long double.
#include <gtest/gtest.h>

#include <cmath>

#include "base/hash.h"
#include "lod/posed_patch.h"
#include "tests/support/campaign.h"
#include "tests/support/diced_mesh.h"
#include "tests/support/limit_oracle.h"
#include "tests/support/shape_builders.h"
#include "tests/support/shapes.h"

namespace occam::test {
namespace {

/// OpenSubdiv's Bfr divides a patch at most ten times towards a vertex that is not regular, or a crease, and approximates
/// what is left: a ring of a thousandth of a face's side. Where an infinitely sharp crease ends, a twentieth of that ring is
/// the largest difference that was found, if the vertex is a semi-sharp corner, too: then few of the ten divisions are left
/// to make the difference smaller. Elsewhere the two surfaces agree to 1e-7.
constexpr double kPositionBound = 0x1p-10 / 20;

/// The control points of a patch that was divided ten times are floats, rounded by half an ulp in the last step and by as
/// much again in those before. A derivative is three times the difference of two of them, times 2^10.
constexpr double kTangentRounding = 3 * 0x1p10 * 4 * 0x1p-24;

/// The largest differences between the engine's surface and the oracle's.
struct Difference {
    double position = 0;  ///< in extents of the cage
    double degrees = 0;   ///< between normals, without what the rounding of the tangents explains
    int points = 0, normals = 0;
};

/// Compares points and normals at all vertices of a cage that was subdivided `steps` times, at least once.
Difference difference_from_oracle(const Cage& cage, int steps)
{
    Difference out;
    SubdivisionMesh mesh(cage);
    if (!mesh.is_closed_manifold()) return out;
    for (int step = 0; step < steps; ++step) mesh = mesh.refined();
    DicedCage diced(cage, 0);
    const double extent = 2 * cage.bounds().radius();
    std::map<std::uint32_t, SubdivisionMesh::Limit> limits;
    lod::PosedPatch patch;
    lod::PatchRef at{~0u, 0};
    for (const SubdivisionMesh::Face& face : mesh.faces) {
        if (!diced.topology().is_seen(face.face)) continue;
        const lod::PatchRef here{face.face, face.sub};
        if (!(here == at)) patch.set(diced.posed, at = here);
        float values[9][4];
        float* const rows[9] = {values[0], values[1], values[2], values[3], values[4],
                                values[5], values[6], values[7], values[8]};
        const auto u = static_cast<float>(face.u), v = static_cast<float>(face.v), size = static_cast<float>(face.size);
        patch.points_and_tangents({u, v, size, size, 2, 2}, rows, 2);
        constexpr int kPlace[4] = {0, 1, 3, 2};
        for (int c = 0; c < 4; ++c) {
            const int k = kPlace[c];
            const auto row = [&](int r) { return Vec3d(values[r][k], values[r + 1][k], values[r + 2][k]); };
            const std::uint32_t vertex = face.corners[static_cast<std::size_t>(c)];
            const auto [found, is_new] = limits.try_emplace(vertex);
            if (is_new) found->second = mesh.limit(vertex);
            const SubdivisionMesh::Limit& limit = found->second;
            out.position = std::max(out.position, glm::distance(row(0) + diced.posed.anchor, Vec3d(limit.point)) / extent);
            ++out.points;
            const Vec3d normal = glm::cross(row(3), row(6)), expected(glm::normalize(limit.normal));
            // At a large vertex the patches have the normals beside it (lod/ring_patch.h).
            if (!limit.has_normal || limit.valence >= 65 || !(glm::length(normal) > 0)) continue;
            ++out.normals;
            const double cosine = std::clamp(glm::dot(glm::normalize(normal), expected), -1.0, 1.0);
            const double rounding = kTangentRounding * extent * (glm::length(row(3)) + glm::length(row(6))) /
                                    glm::length(normal);
            out.degrees = std::max(out.degrees, (std::acos(cosine) - rounding) * 57.29578);
        }
    }
    return out;
}

void expect_oracle(Cage cage, const std::string& what, int steps = 2)
{
    sanitize(cage);  // some creases at vertices of two faces are dropped
    const Difference found = difference_from_oracle(cage, steps);
    EXPECT_LE(found.position, kPositionBound) << what << ", in extents of the cage, at " << found.points << " points";
    EXPECT_LE(found.degrees, 0.5) << what << ", at " << found.normals << " normals";
}

/// Returns the edges of a cage, each once.
std::vector<Crease> edges_of(const Cage& cage)
{
    std::vector<Crease> edges;
    std::size_t first = 0;
    for (const std::uint32_t size : cage.face_sizes) {
        for (std::uint32_t i = 0; i < size; ++i) {
            const std::uint32_t a = cage.face_vertices[first + i], b = cage.face_vertices[first + (i + 1) % size];
            if (a < b) edges.push_back({a, b, 0});
        }
        first += size;
    }
    return edges;
}

/// Returns the cage with creases and corners of 0.25 to 11.25 in steps of a quarter on some of its edges and vertices.
Cage creased(Cage cage, std::uint64_t seed)
{
    std::uint64_t state = seed;
    const auto number = [&state](std::uint64_t count) { return mix_bits(state += 0x9e3779b97f4a7c15ull) % count; };
    const auto sharpness = [&] { return 0.25f * static_cast<float>(1 + number(45)); };
    const std::uint64_t one_in = 1 + number(6);
    cage.creases.clear();
    cage.corners.clear();
    for (Crease edge : edges_of(cage)) {
        edge.sharpness = sharpness();
        if (number(one_in) == 0) cage.creases.push_back(edge);
    }
    for (std::uint32_t v = 0; v < cage.positions.size(); ++v)
        if (number(12) == 0) cage.corners.push_back({v, sharpness()});
    return cage;
}

TEST(LimitOracle, FindsEachSharpnessOfACube)
{
    Cage cube = prism(4);
    const std::vector<Crease> edges = edges_of(cube);
    for (float sharpness = 0; sharpness <= 10.5f; sharpness += 0.25f) {
        // All edges; a closed line of four; three that meet; one, which ends in two darts; none, but a corner.
        for (int kind = 0; kind < 5; ++kind) {
            Cage cage = cube;
            for (Crease edge : edges) {
                edge.sharpness = sharpness;
                const bool is_top = edge.v0 < 4 && edge.v1 < 4, has_first = edge.v0 == edges[0].v0 || edge.v1 == edges[0].v0;
                if (kind == 0 || (kind == 1 && is_top) || (kind == 2 && has_first)) cage.creases.push_back(edge);
            }
            if (kind == 3) cage.creases = {{edges[0].v0, edges[0].v1, sharpness}};
            if (kind == 4) cage.corners = {{0, sharpness}};
            expect_oracle(cage, "kind " + std::to_string(kind) + ", sharpness " + std::to_string(sharpness));
        }
    }
}

TEST(LimitOracle, FindsCreasesAtEachValence)
{
    for (std::uint32_t valence = 3; valence <= 50; ++valence) {
        Cage cage = spindle(valence);
        const float sharpness = 0.25f * static_cast<float>(1 + valence * 7 % 40);
        cage.creases = {{0, 2, sharpness}, {0, 2 + valence / 2, sharpness}, {1, 2, sharpness}, {3, 4, 10}};
        expect_oracle(cage, "valence " + std::to_string(valence));
    }
}

class LimitOfShapes : public testing::TestWithParam<std::string> {};
TEST_P(LimitOfShapes, IsThatOfSubdivision)
{
    const Cage cage = load_cage(GetParam());
    // The oracle has the rules of Catmull and Clark alone, and none for borders. Large cages take seconds each.
    if (cage.scheme != Scheme::CatmullClark) GTEST_SKIP() << "it has another scheme";
    if (!SubdivisionMesh(cage).is_closed_manifold()) GTEST_SKIP() << "it is no closed manifold";
    if (cage.face_count() > 3000 && !is_long()) GTEST_SKIP() << "it has more faces than are tested by default";
    const bool is_large = cage.face_count() > (is_long() ? 2000u : 200u);
    expect_oracle(cage, "as it is", is_large ? 1 : 2);
    for (std::uint64_t seed = 1; !is_large && seed <= (is_long() ? 20u : 2u); ++seed)
        expect_oracle(creased(cage, seed), "creases of seed " + std::to_string(seed));
}
INSTANTIATE_TEST_SUITE_P(Closed, LimitOfShapes, testing::ValuesIn(closed_shapes()), shape_test_name);

}  // namespace
}  // namespace occam::test
