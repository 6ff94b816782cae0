// Tests of the vertex colours of cages: bilinear over faces and quadrants at any level, and read from files.
#include <gtest/gtest.h>

#include "accel/frame.h"
#include "accel/tracer.h"
#include "tests/support/gltf_scene.h"
#include "tests/support/import_errors.h"
#include "tests/support/shape_builders.h"
#include "tests/support/temp_folder.h"

namespace occam::test {
namespace {

/// Looks at a cage from straight above, by rays with beams of a given width.
class Above {
public:
    explicit Above(Cage cage)
    {
        cage.scheme = Scheme::Bilinear;
        place(scene_, scene_.add(std::move(cage)), {0, 0, 0});
        scene_.refit();
        frame_ = std::make_unique<accel::Frame>(scene_, topologies_, lod::LevelSettings{.pixel = {0.01f, 0}});
        tracer_ = std::make_unique<accel::Tracer>(*frame_, std::size_t(1) << 28);
    }
    Vec4f color(double x, double z, float width = 0.01f)
    {
        accel::Ray ray;
        ray.origin = {x, 10, z};
        ray.direction = {0, -1, 0};
        ray.footprint = {width, 0};
        accel::SurfaceHit hit;
        tracer_->closest({&ray, 1}, {&hit, 1});
        EXPECT_TRUE(hit.is_hit());
        return hit.color;
    }

private:
    Scene scene_;
    lod::TopologyCache topologies_;
    std::unique_ptr<accel::Frame> frame_;
    std::unique_ptr<accel::Tracer> tracer_;
};

void expect_near(Vec4f found, Vec4f expected, float tolerance, const std::string& where)
{
    EXPECT_LT(glm::distance(found, expected), tolerance) << where;
}

/// Returns two unit quads side by side in x that share an edge.
Cage two_quads()
{
    Cage cage;
    cage.positions = {{0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 0, 0}, {2, 0, 1}, {2, 0, 0}};
    cage.face_sizes = {4, 4};
    cage.face_vertices = {0, 1, 2, 3, 3, 2, 4, 5};
    return cage;
}

TEST(VertexColors, AreBilinearOverAQuadAtEveryLevel)
{
    Cage cage = two_quads();
    cage.colors = {{0, 0, 0, 1}, {0.2f, 0.8f, 0, 1}, {0.7f, 0.9f, 0.4f, 0.5f}, {0.5f, 0, 1, 1}, {1, 1, 1, 1}, {0, 1, 0, 1}};
    Above above(cage);
    const auto expected = [&](double x, double z) {
        const Vec4f* c = cage.colors.data();
        const int first = x < 1 ? 0 : 2;
        const Vec4f low = x < 1 ? glm::mix(c[0], c[1], float(z)) : glm::mix(c[3], c[2], float(z));
        const Vec4f high = first == 0 ? glm::mix(c[3], c[2], float(z)) : glm::mix(c[5], c[4], float(z));
        return glm::mix(low, high, float(x < 1 ? x : x - 1));
    };
    for (int k = 0; k < 40; ++k) {
        const double x = 0.013 + 0.0491 * k, z = 0.987 - 0.0237 * k;
        const std::string where = std::to_string(x) + ' ' + std::to_string(z);
        // The rays hit the inside of micropolygons. Nothing pops: two triangles differ from the bilinear quad by a quarter
        // of its twist, 0.52. The surface goes from one to the other while the width doubles, by a smoothstep, whose
        // steepest slope is 1.5. So the bound is 0.52 * 1.5 * log2(1.03) = 0.033.
        for (const float width : {0.005f, 0.01f, 0.02f, 0.04f})
            expect_near(above.color(x, z, width), expected(x, z), 2 * width, where);
        Vec4f before = above.color(x, z, 0.01f);
        for (float width = 0.01f; width < 2; width *= 1.03f) {
            const Vec4f now = above.color(x, z, width);
            expect_near(now, before, 0.033f, where);
            before = now;
        }
    }
}

TEST(VertexColors, OfAnNGonMeetInItsMiddleAtTheirMean)
{
    Cage cage;
    const int kCorners = 5;
    Vec4f sum(0);
    Vec2d middle(0);
    for (int k = 0; k < kCorners; ++k) {
        const double angle = -6.283185307 * k / kCorners;
        cage.positions.push_back({float(std::cos(angle)), 0, float(std::sin(angle))});
        cage.face_vertices.push_back(std::uint32_t(k));
        cage.colors.push_back({float(k) / kCorners, k == 2 ? 1 : 0, k % 2 ? 0.3f : 0.6f, 1});
        sum += cage.colors.back() / float(kCorners);
        middle += Vec2d(cage.positions.back().x, cage.positions.back().z) / double(kCorners);
    }
    cage.face_sizes = {kCorners};
    Above above(cage);
    expect_near(above.color(middle.x, middle.y), sum, 0.02f, "middle");
    for (std::size_t k = 0; k < kCorners; ++k) {
        const Vec3f a = cage.positions[k], b = cage.positions[(k + 1) % kCorners];
        const auto inside = [&](Vec3f p) { return above.color(double(p.x) * 0.995, double(p.z) * 0.995); };
        expect_near(inside(a), cage.colors[k], 0.03f, "corner " + std::to_string(k));
        expect_near(inside((a + b) * 0.5f), (cage.colors[k] + cage.colors[(k + 1) % kCorners]) * 0.5f, 0.03f,
                    "edge " + std::to_string(k));
    }
}

TEST(VertexColors, MayDifferOnBothSidesOfAnEdge)
{
    Cage cage = two_quads();
    cage.colors = {{1, 0, 0, 1}, {0, 0, 1, 1}};
    cage.color_indices = {0, 0, 0, 0, 1, 1, 1, 1};
    Above above(cage);
    EXPECT_EQ(above.color(0.99, 0.4), Vec4f(1, 0, 0, 1));
    EXPECT_EQ(above.color(1.01, 0.4), Vec4f(0, 0, 1, 1));
}

TEST(VertexColors, WithoutAColourForEveryCornerAreRefusedOrMended)
{
    Cage cage = two_quads();
    cage.colors = {{1, 0, 0, 1}};
    EXPECT_THROW(sanitize(cage), Error);
    cage.color_indices = {0, 0, 0};
    EXPECT_THROW(sanitize(cage), Error);
    cage.color_indices = {0, 0, 0, 0, 7, 0, 0, 0xffffffff};
    sanitize(cage);
    EXPECT_EQ(cage.color_indices, std::vector<std::uint32_t>(8, 0));
    cage.colors.clear();
    sanitize(cage);
    EXPECT_EQ(cage.colors, std::vector<Vec4f>{Vec4f(1)});
    // A face that is dropped takes its colours with it.
    cage.colors = {{1, 0, 0, 1}, {0, 0, 1, 1}};
    cage.color_indices = {0, 0, 0, 0, 1, 1, 1, 1};
    cage.face_vertices[0] = 99;
    sanitize(cage);
    EXPECT_EQ(cage.color_indices, std::vector<std::uint32_t>(4, 1));
}

// Vertices in one place are joined, and each face keeps the colours that it had there.
TEST(VertexColors, OfGltfSurviveWelding)
{
    const TempFolder folder;
    Gltf g;
    g.put<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 1, 0, 0, 2, 0, 0, 2, 1, 0, 1, 1, 0});
    g.put<std::uint16_t>({0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7});
    g.put<float>({1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1});
    g.accessor(
        R"({"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [0, 0, 0], "max": [2, 1, 0]})");
    g.accessor(R"({"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"})");
    g.accessor(R"({"bufferView": 2, "componentType": 5126, "count": 8, "type": "VEC3"})");
    g.meshes = R"({"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 2}, "indices": 1}]})";
    g.nodes = R"({"mesh": 0})";
    const Scene scene = load(g.write(folder), {.subdivide = Subdivide::On});
    const Cage& cage = *cages(scene).at(0);
    ASSERT_EQ(cage.positions.size(), 6u);
    ASSERT_EQ(cage.color_indices.size(), 12u);
    for (std::size_t corner = 0; corner < 12; ++corner)
        EXPECT_EQ(cage.colors[cage.color_indices[corner]], corner < 6 ? Vec4f(1, 0, 0, 1) : Vec4f(0, 0, 1, 1));
}

