// Emissive triangles: their tree draws points without bias, and knows with which density.
#include "shade/mesh_lights.h"

#include <gtest/gtest.h>

#include <cfloat>
#include <cmath>

#include "base/maths.h"
#include "tests/support/shape_builders.h"
#include "tests/support/statistics.h"

namespace occam::shade {
namespace {

Vec3f unit(test::Numbers& n)
{
    const float z = 2 * n.one() - 1, angle = 2 * maths::kPi * n.one(), r = std::sqrt(std::max(0.0f, 1 - z * z));
    return {r * maths::cos(angle), r * maths::sin(angle), z};
}

struct Lamp {
    Vec3d corner[3];
    NodeId node;
    CageId cage;
    std::uint32_t face;
    const Material* material;

    MeshLights::Place place(Vec3d position) const { return {node, cage, material, face, position, 0}; }
    Vec3d at(double b, double c) const { return corner[0] + (corner[1] - corner[0]) * b + (corner[2] - corner[0]) * c; }
};

// Two nodes show one cage of random triangles with two emissive materials.
struct Lamps {
    Scene scene;
    std::vector<Lamp> all;

    /// size   about the length of an edge
    explicit Lamps(std::uint32_t triangles, float size = 1)
    {
        test::Numbers n(3);
        Cage cage;
        cage.scheme = Scheme::Triangles;
        for (std::uint32_t i = 0; i < triangles; ++i) {
            const Vec3f middle(8 * n.one() - 4, 8 * n.one() - 4, 8 * n.one() - 4);
            for (int p = 0; p < 3; ++p) {
                cage.face_vertices.push_back(3 * i + std::uint32_t(p));
                cage.positions.push_back(middle + unit(n) * (size * (0.1f + n.one())));
            }
            cage.face_slots.push_back(i % 2);
        }
        Material dim, bright;
        dim.emission = Vec3f(1);
        bright.emission = Vec3f(30);
        cage.materials = {scene.add(dim), scene.add(bright)};
        const CageId shape = scene.add(Cage(cage));
        for (const Vec3d at : {Vec3d(0), Vec3d(0, 0, 12)}) {
            const NodeId node = test::place(scene, shape, at);
            for (std::uint32_t i = 0; i < triangles; ++i) {
                Lamp lamp{{}, node, shape, i, scene.find(cage.materials[i % 2])};
                for (std::uint32_t p = 0; p < 3; ++p) lamp.corner[p] = at + Vec3d(cage.positions[3 * i + p]);
                all.push_back(lamp);
            }
        }
        scene.refit();
    }
};

struct Place {
    Vec3d point;
    Receiver receiver;

