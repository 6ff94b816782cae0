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

// Edges beside a pole are longer than their level says. With margins as short as elsewhere, hundreds of pixels are lit.
TEST(ClosedRooms, AreDarkBesidePoles)
{
    for (const std::uint32_t faces : {12u, 50u})
        for (const double away : {0.02, 0.005}) {
            Room room{"a spindle with poles of " + std::to_string(faces) + " faces", spindle(faces)};
            const DicedCage diced(room.cage, 0);
            lod::PatchSurface surface;
            const Vec3d pole(lod::OwnedCurves(surface).vertex_point(diced.posed, 0, lod::kFinestLevel - 1));
            room.eye = pole + diced.posed.anchor + away * Vec3d(0.0003, -1, 0.0001);
            room.target = pole + diced.posed.anchor + away * Vec3d(0.1, 0, 0.05);
            for (const float rate : {1.0f, 4.0f}) expect_dark(room, {.rate = rate, .width = 48, .height = 48});
        }
}

}  // namespace
}  // namespace occam::test
