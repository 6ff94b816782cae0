// Tests that little light enters closed rooms whose walls cross themselves, or are crossed by meshes.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include <algorithm>
#include <array>

#include "tests/support/closed_rooms.h"

namespace occam::test {
namespace {

constexpr std::array<std::uint32_t, 4> kFacesOfCube[] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                                         {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};

std::vector<Vec3f> corners_between(Vec3f low, Vec3f high)
{
    std::vector<Vec3f> corners;
    for (int i = 0; i < 8; ++i) corners.push_back({i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z});
    return corners;
}

/// Returns a cage that crosses itself: a smooth room, and a pillar from its middle through the ceiling, which reaches
/// `width` to each side of its axis. The faces of the pillar have one piece at levels at which the ceiling still has many.
Cage room_with_pillar(float width)
{
    Cage cage;
    cage.scheme = Scheme::CatmullClark;
    const auto add = [&](std::array<std::uint32_t, 4> face) {
        cage.face_sizes.push_back(4);
        cage.face_vertices.insert(cage.face_vertices.end(), face.begin(), face.end());
    };
    cage.positions = corners_between(Vec3f(-1), Vec3f(1));
    for (const auto& face : kFacesOfCube) add(face);
    constexpr std::uint32_t kRings = 8;
    const auto at = [&](std::uint32_t ring, std::uint32_t side) { return 8 + 4 * ring + side % 4; };
    const auto crease = [&](std::uint32_t a, std::uint32_t b) { cage.creases.push_back({a, b, kInfiniteSharpness}); };
    for (std::uint32_t ring = 0; ring <= kRings; ++ring)
        for (std::uint32_t side = 0; side < 4; ++side) {
            const float x = side == 1 || side == 2 ? width : -width, z = side >= 2 ? width : -width;
            cage.positions.push_back({0.3f + x, 0.3f + 0.1f * static_cast<float>(ring), 0.3f + z});
            if (ring == 0 || ring == kRings) crease(at(ring, side), at(ring, side + 1));
            if (ring == kRings) continue;
            add({at(ring, side), at(ring + 1, side), at(ring + 1, side + 1), at(ring, side + 1)});
            crease(at(ring, side), at(ring + 1, side));
        }
    add({at(0, 0), at(0, 1), at(0, 2), at(0, 3)});
    add({at(kRings, 0), at(kRings, 3), at(kRings, 2), at(kRings, 1)});
    return cage;
}

/// The pillar is the same at all levels that a ray sees of it, and the ceiling that it crosses is not. So a ray that starts
/// on the pillar has to start on the level that its parent saw there: where levels were chosen by the target edge length
/// alone, 475 pixels of 10,368 were lit instead of 1.
TEST(ClosedRooms, ThatCrossThemselvesLetLittleLightIn)
{
    int lit = 0, seen = 0;
    for (const float width : {0.02f, 0.1f}) {
        const Room room{"room with a pillar", room_with_pillar(width), {-0.3, 0, -0.3}, {0.3, 0.6, 0.3}};
        for (const float rate : {1.0f, 4.0f, 16.0f})
            for (const IntegratorKind kind : {IntegratorKind::Path, IntegratorKind::Ao}) {
                Look look{.rate = rate, .integrator = kind};
                look.spp = 8;
                for (const render::Lod lod : {render::Lod::On, render::Lod::Frozen}) {
                    look.lod = lod;
                    lit += lit_pixels(room, look);
                    seen += look.width * look.height;
                }
                look.lod = render::Lod::Off;
                EXPECT_EQ(lit_pixels(room, look), 0) << "width " << width << ", rate " << rate;
            }
    }
    EXPECT_LE(lit, seen / 2000);
}

/// Returns the number of lit pixels in a smooth room through whose ceiling a pillar goes that is a mesh.
int lit_pixels_beside_mesh(float width, float rate, Lod lod, IntegratorKind integrator)
{
    Scene scene;
    Material white;
    white.base_color = Vec4f(1);
    white.roughness = 1;
    Cage room, pillar;
    room.scheme = Scheme::CatmullClark;
    pillar.scheme = Scheme::Triangles;
    room.materials = pillar.materials = {scene.add(white)};
    room.positions = corners_between(Vec3f(-1), Vec3f(1));
    pillar.positions = corners_between({0.3f - width, 0.3f, 0.3f - width}, {0.3f + width, 1.1f, 0.3f + width});
    for (const auto& face : kFacesOfCube) {
        room.face_sizes.push_back(4);
        room.face_vertices.insert(room.face_vertices.end(), face.begin(), face.end());
        for (const int corner : {0, 1, 2, 0, 2, 3}) pillar.face_vertices.push_back(face[std::size_t(corner)]);
    }
    NodeDesc desc;
    desc.cages = {scene.add(room), scene.add(pillar)};
    scene.add_node(scene.root(), desc);
    scene.environment.radiance = Vec3f(1000);
    const Camera camera = Camera::look_at({-0.3, 0, -0.3}, {0.3, 0.6, 0.3}, {0, 1, 0}, 1.5f);
    Settings settings{.width = 24, .height = 18, .spp = 8};
    settings.integrator = integrator;
    settings.bounces = 4;
    settings.shading_rate = rate;
    settings.lod = lod;
    const Image image = Renderer({.threads = 2}).render(scene, camera, settings);
    const std::vector<float>& pixels = image.find("beauty")->pixels;
    int lit = 0;
    for (std::size_t i = 0; i < pixels.size(); i += 4) lit += pixels[i] != 0 || pixels[i + 1] != 0 || pixels[i + 2] != 0;
    return lit;
}

/// A mesh has no levels, and the ceiling that it crosses has.
TEST(ClosedRooms, ThatMeshesCrossLetLittleLightIn)
{
    int lit = 0, pictures = 0;
    for (const float width : {0.02f, 0.1f})
        for (const float rate : {1.0f, 4.0f, 16.0f})
            for (const IntegratorKind kind : {IntegratorKind::Path, IntegratorKind::Ao}) {
                for (const Lod lod : {Lod::On, Lod::Frozen}) lit += lit_pixels_beside_mesh(width, rate, lod, kind);
                pictures += 2;
                EXPECT_EQ(lit_pixels_beside_mesh(width, rate, Lod::Off, kind), 0) << "width " << width << ", rate " << rate;
            }
    EXPECT_LE(lit, pictures * 24 * 18 / 2000);
}

}  // namespace
}  // namespace occam::test
