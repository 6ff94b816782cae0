// Tests of frames in which something moves: what they count, and what does not depend on how they are traced.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include <algorithm>
#include <cmath>

#include "tests/support/displaced_cages.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

// Four million placements of a mesh, by instances of instances, are no placements of the one displaced cage that moves.
TEST(MovingFrames, CountPlacementsOfDisplacedCagesAlone)
{
    Scene scene;
    NodeId below = scene.add_node(scene.root(), {.cages = {scene.add(torus_mesh(8, 6))}, .visible = false});
    for (int level = 0; level < 22; ++level) {
        const NodeId pair = scene.add_node(scene.root(), {.visible = false});
        const double apart = 3.0 * (1 << level / 2);
        for (const Vec3d at : {Vec3d(0), level % 2 > 0 ? Vec3d(0, 0, apart) : Vec3d(apart, 0, 0)}) {
            NodeDesc desc;
            desc.place.translation = at;
            desc.instance_of = below;
            scene.add_node(pair, desc);
        }
        below = pair;
    }
    NodeDesc top;
    top.instance_of = below;
    scene.add_node(scene.root(), top);
    const DisplacedCage displaced = displaced_case(0);
    Cage cage = displaced.cage;
    TextureUse& use = cage.displacement->texture;
    use.texture = scene.add(Texture(displaced.scene.texture(use.texture)));
    const NodeId moving = place(scene, scene.add(cage), {0, 5, 0});
    scene.record_shutter(1, [&](double time) { scene.set_transform(moving, Trs{.translation = {time, 5, 0}}); });
    Settings settings{.width = 16, .height = 12, .spp = 1};
    settings.view = render::View::Normal;
    settings.shutter = {0, 0.5f};
    Renderer renderer({.threads = 1});
    EXPECT_NO_THROW(renderer.render(scene, Camera::look_at({0, 8, 9}, {0, 3, 0}, {0, 1, 0}, 0.8f), settings));
}

// A cage that moves fast has a finest level, and its patches may share an igrid from a finer one on.
TEST(MovingFrames, ShowTheSameMicropolygonsInEachTree)
{
    Scene scene;
    const NodeId node = place(scene, scene.add(torus(400, 160, false)), {0, 0, 0});
    scene.record_shutter(1, [&](double time) { scene.set_transform(node, Trs{.translation = {time - 0.5, 0, 0}}); });
    const Camera camera = Camera::look_at({0, 1.5, 4.8}, {0, 0, 0}, {0, 1, 0}, 0.8f);
    Settings settings{.width = 64, .height = 48, .spp = 2, .shading_rate = 0.16f};
    settings.view = render::View::Grid;
    settings.shutter = {0, 0.5f};
    const auto picture = [&](const Resources& resources) {
        return Renderer(resources).render(scene, camera, settings).layers()[0].pixels;
    };
    const std::vector<float> boxes = picture({.threads = 1, .tree = TreeKind::Bvh});
    EXPECT_EQ(boxes, picture({.threads = 1, .tree = TreeKind::Kd}));
    EXPECT_EQ(boxes, picture({.threads = 2, .workers_a_tree = 0, .tree = TreeKind::Bvh}));
}

// A morph target that rests changes nothing of how a displaced cage turns.
TEST(MovingFrames, FollowDisplacedCagesWithTargetsAsTheyFollowOthers)
{
    const auto segments = [](float bound, bool has_target) {
        Scene scene;
        Cage cage = torus();
        cage.uv_sets = {{std::vector<Vec2f>(cage.positions.size(), Vec2f(0.3f)), {}}};
        Texture texture;
        texture.role = TextureRole::Data;
        texture.width = texture.height = 1;
        texture.pixels = {Vec4f(1)};
        Displacement displacement;
        displacement.texture.texture = scene.add(texture);
        displacement.scale = displacement.bound = bound;
        displacement.midlevel = 0;
        cage.displacement = displacement;
        if (has_target) cage.morph_targets = {{"rests", std::vector<Vec3f>(cage.positions.size(), Vec3f(0, 0.01f, 0)), {}}};
        const NodeId node = place(scene, scene.add(cage), {0, 0, 0});
        const auto turn = [&](double time) {
            scene.set_transform(node,
                                Trs{.rotation = {0, 0, std::sin(0.2 * time), std::cos(0.2 * time)}, .scale = Vec3d(0.1)});
        };
        const Camera camera = Camera::look_at({0, 0, 8}, {0, 0, 0}, {0, 1, 0}, 0.7f);
        record_shutter(
            scene, turn, [&] { return camera; }, 720);
        return scene.shutter_segments();
    };
    for (const float bound : {1.0f, 3.0f, 9.0f}) EXPECT_EQ(segments(bound, true), segments(bound, false)) << bound;
    EXPECT_GT(segments(9, true), segments(0, true)) << "the bound does count";
}

}  // namespace
}  // namespace occam::test
