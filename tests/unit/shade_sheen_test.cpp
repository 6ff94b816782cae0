// Tests of sheen and brushed layers: white furnaces, reciprocity and chi-square tests.
#include "shade/sheen.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "shade/bsdf.h"
#include "shade/stroke_albedo.h"
#include "tests/support/campaign.h"
#include "tests/support/furnace.h"
#include "tests/support/statistics.h"

namespace occam::shade {
namespace {

using test::direction;
using test::furnace;
using test::kWhite;
using test::Numbers;

constexpr float kCosines[] = {0.01f, 0.05f, 0.3f, 0.7f, 1.0f};
constexpr float kRoughnesses[] = {0.0f, 0.085f, 0.2f, 0.55f, 1.0f};

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

TEST(Sheen, ReflectsAloneWhatItsTableSays)
{
    test::EveryNth some(3);
    for (const float roughness : kRoughnesses)
        for (const float cos_eye : kCosines) {
            if (!some.takes()) continue;
            const Surface s = cloth(roughness, Vec3f(0), cos_eye);
            EXPECT_NEAR(furnace(s, 64'000, 0), double(sheen_for_eye(s, cos_eye).reflects), kWhite)
                << roughness << ' ' << cos_eye;
        }
}

// Returns white surfaces of every kind of lobe, on which sheen may lie.
std::vector<std::pair<std::string, Surface>> white_surfaces(float alpha)
{
    Surface base;
    base.alpha = alpha;
    base.f0 = Vec3f(0.04f);
    base.dielectric_f0 = 0.04f;
    Surface matte = base, metal = base, half_metal = base, pane = base, glass = base;
    base.diffuse = Vec3f(1);
    matte.diffuse = Vec3f(1);
    matte.f0 = Vec3f(0);
    matte.f90 = matte.dielectric_f0 = matte.dielectric_f90 = 0;
    metal.f0 = Vec3f(1);
    metal.dielectric_f0 = 1;
    half_metal.f0 = Vec3f(0.52f);
    half_metal.dielectric_f0 = 0.52f;
    half_metal.diffuse = Vec3f(1);
    pane.transmission = Vec3f(0.7f);
    pane.diffuse = Vec3f(0.3f);
    glass.transmission = Vec3f(1);
    glass.is_solid = true;
    glass.eta = 1.5f;
    return {{"matte", matte}, {"dielectric", base}, {"metal", metal}, {"half a metal", half_metal},
            {"a pane", pane}, {"glass", glass}};
}

TEST(Sheen, OverAnyWhiteSurfaceLosesNothing)
{
    test::EveryNth some(7);
    for (const float alpha : {0.01f, 0.36f})
        for (const auto& [name, below] : white_surfaces(alpha))
            for (const float roughness : kRoughnesses)
                for (const float cos_eye : kCosines)
                    for (const bool coated : {false, true}) {
                        if (!some.takes()) continue;
                        Surface s = below;
                        s.sheen = Vec3f(coated ? 0.5f : 1.0f);
                        s.sheen_alpha = sheen_width(roughness);
                        s.to_eye = direction(cos_eye);
                        if (coated) s.coat = 0.8f, s.coat_alpha = 0.1f;
                        EXPECT_NEAR(furnace(s), 1, kWhite)
                            << name << " of width " << alpha << ", sheen of roughness " << roughness
                            << ", cosine of the eye " << cos_eye << (coated ? ", coated" : "");
                    }
}

TEST(Sheen, IsStrongestAtGrazingAngles)
{
    const auto reflects = [](float roughness, float cosine) {
        return sheen_for_eye(cloth(roughness, Vec3f(0), cosine), cosine).reflects;
    };
    for (const float roughness : kRoughnesses)
        EXPECT_GT(reflects(roughness, 0.1f), 1.5f * reflects(roughness, 1)) << roughness;
}

TEST(Anisotropy, EqualWidthsAreTheRoundLobe)
{
    Numbers numbers(5);
    for (const float alpha : {0.05f, 0.3f, 1.0f})
        for (int i = 0; i < 50; ++i) {
            const float eye_cosine = 0.05f + 0.9f * numbers.one(), eye_angle = 6 * numbers.one();
            const float light_cosine = 0.05f + 0.9f * numbers.one(), light_angle = 6 * numbers.one();
            const Vec3f eye = direction(eye_cosine, eye_angle), light = direction(light_cosine, light_angle),
                        h = glm::normalize(eye + light);
            const auto expect_equal = [](float found, float expected) { EXPECT_NEAR(found, expected, 1e-4f * expected); };
            expect_equal(ggx_density(h, {alpha, alpha}), ggx_density(h.z, 1 - h.z * h.z, alpha));
            expect_equal(ggx_visibility(light, eye, {alpha, alpha}), ggx_visibility(light.z, eye.z, alpha));
            expect_equal(visible_density_over_cosine(eye, h, {alpha, alpha}),
                         visible_density_over_cosine(eye.z, h.z, 1 - h.z * h.z, alpha));
            const LayerAlbedo strokes = stroke_albedo(eye, {alpha, alpha}), round = AlbedoTable::instance().at(eye.z, alpha);
            EXPECT_NEAR(strokes.f0, round.f0, kWhite / 2) << alpha << ' ' << eye.z;
            EXPECT_NEAR(strokes.f90, round.f90, kWhite / 2) << alpha << ' ' << eye.z;
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

TEST(Anisotropy, TheAlbedoIsItsIntegral)
{
    Numbers numbers(13);
    for (int i = 0; i < 60; ++i) {
        const float root = 0.15f + 0.85f * numbers.one(), across = root * root * root * root, strength = numbers.one();
        const Widths widths{across + (1 - across) * strength * strength, across};
        const float cosine = 0.05f + 0.95f * numbers.one(), angle = 1.5707963f * numbers.one();
        const Vec3f eye = direction(cosine, angle);
        constexpr double kNoise = 0.01;  // four standard errors of a share of 40,000 draws
        EXPECT_NEAR(double(stroke_albedo(eye, widths).sum()), albedo_of(eye, widths), 0.001 + kNoise)
            << widths.x << ' ' << across;
    }
}

// Integrates the same finely, over points of the disc from which visible normals come.
double fine_albedo_of(Vec3f to_eye, Widths widths)
{
    const Vec3d eye(to_eye), stretched(double(widths.x) * eye.x, double(widths.y) * eye.y, eye.z);
    const double length = glm::length(stretched);
    const Vec3d z = stretched / length, x = glm::normalize(Vec3d(-z.y, z.x, 0)), y = glm::cross(z, x);
    constexpr int kRings = 60, kAngles = 120;
    double sum = 0, whole = 0;
    for (int ring = 0; ring < kRings; ++ring) {
        // One minus the squared radius is the fourth power of the root.
        const double root = (ring + 0.5) / kRings, radius = std::sqrt(1 - std::pow(root, 4)), weight = std::pow(root, 3);
        for (int i = 0; i < kAngles; ++i) {
            const double angle = (i + 0.5) / kAngles * 2 * double(kPi), p = radius * std::cos(angle);
            const double q = (1 - z.z) / 2 * std::sqrt(1 - p * p) + (1 + z.z) / 2 * radius * std::sin(angle);
            const Vec3d on_ball = x * p + y * q + z * std::sqrt(std::max(0.0, 1 - p * p - q * q));
            const Vec3d h = glm::normalize(
                Vec3d(double(widths.x) * on_ball.x, double(widths.y) * on_ball.y, std::max(on_ball.z, 1e-6)));
            const Vec3d light = h * (2 * glm::dot(eye, h)) - eye;
            whole += weight;
            if (!(light.z > 0)) continue;
            const double of_light = glm::length(Vec3d(double(widths.x) * light.x, double(widths.y) * light.y, light.z));
            sum += weight * light.z * (eye.z + length) / (light.z * length + eye.z * of_light);  // masking of both over one
        }
    }
    return sum / whole;
}

TEST(Anisotropy, TheAlbedoIsExactForStrokesOfAnyStrength)
{
    for (const float across : {0.001f, 0.04f, 0.16f, 0.36f})
        for (const float strength : {0.05f, 0.3f, 0.6f, 1.0f})
            for (const float cosine : {0.1f, 0.4f, 0.7f, 0.97f})
                for (const float angle : {0.05f, 0.4f, 0.8f, 1.5f}) {
                    const Widths widths{across + (1 - across) * strength * strength, across};
                    const Vec3f eye = direction(cosine, angle);
                    EXPECT_NEAR(double(stroke_albedo(eye, widths).sum()), fine_albedo_of(eye, widths), 0.0015)
                        << across << ' ' << strength << ' ' << cosine << ' ' << angle;
                }
}

// What single scattering loses is given back, so a white metal reflects all of a white sky, and so does a dielectric over a
// white base, which gets what the layer does not reflect.
TEST(Anisotropy, AWhiteSurfaceReflectsAllOfAUniformSky)
{
    test::EveryNth some(4);
    for (const float along : {0.02f, 0.1f, 0.4f, 1.0f})
        for (const float across : {0.0001f, 0.01f, 0.1f, 0.3f}) {
            if (across > along) continue;
            for (const float cos_eye : kCosines)
                for (const float angle : {0.0f, 0.8f, 1.57f}) {
                    if (!some.takes()) continue;
                    Surface s = brushed(along, across, cos_eye, angle);
                    EXPECT_NEAR(furnace(s), 1, kWhite)
                        << along << ' ' << across << ' ' << cos_eye << ' ' << angle << ", metal";
                    s.f0 = Vec3f(0.04f);
                    s.dielectric_f0 = 0.04f;
                    s.diffuse = Vec3f(1);
                    EXPECT_NEAR(furnace(s), 1, kWhite) << along << ' ' << across << ' ' << cos_eye << ' ' << angle;
                }
        }
}

TEST(Anisotropy, StretchesTheHighlightAcrossTheStrokes)
{
    const Surface s = brushed(0.6f, 0.05f, 1);
    EXPECT_GT(scatter(s, direction(0.8f, 0)).x, 20 * scatter(s, direction(0.8f, 1.5707963f)).x);
}

// What is given back of several bounces follows from the eye alone; the lobe of one bounce is reciprocal.
TEST(Anisotropy, TheLobeIsReciprocal)
{
    Numbers numbers(7);
    for (int i = 0; i < 100; ++i) {
        const float first = 0.05f + 0.9f * numbers.one(), first_angle = 6 * numbers.one();
        const float second = 0.05f + 0.9f * numbers.one(), second_angle = 6 * numbers.one();
        const Vec3f a = direction(first, first_angle), b = direction(second, second_angle);
        const Widths widths{0.5f, 0.2f};
        EXPECT_NEAR(ggx_visibility(a, b, widths), ggx_visibility(b, a, widths), 1e-5f * ggx_visibility(a, b, widths));
        Surface s = brushed(widths.x, widths.y, 1);
        s.f0 = Vec3f(0.001f);  // Light of several bounces is a thousandth of that of one.
        s.dielectric_f0 = 0.001f;
        s.f90 = s.dielectric_f90 = 0;
        s.to_eye = a;
        const float ab = scatter(s, b).x / b.z;
        s.to_eye = b;
        EXPECT_NEAR(scatter(s, a).x / a.z, ab, 1e-3f * ab + 1e-6f);
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
