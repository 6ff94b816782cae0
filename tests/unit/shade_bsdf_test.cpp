#include "shade/bsdf.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "render/sampler.h"
#include "shade/frame_of.h"

namespace occam::shade {
namespace {

Surface surface_of(float alpha, Vec3f diffuse, Vec3f f0, float cos_eye)
{
    Surface s;
    s.alpha = alpha;
    s.diffuse = diffuse;
    s.f0 = f0;
    s.dielectric_f0 = std::max({f0.x, f0.y, f0.z});
    s.to_eye = {std::sqrt(1 - cos_eye * cos_eye), 0, cos_eye};
    return s;
}

// Stratified numbers: n x n squares and as many lobe choices.
template <class Use>
void for_numbers(int n, Use&& use)
{
    const render::Sampler sampler(3, 1, true);
    const auto count = static_cast<std::uint32_t>(n * n);
    for (std::uint32_t i = 0; i < count; ++i)
        use(sampler.square(0, 0, i, count, render::Dimension::light(0, 0)),
            sampler.interval(0, 0, i, count, render::Dimension::light(1, 0)));
}

// Albedo by importance sampling: the mean of f cos / density.
double albedo(const Surface& s, int n = 128)
{
    double sum = 0;
    for_numbers(n, [&](Vec2f square, float lobe) {
        const Vec3f d = sample_direction(s, lobe, square);
        const float density = direction_density(s, d);
        if (density > 0) sum += double(reflect(s, d).x) / double(density);
    });
    return sum / (n * n);
}

TEST(Bsdf, AWhiteFurnaceNeverGainsLight)
{
    for (float alpha : {kMinAlpha, 0.01f, 0.1f, 0.5f, 1.0f})
        for (float cos_eye : {0.05f, 0.3f, 0.7f, 1.0f}) {
            const double metal = albedo(surface_of(alpha, Vec3f(0), Vec3f(1), cos_eye));
            EXPECT_LT(metal, 1.005) << alpha << ' ' << cos_eye;
            EXPECT_GT(metal, alpha <= 0.1f ? 0.9 : 0.3) << alpha << ' ' << cos_eye << ": single scattering loses some";
            const double plastic = albedo(surface_of(alpha, Vec3f(1), Vec3f(0.04f), cos_eye));
            EXPECT_LT(plastic, 1.005) << alpha << ' ' << cos_eye;
            EXPECT_GT(plastic, 0.4) << alpha << ' ' << cos_eye;
        }
}

TEST(Bsdf, AWhiteBaseUnderASmoothLayerLosesNothing)
{
    for (float cos_eye : {0.05f, 0.3f, 0.7f, 1.0f})
        EXPECT_NEAR(albedo(surface_of(kMinAlpha, Vec3f(1), Vec3f(0.04f), cos_eye)), 1, 5e-3) << cos_eye;
}

// Seen from above with alpha = 1: D = 1 / pi and the masking leaves the integral of c / (1 + c) over the cosine, 1 - ln 2.
TEST(Bsdf, TheRoughestMetalReflectsOneMinusLnTwo)
{
    EXPECT_NEAR(albedo(surface_of(1, Vec3f(0), Vec3f(1), 1)), 1 - std::log(2.0), 2e-3);
}

TEST(Bsdf, ASurfaceWithoutReflectanceIsLambertian)
{
    Surface s = surface_of(0.5f, Vec3f(0.6f), Vec3f(0), 0.8f);
    s.dielectric_f90 = s.f90 = 0;
    EXPECT_NEAR(albedo(s), 0.6, 1e-3);
    EXPECT_NEAR(reflect(s, {0, 0, 1}).x, 0.6f / kPi, 1e-6f);
    EXPECT_NEAR(reflect(s, glm::normalize(Vec3f(0, 1, 1))).x, 0.6f / kPi * std::sqrt(0.5f), 1e-6f);
}

TEST(Bsdf, IsReciprocal)
{
    Surface s = surface_of(0.3f, Vec3f(0.5f), Vec3f(0.04f), 0.9f);
    s.coat = 0.7f;
    s.coat_alpha = 0.05f;
    const Vec3f a = glm::normalize(Vec3f(0.3f, -0.2f, 0.8f)), b = glm::normalize(Vec3f(-0.6f, 0.4f, 0.5f));
    s.to_eye = a;
    const Vec3f ab = reflect(s, b) / b.z;
    s.to_eye = b;
    const Vec3f ba = reflect(s, a) / a.z;
    EXPECT_NEAR(ab.x, ba.x, 1e-5f * ab.x);
}

TEST(Bsdf, IsBlackBelowEitherHorizon)
{
    Surface s = surface_of(0.3f, Vec3f(0.5f), Vec3f(0.04f), 0.9f);
    EXPECT_EQ(reflect(s, {0, 0, -1}), Vec3f(0));
    s.normal = glm::normalize(Vec3f(1, 0, 1));
    EXPECT_EQ(reflect(s, glm::normalize(Vec3f(1, 0, -0.1f))), Vec3f(0)) << "above the shading normal's horizon only";
}

// Chi-square of sampled directions against direction_density(), over 16 x 32 cells of (cos, angle) of the whole sphere.
// Cells with an expectation below 5 are pooled. Bound: mean + 4.5 standard deviations of the distribution.
TEST(Bsdf, SampledDirectionsFollowTheirDensity)
{
    constexpr int kRows = 16, kColumns = 32, kSide = 300, kFine = 12;
    for (float alpha : {0.15f, 0.6f})
        for (float cos_eye : {0.2f, 0.9f}) {
            Surface s = surface_of(alpha, Vec3f(0.3f), Vec3f(0.5f), cos_eye);
            s.coat = 0.5f;
            s.coat_alpha = 0.3f;
            std::vector<double> found(kRows * kColumns), wanted(kRows * kColumns);
            const auto cell = [](Vec3f d) {
                const int row = std::min(kRows - 1, int((double(d.z) + 1) / 2 * kRows));
                const int column =
                    std::min(kColumns - 1, int((std::atan2(double(d.y), double(d.x)) / 6.283185307179586 + 0.5) * kColumns));
                return std::size_t(row * kColumns + column);
            };
            // Independent numbers: strata would make the statistic too small.
            const render::Sampler sampler(11, 1, true);
            for (int i = 0; i < kSide * kSide; ++i) {
                const auto d = render::Dimension::pixel();
                const Vec2f square = sampler.square(i, 0, 0, 1, d);
                const float lobe = sampler.interval(i, 1, 0, 1, d);
                ++found[cell(sample_direction(s, lobe, square))];
            }
            for (int row = 0; row < kRows * kFine; ++row)
                for (int column = 0; column < kColumns * kFine; ++column) {
                    const double z = (row + 0.5) / (kRows * kFine) * 2 - 1;
                    const double angle = ((column + 0.5) / (kColumns * kFine) - 0.5) * 6.283185307179586;
                    const double r = std::sqrt(1 - z * z);
                    const Vec3f d(float(r * std::cos(angle)), float(r * std::sin(angle)), float(z));
                    wanted[std::size_t(row / kFine * kColumns + column / kFine)] +=
                        double(direction_density(s, d)) * 4 * 3.141592653589793 / (kRows * kFine * kColumns * kFine) *
                        kSide * kSide;
                }
            double chi2 = 0, pooled_found = 0, pooled_wanted = 0;
            int freedom = 0;
            const auto add = [&](double f, double w) {
                chi2 += (f - w) * (f - w) / w;
                ++freedom;
            };
            for (std::size_t i = 0; i < found.size(); ++i) {
                if (wanted[i] < 5) {
                    pooled_found += found[i];
                    pooled_wanted += wanted[i];
                } else {
                    add(found[i], wanted[i]);
                }
            }
            if (pooled_wanted >= 5) add(pooled_found, pooled_wanted);
            EXPECT_LT(chi2, freedom + 4.5 * std::sqrt(2.0 * freedom)) << "alpha " << alpha << " cos " << cos_eye;
        }
}

}  // namespace
}  // namespace occam::shade
