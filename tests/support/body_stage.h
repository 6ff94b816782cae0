// A stage for tests of bodies that absorb light: their pictures have closed forms by Beer-Lambert.
#pragma once

#include <gtest/gtest.h>
#include <occam/occam.h>

#include <cmath>

#include "tests/support/shape_builders.h"

namespace occam::test {

/// Returns the share that kWater leaves of the light in each channel after a way of one world length.
inline constexpr Vec3f kWater{0.5f, 0.25f, 0.8f};

/// Returns a body that leaves that share of the light after a way of one world length, and all of it at its boundary if it
/// does not bend light.
inline Material body_of(float ior, Vec3f color = kWater)
{
    Material m;
    m.roughness = 0;
    m.transmission = 1;
    m.thickness = 1;
    m.ior = ior;
    m.attenuation_color = color;
    m.attenuation_distance = 1;
    return m;
}

/// Returns a material that scatters light by its base alone.
inline Material matte_of(float color)
{
    Material m;
    m.base_color = Vec4f(color, color, color, 1);
    m.specular = 0;
    m.roughness = 1;
    return m;
}

/// Returns a material that shines and reflects nothing.
inline Material shining(float radiance)
{
    Material m = matte_of(0);
    m.emission = Vec3f(radiance);
    return m;
}

/// Returns what is left of the light after that way.
inline Vec3f left_after(double way, Vec3f color = kWater)
{
    Vec3f left;
    for (int c = 0; c < 3; ++c) left[c] = float(std::pow(double(color[c]), way));
    return left;
}

inline void expect_close(Vec3f found, Vec3f expected, double tolerance, const char* what = "")
{
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(found[c], expected[c], tolerance * double(expected[c])) << what << ", channel " << c;
}

/// Calls test(size, hand) for worlds of very different sizes, as they are and mirrored.
template <class Test>
void for_sizes_and_hands(const Test& test)
{
    for (const double size : {3e-7, 1.0, 1e7})
        for (const double hand : {1.0, -1.0}) test(size, hand);
}

struct BodyStage {
    Scene scene;
    Settings settings{.width = 4, .height = 4, .spp = 16, .sky = shade::Sky::Off};

    NodeId put(Cage cage, const Material& material, Vec3d at = Vec3d(0), Vec3d scale = Vec3d(1))
    {
        cage.materials = {scene.add(material)};
        NodeDesc desc;
        desc.place.translation = at;
        desc.place.scale = scale;
        desc.cages = {scene.add(std::move(cage))};
        return scene.add_node(scene.root(), desc);
    }
    /// Adds a light that shines downwards.
    NodeId put(const Light& light, Vec3d at = Vec3d(0))
    {
        NodeDesc desc;
        desc.place.translation = at;
        desc.place.rotation = {-0.7071067811865476, 0, 0, 0.7071067811865476};
        desc.light = scene.add(light);
        return scene.add_node(scene.root(), desc);
    }
    /// Returns the mean of all pixels.
    Vec3f seen(const Camera& camera)
    {
        Renderer renderer({.threads = 1});
        const Image image = renderer.render(scene, camera, settings);
        const auto& pixels = image.find("beauty")->pixels;
        Vec3d sum(0);
        for (std::size_t i = 0; i < pixels.size(); i += 4) sum += Vec3d(pixels[i], pixels[i + 1], pixels[i + 2]);
        EXPECT_EQ(renderer.stats().image.samples_not_finite, 0u);
        return Vec3f(sum * (4.0 / double(pixels.size())));
    }
    /// Returns what a camera sees that looks straight down from there, in a narrow view.
    Vec3f seen_from(Vec3d eye) { return seen(Camera::look_at(eye, eye - Vec3d(0, 1, 0), {0, 0, -1}, 0.001f)); }
};

}  // namespace occam::test
