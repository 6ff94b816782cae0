// Tests that closed rooms stay dark where micropolygons are much longer than wide, or longer than their level says.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include "lod/owned_curves.h"
#include "tests/support/closed_rooms.h"
#include "tests/support/diced_mesh.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

/// Returns a box from (-1, -1, -1) to (1, 1, 1). Each of the walls along x has strips of this width in its middle.
Cage box_of_strips(float width, Scheme scheme)
{
    constexpr int kStrips = 24;
    std::vector<float> across{-1};
    for (int i = 0; i <= kStrips; ++i) across.push_back(width * (float(i) - 0.5f * kStrips));
    // Once around the x axis.
    std::vector<Vec2f> around;
    for (int turn = 0; turn < 4; ++turn)
        for (const float a : across) {
            Vec2f p(a, -1);
            for (int k = 0; k < turn; ++k) p = {-p.y, p.x};
            around.push_back(p);
        }
    const auto n = static_cast<std::uint32_t>(around.size());
    Cage cage;
    cage.scheme = scheme;
    for (const Vec2f p : around) cage.positions.insert(cage.positions.end(), {{-1, p.x, p.y}, {1, p.x, p.y}});
    cage.positions.insert(cage.positions.end(), {{-1, 0.013f, 0.021f}, {1, 0.013f, 0.021f}});
    const auto add = [&](std::initializer_list<std::uint32_t> face) {
        cage.face_vertices.insert(cage.face_vertices.end(), face);
        if (scheme != Scheme::Triangles) cage.face_sizes.push_back(static_cast<std::uint32_t>(face.size()));
    };
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t a = 2 * i, b = 2 * ((i + 1) % n);
        if (scheme == Scheme::Triangles) add({a, b + 1, a + 1}), add({a, b, b + 1});
        else add({a, b, b + 1, a + 1});
        add({2 * n, b, a});
        add({2 * n + 1, a + 1, b + 1});
        if (scheme == Scheme::Triangles) continue;
        for (const std::uint32_t end : {0u, 1u}) {
            cage.creases.push_back({a + end, b + end, kInfiniteSharpness});
            cage.creases.push_back({a + end, 2 * n + end, kInfiniteSharpness});
        }
        cage.creases.push_back({a, a + 1, kInfiniteSharpness});
    }
    return cage;
}

// A ray that starts next to a long thin triangle met it again from the wrong side, and the next one started outside.
TEST(ClosedRooms, AreDarkBetweenWallsOfSlivers)
{
    Look look{.place = Trs{}, .field = 1.4f, .width = 48, .height = 36, .spp = 16};
    look.place->rotation = glm::normalize(Vec4d(0.15, 0.29, -0.07, 0.94));
    for (const Scheme scheme : {Scheme::Triangles, Scheme::CatmullClark})
        for (const float width : {3e-3f, 1e-3f, 1e-4f}) {
            const Room room{"a box of strips", box_of_strips(width, scheme), {0.1, 0.1, 0.1}, {1, 0.3, 0.2}};
            for (const float rate : {1.0f, 8.0f}) {
                if (scheme == Scheme::Triangles && rate > 1) continue;
                look.rate = rate;
                expect_dark(room, look);
            }
        }
}

/// Returns a spindle, seen from inside, so near to its pole.
Room beside_pole(std::uint32_t faces, double away)
{
    Room room{"a spindle with poles of " + std::to_string(faces) + " faces", spindle(faces)};
    const DicedCage diced(room.cage, 0);
    lod::PatchSurface surface;
    const Vec3d pole(lod::OwnedCurves(surface).vertex_point(diced.posed, 0, lod::kFinestLevel - 1));
    room.eye = pole + diced.posed.anchor + away * Vec3d(0.0003, -1, 0.0001);
    room.target = pole + diced.posed.anchor + away * Vec3d(0.1, 0, 0.05);
    return room;
}

// Edges beside a pole are longer than their level says. With margins as short as elsewhere, hundreds of pixels are lit.
TEST(ClosedRooms, AreDarkBesidePoles)
{
    for (const std::uint32_t faces : {12u, 50u})
        for (const double away : {0.02, 0.005})
            for (const float rate : {1.0f, 4.0f})
                expect_dark(beside_pole(faces, away), {.rate = rate, .width = 48, .height = 48});
}

