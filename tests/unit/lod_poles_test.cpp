// Tests of how long edges become beside poles, on which a ray's margins rely (watertightness rule 11).
#include <gtest/gtest.h>
#include <occam/occam.h>

#include <cmath>
#include <random>

#include "lod/longest_edges.h"
#include "lod/owned_curves.h"
#include "lod/patch_sizes.h"
#include "lod/ray_levels.h"
#include "scenegraph/poles.h"
#include "tests/support/diced_mesh.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

/// Measures the longest edge of the quads in the four corners of every patch of a cage at a level.
class CornerEdges {
public:
    explicit CornerEdges(const Cage& cage)
        : diced_(cage, 0), bound_(diced_.scene().contents().poles), curves_(surface_), sizes_(surface_, curves_)
    {
    }
    /// Finer levels are the same.
    int finest() const { return diced_.posed.finest_level(); }
    double over_bound(int level) { return longest(level) / double(bound_.at(level)); }
    double over_edge(int level) { return longest(level) / std::ldexp(1.0, level); }

private:
    double longest(int level)
    {
        double longest = 0;
        const lod::Topology& topology = diced_.topology();
        for (std::uint32_t face = 0; face < topology.face_count(); ++face)
            for (std::uint32_t sub = 0; sub < topology.patches_of(face); ++sub)
                for (const bool far_u : {false, true})
                    for (const bool far_v : {false, true})
                        longest = std::max(longest, longest_in_corner({face, sub}, level, far_u, far_v));
        return longest;
    }
    double longest_in_corner(lod::PatchRef patch, int level, bool far_u, bool far_v)
    {
        const lod::PatchRates rates = sizes_.scale(diced_.posed, patch).rates(level);
        const float du = std::ldexp(1.0f, -rates.u), dv = std::ldexp(1.0f, -rates.v);
        const float u = far_u ? 1 - du : 0, v = far_v ? 1 - dv : 0;
        const auto at = [&](float a, float b) { return surface_.point(diced_.posed, {patch, a, b}, lod::kFinestLevel - 1); };
        const Vec3f p00 = at(u, v), p10 = at(u + du, v), p01 = at(u, v + dv), p11 = at(u + du, v + dv);
        return double(std::max(std::max(glm::distance(p00, p10), glm::distance(p01, p11)),
                               std::max(glm::distance(p00, p01), glm::distance(p10, p11))));
    }

    DicedCage diced_;
    lod::LongestEdges bound_;
    lod::PatchSurface surface_;
    lod::OwnedCurves curves_;
    lod::PatchSizes sizes_;
};

using Random = std::mt19937;
double uniform(Random& random) { return std::uniform_real_distribution<double>(0, 1)(random); }
std::uint32_t below(Random& random, std::uint32_t end)
{
    return std::uniform_int_distribution<std::uint32_t>(0, end - 1)(random);
}
float random_sharpness(Random& random)
{
    const bool is_infinite = below(random, 2) > 0;
    return is_infinite ? kInfiniteSharpness : 0.25f * float(below(random, 40));
}

/// Returns a sheet of 4 x 4 quads, some of which are two triangles and some of which may be missing, with creases and
/// corners anywhere.
Cage random_sheet(Random& random, bool has_gaps)
{
    constexpr std::uint32_t n = 5;
    Cage cage;
    const double width = std::exp(2 * uniform(random) - 1);
    for (std::uint32_t y = 0; y < n; ++y)
        for (std::uint32_t x = 0; x < n; ++x) {
            const double across = width * (x + 0.6 * uniform(random) - 0.3), up = 0.7 * uniform(random);
            cage.positions.emplace_back(across, up, y + 0.6 * uniform(random) - 0.3);
        }
    for (std::uint32_t y = 0; y + 1 < n; ++y)
        for (std::uint32_t x = 0; x + 1 < n; ++x) {
            const std::uint32_t a = y * n + x, b = a + n, c = b + 1, d = a + 1;
            if (has_gaps && below(random, 4) == 0) continue;
            const bool is_split = below(random, 6) == 0;
            if (is_split) cage.face_vertices.insert(cage.face_vertices.end(), {a, b, c, a, c, d});
            else cage.face_vertices.insert(cage.face_vertices.end(), {a, b, c, d});
            cage.face_sizes.insert(cage.face_sizes.end(), is_split ? 2 : 1, is_split ? 3 : 4);
        }
    for (std::uint32_t i = below(random, 12); i > 0; --i) {
        const std::uint32_t a = below(random, n - 1) * n + below(random, n - 1), along = below(random, 2) > 0 ? 1 : n;
        cage.creases.push_back({a, a + along, random_sharpness(random)});
    }
    for (std::uint32_t i = below(random, 3); i > 0; --i) {
        const std::uint32_t vertex = below(random, n * n);
        cage.corners.push_back({vertex, random_sharpness(random)});
    }
    return cage;
}

