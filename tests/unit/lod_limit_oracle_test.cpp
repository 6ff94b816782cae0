// Tests of limit points and normals at creases of every sharpness, against subdivision in long double.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "base/hash.h"
#include "lod/patch_surface.h"
#include "tests/support/campaign.h"
#include "tests/support/creased_cages.h"
#include "tests/support/diced_mesh.h"
#include "tests/support/displaced_cages.h"
#include "tests/support/limit_oracle.h"
#include "tests/support/shape_builders.h"
#include "tests/support/shapes.h"

namespace occam::test {
namespace {

/// The engine's points are sums of floats, each of them rounded.
constexpr double kPositionBound = 1e-6;

/// The engine's stencils are made in double, and close to the corners of a patch after nine steps of subdivision.
constexpr double kDegrees = 0.001;

/// Returns the largest relative error of a tangent of the cage's extent: a derivative is three times the difference of two
/// control points, times 2^depth, and these are floats, rounded by half an ulp in the last step and by as much again in
/// those before. Deep pieces and what is not bicubic have weights of differences, whose errors do not grow with the depth.
/// largest_depth   of pieces whose errors grow; in finer ones they are those of this depth at most
double tangent_rounding(const lod::PatchClass& kind, float u, float v, int largest_depth)
{
    const lod::PatchClass::Node& node = kind.locate(u, v);
    const bool grows = node.kind == lod::PatchClass::Node::Bicubic;
    const auto factor = [&](int depth) {
        return lod::PatchClass::is_deep(depth) ? 1.0 : std::exp2(std::min(depth, largest_depth));
    };
    return 3 * 4 * 0x1p-24 * (grows ? std::max(factor(node.depth_u), factor(node.depth_v)) : 1.0);
}

/// The largest differences between the engine's surface and the oracle's.
struct Difference {
    double position = 0;  ///< in extents of the cage
    double degrees = 0;   ///< between normals, without what the rounding of the tangents explains
    int points = 0, normals = 0;
};

/// Compares a cage with its oracle.
class Comparison {
public:
    explicit Comparison(const Cage& cage, const TextureStore* textures = nullptr, std::span<const Mat4d> joints = {})
        : extent_(2 * cage.bounds().radius()), diced_(cage, 0, Mat4d(1), textures, joints), origin_(diced_.posed.anchor)
    {
    }

    /// Returns the cage as it is posed, and compares with that from now on.
    Cage pose(Cage cage)
    {
        for (std::uint32_t v = 0; v < cage.positions.size(); ++v) cage.positions[v] = diced_.posed.vertex(v);
        origin_ = Vec3d(0);
        return cage;
    }

    /// Compares points and normals at those vertices of a subdivided mesh of the cage that it knows all faces of.
    void add(const SubdivisionMesh& mesh)
    {
        std::map<std::uint32_t, SubdivisionMesh::Limit> limits;
        for (const SubdivisionMesh::Face& face : mesh.faces) {
            if (!diced_.topology().is_seen(face.face)) continue;
            const lod::PatchRef here{face.face, face.sub};
            if (!(here == at_)) patch_.set(diced_.posed, at_ = here);
            float values[9][4];
            float* const rows[9] = {values[0], values[1], values[2], values[3], values[4],
                                    values[5], values[6], values[7], values[8]};
            const auto u = static_cast<float>(face.u), v = static_cast<float>(face.v), size = static_cast<float>(face.size);
            patch_.points_and_tangents({u, v, size, size, 2, 2}, rows, 2);
            Vec3f normals[4];
            surface_.normals({diced_.posed, here, 0}, {u, v, size, size, 2, 2}, normals);
            constexpr int kPlace[4] = {0, 1, 3, 2};
            for (int c = 0; c < 4; ++c) {
                const int k = kPlace[c];
                const auto row = [&](int r) { return Vec3d(values[r][k], values[r + 1][k], values[r + 2][k]); };
                const std::uint32_t vertex = face.corners[static_cast<std::size_t>(c)];
                if (!mesh.is_inside(vertex)) continue;
                const auto [of, is_new] = limits.try_emplace(vertex);
                if (is_new) of->second = mesh.limit(vertex);
                const float at_u = u + float(k & 1) * size, at_v = v + float(k >> 1) * size;
                add_point({at_u, at_v, row(0), row(3), row(6), Vec3d(normals[k])}, of->second);
            }
        }
    }

    /// Explains no rounding of pieces that were divided more than this many times.
    void forgive_rounding_to_depth(int depth) { largest_depth_ = depth; }

    Difference found;

private:
    struct Found {
        float u, v;
        Vec3d p, du, dv, normal;
    };

