// Tests of the limit surface against uniform refinement, whose vertices are pushed to the limit by the rules of subdivision
// themselves.
#include <gtest/gtest.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <array>
#include <cmath>

#include "lod/patch_surface.h"
#include "lod/posed_patch.h"
#include "tests/support/campaign.h"
#include "tests/support/diced_mesh.h"
#include "tests/support/shape_builders.h"
#include "tests/support/shapes.h"

namespace occam::test {
namespace {

using namespace OpenSubdiv;

struct Point {
    Vec3d p{0};
    void Clear(void* = nullptr) { p = Vec3d(0); }
    void AddWithWeight(const Point& q, double w) { p += q.p * w; }
};

struct LimitVertex {
    Vec3d p{0}, normal{0};
    bool has_position = false;  ///< whether the masks are exact: there is no semi-sharp edge or vertex, and no dart
    bool has_normal = false;    ///< whether, besides, all faces share one normal
};

// Returns the limit of one vertex of a refined mesh, by applying the rules of subdivision to its ring of quads until it no
// longer moves. Unlike masks this works at valence 2 and at ends of creases, too. (OpenSubdiv 3.5's PrimvarRefiner::Limit is
// inexact at the latter, and writes past its buffers at non-manifold vertices.)
LimitVertex limit_vertex(const Far::TopologyLevel& level, int v, const std::vector<Point>& points, bool bilinear)
{
    LimitVertex out;
    const auto edges = level.GetVertexEdges(v);
    const auto faces = level.GetVertexFaces(v);
    std::vector<int> sharp_ends;
    bool semi = level.GetVertexSharpness(v) > 0 && level.GetVertexSharpness(v) < 10;
    for (const int e : edges) {
        const float s = level.GetEdgeSharpness(e);
        semi |= s > 0 && s < 10;
        const auto ends = level.GetEdgeVertices(e);
        if (s >= 10 || level.IsEdgeBoundary(e) || level.IsEdgeNonManifold(e))
            sharp_ends.push_back(ends[0] == v ? ends[1] : ends[0]);
    }
    out.p = points[v].p;
    out.has_position = !semi;
    if (semi || bilinear || level.GetVertexSharpness(v) >= 10 || sharp_ends.size() > 2) return out;
    if (sharp_ends.size() == 2) {
        out.p = (points[sharp_ends[0]].p + points[v].p * 4.0 + points[sharp_ends[1]].p) / 6.0;
        return out;
    }
    const int n = edges.size();
    const auto places = level.GetVertexFaceLocalIndices(v);
    std::vector<Vec3d> e(n), f(n);
    int sharp = -1;
    for (int i = 0; i < n; ++i) {
        const auto corners = level.GetFaceVertices(faces[i]);
        const int edge_end = corners[(places[i] + 1) % 4];
        e[i] = points[edge_end].p;
        f[i] = points[corners[(places[i] + 2) % 4]].p;
        if (!sharp_ends.empty() && edge_end == sharp_ends[0]) sharp = i;
    }
    const double turn = 2 * 3.14159265358979323846 / n;
    const double a = 1 + std::cos(turn) + std::cos(turn / 2) * std::sqrt(2 * (9 + std::cos(turn)));
    Vec3d t1(0), t2(0);
    for (int i = 0; i < n; ++i) {
        t1 += e[i] * (a * std::cos(turn * i)) + f[i] * (std::cos(turn * i) + std::cos(turn * (i + 1)));
        t2 += e[i] * (a * std::sin(turn * i)) + f[i] * (std::sin(turn * i) + std::sin(turn * (i + 1)));
    }
    // A fold has only one tangent and therefore no normal.
    out.normal = glm::cross(t1, t2);
    out.has_normal = n > 2 && sharp < 0 && glm::length(out.normal) > 1e-6 * std::max(glm::dot(t1, t1), glm::dot(t2, t2));
    for (int step = 0; step < 100; ++step) {
        Vec3d edge_sum(0), face_sum(0);
        std::vector<Vec3d> next_f(n), next_e(n);
        for (int i = 0; i < n; ++i) {
            next_f[i] = (out.p + e[i] + e[(i + 1) % n] + f[i]) / 4.0;
            face_sum += next_f[i];
            edge_sum += e[i];
        }
        for (int i = 0; i < n; ++i)
            next_e[i] = i == sharp ? (out.p + e[i]) / 2.0 : (out.p + e[i] + next_f[i] + next_f[(i + n - 1) % n]) / 4.0;
        out.p = out.p * (double(n - 2) / n) + (edge_sum + face_sum) / double(n * n);
        e = next_e;
        f = next_f;
    }
    return out;
}

/// A quad of the refined mesh, as a square of its base patch.
struct Square {
    lod::PatchRef patch;
    double u0, v0, size;
};

class Refinement {
public:
    Refinement(const Cage& cage, int levels) : mesh_(cage)
    {
        Far::TopologyRefiner& refiner = *mesh_.refiner;
        Far::TopologyRefiner::UniformOptions options(levels);
        options.fullTopologyInLastLevel = true;
        refiner.RefineUniform(options);
        Far::PrimvarRefinerReal<double> primvars(refiner);
        std::vector<Point> from(cage.positions.size());
        for (std::size_t v = 0; v < from.size(); ++v) from[v].p = Vec3d(cage.positions[v]);
        for (int l = 1; l <= levels; ++l) {
            std::vector<Point> to(refiner.GetLevel(l).GetNumVertices());
            primvars.Interpolate(l, from, to);
            from = std::move(to);
        }
        const Far::TopologyLevel& last = refiner.GetLevel(levels);
        for (int v = 0; v < last.GetNumVertices(); ++v)
            vertices.push_back(limit_vertex(last, v, from, cage.scheme == Scheme::Bilinear));
        // A quad's children keep its orientation: child i lies at corner i. An n-gon's child i begins at corner i.
        std::vector<Square> squares(refiner.GetLevel(0).GetNumFaces());
        for (int l = 0; l < levels; ++l) {
            const Far::TopologyLevel& level = refiner.GetLevel(l);
            std::vector<Square> next(refiner.GetLevel(l + 1).GetNumFaces());
            for (int f = 0; f < level.GetNumFaces(); ++f) {
                const auto children = level.GetFaceChildFaces(f);
                for (int c = 0; c < children.size(); ++c) {
                    if (children[c] < 0) continue;
                    Square s;
                    if (l == 0 && children.size() != 4) {
                        s = {{std::uint32_t(f), std::uint32_t(c)}, 0, 0, 1};
                    } else {
                        const Square parent = l == 0 ? Square{{std::uint32_t(f), 0}, 0, 0, 1} : squares[f];
                        const double half = parent.size / 2;
                        s = {parent.patch, parent.u0 + (c == 1 || c == 2 ? half : 0), parent.v0 + (c >= 2 ? half : 0), half};
                    }
                    next[children[c]] = s;
                }
            }
            squares = std::move(next);
        }
        for (int f = 0; f < last.GetNumFaces(); ++f) {
            const auto corners = last.GetFaceVertices(f);
            faces.push_back({squares[f], {corners[0], corners[1], corners[2], corners[3]}});
        }
    }