/// Returns kites around a pole, with up to two creases at it; with as many below, or open there.
Cage random_kites(Random& random)
{
    const std::uint32_t n = 3 + below(random, 12);
    const double height = std::exp(3 * uniform(random) - 1.5), outer = 0.3 + 1.2 * uniform(random);
    const double uneven = below(random, 2) > 0 ? 0.8 * uniform(random) : 0;
    Cage cage;
    for (const double side : {1.0, -1.0}) cage.positions.emplace_back(0, side * height * (0.2 + uniform(random)), 0);
    for (std::uint32_t i = 0; i < 2 * n; ++i) {
        const double turn = (i < n ? i : i - n + 0.5) + uneven * (2 * uniform(random) - 1) / 3;
        const double radius = (i < n ? 1 : outer) * (1 + uneven * (uniform(random) - 0.5)), angle = 6.2831853 * turn / n;
        cage.positions.emplace_back(radius * std::cos(angle), (i < n ? 0.1 : -0.1) * height, radius * std::sin(angle));
    }
    const bool is_open = below(random, 2) > 0;
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t next = (i + 1) % n, a = 2 + i, b = 2 + next, low = 2 + n + i, low_next = 2 + n + next;
        cage.face_vertices.insert(cage.face_vertices.end(), {0, b, low, a});
        if (!is_open) cage.face_vertices.insert(cage.face_vertices.end(), {1, low, b, low_next});
        cage.face_sizes.insert(cage.face_sizes.end(), is_open ? 1 : 2, 4);
    }
    for (std::uint32_t i = below(random, 3); i > 0; --i) {
        const std::uint32_t end = 2 + below(random, n);
        cage.creases.push_back({0, end, random_sharpness(random)});
    }
    return cage;
}

TEST(Poles, MakeNoEdgeLongerThanTheBoundSays)
{
    Random random(1);
    for (int trial = 0; trial < 160; ++trial) {
        Cage cage = trial % 2 > 0 ? random_kites(random) : random_sheet(random, trial % 4 > 0);
        if (cage.face_sizes.empty()) continue;
        CornerEdges edges(cage);
        // Speeds are measured, and not bounded, in the last squares beside a pole: hence the hundredth.
        for (const int level : {-1, -3, -5, -8, -12, -15})
            EXPECT_LE(edges.over_bound(std::max(level, edges.finest())), 1.01) << "trial " << trial << ", level " << level;
    }
}

// Without poles the bound is d_l, and with them the edges do need more: the bound is not much too long.
TEST(Poles, MakeEdgesThatAreLongerThanTheirLevelSays)
{
    for (const std::uint32_t faces : {6u, 16u, 400u}) {
        CornerEdges edges(spindle(faces));
        EXPECT_GT(edges.over_edge(edges.finest()), faces > 6 ? 3 : 1.5) << faces;
        EXPECT_GT(edges.over_bound(edges.finest()), 0.4) << faces;
        EXPECT_GT(edges.over_edge(-15), faces > 6 ? 16 : 4) << "if there were such a level: " << faces;
    }
}

Poles poles_of(Cage cage)
{
    sanitize(cage);
    return PoleFaces(cage).measure(cage, cage.positions);
}

TEST(Poles, AreFoundByHowManyFacesMeet)
{
    EXPECT_EQ(poles_of(creased_cube(0)), Poles()) << "three faces meet at each vertex";
    EXPECT_EQ(poles_of(creased_cube(4)), Poles());
    for (const std::uint32_t faces : {5u, 6u, 7u, 8u, 9u}) {
        const Poles poles = poles_of(spindle(faces));
        for (std::size_t c = 0; c < poles.longest.size(); ++c) {
            const std::uint32_t least = c > 0 ? Poles::kMostFaces[c - 1] + 1 : 5;
            // The belt of a spindle has vertices of four faces.
            if (faces >= least && faces <= Poles::kMostFaces[c]) EXPECT_NEAR(poles.longest[c], std::hypot(1.5, 1.0), 0.1);
            else EXPECT_EQ(poles.longest[c], 0) << faces;
        }
    }
}

