// Tests of sheen and brushed layers: white furnaces, reciprocity and chi-square tests.
#include "shade/sheen.h"

#include <gtest/gtest.h>

#include <cmath>

#include "shade/bsdf.h"
#include "shade/stroke_albedo.h"
#include "tests/support/furnace.h"
#include "tests/support/statistics.h"

namespace occam::shade {
namespace {

using test::direction;
using test::Mean;
using test::Numbers;

constexpr float kCosines[] = {0.05f, 0.3f, 0.7f, 1.0f};
constexpr float kRoughnesses[] = {0.0f, 0.2f, 0.5f, 1.0f};

Surface cloth(float roughness, Vec3f diffuse, float cos_eye)
{
    Surface s;
    s.diffuse = diffuse;
    s.f0 = Vec3f(0);
    s.f90 = s.dielectric_f0 = s.dielectric_f90 = 0;
    s.sheen = Vec3f(1);
    s.sheen_alpha = sheen_width(roughness);
    s.to_eye = direction(cos_eye);
    return s;
}

Surface brushed(float along, float across, float cos_eye, float angle = 0.5f)
{
    Surface s;
    s.f0 = Vec3f(1);
    s.dielectric_f0 = 1;
    s.tangent = {1, 0, 0};
    s.alpha_along = along;
    s.alpha_across = across;
    s.alpha = std::sqrt(along * across);
    s.to_eye = direction(cos_eye, angle);
    return s;
}

// Returns the radiance towards the eye under a uniform sky of radiance 1.
Mean furnace(const Surface& s)
{
    Numbers numbers(3);
    Mean mean;
    for (int i = 0; i < 20'000; ++i) {
        const float choice = numbers.one();
        mean.add(double(sample_scatter(s, choice, numbers.square()).weight.x));
    }
    return mean;
}

// The table's nodes are sums over cells, and values between them are interpolated. The error is up to this at grazing
// angles.
constexpr double kTable = 0.02;

TEST(Sheen, ReflectsAloneWhatItsTableSays)
{
    for (const float roughness : kRoughnesses)
        for (const float cos_eye : kCosines) {
            const Surface s = cloth(roughness, Vec3f(0), cos_eye);
            const Mean f = furnace(s);
            EXPECT_NEAR(f.value(), double(sheen_albedo(cos_eye, s.sheen_alpha)), 4 * f.error() + kTable)
                << roughness << ' ' << cos_eye;
        }
}

TEST(Sheen, NeverGainsLightOverAWhiteBaseAndLosesLittle)
{
    for (const float roughness : kRoughnesses)
        for (const float cos_eye : kCosines) {
            const Mean f = furnace(cloth(roughness, Vec3f(1), cos_eye));
            EXPECT_LT(f.value(), 1 + 4 * f.error() + kTable) << roughness << ' ' << cos_eye;
            EXPECT_GT(f.value(), 0.75) << roughness << ' ' << cos_eye;
        }
}

TEST(Sheen, IsStrongestAtGrazingAngles)
{
    for (const float roughness : kRoughnesses)
        EXPECT_GT(sheen_albedo(0.1f, sheen_width(roughness)), 1.5f * sheen_albedo(1, sheen_width(roughness))) << roughness;
}

TEST(Anisotropy, EqualWidthsAreTheRoundLobe)
{
    Numbers numbers(5);
    for (const float alpha : {0.05f, 0.3f, 1.0f})
        for (int i = 0; i < 50; ++i) {
            const Surface s = brushed(alpha, alpha, 0.05f + 0.9f * numbers.one(), 6 * numbers.one());
            Surface round = s;
            round.tangent = Vec3f(0);
            const Vec3f light = direction(0.05f + 0.9f * numbers.one(), 6 * numbers.one());
            EXPECT_NEAR(scatter(s, light).x, scatter(round, light).x, 2e-3f * scatter(round, light).x + 1e-6f);
            EXPECT_NEAR(scatter_density(s, light), scatter_density(round, light), 2e-3f * scatter_density(round, light));
        }
}

// Integrates the albedo of a layer that reflects all light, finely and in another way than the table does: over the light.
double albedo_of(Vec3f eye, Widths widths)
{
    Numbers numbers(11);
    double sum = 0;
    constexpr int kDraws = 40'000;
    for (int i = 0; i < kDraws; ++i) {
        const Vec3f h = visible_normal(eye, widths, numbers.square());
        const Vec3f light = h * (2 * glm::dot(eye, h)) - eye;
        if (!(light.z > 0)) continue;
        const double lobe = double(ggx_density(h, widths) * ggx_visibility(light, eye, widths) * light.z);
        sum += lobe / (double(visible_density_over_cosine(eye, h, widths)) / 4);
    }
    return sum / kDraws;
}

TEST(Anisotropy, TheTableHoldsTheAlbedo)
{
    Numbers numbers(13);
    const StrokeAlbedo& table = StrokeAlbedo::instance();
    for (int i = 0; i < 60; ++i) {
        const float root = 0.15f + 0.85f * numbers.one(), across = root * root * root * root, strength = numbers.one();
        const Widths widths{across + (1 - across) * strength * strength, across};
        const Vec3f eye = direction(0.05f + 0.95f * numbers.one(), 1.5707963f * numbers.one());
        const float found = table.at(eye, widths, std::sqrt(widths.x * widths.y)).sum();
        constexpr double kNoise = 0.01;  // four standard errors of a share of 40,000 draws
        EXPECT_NEAR(double(found), albedo_of(eye, widths), double(StrokeAlbedo::kError) + kNoise)
            << widths.x << ' ' << across;
    }
}

// What single scattering loses is given back but for the error of the table, so a white metal reflects all of a white sky.
TEST(Anisotropy, AWhiteMetalReflectsAllOfAUniformSky)
{
    for (const float along : {0.1f, 0.4f, 1.0f})
        for (const float across : {0.01f, 0.1f, 0.3f}) {
            if (across > along) continue;
            for (const float cos_eye : kCosines)
                for (const float angle : {0.0f, 0.8f, 1.57f}) {
                    const Mean f = furnace(brushed(along, across, cos_eye, angle));
                    EXPECT_NEAR(f.value(), 1, 4 * f.error() + double(StrokeAlbedo::kError))
                        << along << ' ' << across << ' ' << cos_eye << ' ' << angle;
                }
        }
}

// The base below a brushed dielectric gets what the layer does not reflect.
TEST(Anisotropy, AWhiteBaseUnderABrushedLayerIsWhite)
{
    for (const float cos_eye : kCosines)
        for (const float angle : {0.0f, 1.57f}) {
            Surface s = brushed(0.8f, 0.1f, cos_eye, angle);
            s.f0 = Vec3f(0.04f);
            s.dielectric_f0 = 0.04f;
            s.diffuse = Vec3f(1);
            const Mean f = furnace(s);
            EXPECT_NEAR(f.value(), 1, 4 * f.error() + double(StrokeAlbedo::kError)) << cos_eye << ' ' << angle;
        }
}

TEST(Anisotropy, StretchesTheHighlightAcrossTheStrokes)
{
    const Surface s = brushed(0.6f, 0.05f, 1);
    EXPECT_GT(scatter(s, direction(0.8f, 0)).x, 20 * scatter(s, direction(0.8f, 1.5707963f)).x);
}

TEST(Anisotropy, AndSheenAreReciprocal)
{
    Numbers numbers(7);
    for (int i = 0; i < 100; ++i) {
        const Vec3f a = direction(0.05f + 0.9f * numbers.one(), 6 * numbers.one()),
                    b = direction(0.05f + 0.9f * numbers.one(), 6 * numbers.one());
        for (Surface s : {brushed(0.5f, 0.2f, 1), cloth(0.4f, Vec3f(0.5f), 1)}) {
            s.to_eye = a;
            const float ab = scatter(s, b).x / b.z;
            s.to_eye = b;
            EXPECT_NEAR(scatter(s, a).x / a.z, ab, 1e-3f * ab + 1e-6f);
        }
    }
}

TEST(Anisotropy, AndSheenAreSampledByTheirDensity)
{
    const auto excess = [](const Surface& s) {
        return test::direction_excess(
            90'000, 12,
            [&](Numbers& n) {
                const float choice = n.one();
                return sample_scatter(s, choice, n.square()).direction;
            },
            [&](Vec3f d) { return scatter_density(s, d); });
    };
    for (const float cos_eye : {0.2f, 0.9f}) {
        EXPECT_LT(excess(brushed(0.7f, 0.2f, cos_eye)), 4.5);
        EXPECT_LT(excess(cloth(0.4f, Vec3f(0.5f), cos_eye)), 4.5);
    }
}

}  // namespace
}  // namespace occam::shade