    Place(const MeshLights& lights, test::Numbers& n)
        : point(Vec3d(n.one() - 0.5f, n.one() - 0.5f, n.one() - 0.2f) * 20.0),
          receiver{lights.tree().relative(point), unit(n), kAllGroups, n.one() < 0.3f}
    {
    }
};

TEST(MeshLights, DensitiesOfPlacesAreThoseOfSamples)
{
    for (const std::uint32_t triangles : {5u, 60u}) {
        const Lamps lamps(triangles);
        const TextureStore textures(1 << 20);
        MeshLights lights(lamps.scene, textures);
        lights.make_tree({});
        test::Numbers n(7);
        int compared = 0;
        for (int i = 0; i < 2000; ++i) {
            const Place at(lights, n);
            const LightSample s = lights.sample(at.point, at.receiver, {{n.one(), n.one()}, n.one()});
            if (s.radiance == Vec3f(0)) continue;
            // The nearest triangle that the direction meets at that distance, before whose plane the sample ends by what
            // rounding may move it.
            for (const Lamp& lamp : lamps.all) {
                const Vec3d normal = glm::cross(lamp.corner[1] - lamp.corner[0], lamp.corner[2] - lamp.corner[0]);
                const double along = glm::dot(Vec3d(s.direction), normal);
                const double distance = glm::dot(lamp.corner[0] - at.point, normal) / along;
                const double cosine = std::abs(along) / glm::length(normal), size = 40;  // the cage's edges added up
                const double gap = (distance - double(s.distance)) * cosine, rounding = FLT_EPSILON * (distance + size);
                if (!(gap > -rounding && gap < 20 * rounding)) continue;
                const Vec3d hit = at.point + Vec3d(s.direction) * distance;
                const double area2 = glm::dot(normal, normal);
                const double b = glm::dot(glm::cross(hit - lamp.corner[0], lamp.corner[2] - lamp.corner[0]), normal) / area2,
                             c = glm::dot(glm::cross(lamp.corner[1] - lamp.corner[0], hit - lamp.corner[0]), normal) / area2;
                if (b < 1e-4 || c < 1e-4 || b + c > 1 - 1e-4 || cosine < 0.02) continue;
                const float per_area = lights.area_density(lamp.place(hit), at.receiver);
                EXPECT_NEAR(double(per_area) * distance * distance / cosine, double(s.density), 1e-2 * double(s.density));
                ++compared;
                break;
            }
        }
        EXPECT_GT(compared, 1000);
    }
}

TEST(MeshLights, SumsOfSamplesAreThoseOfAllTriangles)
{
    const Lamps lamps(60);
    const TextureStore textures(1 << 20);
    MeshLights lights(lamps.scene, textures);
    lights.make_tree({});
    test::Numbers n(11);
    for (int place = 0; place < 12; ++place) {
        const Place at(lights, n);
        const auto cosine_at = [&](Vec3d direction) {
            const double cosine = glm::dot(direction, Vec3d(at.receiver.normal));
            return at.receiver.is_two_sided ? std::abs(cosine) : std::max(cosine, 0.0);
        };
        double exact = 0;
        constexpr int kSteps = 40;
        for (const Lamp& lamp : lamps.all) {
            const Vec3d normal = glm::cross(lamp.corner[1] - lamp.corner[0], lamp.corner[2] - lamp.corner[0]);
            for (int i = 0; i < kSteps; ++i)
                for (int j = 0; j < 2 * (kSteps - i) - 1; ++j) {
                    // The middles of the triangles into which a lamp is divided evenly.
                    const double third = 1.0 / 3, low = j % 2 == 0 ? third : 2 * third;
                    const Vec3d to = lamp.at((i + low) / kSteps, (j / 2 + low) / kSteps) - at.point;
                    const double d2 = glm::dot(to, to), d = std::sqrt(d2);
                    exact += double(lamp.material->emission.x) * cosine_at(to / d) * std::abs(glm::dot(to / d, normal)) / 2 /
                             (kSteps * kSteps) / d2;
                }
        }
        test::Mean mean;
        for (int i = 0; i < 40000; ++i) {
            const LightSample s = lights.sample(at.point, at.receiver, {{n.one(), n.one()}, n.one()});
            mean.add(double(s.radiance.x) * cosine_at(Vec3d(s.direction)));
        }
        EXPECT_NEAR(mean.value(), exact, 5 * mean.error() + 0.01 * exact) << place;
    }
}

// A lamp a unit away gives a third of the light. The other two thirds come from one that is 89 times as strong and 6.7 units
// away, and may be hidden.
TEST(MeshLights, TheNearOneOfTwoIsDrawnAsOftenAsItsLightIsWorth)
{
    Scene scene;
    Material dim, bright;
    dim.emission = Vec3f(1);
    bright.emission = Vec3f(89);
    for (const auto& [material, height] : {std::pair(dim, 1.0), {bright, 6.7}}) {
        Cage cage;
        cage.scheme = Scheme::Triangles;
        cage.positions = {{-0.1f, -0.1f, 0}, {0.1f, -0.1f, 0}, {0, 0.1f, 0}};
        cage.face_vertices = {0, 1, 2};
        cage.materials = {scene.add(Material(material))};
        test::place(scene, scene.add(std::move(cage)), {0, 0, height});
    }
    scene.refit();
    const TextureStore textures(1 << 20);
    MeshLights lights(scene, textures);
    lights.make_tree({});
    test::Numbers n(5);
    const Receiver receiver{lights.tree().relative(Vec3d(0)), {0, 0, 1}, kAllGroups, false};
    constexpr int kSamples = 1000;
    int near = 0;
    for (int i = 0; i < kSamples; ++i) near += lights.sample(Vec3d(0), receiver, {{n.one(), n.one()}, n.one()}).distance < 2;
    EXPECT_NEAR(near, kSamples / 3, kSamples / 10);
}

// A sample finds as much light as a ray that hits the surface there.
TEST(MeshLights, TheAlphaOfVertexColoursCountsInSamples)
{
    Material glass;
    glass.emission = Vec3f(1);
    glass.alpha_mode = AlphaMode::Blend;
    Cage cage;
    cage.scheme = Scheme::Triangles;
    cage.positions = {{-1, 0, -1}, {1, 0, -1}, {0, 0, 1}};
    cage.face_vertices = {0, 1, 2};
    cage.colors = {Vec4f(1, 1, 1, 0), Vec4f(1, 1, 1, 0), Vec4f(1, 1, 1, 0.75f)};
    for (const bool has_indices : {false, true}) {
        if (has_indices) cage.color_indices = {1, 0, 2};
        Scene scene;
        Cage shown = cage;
        shown.materials = {scene.add(Material(glass))};
        test::place(scene, scene.add(std::move(shown)), Vec3d(0));
        scene.refit();
        const TextureStore textures(1 << 20);
        MeshLights lights(scene, textures);
        lights.make_tree({});
        test::Numbers n(5);
        for (int i = 0; i < 100; ++i) {
            const Vec3d point(0, -1, 0);
            const Receiver receiver{lights.tree().relative(point), {0, 1, 0}, kAllGroups, false};
            const LightSample s = lights.sample(point, receiver, {{n.one(), n.one()}, n.one()});
            const Vec3d at = point + Vec3d(s.direction) * (-point.y / double(s.direction.y));
            EXPECT_NEAR(double(s.radiance.x * s.density), 0.75 * (at.z + 1) / 2, 1e-4);
        }
    }
}

TEST(MeshLights, WhatIsNotSampledHasNoDensity)
{
    Lamps lamps(60);
    const TextureStore textures(1 << 20);
    MeshLights lights(lamps.scene, textures);
    lights.make_tree({});
    const Lamp& lamp = lamps.all.front();
    const Material other;
    const Receiver receiver{lights.tree().relative(Vec3d(5)), glm::normalize(Vec3f(-1)), kAllGroups, true};
    const Vec3d middle = lamp.at(1.0 / 3, 1.0 / 3);
    EXPECT_GT(lights.area_density(lamp.place(middle), receiver), 0);
    const NodeId node = lamp.node;
    EXPECT_EQ(lights.area_density({node, lamp.cage, &other, lamp.face, middle, 0}, receiver), 0);
    EXPECT_EQ(lights.area_density({node, lamp.cage, lamp.material, 60, middle, 0}, receiver), 0);
    EXPECT_EQ(lights.area_density({node, {}, lamp.material, lamp.face, middle, 0}, receiver), 0);
    EXPECT_EQ(lights.area_density(lamp.place(Vec3d(1000)), receiver), 0);
}

// A node keeps the dead handle of a skin that was removed.
TEST(MeshLights, WhatWoreASkinThatWasRemovedIsSampledAgain)
{
    Lamps lamps(60);
    const TextureStore textures(1 << 20);
    const double power = MeshLights(lamps.scene, textures).power();
    const NodeId wearer = lamps.all.front().node;
    const SkinId skin = lamps.scene.add(Skin{{}, {lamps.scene.root()}, {}});
    lamps.scene.set_skin(wearer, skin);
    lamps.scene.remove(skin);
    lamps.scene.refit();
    ASSERT_TRUE(lamps.scene.node(wearer).skin);
    MeshLights lights(lamps.scene, textures);
    lights.make_tree({});
    EXPECT_EQ(lights.power(), power);
    const Receiver receiver{lights.tree().relative(Vec3d(5)), glm::normalize(Vec3f(-1)), kAllGroups, true};
    for (const Lamp& lamp : lamps.all) EXPECT_GT(lights.area_density(lamp.place(lamp.at(1.0 / 3, 1.0 / 3)), receiver), 0);
}

// Where triangles share leaves, those of a leaf are neighbours, although the mesh lists them in any order. A point was in
// the boxes of half of all leaves, and looking for its triangle took as long as looking at all of them.
TEST(MeshLights, LeavesOfManyTrianglesAreSmall)
{
    const Lamps lamps(50'000, 0.01f);
    const TextureStore textures(1 << 20);
    MeshLights lights(lamps.scene, textures);
    lights.make_tree({});
    const Receiver receiver{lights.tree().relative(Vec3d(9, 9, 6)), glm::normalize(Vec3f(-1)), kAllGroups, true};
    std::size_t around = 0;
    double sum = 0;
    for (const Lamp& lamp : lamps.all) {
        const Vec3d middle = lamp.at(1.0 / 3, 1.0 / 3);
        lights.tree().for_boxes_around(middle, 0, [&](std::uint32_t) { ++around; });
        const double area = 0.5 * glm::length(glm::cross(lamp.corner[1] - lamp.corner[0], lamp.corner[2] - lamp.corner[0]));
        sum += area * double(lights.area_density(lamp.place(middle), receiver));
    }
    EXPECT_LT(around, 3 * lamps.all.size());
    EXPECT_NEAR(sum, 1, 1e-3) << "the density is that of one sample";
}

// The mesh that comes first has one triangle, and the triangle that comes first along the curve belongs to the other mesh.
TEST(MeshLights, ManyTrianglesMayBeOfSmallAndLargeMeshes)
{
    Scene scene;
    Material glow;
    glow.emission = Vec3f(1);
    const MaterialId material = scene.add(glow);
    for (const std::uint32_t triangles : {1u, 70'000u}) {
        Cage cage;
        cage.scheme = Scheme::Triangles;
        cage.materials = {material};
        for (std::uint32_t i = 0; i < triangles; ++i)
            for (std::uint32_t p = 0; p < 3; ++p) {
                cage.face_vertices.push_back(3 * i + p);
                cage.positions.emplace_back(float(triangles - i) / float(triangles), p == 1, p == 2);
            }
        test::place(scene, scene.add(std::move(cage)), Vec3d(triangles == 1 ? 5 : 0));
    }
    scene.refit();
    const TextureStore textures(1 << 20);
    MeshLights lights(scene, textures);
    lights.make_tree({});
    EXPECT_LT(lights.tree().origin().x, 1e-3)
        << "a corner of the last triangle of the large mesh, which is the first along x";
}

// 8,192 placements of a mesh of 8,192 triangles, or of as many slots of materials.
TEST(MeshLights, RefusesMoreFacesThanFitInMemory)
{
    for (const bool has_slots : {false, true}) {
        Scene scene;
        Material glow;
        glow.emission = Vec3f(1);
        Cage cage;
        cage.scheme = Scheme::Triangles;
        cage.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
        for (int i = 0; i < (has_slots ? 1 : 8192); ++i) cage.face_vertices.insert(cage.face_vertices.end(), {0, 1, 2});
        cage.materials.assign(has_slots ? 8192 : 1, scene.add(glow));
        const CageId lamp = scene.add(std::move(cage));
        NodeId shown = scene.add_node(scene.root(), {.name = "lamp", .cages = {lamp}, .visible = false});
        for (int k = 0; k < 13; ++k) {
            const NodeId both = scene.add_node(scene.root(), {.visible = false});
            scene.add_node(both, {.instance_of = shown});
            scene.add_node(both, {.instance_of = shown});
            shown = both;
        }
        scene.add_node(scene.root(), {.instance_of = shown});
        scene.refit();
        const TextureStore textures(1 << 20);
        EXPECT_THROW(MeshLights(scene, textures), Error) << has_slots;
    }
}

// Materials of many slots are found in one pass over the faces, and their triangles stay in the order of the slots.
TEST(MeshLights, HasTheTrianglesOfEachSlotOneAfterAnother)
{
    Scene scene;
    Cage cage;
    cage.scheme = Scheme::Triangles;
    cage.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    for (std::uint16_t i = 0; i < 6; ++i) {
        cage.face_vertices.insert(cage.face_vertices.end(), {0, 1, 2});
        cage.face_slots.push_back(static_cast<std::uint16_t>(i % 3));
    }
    for (const float strength : {1.0f, 0.0f, 4.0f}) {
        Material glow;
        glow.emission = Vec3f(strength);
        cage.materials.push_back(scene.add(glow));
    }
    scene.add_node(scene.root(), {.cages = {scene.add(std::move(cage))}});
    scene.refit();
    const TextureStore textures(1 << 20);
    const MeshLights lights(scene, textures);
    EXPECT_TRUE(lights.any_emitter());
    EXPECT_NEAR(lights.power(), 0.5 * (2 * 1 + 2 * 4), 1e-5);
}

// The power of the others decides whether the scene gets a light that it does not have.
TEST(MeshLights, CagesWithoutFacesAndBoxesWithoutASizeHaveNoPower)
{
    for (const int kind : {0, 1, 2}) {
        Scene scene;
        Material glow;
        glow.emission = Vec3f(2);
        Cage lamp;
        lamp.scheme = Scheme::Triangles;
        lamp.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
        lamp.face_vertices = {0, 1, 2};
        lamp.materials = {scene.add(glow)};
        Cage other = lamp;
        if (kind < 2) other.morph_targets.push_back({"", {Vec3f(1), Vec3f(1), Vec3f(1)}, {}});
        if (kind == 0) other.face_vertices.clear();
        scene.add_node(scene.root(), {.cages = {scene.add(std::move(lamp))}});
        Mat4d place(1);
        if (kind > 0) place *= 1e300, place[3] = Vec4d(0, 0, 0, 1);
        scene.add_node(scene.root(), {.matrix = place, .cages = {scene.add(std::move(other))}});
        scene.refit();
        const TextureStore textures(1 << 20);
        EXPECT_NEAR(MeshLights(scene, textures).power(), 0.5 * 2, 1e-5) << kind;
    }
}

}  // namespace
}  // namespace occam::shade