/// Returns that room with a small closed cage beside it, which is a part of the same cage and whose vertices come last.
Room with_small_shell(Room room)
{
    const Cage shell = spindle(4);
    const auto first = static_cast<std::uint32_t>(room.cage.positions.size());
    for (const Vec3f p : shell.positions) room.cage.positions.push_back(p * 0.05f + Vec3f(3, 0, 0));
    for (const std::uint32_t v : shell.face_vertices) room.cage.face_vertices.push_back(first + v);
    room.cage.face_sizes.insert(room.cage.face_sizes.end(), shell.face_sizes.begin(), shell.face_sizes.end());
    return room;
}

/// Gives a cage another shape at rest, which a morph target makes what it was.
void morph_from(std::vector<Vec3f> rest, Cage& cage)
{
    MorphTarget target;
    for (std::size_t v = 0; v < rest.size(); ++v) target.positions.push_back(cage.positions[v] - rest[v]);
    cage.positions = std::move(rest);
    cage.morph_targets = {target};
    cage.morph_weights = {1};
}

// What is small at rest has short edges at poles there.
TEST(ClosedRooms, AreDarkBesidePolesThatMorphTargetsMake)
{
    Room from_nothing = beside_pole(12, 0.005);
    morph_from(std::vector<Vec3f>(from_nothing.cage.positions.size(), Vec3f(0)), from_nothing.cage);
    Room grown = with_small_shell(beside_pole(12, 0.005));
    std::vector<Vec3f> small = grown.cage.positions;
    for (std::size_t v = 0; v < spindle(12).positions.size(); ++v) small[v] *= 1e-3f;
    morph_from(small, grown.cage);
    for (const Room& room : {from_nothing, grown}) expect_dark(room, {.rate = 4, .width = 48, .height = 48});
}

TEST(ClosedRooms, AreDarkBesidePolesThatJointsEnlarge)
{
    const Room room = with_small_shell(beside_pole(12, 0.005));
    Cage cage = room.cage;
    cage.skin.sets = 1;
    const std::size_t vertices = spindle(12).positions.size();
    for (std::size_t v = 0; v < cage.positions.size(); ++v) {
        if (v < vertices) cage.positions[v] *= 1e-3f;
        cage.skin.joints.emplace_back(v < vertices ? 0 : 1, 0, 0, 0);
        cage.skin.weights.emplace_back(1, 0, 0, 0);
    }
    Scene scene;
    NodeDesc enlarged, shown;
    enlarged.place.scale = Vec3d(1000);
    const NodeId joints[] = {scene.add_node(scene.root(), enlarged), scene.add_node(scene.root(), {})};
    shown.cages = {scene.add(cage)};
    shown.skin = scene.add(Skin{"skin", {joints[0], joints[1]}});
    scene.add_node(scene.root(), shown);
    scene.environment.radiance = Vec3f(100);
    Renderer renderer({.threads = 2});
    Settings settings{.width = 48, .height = 48, .spp = 4, .shading_rate = 4};
    const Image image = renderer.render(scene, Camera::look_at(room.eye, room.target, {0, 1, 0}, 1.5f), settings);
    const std::vector<float>& pixels = image.layers()[0].pixels;
    for (std::size_t i = 0; i < pixels.size(); i += 4) ASSERT_EQ(pixels[i] + pixels[i + 1] + pixels[i + 2], 0) << i / 4;
}

// A small part that lies far away makes the cage's box long, which a node's scale shortens.
TEST(ClosedRooms, AreDarkBesidePolesOfStretchedCages)
{
    Room room = with_small_shell(beside_pole(12, 0.005));
    for (std::size_t v = spindle(12).positions.size(); v < room.cage.positions.size(); ++v)
        room.cage.positions[v] += Vec3f(-3, 3000, 0);
    Trs place;
    place.scale = {1000, 1, 1};
    expect_dark(room, {.rate = 4, .place = place, .width = 48, .height = 48});
}

}  // namespace
}  // namespace occam::test
