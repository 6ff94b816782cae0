// Tests of maps of occlusion: how much ambient light they leave, and that they do not change traced light; and of maps of
// transmission beyond their range.
#include <gtest/gtest.h>

#include "tests/support/campaign.h"
#include "tests/support/shape_builders.h"
#include "tests/support/textured_floor.h"

namespace occam::test {
namespace {

/// Returns a material whose map leaves a quarter of the light in one half of the floor and all of it in the other, with a
/// strength of four fifths.
Material half_occluded(Scene& scene)
{
    Material m;
    m.occlusion_texture.texture = scene.add(
        texture_of([](float x, float) { return Vec4f(x < kTexels / 2 ? 0.25f : 1, 0, 0, 1); }));
    m.occlusion_strength = 0.8f;
    return m;
}

/// Returns the first channel of a layer in a pixel that shows the floor's left or right half.
float value(const Image& image, const char* layer, bool is_right)
{
    const Layer* found = image.find(layer);
    const std::size_t pixel = std::size_t(image.height / 2) * std::size_t(image.width) +
                              std::size_t(image.width * (is_right ? 5 : 3) / 8);
    return found->pixels[pixel * found->channels.size()];
}

TEST(Occlusion, DimsAmbientLightByItsStrength)
{
    for (const Scheme scheme : {Scheme::Bilinear, Scheme::Triangles})
        for (const render::ShadeAt at : {render::ShadeAt::Hit, render::ShadeAt::Vertex}) {
            TexturedFloor world(scheme, half_occluded);
            const Image image = world.picture({.integrator = IntegratorKind::Ao, .shade_at = at, .aovs = Aov::Occlusion});
            for (const char* layer : {"beauty", "occlusion"}) {
                EXPECT_NEAR(value(image, layer, false), 1 + 0.8f * (0.25f - 1), 2e-3f) << layer;
                EXPECT_NEAR(value(image, layer, true), 1, 2e-3f) << layer;
            }
        }
}

// Texels of files of floats may be above 1.
TEST(Occlusion, IsBetweenNoneAndAllWhateverItsTexelsAre)
{
    for (const float texel : {0.0f, 3.0f})
        for (const render::ShadeAt at : {render::ShadeAt::Hit, render::ShadeAt::Vertex}) {
            TexturedFloor world(Scheme::Bilinear, [&](Scene& scene) {
                Material m;
                m.occlusion_texture.texture = scene.add(texture_of([&](float, float) { return Vec4f(texel); }));
                return m;
            });
            const Image image = world.picture({.integrator = IntegratorKind::Ao, .shade_at = at, .aovs = Aov::Occlusion});
            for (const char* layer : {"beauty", "occlusion"})
                EXPECT_NEAR(value(image, layer, false), texel > 0 ? 1 : 0, 1e-5f) << layer;
        }
}

// A surface lets no more than all light through.
TEST(Transmission, OfTexelsAboveOneIsThatOfOne)
{
    EveryNth some(3);
    for (const float roughness : {0.0f, 0.5f})
        for (const float thickness : {0.0f, 1.0f}) {
            if (!some.takes()) continue;
            std::uint64_t sums[2];
            for (const int k : {0, 1}) {
                TexturedFloor world(Scheme::Bilinear, [&](Scene& scene) {
                    Material m;
                    m.transmission = 1;
                    m.thickness = thickness;
                    m.roughness = roughness;
                    m.transmission_texture.texture = scene.add(
                        texture_of([&](float, float) { return Vec4f(k ? 3.0f : 1.0f); }));
                    return m;
                });
                place(world.scene, world.scene.add(floor_of(world.scene.add(Material()), Scheme::Triangles)), {0, -1, 0}, 2);
                sums[k] = world.picture({.spp = 2, .shade_at = render::ShadeAt::Hit}).checksum();
            }
            EXPECT_EQ(sums[0], sums[1]) << "roughness " << roughness << ", thickness " << thickness;
        }
}

TEST(Occlusion, LeavesTracedLightAsItIs)
{
    TexturedFloor with(Scheme::Bilinear, half_occluded), without(Scheme::Bilinear, [](Scene&) { return Material(); });
    for (const IntegratorKind kind : {IntegratorKind::Direct, IntegratorKind::Path}) {
        const Settings settings{.integrator = kind};
        EXPECT_EQ(with.picture(settings).checksum(), without.picture(settings).checksum());
    }
    const Image layers = with.picture({.aovs = Aov::Occlusion});
    EXPECT_NEAR(value(layers, "occlusion", false), 0.4f, 2e-3f) << "but tells the compositor";
}

TEST(Occlusion, OfUnlitMaterialsIsNone)
{
    TexturedFloor world(Scheme::Bilinear, [](Scene& scene) {
        Material m = half_occluded(scene);
        m.unlit = true;
        return m;
    });
    EXPECT_EQ(value(world.picture({.aovs = Aov::Occlusion}), "occlusion", false), 1);
}

}  // namespace
}  // namespace occam::test