    struct Face {
        Square square;
        std::array<int, 4> vertices;
    };
    std::vector<LimitVertex> vertices;
    std::vector<Face> faces;

    const Far::TopologyLevel& base() const { return mesh_.refiner->GetLevel(0); }
    const Far::TopologyLevel& finest() const { return mesh_.refiner->GetLevel(mesh_.refiner->GetMaxLevel()); }

private:
    struct OwnMesh {
        explicit OwnMesh(const Cage& cage)
        {
            const std::vector<int> sizes(cage.face_sizes.begin(), cage.face_sizes.end());
            const std::vector<int> corners(cage.face_vertices.begin(), cage.face_vertices.end());
            std::vector<int> pairs, sharp, holes(cage.holes.begin(), cage.holes.end());
            std::vector<float> pair_weights, sharp_weights;
            for (const Crease& c : cage.creases) {
                pairs.push_back(int(c.v0));
                pairs.push_back(int(c.v1));
                pair_weights.push_back(c.sharpness);
            }
            for (const Corner& c : cage.corners) {
                sharp.push_back(int(c.vertex));
                sharp_weights.push_back(c.sharpness);
            }
            Far::TopologyDescriptor d;
            d.numVertices = int(cage.positions.size());
            d.numFaces = int(sizes.size());
            d.numVertsPerFace = sizes.data();
            d.vertIndicesPerFace = corners.data();
            d.numCreases = int(pair_weights.size());
            d.creaseVertexIndexPairs = pairs.data();
            d.creaseWeights = pair_weights.data();
            d.numCorners = int(sharp_weights.size());
            d.cornerVertexIndices = sharp.data();
            d.cornerWeights = sharp_weights.data();
            d.numHoles = int(holes.size());
            d.holeIndices = holes.data();
            Sdc::Options options;
            options.SetVtxBoundaryInterpolation(
                cage.boundary == BoundaryRule::EdgeAndCorner ? Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER
                : cage.boundary == BoundaryRule::EdgeOnly    ? Sdc::Options::VTX_BOUNDARY_EDGE_ONLY
                                                             : Sdc::Options::VTX_BOUNDARY_NONE);
            using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
            const Sdc::SchemeType scheme = cage.scheme == Scheme::Bilinear ? Sdc::SCHEME_BILINEAR : Sdc::SCHEME_CATMARK;
            refiner.reset(Factory::Create(d, Factory::Options(scheme, options)));
        }
        std::unique_ptr<Far::TopologyRefiner> refiner;
    };
    OwnMesh mesh_;
};

// Returns true for two faces that share several semi-sharp edges in a row, and so have a vertex of valence 2. Bfr 3.5 warns
// that it loses these creases.
bool is_lost_by_bfr(const Far::TopologyLevel& level, int face)
{
    for (const int v : level.GetFaceVertices(face)) {
        int semi = 0;
        for (const int e : level.GetVertexEdges(v)) semi += level.GetEdgeSharpness(e) > 0 && level.GetEdgeSharpness(e) < 10;
        if (level.GetVertexEdges(v).size() == 2 && level.GetVertexFaces(v).size() == 2 && semi == 2) return true;
    }
    return false;
}

/// Compares points and normals at the vertices of the refined cage.
void expect_limit(Cage cage, int levels = 4)
{
    DicedCage diced(cage, 0);
    cage = diced.posed.slot->cage;
    const Refinement refined(cage, cage.face_count() > 1000 ? 1 + is_long() : std::min(levels, is_long() ? 4 : 3));
    const double extent = 2 * cage.bounds().radius();

    lod::PosedPatch patch;
    lod::PatchRef at{~0u, 0};
    double worst_position = 0, worst_degrees = 0;
    int compared = 0;
    for (const Refinement::Face& face : refined.faces) {
        const std::uint32_t base = face.square.patch.face;
        if (!diced.topology().is_seen(base) || is_lost_by_bfr(refined.base(), int(base))) continue;
        if (!(face.square.patch == at)) patch.set(diced.posed, at = face.square.patch);
        const float u0 = float(face.square.u0), v0 = float(face.square.v0), size = float(face.square.size);
        float values[9][4];
        float* const out[9] = {values[0], values[1], values[2], values[3], values[4],
                               values[5], values[6], values[7], values[8]};
        patch.points_and_tangents({u0, v0, size, size, 2, 2}, out, 2);
        const auto vec = [&](int row, int k) { return Vec3d(values[row][k], values[row + 1][k], values[row + 2][k]); };
        const auto corner = [&](int c) { return refined.vertices[face.vertices[c & 3]]; };
        constexpr int kPlace[4] = {0, 1, 3, 2};
        for (int c = 0; c < 4; ++c) {
            const LimitVertex limit = corner(c);
            if (!limit.has_position) continue;
            ++compared;
            const int k = kPlace[c];
            worst_position = std::max(worst_position, glm::distance(vec(0, k) + diced.posed.anchor, limit.p) / extent);
            // The tangents of a bilinear patch are its own sides. Elsewhere the masks give tangents where all faces share a
            // plane.
            const bool flat = cage.scheme == Scheme::Bilinear;
            if (!flat && !limit.has_normal) continue;
            // At a large vertex the patches have the normals beside it (lod/ring_patch.h).
            if (refined.finest().GetVertexFaces(face.vertices[c]).size() >= 65) continue;
            const Vec3d expected = flat ? glm::cross(corner(c + 1).p - limit.p, corner(c + 3).p - limit.p) : limit.normal;
            const Vec3d n = glm::cross(vec(3, k), vec(6, k));
            const double scale = glm::length(expected) * glm::length(n);
            if (!(scale > 0)) continue;
            worst_degrees = std::max(worst_degrees,
                                     std::acos(std::clamp(glm::dot(n, expected) / scale, -1.0, 1.0)) * 57.29578);
        }
    }
    EXPECT_GT(compared, 0);
    EXPECT_LE(worst_position, 1e-6) << "of the cage's extent";
    // Tangents are floats, whose rounding turns a normal where the faces are narrow beside the cage.
    EXPECT_LE(worst_degrees, 0.02);
}

class SurfaceShapes : public testing::TestWithParam<std::string> {};

TEST_P(SurfaceShapes, AgreeWithRefinementAndLimitMasks) { expect_limit(load_cage(GetParam())); }

/// Returns a fan of triangles around vertex 0; it is a cone if it is closed, and else vertex 0 is at its border.
Cage fan(std::uint32_t faces, bool is_closed)
{
    Cage cage;
    cage.positions = {{0, 0.7f, 0}};
    const std::uint32_t ends = is_closed ? faces : faces + 1;
    for (std::uint32_t i = 0; i < ends; ++i) {
        const float angle = (is_closed ? 6.2831853f : 4.0f) * float(i) / float(faces);
        cage.positions.push_back({std::cos(angle), 0.1f * float(i % 3), -std::sin(angle)});
    }
    for (std::uint32_t i = 0; i < faces; ++i) {
        cage.face_vertices.insert(cage.face_vertices.end(), {0, 1 + i, 1 + (i + 1) % ends});
        cage.face_sizes.push_back(3);
    }
    return cage;
}

TEST(LargeFacesAndVertices, AgreeWithRefinementAndLimitMasks)
{
    expect_limit(prism(70), 3);
    expect_limit(spindle(72), 3);
    expect_limit(fan(66, true), 3);
    expect_limit(fan(66, false), 3);
    Cage bilinear = prism(70);
    bilinear.scheme = Scheme::Bilinear;
    expect_limit(bilinear, 3);
    // A pyramid over a polygon: patches between a large vertex and a large face.
    Cage pyramid = fan(66, true);
    for (std::uint32_t i = 66; i > 0; --i) pyramid.face_vertices.push_back(i);
    pyramid.face_sizes.push_back(66);
    expect_limit(pyramid, 3);
    // Creases through the large vertex, sharp and not, and some that touch only its neighbours.
    Cage creased = spindle(70);
    creased.creases = {{0, 2, 10}, {0, 30, 10}, {3, 4, 10}, {4, 5, 1.5f}, {1, 40, 10}, {1, 9, 10}, {1, 20, 10}};
    expect_limit(creased, 3);
    creased.creases = {{0, 2, 1.75f}, {0, 5, 0.5f}, {0, 30, 3}, {1, 40, 10}, {1, 41, 10}};
    creased.corners = {{0, 1.5f}};
    expect_limit(creased, 3);
}

// Where texture coordinates have no seam, they have the same limit as positions, so st = (x, y) at each vertex stays (x, y)
// everywhere.
TEST(TextureCoordinates, FollowTheSurfaceWhereTheyHaveNoSeam)
{
    for (Cage cage : {torus(), prism(5), prism(4)}) {
        UvSet set;
        for (const Vec3f p : cage.positions) set.values.push_back(Vec2f(p));
        cage.uv_sets = {set};
        DicedCage diced(cage, 0);
        lod::PosedPatch surface, uv;
        for (std::uint32_t face = 0; face < diced.topology().face_count(); ++face)
            for (std::uint32_t sub = 0; sub < diced.topology().patches_of(face); ++sub) {
                surface.set(diced.posed, {face, sub});
                uv.set_uv(diced.posed, {face, sub}, 0);
                for (const Vec2f at : {Vec2f(0, 0), Vec2f(0.25f, 0.75f), Vec2f(0.5f, 0.5f), Vec2f(1, 0.5f), Vec2f(1, 1)}) {
                    const Vec3d p = Vec3d(surface.point(at.x, at.y)) + diced.posed.anchor;
                    const Vec3f st = uv.point(at.x, at.y);
                    EXPECT_NEAR(st.x, p.x, 2e-6) << "face " << face;
                    EXPECT_NEAR(st.y, p.y, 2e-6) << "face " << face;
                }
            }
    }
}

// The middle quad of nine on a torus touches all others. Its coordinates have a seam on the far side, and a crease ends at
// one of its corners.
TEST(TextureCoordinates, AreContinuousAtTheEndOfACreaseOppositeASeam)
{
    Cage cage;
    UvSet set;
    const auto vertex = [](std::uint32_t i, std::uint32_t j) { return i % 3 * 3 + j % 3; };
    for (std::uint32_t i = 0; i < 3; ++i)
        for (std::uint32_t j = 0; j < 3; ++j) {
            const float a = 2.1f * float(i), b = 2.1f * float(j), radius = 2 + std::cos(b);
            cage.positions.push_back({radius * std::cos(a), radius * std::sin(a), std::sin(b)});
        }
    for (std::uint32_t i = 0; i < 4; ++i)
        for (std::uint32_t j = 0; j < 4; ++j) set.values.push_back(Vec2f(float(i), float(j)));
    for (std::uint32_t i = 0; i < 3; ++i)
        for (std::uint32_t j = 0; j < 3; ++j) {
            cage.face_sizes.push_back(4);
            for (const auto& [x, y] : {std::pair(i, j), std::pair(i + 1, j), std::pair(i + 1, j + 1), std::pair(i, j + 1)}) {
                cage.face_vertices.push_back(vertex(x, y));
                set.indices.push_back(x * 4 + y);
            }
        }
    cage.creases = {{vertex(2, 1), vertex(2, 2), kInfiniteSharpness}};
    cage.uv_sets = {set};
    DicedCage diced(cage, 0);
    lod::PosedPatch uv;
    constexpr std::uint32_t kMiddle = 4;
    uv.set_uv(diced.posed, {kMiddle, 0}, 0);
    for (const Vec2f corner : {Vec2f(0, 0), Vec2f(1, 0), Vec2f(1, 1), Vec2f(0, 1)}) {
        const Vec2f beside = corner + (Vec2f(0.5f) - corner) * 0.01f;
        EXPECT_LT(glm::distance(uv.point(corner.x, corner.y), uv.point(beside.x, beside.y)), 0.05f)
            << corner.x << ", " << corner.y;
    }
}

INSTANTIATE_TEST_SUITE_P(Shapes, SurfaceShapes, testing::ValuesIn(subdivision_shapes()), shape_test_name);

// The squares of the products of tangents so short are no normal numbers in single precision.
TEST(LimitSurface, NormalsDoNotDependOnTheSizeOfTheCage)
{
    const Cage cage = torus();
    lod::PatchSurface surface;
    const lod::ParameterGrid grid{0.125f, 0.25f, 0.25f, 0.25f, 3, 3};
    const auto normals = [&](double scale) {
        Mat4d place(scale);
        place[3][3] = 1;
        const DicedCage diced(cage, 0, place);
        std::vector<Vec3f> all;
        for (std::uint32_t face = 0; face < cage.face_sizes.size(); face += 7) {
            Vec3f found[9];
            surface.forget();
            surface.normals({diced.posed, {face, 0}, 0}, grid, found);
            all.insert(all.end(), found, found + 9);
        }
        return all;
    };
    const std::vector<Vec3f> wanted = normals(1);
    for (const int exponent : {-20, -30, -40, -50, -60}) {
        const std::vector<Vec3f> found = normals(std::exp2(exponent));
        for (std::size_t k = 0; k < wanted.size(); ++k) {
            EXPECT_NEAR(glm::length(wanted[k]), 1, 1e-6);
            EXPECT_LE(glm::distance(found[k], wanted[k]), 1e-6f) << "2^" << exponent << ", normal " << k;
        }
    }
}

}  // namespace
}  // namespace occam::test