    void add_point(const Found& at, const SubdivisionMesh::Limit& limit)
    {
        const double off = glm::distance(at.p + origin_, Vec3d(limit.point)) / extent_;
        found.position = std::max(found.position, off);
        ++found.points;
        const Vec3d expected(glm::normalize(limit.normal));
        // At a large vertex the patches have the normals beside it (lod/ring_patch.h).
        if (!limit.has_normal || limit.valence >= 65 || !(glm::length(at.normal) > 0)) return;
        ++found.normals;
        const double rounding = tangent_rounding(*diced_.topology().controls(at_).kind, at.u, at.v, largest_depth_) *
                                extent_ * (glm::length(at.du) + glm::length(at.dv)) / glm::length(glm::cross(at.du, at.dv));
        const double angle = std::atan2(glm::length(glm::cross(at.normal, expected)), glm::dot(at.normal, expected));
        found.degrees = std::max(found.degrees, (angle - rounding) * 57.29578);
    }

    double extent_;
    int largest_depth_ = lod::PatchClass::kDeepest;
    DicedCage diced_;
    Vec3d origin_;
    lod::PatchSurface surface_;
    lod::PosedPatch patch_;
    lod::PatchRef at_{~0u, 0};
};

void expect_close(const Difference& found, const std::string& what)
{
    EXPECT_LE(found.position, kPositionBound) << what << ", in extents of the cage, at " << found.points << " points";
    EXPECT_LE(found.degrees, kDegrees) << what << ", at " << found.normals << " normals";
}

/// Compares points and normals at all vertices of a cage that is subdivided `steps` times, at least once.
void expect_oracle(Cage cage, const std::string& what, int steps = 2)
{
    sanitize(cage);  // some creases at vertices of two faces are dropped
    SubdivisionMesh mesh(cage);
    if (!mesh.is_closed_manifold()) return;
    for (int step = 0; step < steps; ++step) mesh = mesh.refined();
    Comparison comparison(cage);
    comparison.add(mesh);
    expect_close(comparison.found, what);
}

/// Compares points and normals around a vertex of a cage, and around the middle of a face at it, down to 2^-16 of a face's
/// side. OpenSubdiv itself approximates from 2^-10 on.
/// deepest   16, or the power of two down to which they are compared
void expect_oracle_near(Comparison& comparison, const Cage& cage, std::uint32_t vertex, const std::string& what,
                        int deepest = 16)
{
    const SubdivisionMesh mesh(cage);
    ASSERT_TRUE(mesh.is_closed_manifold());
    SubdivisionMesh part = mesh.around(vertex).refined();
    // Each new face has the vertex, an edge's middle, the middle of its face, and another edge's middle.
    SubdivisionMesh middle = part.around(part.faces.front().corners[2]);
    part = part.around(0);
    for (int depth = 1;; ++depth) {
        comparison.add(part);
        comparison.add(middle);
        if (depth == deepest) break;
        part = part.refined().around(0);
        middle = middle.refined().around(0);
    }
    expect_close(comparison.found, what);
}

void expect_oracle_near(const Cage& cage, std::uint32_t vertex, const std::string& what)
{
    Comparison comparison(cage);
    expect_oracle_near(comparison, cage, vertex, what);
}

TEST(LimitOracle, FindsEachSharpnessOfACube)
{
    Cage cube = prism(4);
    const std::vector<Crease> edges = edges_of(cube);
    for (float sharpness = 0; sharpness <= 10.5f; sharpness += is_long() ? 0.25f : 1.75f) {
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
    for (std::uint32_t valence = 3; valence <= 50; valence += is_long() || valence < 6 ? 1 : 11) {
        Cage cage = spindle(valence);
        const float sharpness = 0.25f * static_cast<float>(1 + valence * 7 % 40);
        cage.creases = {{0, 2, sharpness}, {0, 2 + valence / 2, sharpness}, {1, 2, sharpness}, {3, 4, 10}};
        expect_oracle(cage, "valence " + std::to_string(valence));
    }
}

/// Returns a spindle with creases of 6 to 9.75 along its spokes.
Cage sharp_spindle(std::uint32_t valence)
{
    Cage cage = spindle(valence);
    const float sharpness = 6 + 0.25f * static_cast<float>(valence * 7 % 16);
    cage.creases = {{0, 2, sharpness}, {0, 2 + valence / 2, sharpness}, {1, 2, sharpness}};
    return cage;
}

TEST(LimitOracle, FindsNormalsNearVerticesOfEachValence)
{
    for (std::uint32_t valence = 3; valence <= 50; valence += is_long() || valence < 6 ? 1 : 14)
        expect_oracle_near(sharp_spindle(valence), 0, "valence " + std::to_string(valence));
}

TEST(LimitOracle, FindsNormalsNearCreasesOfEachSharpness)
{
    for (float sharpness = 0.5f; sharpness < 10; sharpness += is_long() ? 0.25f : 1.75f) {
        Cage cage = prism(5);
        cage.creases.clear();
        for (Crease edge : edges_of(cage)) {
            edge.sharpness = sharpness;
            if (edge.v0 < 5) cage.creases.push_back(edge);
        }
        cage.corners = {{1, sharpness}};
        expect_oracle_near(cage, 0, "sharpness " + std::to_string(sharpness));
        expect_oracle_near(cage, 1, "a corner of sharpness " + std::to_string(sharpness));
    }
}

// An infinitely sharp corner stays where it is, and the surface beside it has no other limit than that of subdivision.
TEST(LimitOracle, FindsNormalsNearCornersOfEachValence)
{
    for (const std::uint32_t valence : {3u, 4u, 7u})
        for (const float sharpness : {5.0f, 9.5f, kInfiniteSharpness}) {
            Cage cage = spindle(valence);
            cage.corners = {{0, sharpness}};
            expect_oracle_near(cage, 0, "valence " + std::to_string(valence) + ", sharpness " + std::to_string(sharpness));
        }
}

TEST(LimitOracle, FindsPointsNearCornersOfTwoFaces)
{
    // A vertex in the middle of the first edge, which belongs to two faces.
    Cage cage = prism(5);
    cage.creases.clear();
    const Crease edge = edges_of(cage).front();
    const auto middle = static_cast<std::uint32_t>(cage.positions.size());
    cage.positions.push_back((cage.positions[edge.v0] + cage.positions[edge.v1]) * 0.6f);
    std::vector<std::uint32_t> vertices;
    for (std::size_t face = 0, first = 0; face < cage.face_sizes.size(); ++face) {
        const std::uint32_t size = cage.face_sizes[face];
        for (std::uint32_t i = 0; i < size; ++i) {
            const std::uint32_t a = cage.face_vertices[first + i], b = cage.face_vertices[first + (i + 1) % size];
            vertices.push_back(a);
            if (std::minmax(a, b) != std::minmax(edge.v0, edge.v1)) continue;
            vertices.push_back(middle);
            ++cage.face_sizes[face];
        }
        first += size;
    }
    cage.face_vertices = vertices;
    for (const float sharpness : {0.0f, 5.0f, 9.5f, kInfiniteSharpness}) {
        cage.corners = {{middle, sharpness}};
        expect_oracle_near(cage, middle, "sharpness " + std::to_string(sharpness));
    }
}

/// The engine's moves of large vertices (lod/ring_patch.h) are OpenSubdiv's own within 2^-10 of a face's side, and tangents
/// within 2^-12 are those beside it.
constexpr int kDeepestAtLargeVertices = 12;

/// Returns a spindle of many faces with three creases at one of its poles; two of them are neighbours.
Cage large_spindle(float sharpness)
{
    Cage cage = spindle(72);
    cage.creases = {{0, 2, sharpness}, {0, 30, sharpness}, {0, 31, 4.6f}};
    return cage;
}

// Creases above 6 have trees of strips, whose pieces have weights of differences (lod/patch_class.h).
TEST(LimitOracle, FindsNormalsNearLargeVerticesOfEachSharpness)
{
    for (float sharpness = 2.5f; sharpness < 10.5f; sharpness += is_long() ? 0.5f : 6) {
        const Cage cage = large_spindle(sharpness);
        Comparison comparison(cage);
        expect_oracle_near(comparison, cage, 0, "sharpness " + std::to_string(sharpness), kDeepestAtLargeVertices);
    }
}

TEST(LimitOracle, FindsNormalsNearLargeVerticesOfPosedAndDisplacedCages)
{
    Cage posed = large_spindle(8);
    add_skin(posed);
    Comparison of_posed(posed, nullptr, bent_joints());
    expect_oracle_near(of_posed, of_posed.pose(posed), 0, "posed", kDeepestAtLargeVertices);
    Cage charted = large_spindle(8);
    add_charts(charted);
    DisplacedCage displaced("spindle", charted, 1e-10f, 1);
    set_texel(displaced, Vec3f(1));
    Comparison of_displaced(displaced.cage, &displaced.textures);
    expect_oracle_near(of_displaced, displaced.cage, 0, "displaced", kDeepestAtLargeVertices);
}

TEST(LimitOracle, FindsNormalsAtAnySizeAndFarAway)
{
    for (const std::uint32_t valence : {3u, 9u})
        // A frame has a unit of its own (scenegraph/frame_scale.h), so cages of other sizes are not diced.
        for (const float size : {1e-6f, 1.0f, 1e6f})
            for (const float distance : {0.0f, 1e5f}) {
                Cage cage = sharp_spindle(valence);
                for (Vec3f& p : cage.positions) p = (p + Vec3f(1, 0.7f, -0.4f) * distance) * size;
                // The oracle starts from the positions around the middle of the cage, which are rounded.
                Comparison comparison(cage);
                expect_oracle_near(comparison, comparison.pose(cage), 0,
                                   "valence " + std::to_string(valence) + ", size " + std::to_string(size) + ", distance " +
                                       std::to_string(distance));
            }
}

TEST(LimitOracle, FindsNormalsOfSmallFacesFarFromTheMiddleOfTheirCage)
{
    for (const std::uint32_t valence : {3u, 9u, 72u}) {
        // A second spindle on the other side keeps the middle of the cage where it is.
        constexpr float kSize = 0x1p-10f;
        Cage cage = sharp_spindle(valence);
        const auto count = static_cast<std::uint32_t>(cage.positions.size());
        const Cage one = cage;
        for (Vec3f& p : cage.positions) p = p * kSize + Vec3f(1, 0.7f, 0.4f);
        for (const Vec3f p : one.positions) cage.positions.push_back(p * kSize - Vec3f(1, 0.7f, 0.4f));
        for (const std::uint32_t size : one.face_sizes) cage.face_sizes.push_back(size);
        for (const std::uint32_t v : one.face_vertices) cage.face_vertices.push_back(v + count);
        for (const bool is_creased : {true, false}) {
            if (!is_creased) cage.creases.clear();
            Comparison comparison(cage);
            const bool is_large = valence >= 65;
            comparison.forgive_rounding_to_depth(is_large ? 0 : 3);
            // From 2^-11 on, the rounding of derived points can be told beside the pole.
            expect_oracle_near(comparison, cage, 0, "valence " + std::to_string(valence), is_large ? 10 : 16);
        }
    }
}

TEST(LimitOracle, FindsNormalsOfPosedCages)
{
    for (const std::uint32_t valence : {3u, 8u, 21u}) {
        Cage cage = sharp_spindle(valence);
        add_skin(cage);
        Comparison comparison(cage, nullptr, bent_joints());
        expect_oracle_near(comparison, comparison.pose(cage), 0, "valence " + std::to_string(valence));
    }
}

// Where all points move as far along their normals, the normals stay. The way is short beside the smallest step, over which
// the normals turn at a crease: differences of displacements are exact to the first order only.
TEST(LimitOracle, FindsNormalsOfDisplacedCages)
{
    for (const std::uint32_t valence : {3u, 8u, 21u}) {
        Cage cage = sharp_spindle(valence);
        add_charts(cage);
        DisplacedCage displaced("spindle", cage, 1e-10f, 1);
        set_texel(displaced, Vec3f(1));
        Comparison comparison(displaced.cage, &displaced.textures);
        expect_oracle_near(comparison, displaced.cage, 0, "valence " + std::to_string(valence));
    }
}

class LimitOfShapes : public testing::TestWithParam<std::string> {};
TEST_P(LimitOfShapes, IsThatOfSubdivision)
{
    const Cage cage = load_cage(GetParam());
    // The oracle has the rules of Catmull and Clark alone, and none for borders. Large cages take seconds each.
    if (cage.scheme != Scheme::CatmullClark) GTEST_SKIP() << "the oracle has the rules of Catmull and Clark alone";
    if (!SubdivisionMesh(cage).is_closed_manifold()) GTEST_SKIP() << "the oracle has no rules for borders";
    if (cage.face_count() > 3000 && !is_long())
        GTEST_SKIP() << "it has more faces than are tested by default; OCCAM_LONG tests it";
    const bool is_large = cage.face_count() > (is_long() ? 2000u : 100u);
    expect_oracle(cage, "as it is", is_large ? 1 : 2);
    for (std::uint64_t seed = 1; !is_large && seed <= (is_long() ? 20u : 1u); ++seed)
        expect_oracle(creased(cage, seed), "creases of seed " + std::to_string(seed));
}
INSTANTIATE_TEST_SUITE_P(Closed, LimitOfShapes, testing::ValuesIn(closed_shapes()), shape_test_name);

}  // namespace
}  // namespace occam::test
