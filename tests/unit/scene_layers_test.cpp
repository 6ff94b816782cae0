// Surfaces that light passes are counted where they lie one behind the other or in each other, and a frame with too many is
// refused.
#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <string>

#include "base/error.h"
#include "scenegraph/scene.h"
#include "tests/support/random_directions.h"

namespace occam {
namespace {

/// Returns triangles whose boxes are much larger than they are, so that each point of a unit cube lies in many of them, and
/// one more in the last material slot.
Cage hay_and_pane()
{
    Cage cage;
    cage.scheme = Scheme::Triangles;
    std::mt19937 random(3);
    const auto coordinate = [&] { return float(random() >> 8) * 0x1p-24f; };
    for (std::uint32_t face = 0; face < 20'000; ++face) {
        const Vec3f a(coordinate(), coordinate(), coordinate()), b(coordinate(), coordinate(), coordinate());
        for (const Vec3f p : {a, b, b + Vec3f(0.002f, 0, 0.002f)}) {
            cage.face_vertices.push_back(static_cast<std::uint32_t>(cage.positions.size()));
            cage.positions.push_back(p);
        }
    }
    cage.face_slots.assign(cage.face_count() - 1, 0);
    cage.face_slots.push_back(1);
    return cage;
}

// An opaque surface ends a ray, whatever it shares a node or a cage with.
TEST(Contents, OnlyFacesThatPassLightCountForThoseThatARayGoesOnBehind)
{
    Scene scene;
    Material glass;
    glass.transmission = 1;
    glass.roughness = 0;
    const MaterialId clear = scene.add(glass), opaque = scene.add(Material{}), third = scene.add(Material{});
    const auto depth = [&] {
        scene.refit();
        return scene.contents().most_depth;
    };
    Cage cage = hay_and_pane();
    cage.materials = {opaque, clear};
    const CageId both = scene.add(cage);
    cage.materials = {opaque, third};
    const CageId hay = scene.add(cage);
    Cage triangle;
    triangle.scheme = Scheme::Triangles;
    triangle.positions = {{0, 0, 0}, {0.1f, 0, 0}, {0, 0.1f, 0.1f}};
    triangle.face_vertices = {0, 1, 2};
    triangle.materials = {clear};
    const CageId pane = scene.add(triangle);
    const NodeId node = scene.add_node(scene.root(), {.cages = {hay}});
    EXPECT_EQ(depth(), 0);
    scene.set_cages(node, {hay, pane});
    EXPECT_LE(depth(), 1) << "two cages of one node";
    scene.set_cages(node, {both});
    EXPECT_LE(depth(), 2) << "two slots of one cage";
    scene.write_vertices(both, cage.positions);
    EXPECT_LE(depth(), 2) << "written";
    scene.set_materials(node, {clear, opaque});
    EXPECT_GT(depth(), 64) << "the node's own materials count";
    scene.set_materials(node, {});
    scene.replace(opaque, glass);
    EXPECT_GT(depth(), 64) << "the hay is of glass";
    scene.replace(clear, Material{});
    EXPECT_GT(depth(), 64) << "and the pane is opaque";
    scene.replace(opaque, Material{});
    EXPECT_EQ(depth(), 0);
}

/// Returns panes of two triangles each, one behind the other, whose boxes have no volume.
Cage panes_in_a_row(std::uint32_t panes)
{
    Cage cage;
    cage.scheme = Scheme::Triangles;
    for (std::uint32_t i = 0; i < panes; ++i) {
        const float z = float(i) * 0x1p-14f;
        cage.positions.insert(cage.positions.end(), {{0, 0, z}, {1, 0, z}, {1, 1, z}, {0, 1, z}});
        for (const std::uint32_t corner : {0, 1, 2, 0, 2, 3}) cage.face_vertices.push_back(4 * i + corner);
    }
    return cage;
}

// A ray is shaded at each surface that it passes, however flat their boxes are.
TEST(Contents, PanesInARowAreRefusedBeyondTheirLimit)
{
    constexpr auto kMost = static_cast<std::uint32_t>(kMostPassed);
    Material faint;
    faint.alpha_mode = AlphaMode::Blend;
    const auto refusal_of = [&](std::uint32_t panes, std::uint32_t nodes, const Material& material) {
        Scene scene;
        Cage cage = panes_in_a_row(panes);
        cage.materials = {scene.add(material)};
        const CageId id = scene.add(std::move(cage));
        const NodeId group = scene.add_node(scene.root(), {.name = "panes"});
        for (std::uint32_t i = 0; i < nodes; ++i)
            scene.add_node(group, {.place = {.translation = {0, 0, double(i) * 0x1p-12}}, .cages = {id}});
        scene.refit();
        try {
            check_layers(scene);
        } catch (const Error& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    const std::string why = "too many surfaces that light passes lie one behind the other";
    EXPECT_NE(refusal_of(2 * kMost, 1, faint).find(why), std::string::npos);
    EXPECT_NE(refusal_of(1, 2 * kMost, faint).find(why), std::string::npos);
    EXPECT_NE(refusal_of(1, 2 * kMost, faint).find("(node 'panes')"), std::string::npos);
    EXPECT_EQ(refusal_of(kMost / 2, 1, faint), "");
    EXPECT_EQ(refusal_of(1, kMost / 2, faint), "");
    EXPECT_EQ(refusal_of(2 * kMost, 1, Material{}), "") << "an opaque surface ends a ray";
}

// The boxes of what moves and of what turns are larger than it is.
TEST(Contents, SurfacesThatLightPassesCountByTheirAreasWhereTheyMoveAndTurn)
{
    Material faint;
    faint.alpha_mode = AlphaMode::Blend;
    for (const bool moves : {false, true}) {
        Scene scene;
        Cage spark = panes_in_a_row(1);
        spark.materials = {scene.add(faint)};
        const CageId id = scene.add(std::move(spark));
        test::Random random(3);
        std::vector<Vec3d> places, ways;
        std::vector<NodeId> sparks;
        for (int i = 0; i < 4000; ++i) {
            places.push_back(random.direction());
            ways.push_back(random.direction());
            sparks.push_back(scene.add_node(scene.root(),
                                            {.place = {.translation = places.back(), .scale = Vec3d(0.01)}, .cages = {id}}));
        }
        if (moves)
            scene.record_shutter(1, [&](double tau) {
                for (std::size_t i = 0; i < sparks.size(); ++i)
                    scene.set_transform(sparks[i], Trs{.translation = places[i] + tau * ways[i], .scale = Vec3d(0.01)});
            });
        scene.refit();
        // 4,000 squares of 0.01 in a cube of a side of 2, or of 4 where they move.
        EXPECT_NEAR(scene.contents().passed_in(scene.bounds()), 4000 * 1e-4 / (moves ? 48 : 12), moves ? 0.003 : 0.005)
            << moves;
    }

    // A square under ten nodes, each of which turns by the eighth of a turn, has a box that grows ten times.
    Scene scene;
    Cage pane = panes_in_a_row(1);
    pane.materials = {scene.add(faint)};
    const CageId id = scene.add(std::move(pane));
    NodeId at = scene.root();
    constexpr double kHalf = 0.39269908169872414;
    for (int i = 0; i < 10; ++i) at = scene.add_node(at, {.place = {.rotation = {0, std::sin(kHalf), 0, std::cos(kHalf)}}});
    scene.add_node(at, {.cages = {id}});
    scene.refit();
    EXPECT_NEAR(scene.contents().passing_area, 1, 1e-6);
}

TEST(Contents, PanesOnDemandAreCountedByTheirBoxes)
{
    for (const int panes : {100, 2000}) {
        Scene scene;
        Material faint;
        faint.alpha_mode = AlphaMode::Blend;
        const MaterialId material = scene.add(faint);
        const CageId id = scene.add(OnDemandCage{.name = "pane",
                                                 .bounds = {Vec3d(0, 0, -1e-6), Vec3d(1, 1, 1e-6)},
                                                 .make = [] { return panes_in_a_row(1); },
                                                 .materials = {material}});
        for (int i = 0; i < panes; ++i)
            scene.add_node(scene.root(), {.place = {.translation = {0, 0, i * 1e-5}}, .cages = {id}});
        scene.refit();
        EXPECT_NEAR(scene.contents().most_passed, panes, 0.05 * panes);
    }
}

// Slivers that blend have large boxes, but a ray meets few of them.
TEST(Contents, BladesThatLightPassesCountByTheirAreas)
{
    Scene scene;
    Material faint;
    faint.alpha_mode = AlphaMode::Blend;
    Cage cage = hay_and_pane();
    cage.materials.assign(2, scene.add(faint));
    scene.add_node(scene.root(), {.cages = {scene.add(std::move(cage))}});
    scene.refit();
    EXPECT_GT(scene.contents().most_passed, 1);
    EXPECT_LT(scene.contents().most_passed, 20);
}

}  // namespace
}  // namespace occam