TEST(VertexColors, OfObjStandAfterThePlaceAndAreSrgb)
{
    const TempFolder folder;
    const std::string quad = "v 0 0 0 0.5 0 1\nv 1 0 0 1 1 1\nv 1 1 0\nv 0 1 0 2 0 -1\nf 1 2 3 4\n";
    for (const Subdivide subdivide : {Subdivide::On, Subdivide::Off}) {
        const Scene scene = load(folder.write("q.obj", quad), {.subdivide = subdivide});
        const Cage& cage = *cages(scene).at(0);
        ASSERT_EQ(cage.colors.size(), 4u);
        EXPECT_NEAR(cage.colors[0].x, 0.21404f, 1e-4f);
        EXPECT_EQ(Vec3f(cage.colors[0]).z, 1);
        EXPECT_EQ(cage.colors[2], Vec4f(1)) << "says nothing";
        EXPECT_EQ(cage.colors[3], Vec4f(1, 0, 0, 1));
        EXPECT_TRUE(warns(scene, "not between 0 and 1"));
    }
    const Scene late = load(folder.write("l.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0 1 0 0\nv 0 2 0\nf 1 2 3 4 5\n"));
    EXPECT_EQ(test::only_cage(late).colors, (std::vector<Vec4f>{Vec4f(1), Vec4f(1), Vec4f(1), {1, 0, 0, 1}, Vec4f(1)}))
        << "vertices before the first that has a colour are white";
    const Scene plain = load(folder.write("w.obj", "v 0 0 0 1\nv 1 0 0 1\nv 1 1 0 1\nv 0 1 0 1 0.1 0.2 0.3\nf 1 2 3 4\n"));
    EXPECT_TRUE(cages(plain).at(0)->colors.empty())
        << "a fourth number is a weight, and where one comes first there are no colours";
}

}  // namespace
}  // namespace occam::test