/// Returns a flat sheet of 4 x 4 unit quads.
Cage sheet()
{
    Cage cage;
    for (int i = 0; i < 25; ++i) cage.positions.emplace_back(i % 5, 0, i / 5);
    for (std::uint32_t i = 0; i < 16; ++i) {
        const std::uint32_t a = i / 4 * 5 + i % 4;
        cage.face_vertices.insert(cage.face_vertices.end(), {a, a + 5, a + 6, a + 1});
        cage.face_sizes.push_back(4);
    }
    return cage;
}

// The middle vertex of the sheet is 12, and its neighbours are 7, 11, 13 and 17.
TEST(Poles, AreFoundBetweenCreasesAndBorders)
{
    EXPECT_EQ(poles_of(sheet()), Poles()) << "borders and corners of a regular sheet are no poles";
    Cage line = sheet();
    line.creases = {{10, 11, 10}, {11, 12, 10}, {12, 13, 10}, {13, 14, 10}};
    EXPECT_EQ(poles_of(line), Poles()) << "a crease along a row leaves two faces on either side, and one at its ends";
    Cage bent = sheet();
    bent.creases = {{2, 7, 10}, {7, 12, 10}, {12, 13, 10}, {13, 14, 10}};
    EXPECT_EQ(poles_of(bent).longest, (std::array<double, 4>{0, 1, 0, 0})) << "three faces lie outside of the bend";
    Cage tip = sheet();
    tip.corners = {{12, 10}};
    EXPECT_EQ(poles_of(tip).longest, (std::array<double, 4>{0, 0, 0, 1})) << "a tip shrinks like a cone";
    Cage notched = sheet();
    notched.holes.clear();
    notched.face_vertices.erase(notched.face_vertices.begin(), notched.face_vertices.begin() + 4);
    notched.face_sizes.pop_back();
    EXPECT_EQ(poles_of(notched).longest, (std::array<double, 4>{0, 1, 0, 0})) << "three faces at the border of a notch";
}

TEST(Poles, CountWhereAndHoweverTheyArePlaced)
{
    Scene scene;
    const CageId cage = scene.add(spindle(12));
    const double edge = poles_of(spindle(12)).longest[3];
    NodeDesc desc;
    desc.cages = {cage};
    desc.place.scale = Vec3d(1, 3, 2);
    const NodeId outer = scene.add_node(scene.root(), desc);
    desc.place.scale = Vec3d(5);
    const NodeId inner = scene.add_node(outer, desc);
    scene.refit();
    EXPECT_NEAR(scene.contents().poles.longest[3], 15 * edge, 1e-5 * edge);
    scene.set_visible(inner, false);
    scene.refit();
    EXPECT_NEAR(scene.contents().poles.longest[3], 3 * edge, 1e-5 * edge);
    std::vector<Vec3f> twice = spindle(12).positions;
    for (Vec3f& p : twice) p *= 2.0f;
    scene.write_vertices(cage, twice);
    scene.refit();
    EXPECT_NEAR(scene.contents().poles.longest[3], 6 * edge, 1e-5 * edge);
}

/// Deforms a cage by up to two morph targets and, or, four joints; returns the joints' maps.
std::vector<Mat4d> deform(Cage& cage, Random& random)
{
    const auto vector = [&](double size) {
        const double x = uniform(random), y = uniform(random), z = uniform(random);
        return size * (2.0 * Vec3d(x, y, z) - 1.0);
    };
    for (std::uint32_t t = below(random, 3); t > 0; --t) {
        MorphTarget target;
        for (std::size_t v = 0; v < cage.positions.size(); ++v) target.positions.emplace_back(vector(0.3));
        cage.morph_targets.push_back(target);
        cage.morph_weights.push_back(static_cast<float>(3 * uniform(random) - 1));
    }
    std::vector<Mat4d> joints;
    if (below(random, 4) == 0) return joints;
    for (int j = 0; j < 4; ++j) {
        const Vec3d scale = 1.0 + vector(0.8), axis = glm::normalize(vector(1)), translation = vector(1);
        const double half = 1.5 * uniform(random);
        joints.push_back(Trs{translation, Vec4d(axis * std::sin(half), std::cos(half)), scale}.matrix());
    }
    cage.skin.sets = 1;
    for (std::size_t v = 0; v < cage.positions.size(); ++v) {
        const std::uint32_t joint = below(random, 4), other = below(random, 4);
        const float share = below(random, 2) > 0 ? 1.0f : static_cast<float>(uniform(random));
        cage.skin.joints.emplace_back(joint, other, 0, 0);
        cage.skin.weights.emplace_back(share, 1 - share, 0, 0);
    }
    return joints;
}

