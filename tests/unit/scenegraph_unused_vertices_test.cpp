// Tests that vertices which no face has change nothing.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include <cmath>

#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

Cage with_stray_vertex(Cage cage)
{
    cage.positions.insert(cage.positions.begin() + 1, Vec3f(1e6f, 0, 0));
    for (std::uint32_t& v : cage.face_vertices) v += v >= 1;
    for (Crease& crease : cage.creases) {
        crease.v0 += crease.v0 >= 1;
        crease.v1 += crease.v1 >= 1;
    }
    cage.positions.emplace_back(0.0f, -1e9f, 0.0f);
    return cage;
}

std::uint64_t picture_of(Scene& scene)
{
    scene.refit();
    Renderer renderer({.threads = 1});
    const Camera camera = Camera::look_at({1, 2, 6}, {0, 0, 0}, {0, 1, 0}, 0.7f);
    return renderer.render(scene, camera, {.width = 48, .height = 36, .spp = 2}).checksum();
}

TEST(UnusedVertices, ChangeNeitherBoundsNorPictures)
{
    for (const bool is_smooth : {false, true}) {
        std::uint64_t pictures[2];
        Box3d bounds[2];
        for (const bool stray : {false, true}) {
            Scene scene;
            const Cage cube = creased_cube(is_smooth ? 0.0f : 2.5f);
            place(scene, scene.add(stray ? with_stray_vertex(cube) : cube), {0, 0, 0});
            pictures[stray] = picture_of(scene);
            bounds[stray] = scene.bounds();
        }
        EXPECT_EQ(pictures[1], pictures[0]);
        EXPECT_EQ(bounds[1].lo, bounds[0].lo);
        EXPECT_EQ(bounds[1].hi, bounds[0].hi);
    }
}

TEST(UnusedVertices, OfWrittenAndMorphedCagesChangeNoBounds)
{
    for (const bool is_morph : {false, true}) {
        Box3d bounds[2];
        for (const bool stray : {false, true}) {
            Scene scene;
            Cage cage = stray ? with_stray_vertex(creased_cube(1)) : creased_cube(1);
            if (is_morph) {
                MorphTarget target;
                target.positions.assign(cage.positions.size(), Vec3f(0, 0.5f, 0));
                cage.morph_targets.push_back(target);
            }
            const std::vector<Vec3f> rest = cage.positions;
            const CageId id = scene.add(std::move(cage));
            NodeDesc node{.cages = {id}};
            if (is_morph) node.morph_weights = {1};
            scene.add_node(scene.root(), node);
            if (!is_morph)
                scene.record_shutter(2, [&](double tau) {
                    std::vector<Vec3f> moved = rest;
                    for (Vec3f& p : moved) p.x += 0.25f * float(tau);
                    scene.write_vertices(id, moved);
                });
            scene.refit();
            bounds[stray] = scene.bounds();
        }
        EXPECT_EQ(bounds[1].lo, bounds[0].lo);
        EXPECT_EQ(bounds[1].hi, bounds[0].hi);
        EXPECT_LT(bounds[1].radius(), 10);
    }
}

TEST(UnusedVertices, OfCagesMadeOnDemandMayLieOutsideOfTheirBounds)
{
    std::uint64_t pictures[2];
    for (const bool stray : {false, true}) {
        Scene scene;
        const Cage cube = creased_cube(1);
        OnDemandCage cage;
        cage.bounds = cube.bounds();
        cage.make = [=] { return stray ? with_stray_vertex(cube) : cube; };
        place(scene, scene.add(std::move(cage)), {0, 0, 0});
        pictures[stray] = picture_of(scene);
    }
    EXPECT_EQ(pictures[1], pictures[0]);
}

// More faces around a vertex than can be refined are refused by name, whatever the scheme.
TEST(Sanitize, PolesOfBilinearCagesAreLimitedAsThoseOfSmoothOnes)
{
    Cage fan;
    fan.scheme = Scheme::Bilinear;
    fan.positions.push_back({0, 1, 0});
    constexpr std::uint32_t kFaces = 70'000;
    for (std::uint32_t k = 0; k < kFaces; ++k) {
        const double angle = 6.283185307179586 * k / kFaces;
        fan.positions.emplace_back(float(std::cos(angle)), 0.0f, float(std::sin(angle)));
        for (const std::uint32_t v : {0u, 1 + (k + 1) % kFaces, 1 + k}) fan.face_vertices.push_back(v);
        fan.face_sizes.push_back(3);
    }
    Scene scene;
    place(scene, scene.add(fan), {0, 0, 0});
    place(scene, scene.add(creased_cube(1)), {0, 0, 0});
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_NE(scene.warnings[0].find("70000 faces dropped: more than 4096 of them meet at a vertex"), std::string::npos)
        << scene.warnings[0];
    picture_of(scene);
}

}  // namespace
}  // namespace occam::test
