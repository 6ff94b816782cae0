// Light that single scattering loses is given back by a lobe that lies close to the horizon where the layer is narrow. Its
// directions are drawn by its own shape, so no sample weighs much, however low the eye is.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "shade/albedo_table.h"
#include "shade/bsdf.h"
#include "tests/support/furnace.h"
#include "tests/support/statistics.h"

namespace occam::shade {
namespace {

using test::direction;
using test::Numbers;

// Returns the integral of what the table's albedo lacks to 1, times twice the cosine, over cosines up to this one.
double lost_up_to(float cosine, float alpha)
{
    constexpr int kSteps = 20'000;
    const AlbedoTable::Row row = AlbedoTable::row_of(alpha);
    const double end = std::sqrt(std::sqrt(double(cosine)));
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double root = end * (i + 0.5) / kSteps, at = root * root * root * root;
        const double lack = 1 - double(AlbedoTable::instance().at(static_cast<float>(at), row).sum());
        sum += std::max(lack, 0.0) * 2 * at * 4 * root * root * root * end / kSteps;
    }
    return sum;
}

TEST(LostLight, IsDrawnInItsOwnShape)
{
    for (const float alpha : {0.0009f, 0.0025f, 0.01f, 0.03f, 0.2f, 0.7f, 1.0f}) {
        const AlbedoTable::Row row = AlbedoTable::row_of(alpha);
        const double all = lost_up_to(1, alpha);
        EXPECT_NEAR(double(AlbedoTable::instance().lost(row)), all, 1e-3 * all + 1e-7) << alpha;
        float last = 0;
        for (int i = 0; i < 40; ++i) {
            const float number = (static_cast<float>(i) + 0.5f) / 40;
            const float cosine = AlbedoTable::instance().draw_lost(number, row);
            EXPECT_GT(cosine, last) << alpha << ' ' << number;
            EXPECT_NEAR(lost_up_to(cosine, alpha) / all, double(number), 2e-3) << alpha << ' ' << number;
            last = cosine;
        }
    }
}

TEST(LostLight, IsDrawnBetweenTheHorizonAndTheNormal)
{
    for (const float alpha : {kMinAlpha, 0.00185742f, 0.002f, 0.1f, 1.0f})
        for (const float number : {0.0f, 1e-30f, 0.5f, 0x1.fffffep-1f}) {
            const float cosine = AlbedoTable::instance().draw_lost(number, AlbedoTable::row_of(alpha));
            EXPECT_TRUE(cosine >= 0 && cosine <= 1) << alpha << ' ' << number << ' ' << cosine;
        }
}

struct Kind {
    std::string name;
    Surface surface;
};

std::vector<Kind> white_kinds(float roughness)
{
    Surface metal;
    metal.alpha = std::max(roughness * roughness, kMinAlpha);
    metal.base_color = metal.f0 = Vec3f(1);
    metal.f90 = 1;
    Surface brushed = metal;
    brushed.tangent = Vec3f(1, 0, 0);
    brushed.alpha_across = metal.alpha;
    brushed.alpha_along = std::min(1.0f, 3 * metal.alpha);
    brushed.alpha = std::sqrt(brushed.alpha_across * brushed.alpha_along);
    Surface pane;
    pane.alpha = metal.alpha;
    pane.transmission = Vec3f(1);
    pane.f0 = Vec3f(0.04f);
    pane.dielectric_f0 = 0.04f;
    pane.f90 = pane.dielectric_f90 = 1;
    return {{"metal", metal}, {"brushed", brushed}, {"pane", pane}};
}

// Under a white sky the weights of samples have the mean 1, and their squares a mean that is hardly larger. A pane reflects
// and transmits by the angle at the microfacet, which its chances to do either do not know, so its samples weigh more.
TEST(LostLight, MakesNoSampleHeavyAtAnyRoughnessAndAngle)
{
    for (const float roughness : {0.0f, 0.03f, 0.05f, 0.1f, 0.15f, 0.2f, 0.3f, 0.6f, 1.0f})
        for (const float cosine : {0.001f, 0.003f, 0.01f, 0.03f, 0.1f, 0.3f, 0.8f})
            for (Kind& kind : white_kinds(roughness)) {
                const bool is_pane = kind.name == "pane";
                if (is_pane && roughness < 0.05f) continue;  // such a pane scatters nothing
                kind.surface.to_eye = direction(cosine, 0.4f);
                const SurfaceForEye eye(kind.surface);
                Numbers numbers(17);
                double squares = 0, most = 0;
                constexpr int kSamples = 20'000;
                for (int i = 0; i < kSamples; ++i) {
                    const float choice = numbers.one();
                    const auto weight = double(sample_scatter(eye, choice, numbers.square()).weight.x);
                    squares += weight * weight / kSamples;
                    most = std::max(most, weight);
                }
                EXPECT_LT(squares, 1.35) << kind.name << ' ' << roughness << ' ' << cosine;
                EXPECT_LT(most, is_pane ? 12 : 2) << kind.name << ' ' << roughness << ' ' << cosine;
            }
}

TEST(LostLight, MakesNoDirectionDenserThanThePeak)
{
    for (const float roughness : {0.0f, 0.05f, 0.1f, 0.2f, 0.4f, 0.6f, 0.7f, 0.8f, 0.9f, 1.0f})
        for (const float cosine : {0.001f, 0.1f, 0.4f, 0.7f, 1.0f}) {
            Surface metal = white_kinds(roughness).front().surface;
            metal.to_eye = direction(cosine);
            const SurfaceForEye eye(metal);
            const float peak = peak_density(metal) * 1.0001f;
            for (int i = 1; i <= 1000; ++i) {
                const float of_light = static_cast<float>(i) * static_cast<float>(i) * 1e-6f;
                EXPECT_LE(scatter_density(eye, direction(of_light, 2)), peak) << roughness << ' ' << cosine << ' ' << i;
            }
        }
}

}  // namespace
}  // namespace occam::shade