TEST(Poles, OfDeformedCagesAreNoLongerThanTheBoundSays)
{
    Random random(2);
    double tightest = 0;
    for (int trial = 0; trial < 200; ++trial) {
        Cage cage = trial % 2 > 0 ? random_kites(random) : spindle(5 + below(random, 9));
        const std::vector<Mat4d> joints = deform(cage, random);
        sanitize(cage);
        const DicedCage diced(cage, 0, Mat4d(1), nullptr, joints);
        std::vector<Vec3f> posed;
        for (std::uint32_t v = 0; v < cage.positions.size(); ++v) posed.push_back(diced.posed.vertex(v));
        const Poles edges = PoleFaces(cage).measure(cage, posed), bound = diced.scene().contents().poles;
        for (std::size_t c = 0; c < edges.longest.size(); ++c) {
            EXPECT_LE(edges.longest[c], bound.longest[c] * 1.0001) << trial;
            tightest = std::max(tightest, edges.longest[c] / std::max(bound.longest[c], 1e-30));
        }
    }
    EXPECT_GT(tightest, 0.9) << "the bound is not much too long";
}

TEST(Poles, CountAtEachKeyOfWrittenVertices)
{
    const std::vector<Vec3f> full = spindle(12).positions;
    Scene scene;
    const CageId cage = scene.add(spindle(12));
    scene.add_node(scene.root(), {.cages = {cage}});
    scene.record_shutter(2, [&](double time) {
        std::vector<Vec3f> positions = full;
        for (Vec3f& p : positions) p *= time == 0.5 ? 1e-3f : 1.0f;
        scene.write_vertices(cage, positions);
    });
    scene.refit();
    EXPECT_NEAR(scene.contents().poles.longest[3], poles_of(spindle(12)).longest[3], 1e-5);
}

// The edges at the tip of a rod that is drawn out along its axis lie across that axis.
TEST(Poles, DoNotMakeStretchedCagesCoarse)
{
    Cage rod = spindle(8);
    for (Vec3f& p : rod.positions) p.y *= 1e-4f;
    const Mat4d stretched = Trs{.scale = {1, 1e4, 1}}.matrix();
    Cage baked = rod;
    for (Vec3f& p : baked.positions) p.y *= 1e4f;
    EXPECT_LE(DicedCage(rod, 0, stretched).posed.finest_level(), DicedCage(baked, 0).posed.finest_level() + 1);
}

// The camera flies along with the cage, so the picture is as sharp as that of one that stands still.
TEST(Poles, DoNotMakeCagesThatFlyFarCoarse)
{
    const auto micropolygons = [](double path) {
        Scene scene;
        const NodeId node = scene.add_node(scene.root(), {.cages = {scene.add(spindle(8))}});
        scene.environment.radiance = Vec3f(1);
        Vec3d at(0);
        const auto pose = [&](double time) {
            at = {path * (time - 0.5), 0, 0};
            scene.set_transform(node, Trs{.translation = at});
        };
        const auto camera = [&] { return Camera::look_at(at + Vec3d(1, 1.4, 3.4), at, {0, 1, 0}, 0.9f); };
        const Camera seen = record_shutter(scene, pose, camera, 48);
        Renderer renderer({.threads = 1});
        Job job = renderer.start(scene, seen, {.width = 64, .height = 48, .spp = 4, .integrator = IntegratorKind::Direct});
        job.image();
        return job.stats().built.micropolygons;
    };
    EXPECT_GT(micropolygons(3000), micropolygons(0) * 9 / 10);
}

TEST(RayLevels, KeepMarginsAsLongAsTheLongestEdges)
{
    lod::LevelSettings settings;
    Poles poles;
    poles.add(Poles::class_of(16), 1.8);
    settings.edges = lod::LongestEdges(poles);
    lod::RayLevels<float> table;
    ASSERT_TRUE(table.set({1e-4f, 0.01f}, 0.0f, 1.0f, 1.0f, settings));
    table.make();
    for (int pair = table.finest; pair <= table.coarsest; ++pair) {
        EXPECT_GE(table.margin(pair), 2 * settings.edges.at(pair));
        EXPECT_GE(settings.edges.at(pair), lod::edge_length(pair));
    }
    EXPECT_GT(settings.edges.at(-12), 4 * lod::edge_length(-12));
    EXPECT_EQ(settings.edges.at(0), 1) << "a face of one edge";
}

}  // namespace
}  // namespace occam::test
