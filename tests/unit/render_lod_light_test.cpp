// Tests that light converges to the same picture with level of detail on and off: the difference falls with the shading
// rate.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include "render/compare.h"
#include "tests/support/campaign.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

struct Effect {
    const char* name;
    IntegratorKind integrator;
    bool has_lamp;
};

Scene stage_of(const Effect& effect)
{
    Scene scene;
    Material material;
    material.metallic = effect.has_lamp ? 0.0f : 1.0f;
    material.roughness = effect.has_lamp ? 1 : 0.3f;
    Cage ring = torus(12, 6), floor;
    floor.positions = {{-4, 0, -4}, {-4, 0, 4}, {4, 0, 4}, {4, 0, -4}};
    floor.face_vertices = {0, 1, 2, 3};
    floor.face_sizes = {4};
    floor.materials = ring.materials = {scene.add(material)};
    place(scene, scene.add(std::move(floor)), {0, 0, 0});
    place(scene, scene.add(std::move(ring)), {0, 0.6, 0});
    if (effect.has_lamp) {
        NodeDesc lamp;
        lamp.place.translation = {1, 4, 1};
        lamp.place.rotation = {-0.7071067811865476, 0, 0, 0.7071067811865476};
        lamp.light = scene.add(Light{"lamp", AreaLight{AreaLight::Shape::Rectangle, Vec2f(2), Vec3f(6)}});
        scene.add_node(scene.root(), lamp);
    } else {
        scene.environment.radiance = Vec3f(1);
    }
    return scene;
}

// Both pictures use the same random numbers, so that most noise cancels out.
TEST(LodLight, ConvergesToThePictureOfOneFineLevel)
{
    for (const Effect& effect :
         {Effect{"soft shadow", IntegratorKind::Direct, true}, Effect{"ambient occlusion", IntegratorKind::Ao, false},
          Effect{"glossy", IntegratorKind::Path, false}}) {
        Scene scene = stage_of(effect);
        const Camera camera = Camera::look_at({2.5, 2.2, 4}, {0, 0.4, 0}, {0, 1, 0}, 0.7f);
        Renderer renderer({.threads = 2});
        const auto picture = [&](render::Lod lod, float rate) {
            const Settings settings{.width = is_long() ? 64 : 48,
                                    .height = is_long() ? 48 : 36,
                                    .spp = is_long() ? 64 : 32,
                                    .integrator = effect.integrator,
                                    .bounces = 3,
                                    .shading_rate = rate,
                                    .lod = lod};
            return renderer.render(scene, camera, settings);
        };
        const Image fine = picture(render::Lod::Off, 0.25f);
        const auto difference = [&](float rate) {
            return render::compare(picture(render::Lod::On, rate), fine, "beauty").rmse;
        };
        const double coarse = difference(8), middle = difference(2), small = difference(0.5f);
        EXPECT_LT(middle, coarse) << effect.name;
        EXPECT_LT(small, middle) << effect.name;
        EXPECT_LT(small, 0.5 * coarse) << effect.name << ' ' << coarse << ' ' << middle << ' ' << small;
    }
}

}  // namespace
}  // namespace occam::test
