// Tests of pictures in which the backs of single-sided surfaces are hidden: they are as if these backs were not there.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/support/shape_builders.h"
#include "tests/support/textured_floor.h"

namespace occam::test {
namespace {

Material plain(Vec3f color)
{
    Material m;
    m.base_color = Vec4f(color, 1);
    m.unlit = true;
    return m;
}

// Returns the faces of a cage with their corners the other way round.
std::vector<std::uint32_t> turned(const Cage& cage)
{
    std::vector<std::uint32_t> corners = cage.face_vertices;
    const auto sides = static_cast<std::ptrdiff_t>(cage.scheme == Scheme::Triangles ? 3 : 4);
    for (auto face = corners.begin(); face != corners.end(); face += sides) std::reverse(face, face + sides);
    return corners;
}

struct Sheet {
    Scheme scheme;
    bool is_one_mesh;
    bool moves = false;
};

// Holds a sheet of two surfaces in one place: its red side is seen from above, its green side from below.
struct TwoFaced {
    explicit TwoFaced(const Sheet& sheet)
    {
        const MaterialId red = scene.add(plain({1, 0, 0})), green = scene.add(plain({0, 1, 0}));
        Cage upper = floor_of(red, sheet.scheme), lower = floor_of(green, sheet.scheme);
        lower.face_vertices = turned(upper);
        lower.uv_sets.clear();
        upper.uv_sets.clear();
        std::vector<Cage> cages{upper, lower};
        if (sheet.is_one_mesh) {
            const std::size_t faces = upper.face_count();
            upper.face_vertices.insert(upper.face_vertices.end(), lower.face_vertices.begin(), lower.face_vertices.end());
            upper.face_sizes.insert(upper.face_sizes.end(), lower.face_sizes.begin(), lower.face_sizes.end());
            upper.materials = {red, green};
            upper.face_slots.assign(faces, 0);
            upper.face_slots.resize(2 * faces, 1);
            cages = {upper};
        }
        for (Cage& cage : cages) {
            NodeDesc desc;
            desc.cages = {scene.add(std::move(cage))};
            nodes.push_back(scene.add_node(scene.root(), desc));
        }
        if (sheet.moves)
            scene.record_shutter(2, [&](double tau) {
                for (const NodeId id : nodes)
                    scene.set_transform(id, Trs{.translation = {0.1 * tau, 0.2 * tau, 0}}.matrix());
            });
    }
    Image picture(accel::TreeKind tree, double height, int threads)
    {
        const Settings settings{
            .width = 12, .height = 12, .spp = 4, .sky = shade::Sky::Off, .back_faces = false, .background = false};
        const Camera camera = Camera::look_at({0.1, height, 0.2}, {0.1, 0, 0.2}, {0, 0, -1}, 0.5f);
        return Renderer({.threads = threads, .tree = tree}).render(scene, camera, settings);
    }

    Scene scene;
    std::vector<NodeId> nodes;
};

TEST(BackFaces, OfTwoSurfacesInOnePlaceEachIsSeenFromItsFront)
{
    for (const Sheet& sheet :
         {Sheet{Scheme::Triangles, true}, Sheet{Scheme::Triangles, false}, Sheet{Scheme::CatmullClark, false},
          Sheet{Scheme::Bilinear, false}, Sheet{Scheme::Triangles, true, true}, Sheet{Scheme::CatmullClark, false, true}}) {
        TwoFaced world(sheet);
        for (const accel::TreeKind tree : {accel::TreeKind::Kd, accel::TreeKind::Bvh})
            for (const double height : {3.0, -3.0}) {
                const std::string what = "scheme " + std::to_string(int(sheet.scheme)) +
                                         (sheet.is_one_mesh ? ", one mesh" : "") + (sheet.moves ? ", moving" : "") +
                                         ", tree " + std::to_string(int(tree)) + ", from " + std::to_string(height);
                const Image picture = world.picture(tree, height, 1);
                const std::vector<float>& seen = picture.find("beauty")->pixels;
                for (std::size_t i = 0; i < seen.size(); i += 4) {
                    ASSERT_EQ(seen[i], height > 0 ? 1 : 0) << what << ", pixel " << i / 4;
                    ASSERT_EQ(seen[i + 1], height > 0 ? 0 : 1) << what << ", pixel " << i / 4;
                    ASSERT_EQ(seen[i + 3], 1) << what << ", pixel " << i / 4;
                }
                EXPECT_EQ(picture.checksum(), world.picture(tree, height, 2).checksum()) << what;
            }
    }
}

// Adds sheets over one another.
std::vector<NodeId> add_sheets(Scene& scene, Scheme scheme, Vec3d at, double size, bool face_up)
{
    Cage sheet = floor_of(scene.add(Material()), scheme);
    if (!face_up) sheet.face_vertices = turned(sheet);
    sheet.uv_sets.clear();
    const CageId cage = scene.add(sheet);
    std::vector<NodeId> sheets;
    for (int k = 0; k < 3; ++k) sheets.push_back(place(scene, cage, at + Vec3d(0.01, 0.02, 0) * double(k), size));
    return sheets;
}

// What only rays from behind come to may be there or not. Random numbers are those of the picture without it, too.
TEST(BackFaces, ThatAreHiddenChangeNoBit)
{
    for (const Scheme scheme : {Scheme::Triangles, Scheme::CatmullClark})
        for (const bool is_below_lamp : {true, false}) {
            TexturedFloor world(Scheme::Triangles, [](Scene&) { return Material(); });
            // Scattered rays and shadow rays go up to the lamp. Camera rays go down, and nothing comes back to the camera.
            const std::vector<NodeId> sheets = is_below_lamp ? add_sheets(world.scene, scheme, {0.5, 2.6, 0.5}, 0.9, true)
                                                             : add_sheets(world.scene, scheme, {0, 2.2, 2.65}, 0.2, false);
            const Settings settings{.integrator = is_below_lamp ? IntegratorKind::Path : IntegratorKind::Direct,
                                    .back_faces = false};
            const Image through = world.picture(settings);
            const FrameStats with = world.stats;
            for (const NodeId id : sheets) world.scene.set_visible(id, false);
            const Image without = world.picture(settings);
            EXPECT_EQ(through.checksum(), without.checksum()) << int(scheme) << is_below_lamp;
            EXPECT_EQ(with.rays.primary, world.stats.rays.primary);
            EXPECT_EQ(with.rays.shadow, world.stats.rays.shadow);
        }
}

}  // namespace
}  // namespace occam::test
