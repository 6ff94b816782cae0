// Tests of BSDFs: white furnaces, reciprocity and chi-square tests.
#include "shade/bsdf.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "shade/albedo_table.h"
#include "tests/support/campaign.h"
#include "tests/support/furnace.h"
#include "tests/support/statistics.h"

namespace occam::shade {
namespace {

using test::direction;
using test::furnace;
using test::kWhite;
using test::Mean;
using test::Numbers;

constexpr float kAlphas[] = {kMinAlpha, 0.01f, 0.1f, 0.3f, 0.6f, 1.0f};
constexpr float kCosines[] = {0.01f, 0.05f, 0.3f, 0.7f, 1.0f};

Surface surface_of(float alpha, Vec3f diffuse, Vec3f f0, float cos_eye)
{
    Surface s;
    s.alpha = alpha;
    s.diffuse = diffuse;
    s.f0 = f0;
    s.dielectric_f0 = std::max({f0.x, f0.y, f0.z});
    s.to_eye = direction(cos_eye);
    return s;
}

Surface glass_of(float alpha, float eta, float cos_eye)
{
    Surface s = surface_of(alpha, Vec3f(0), Vec3f(0.04f), cos_eye);
    s.transmission = Vec3f(1);
    s.is_solid = true;
    s.eta = eta;
    return s;
}

Surface pane_of(float alpha, float cos_eye)
{
    Surface s = surface_of(alpha, Vec3f(0), Vec3f(0.04f), cos_eye);
    s.transmission = Vec3f(0.8f);
    return s;
}

TEST(Bsdf, AWhiteMetalReflectsAllOfAUniformSky)
{
    for (const float alpha : kAlphas)
        for (const float cos_eye : kCosines)
            EXPECT_NEAR(furnace(surface_of(alpha, Vec3f(0), Vec3f(1), cos_eye)), 1, kWhite) << alpha << ' ' << cos_eye;
}

TEST(Bsdf, AWhiteBaseUnderALayerReflectsAllOfAUniformSky)
{
    for (const float alpha : kAlphas)
        for (const float cos_eye : kCosines)
            for (const float f0 : {0.0f, 0.04f, 0.3f})
                EXPECT_NEAR(furnace(surface_of(alpha, Vec3f(1), Vec3f(f0), cos_eye)), 1, kWhite)
                    << alpha << ' ' << cos_eye << ' ' << f0;
}

TEST(Bsdf, AWhiteSurfaceUnderACoatReflectsAllOfAUniformSky)
{
    test::EveryNth some(7);
    for (const float alpha : kAlphas)
        for (const float coat_alpha : {kMinAlpha, 0.3f, 1.0f})
            for (const float cos_eye : kCosines)
                for (const float metal : {0.0f, 1.0f}) {
                    if (!some.takes()) continue;
                    Surface s = surface_of(alpha, Vec3f(1 - metal), Vec3f(metal > 0 ? 1.0f : 0.04f), cos_eye);
                    s.coat = 0.8f;
                    s.coat_alpha = coat_alpha;
                    EXPECT_NEAR(furnace(s), 1, kWhite) << alpha << ' ' << coat_alpha << ' ' << cos_eye << ' ' << metal;
                }
}

TEST(Bsdf, GlassOfAnyRoughnessAndIndexLosesNothing)
{
    for (const float alpha : kAlphas)
        for (const float cos_eye : kCosines)
            for (const float eta : {1.01f, 1.5f, 2.4f, 1 / 1.5f}) {
                Surface s = glass_of(alpha, eta, cos_eye);
                EXPECT_NEAR(furnace(s), 1, kWhite) << alpha << ' ' << eta << ' ' << cos_eye;
                s.solid_share = 0.4f;
                s.diffuse = Vec3f(1);
                EXPECT_NEAR(furnace(s), 1, kWhite) << alpha << ' ' << eta << ' ' << cos_eye << ", glass in part";
            }
}

TEST(Bsdf, ARoughPaneLosesNothing)
{
    test::EveryNth some(7);
    for (const float alpha : kAlphas)
        for (const float cos_eye : kCosines)
            for (const float f0 : {0.0f, 0.04f, 0.3f}) {
                if (!some.takes()) continue;
                Surface s = pane_of(alpha, cos_eye);
                s.f0 = Vec3f(f0);
                s.dielectric_f0 = f0;
                s.transmission = Vec3f(1);
                EXPECT_NEAR(furnace(s), 1, kWhite) << alpha << ' ' << cos_eye << ' ' << f0;
                s.transmission = s.diffuse = Vec3f(0.5f);
                EXPECT_NEAR(furnace(s), 1, kWhite) << alpha << ' ' << cos_eye << ' ' << f0 << ", a pane in part";
            }
}

// Glass takes the place of a part of the base below the layer, so a white pane is as bright as the white surface without
// glass, also if it is metal in part.
TEST(Bsdf, APaneThatIsMetalInPartGainsNothing)
{
    const TextureStore textures(1 << 20);
    test::EveryNth some(3);
    for (const float roughness : {0.0f, 0.5f})
        for (const float transmission : {0.3f, 1.0f})
            for (const float metallic : {0.0f, 0.25f, 0.5f, 1.0f}) {
                if (!some.takes()) continue;
                Material m;
                m.metallic = metallic;
                m.roughness = roughness;
                ShadePoint p;
                p.material = &m;
                p.to_eye = direction(0.7f);
                const double opaque = furnace(evaluate(p, textures));
                m.transmission = transmission;
                const Surface s = evaluate(p, textures);
                EXPECT_NEAR(furnace(s) + double(s.transmittance.x), opaque, 2 * kWhite)
                    << roughness << ' ' << transmission << ' ' << metallic;
            }
}

// A normal map lies on a metal. Seen from every side of every slope, none of the eye's rays is lost below the facet.
TEST(Bsdf, AMappedNormalLeavesNoBlackRings)
{
    Material metal;
    metal.metallic = 1;
    const TextureStore textures(1 << 20);
    test::EveryNth some(7);
    for (const float roughness : {0.0f, 0.2f, 0.4f, 0.6f})
        for (const float slope : {0.1f, 0.5f, 0.8f, 1.2f, 1.5f})
            for (const float cos_eye : {0.1f, 0.4f, 0.8f, 1.0f})
                for (int turn = 0; turn < 4; ++turn) {
                    if (!some.takes()) continue;
                    metal.roughness = roughness;
                    ShadePoint p;
                    p.material = &metal;
                    p.to_eye = direction(cos_eye);
                    p.normal_geometric = {0, 0, 1};
                    p.normal_shading = direction(std::cos(slope), 1.04f * static_cast<float>(turn));
                    const double white = furnace(evaluate(p, textures), 8000, 1);
                    EXPECT_LT(white, 1.02);
                    if (roughness == 0) EXPECT_GT(white, 0.98) << slope << ' ' << cos_eye << ' ' << turn;
                    else EXPECT_GT(white, 0.5) << roughness << ' ' << slope << ' ' << cos_eye << ' ' << turn;
                }
}

// Seen from above with alpha = 1, D is 1 / pi, and the masking leaves the integral of c / (1 + c) over the cosine c, which
// is 1 - ln 2.
TEST(Bsdf, TheTableKnowsTheRoughestMetalFromAbove)
{
    EXPECT_NEAR(AlbedoTable::instance().at(1, 1).sum(), 1 - std::log(2.0), 1e-3);
    EXPECT_NEAR(AlbedoTable::instance().at(0.7f, kMinAlpha).sum(), 1, 1e-3);
}

TEST(Bsdf, ASurfaceWithoutReflectanceIsLambertian)
{
    Surface s = surface_of(0.5f, Vec3f(0.6f), Vec3f(0), 0.8f);
    s.dielectric_f90 = s.f90 = 0;
    EXPECT_NEAR(scatter(s, {0, 0, 1}).x, 0.6f / kPi, 1e-6f);
    EXPECT_NEAR(scatter(s, glm::normalize(Vec3f(0, 1, 1))).x, 0.6f / kPi * std::sqrt(0.5f), 1e-6f);
}

TEST(Bsdf, AMatteSurfaceIsWorkedOutShortlyToTheSameBits)
{
    Numbers numbers(11);
    for (int i = 0; i < 1000; ++i) {
        Surface s = surface_of(0.5f, Vec3f(0.6f, 0.3f, 0), Vec3f(0), 0.1f + 0.9f * numbers.one());
        s.dielectric_f90 = s.f90 = 0;
        s.normal = direction(0.9f, numbers.one());
        Surface shortly = s;
        shortly.is_matte = true;
        const Vec3f to_light = direction(2 * numbers.one() - 1, 6 * numbers.one());
        EXPECT_EQ(scatter(shortly, to_light), scatter(s, to_light));
        EXPECT_EQ(scatter_density(shortly, to_light), scatter_density(s, to_light));
        const float choice = numbers.one();
        const Vec2f square(numbers.one(), numbers.one());
        EXPECT_EQ(sample_scatter(shortly, choice, square).direction, sample_scatter(s, choice, square).direction);
        EXPECT_EQ(sample_scatter(shortly, choice, square).weight, sample_scatter(s, choice, square).weight);
    }
}

// f(a, b) = f(b, a) holds where the normals agree, except for coats and bodies, which keep all light instead.
TEST(Bsdf, IsReciprocal)
{
    Numbers numbers(5);
    for (int i = 0; i < 200; ++i) {
        const Vec3f a = direction(0.05f + 0.9f * numbers.one(), 6 * numbers.one()),
                    b = direction(0.05f + 0.9f * numbers.one(), 6 * numbers.one());
        Surface layered = surface_of(0.3f, Vec3f(0.5f), Vec3f(0.04f), 0.9f);
        layered.to_eye = a;
        const float ab = scatter(layered, b).x / b.z;
        layered.to_eye = b;
        EXPECT_NEAR(scatter(layered, a).x / a.z, ab, 1e-4f * ab);

        Surface metal = surface_of(0.9f, Vec3f(0), Vec3f(0.9f, 0.6f, 0.3f),
                                   0.9f);  // includes the lobe of multiple scattering
        metal.to_eye = a;
        const Vec3f from_a = scatter(metal, b) / b.z;
        metal.to_eye = b;
        const Vec3f from_b = scatter(metal, a) / a.z;
        for (int c : {0, 1, 2}) EXPECT_NEAR(from_a[c], from_b[c], 1e-4f * from_a[c]);

        Surface pane = pane_of(0.4f, 1);
        const Vec3f mirrored_b(b.x, b.y, -b.z), mirrored_a(a.x, a.y, -a.z);
        pane.to_eye = a;
        const float forward = scatter(pane, mirrored_b).x / b.z;
        pane.to_eye = b;
        EXPECT_NEAR(scatter(pane, mirrored_a).x / a.z, forward, 1e-4f * forward + 1e-6f);
    }
}

TEST(Bsdf, IsBlackBelowEitherHorizon)
{
    Surface s = surface_of(0.3f, Vec3f(0.5f), Vec3f(0.04f), 0.9f);
    EXPECT_EQ(scatter(s, {0, 0, -1}), Vec3f(0));
    s.normal = glm::normalize(Vec3f(1, 0, 1));
    EXPECT_EQ(scatter(s, glm::normalize(Vec3f(1, 0, -0.1f))), Vec3f(0)) << "above the shading normal's horizon only";
}

// Where the smooth normal faces the light but the light is at the facet's horizon, light fades out instead of ending in a
// line.
TEST(Bsdf, LightFadesTowardsTheFacetsHorizon)
{
    Surface s = surface_of(0.5f, Vec3f(0.8f), Vec3f(0), 1);
    s.f90 = s.dielectric_f90 = 0;
    s.normal = glm::normalize(Vec3f(0.3f, 0, 1));
    float before = 1;
    for (const float cosine : {0.3f, 0.2f, 0.1f, 0.03f, 0.003f}) {
        const float f = scatter(s, direction(cosine)).x;
        EXPECT_GT(f, 0);
        EXPECT_LT(f, before);
        before = f;
    }
    EXPECT_LT(before, 0.01f);
    s.normal = s.normal_geometric;
    EXPECT_NEAR(scatter(s, direction(0.1f)).x, 0.8f / kPi * 0.1f, 1e-6f) << "nothing fades where the normals agree";
}

struct Case {
    const char* name;
    std::function<Surface(float cos_eye)> make;
};

const Case kCases[] = {
    {"layer over base", [](float c) { return surface_of(0.15f, Vec3f(0.3f), Vec3f(0.5f), c); }},
    {"rough layer", [](float c) { return surface_of(0.6f, Vec3f(0.3f), Vec3f(0.5f), c); }},
    {"metal with multiple scattering", [](float c) { return surface_of(1, Vec3f(0), Vec3f(0.9f), c); }},
    {"coat with a normal of its own",
     [](float c) {
         Surface s = surface_of(0.5f, Vec3f(0.3f), Vec3f(0.5f), c);
         s.coat = 0.9f;
         s.coat_alpha = 0.3f;
         s.coat_normal = glm::normalize(Vec3f(0.2f, 0.1f, 1));
         return s;
     }},
    {"a coat alone, over black",
     [](float c) {
         Surface s = surface_of(1, Vec3f(0), Vec3f(0), c);
         s.dielectric_f90 = s.f90 = 0;
         s.coat = 1;
         s.coat_alpha = 0.4f;
         return s;
     }},
    {"rough pane", [](float c) { return pane_of(0.4f, c); }},
    {"into glass", [](float c) { return glass_of(0.3f, 1.5f, c); }},
    {"glass in part",
     [](float c) {
         Surface s = glass_of(0.6f, 1.5f, c);
         s.solid_share = 0.6f;
         s.diffuse = Vec3f(0.4f);
         return s;
     }},
    {"roughest glass", [](float c) { return glass_of(1, 1.3f, c); }},
    {"out of the roughest glass", [](float c) { return glass_of(1, 1 / 1.3f, c); }},
    {"roughest pane", [](float c) { return pane_of(1, c); }},
    {"out of glass", [](float c) { return glass_of(0.3f, 1 / 1.5f, c); }},
};

// The test covers eyes and lights down to the horizon, and normals that turn away from either.
TEST(Bsdf, IsFiniteAndNeverNegative)
{
    Numbers numbers(21);
    const auto is_good = [](Vec3f v) { return v.x >= 0 && v.y >= 0 && v.z >= 0 && std::isfinite(v.x + v.y + v.z); };
    for (const Case& c : kCases)
        for (const float alpha : kAlphas)
            for (const float cos_eye : {1e-7f, 1e-3f, 0.5f, 1.0f})
                for (int i = 0; i < 60; ++i) {
                    Surface s = c.make(cos_eye);
                    s.alpha = alpha;
                    if (i % 3 == 0) s.normal = glm::normalize(direction(numbers.one(), 6.2831853f * numbers.one()));
                    const float height = i % 2 ? 2 * numbers.one() - 1 : 1e-7f;
                    const Vec3f light = direction(height, 6.2831853f * numbers.one());
                    ASSERT_TRUE(is_good(scatter(s, light))) << c.name << ' ' << alpha << ' ' << cos_eye << ' ' << height;
                    ASSERT_TRUE(is_good(Vec3f(scatter_density(s, light))))
                        << c.name << ' ' << alpha << ' ' << cos_eye << ' ' << height;
                    const ScatterWithDensity both = scatter_with_density(s, light);
                    ASSERT_EQ(both.light, scatter(s, light)) << c.name << ' ' << alpha << ' ' << cos_eye;
                    ASSERT_EQ(both.density, scatter_density(s, light)) << c.name << ' ' << alpha << ' ' << cos_eye;
                    const float choice = numbers.one();
                    const ScatterSample sample = sample_scatter(s, choice, numbers.square());
                    ASSERT_TRUE(is_good(sample.weight)) << c.name << ' ' << alpha << ' ' << cos_eye;
                    ASSERT_TRUE(sample.weight == Vec3f(0) || std::fabs(glm::length(sample.direction) - 1) < 1e-4f) << c.name;
                }
}

TEST(Bsdf, SampledDirectionsFollowTheirDensity)
{
    for (const Case& c : kCases)
        for (const float cos_eye : {0.2f, 0.9f}) {
            const Surface s = c.make(cos_eye);
            const double excess = test::direction_excess(
                90'000, 12,
                [&](Numbers& n) {
                    const float choice = n.one();
                    return sample_scatter(s, choice, n.square()).direction;
                },
                [&](Vec3f d) { return scatter_density(s, d); });
            EXPECT_LT(excess, 4.5) << c.name << ", cosine " << cos_eye;
        }
}

TEST(Bsdf, ASamplesWeightIsWhatItScattersOverItsDensity)
{
    Numbers numbers(9);
    for (const Case& c : kCases) {
        const Surface s = c.make(0.6f);
        for (int i = 0; i < 200; ++i) {
            const float choice = numbers.one();
            const ScatterSample sample = sample_scatter(s, choice, numbers.square());
            if (sample.weight == Vec3f(0)) continue;
            EXPECT_EQ(sample.density, scatter_density(s, sample.direction)) << c.name;
            EXPECT_EQ(sample.weight, scatter(s, sample.direction) / sample.density) << c.name;
            EXPECT_LT(sample.weight.x, 1.5f) << c.name << ": no sample counts for many";
        }
    }
}

}  // namespace
}  // namespace occam::shade
