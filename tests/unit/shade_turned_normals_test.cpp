// Tests of shading normals that turn away from the eye or lead into the surface, as a normal map has them that is black
// where it is unused, has two channels, or is steep.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "shade/surface.h"
#include "shade/transmission.h"
#include "tests/support/furnace.h"
#include "tests/support/statistics.h"

namespace occam::shade {
namespace {

using test::direction;
using test::Numbers;

struct Kind {
    std::string name;
    Material material;
};

std::vector<Kind> kinds(float roughness)
{
    std::vector<Kind> all{{"metal", {}}, {"plastic", {}}, {"coat", {}}, {"body", {}}, {"pane", {}}, {"cloth", {}}};
    for (Kind& kind : all) {
        kind.material.base_color = Vec4f(1);
        kind.material.metallic = kind.name == "metal" ? 1.0f : 0.0f;
        kind.material.roughness = kind.material.clearcoat_roughness = roughness;
        kind.material.clearcoat = kind.name == "coat" ? 1.0f : 0.0f;
        kind.material.transmission = kind.name == "body" || kind.name == "pane" ? 1.0f : 0.0f;
        kind.material.thickness = kind.name == "body" ? 1.0f : 0.0f;
        if (kind.name != "cloth") continue;
        kind.material.specular = 0;
        kind.material.sheen_color = Vec3f(1);
        kind.material.sheen_roughness = roughness;
    }
    return all;
}

// The facet's normal is z, and the eye is in front of it.
template <class Call>
void for_normals(const Material& m, Call&& call)
{
    static const TextureStore textures(1 << 20);
    Numbers numbers(7);
    for (int i = 0; i < 400; ++i) {
        ShadePoint p;
        p.material = &m;
        const Vec2f eye = numbers.square(), normal = numbers.square();
        p.to_eye = direction(i % 8 == 0 ? 1.0f : 0.01f + 0.98f * eye.x, 6.2831853f * eye.y);
        p.normal_geometric = {0, 0, 1};
        p.normal_shading = i % 5 == 0 ? -p.to_eye : direction(2 * normal.x - 1, 6.2831853f * normal.y);
        call(evaluate(p, textures), i);
    }
}

TEST(TurnedNormals, AreTiltedToTheSideOfTheEyeAndOfTheFacet)
{
    for (const float roughness : {0.0f, 0.3f, 1.0f})
        for (const Kind& kind : kinds(roughness))
            for_normals(kind.material, [&](const Surface& s, int i) {
                for (const Vec3f normal : {s.normal, s.coat > 0 ? s.coat_normal : s.normal}) {
                    EXPECT_NEAR(glm::length(normal), 1, 1e-5f) << kind.name << ' ' << i;
                    EXPECT_GT(glm::dot(normal, s.to_eye), 0) << kind.name << ' ' << i;
                    EXPECT_GT(glm::dot(normal, s.normal_geometric), 0) << kind.name << ' ' << i;
                }
            });
}

// At the lowest cosines the directions of the eye and of its reflection are so nearly opposite that the rounding of what
// lies between them counts. So the facets lie in any axes.
TEST(TurnedNormals, AreOnTheSideOfAnEyeAsLowAsOneMayBe)
{
    const TextureStore textures(1 << 20);
    Material metal;
    Numbers numbers(5);
    for (const float height : {1e-2f, 1e-3f, 3e-4f, 1e-4f, 1e-5f, 1e-6f})
        for (int i = 0; i < 500; ++i) {
            ShadePoint p;
            p.material = &metal;
            const Vec2f facet = numbers.square(), away = numbers.square();
            const ShadingFrame axes(direction(2 * facet.x - 1, 6.2831853f * facet.y));
            p.normal_geometric = axes.z;
            p.to_eye = glm::normalize(axes.to_world(direction(height, 6.2831853f * numbers.one())));
            p.normal_shading = glm::normalize(axes.z - p.to_eye * (0.05f + 0.25f * away.x) + axes.x * (0.05f * away.y));
            const float facing = glm::dot(p.normal_geometric, p.to_eye);
            if (!(facing > 0)) continue;
            const Surface s = evaluate(p, textures);
            EXPECT_GT(glm::dot(s.normal, s.to_eye), 0.12f * facing) << height << ' ' << i;
            EXPECT_GT(glm::dot(s.normal, s.normal_geometric), 0) << height << ' ' << i;
        }
}

// A pane under a coat may get light from a direction that its own lobe does not draw. The light of that direction would
// have the weight of the coat's density, which may be as low as one likes.
TEST(TurnedNormals, OfAPaneLetNoLightThroughWhereNoneIsDrawn)
{
    Numbers numbers(13);
    int none = 0;
    for (int i = 0; i < 2'000; ++i) {
        Surface s;
        s.normal = s.normal_geometric = {0, 0, 1};
        s.to_eye = direction(-0.02f * numbers.one(), 6.2831853f * numbers.one());
        s.alpha = 0.02f + 0.9f * numbers.one();
        s.transmission = Vec3f(1);
        s.dielectric_f0 = 0.04f;
        const Vec3f to_light = direction(-0.02f * numbers.one(), 6.2831853f * numbers.one());
        if (pane_density(s, to_light) > 0) continue;
        ++none;
        EXPECT_EQ(pane_transmission(s, to_light), Vec3f(0)) << i;
    }
    EXPECT_GT(none, 200);
}

// In a white furnace the mean weight of the samples is what the surface scatters. A few samples at grazing angles weigh some
// tens; a sample that was drawn for another eye than that of its density would weigh thousands.
TEST(TurnedNormals, MakeNoLight)
{
    for (const float roughness : {0.1f, 0.3f, 1.0f})
        for (const Kind& kind : kinds(roughness)) {
            Numbers numbers(11);
            for_normals(kind.material, [&](const Surface& s, int i) {
                if (i % 9 != 0 && i % 10 != 0) return;
                constexpr int kSamples = 5'000;
                double sum = 0, squares = 0;
                for (int k = 0; k < kSamples; ++k) {
                    const float choice = numbers.one();
                    const auto weight = double(sample_scatter(s, choice, numbers.square()).weight.x);
                    sum += weight;
                    squares += weight * weight;
                }
                const double mean = sum / kSamples, variance = squares / kSamples - mean * mean;
                EXPECT_LT(mean, 1 + test::kWhite + 4 * std::sqrt(std::max(variance, 0.0) / kSamples))
                    << kind.name << ' ' << roughness << ' ' << i;
                EXPECT_LT(variance, 100) << kind.name << ' ' << roughness << ' ' << i;
            });
        }
}

}  // namespace
}  // namespace occam::shade
