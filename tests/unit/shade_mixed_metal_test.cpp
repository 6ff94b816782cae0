// Tests of surfaces that are metal in part: they are as bright as their parts together.
#include <gtest/gtest.h>

#include "shade/surface.h"
#include "tests/support/campaign.h"
#include "tests/support/furnace.h"
#include "tests/support/statistics.h"

namespace occam::shade {
namespace {

using test::direction;
using test::furnace;
using test::kWhite;

constexpr float kRoughnesses[] = {0.0f, 0.3f, 0.7f, 1.0f};
constexpr float kCosines[] = {0.05f, 0.4f, 1.0f};

Material material_of(float metallic, float roughness, float color = 1)
{
    Material m;
    m.base_color = Vec4f(Vec3f(color), 1);
    m.metallic = metallic;
    m.roughness = roughness;
    return m;
}

Surface surface_of(const Material& m, float cos_eye, bool back_side = false)
{
    static const TextureStore textures(1 << 20);
    ShadePoint p;
    p.material = &m;
    p.to_eye = direction(cos_eye, 0.7f);
    p.axes.along = {1, 0, 0};
    p.back_side = back_side;
    return evaluate(p, textures);
}

double brightness(const Material& m, float cos_eye)
{
    const Surface s = surface_of(m, cos_eye);
    return furnace(s, 24'000, 1) + double(s.transmittance.x);
}

TEST(MixedMetals, ReflectAllOfAUniformSkyIfTheyAreWhite)
{
    test::EveryNth some(4);
    for (const float roughness : kRoughnesses)
        for (const float cos_eye : kCosines)
            for (const float metallic : {0.0f, 0.1f, 0.3f, 0.5f, 0.7f, 0.9f, 1.0f}) {
                if (!some.takes()) continue;
                Material m = material_of(metallic, roughness);
                EXPECT_NEAR(furnace(surface_of(m, cos_eye)), 1, kWhite) << roughness << ' ' << cos_eye << ' ' << metallic;
                m.clearcoat = 0.7f;
                m.clearcoat_roughness = 0.4f;
                EXPECT_NEAR(furnace(surface_of(m, cos_eye)), 1, kWhite)
                    << roughness << ' ' << cos_eye << ' ' << metallic << ", coated";
            }
}

// Texels and values between vertices are rounded, so that a metal may be glass by a ten-millionth.
TEST(MixedMetals, KeepTheirStrokesIfHardlyAnyOfThemIsGlass)
{
    const auto strokes_of = [](float metallic) {
        Material m = material_of(metallic, 0.3f);
        m.transmission = 1;
        m.anisotropy = 0.8f;
        return surface_of(m, 0.8f);
    };
    const Surface metal = strokes_of(1), nearly = strokes_of(0.9999999f), half = strokes_of(0.5f);
    EXPECT_GT(metal.alpha_along, 3 * metal.alpha_across);
    EXPECT_NEAR(nearly.alpha_along, metal.alpha_along, 1e-4f);
    EXPECT_EQ(half.tangent, Vec3f(0));
}

// Strokes fade until a thirty-second of the surface is glass.
TEST(MixedMetals, LoseNoLightWhereTheirStrokesFade)
{
    for (const float roughness : {0.2f, 0.5f})
        for (const float thickness : {0.0f, 1.0f})
            for (const float glass : {0.005f, 0.01f, 0.02f, 0.03f})
                for (const float cos_eye : kCosines) {
                    Material m = material_of(1 - glass, roughness);
                    m.transmission = 1;
                    m.thickness = thickness;
                    m.anisotropy = 1;
                    EXPECT_NEAR(furnace(surface_of(m, cos_eye)), 1, kWhite)
                        << roughness << ' ' << thickness << ' ' << glass << ' ' << cos_eye;
                }
}

/// Whatever the colours of the parts and what lies over them, the mix is the mean of the dielectric and the metal.
TEST(MixedMetals, AreAsBrightAsTheirPartsTogether)
{
    const auto with = [](Material m, int what) {
        if (what == 1) m.clearcoat = 1;
        if (what == 2) m.sheen_color = Vec3f(0.6f), m.sheen_roughness = 0.5f;
        if (what == 3) m.specular = 0.5f, m.ior = 2;
        if (what == 4) m.transmission = 0.6f;
        if (what == 5) m.transmission = 0.6f, m.thickness = 1;
        if (what == 6) m.transmission = 0.6f, m.thickness = 1, m.ior = 1;
        if (what == 7) m.anisotropy = 0.8f;
        return m;
    };
    test::EveryNth some(5);
    for (int what = 0; what <= 7; ++what)
        for (const float roughness : {0.0f, 0.5f, 1.0f})
            for (const float cos_eye : {0.1f, 0.8f})
                for (const float color : {0.3f, 1.0f}) {
                    if (!some.takes()) continue;
                    const auto of = [&](float metallic) {
                        return brightness(with(material_of(metallic, roughness, color), what), cos_eye);
                    };
                    const double dielectric = of(0), metal = of(1);
                    EXPECT_NEAR(of(0.4f), 0.6 * dielectric + 0.4 * metal, 2 * kWhite)
                        << "kind " << what << ", roughness " << roughness << ", cosine " << cos_eye << ", colour " << color;
                }
}

/// Draws a white material of any mix of what scatters light without loss, with a third of all parts absent or alone.
Material white_mix(test::Numbers& numbers)
{
    const auto part = [&] {
        const float kind = numbers.one(), value = numbers.one();
        return kind < 0.2f ? 0.0f : kind < 0.33f ? 1.0f : value;
    };
    const float metallic = part();
    Material m = material_of(metallic, part());
    m.specular = part();
    m.ior = 1 + 2 * part();
    m.transmission = part();
    m.thickness = numbers.one() < 0.5f ? 0.0f : 1.0f;
    m.clearcoat = part();
    m.clearcoat_roughness = part();
    return m;
}

TEST(MixedMetals, OfEveryOtherMixLoseNoLight)
{
    test::Numbers numbers(8);
    for (int i = 0; i < (test::is_long() ? 400 : 100); ++i) {
        const Material m = white_mix(numbers);
        const float cos_eye = 0.02f + 0.98f * numbers.one();
        const Surface s = surface_of(m, cos_eye, i % 3 == 0);
        const double straight = double(s.transmittance.x);
        // Where nearly all light passes straight on, the rest is too little to need many samples.
        const double white = straight > 0 ? furnace(s, 64'000, 1) : furnace(s);
        EXPECT_NEAR(white + straight, 1, kWhite)
            << "metallic " << m.metallic << ", roughness " << m.roughness << ", specular " << m.specular << ", ior " << m.ior
            << ", transmission " << m.transmission << ", thickness " << m.thickness << ", coat " << m.clearcoat
            << " of roughness " << m.clearcoat_roughness << ", cosine " << cos_eye << (i % 3 == 0 ? ", from behind" : "");
    }
}

}  // namespace
}  // namespace occam::shade
