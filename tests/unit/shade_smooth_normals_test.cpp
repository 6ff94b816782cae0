// Tests of glass whose shading normal is not that of the facet, as where normals are interpolated over a coarse mesh.
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
using test::Numbers;

constexpr float kRoughnesses[] = {0.1f, 0.4f, 0.7f, 1.0f};
constexpr float kCosines[] = {0.1f, 0.5f, 0.9f};
constexpr float kTilts[] = {0.02f, 0.2f, 0.5f, 0.9f};  // in radians

/// Returns the surface of a material whose shading normal leans away from the facet's, which is z.
Surface leaning(const Material& m, float cos_eye, float tilt, float around, bool back_side)
{
    static const TextureStore textures(1 << 20);
    ShadePoint p;
    p.material = &m;
    p.to_eye = direction(cos_eye);
    p.normal_geometric = {0, 0, 1};
    p.normal_shading = direction(std::cos(tilt), around);
    p.back_side = back_side;
    return evaluate(p, textures);
}

Material glass(float roughness, float thickness)
{
    Material m;
    m.base_color = Vec4f(1);
    m.metallic = 0;
    m.roughness = roughness;
    m.transmission = 1;
    m.thickness = thickness;
    return m;
}

template <class Call>
void for_all(float thickness, Call&& call)
{
    for (const float roughness : kRoughnesses)
        for (const float cos_eye : kCosines)
            for (const float tilt : kTilts)
                for (const float around : {0.0f, 1.3f, 3.1f})
                    for (const bool back_side : {false, true}) {
                        Material m = glass(roughness, thickness);
                        // What the reflecting layer of a pane reflects is faded towards the horizon, so the pane has none.
                        if (!(thickness > 0) || back_side) m.specular = 0;
                        call(leaning(m, cos_eye, tilt, around, back_side),
                             "roughness " + std::to_string(roughness) + ", cosine " + std::to_string(cos_eye) + ", tilt " +
                                 std::to_string(tilt) + ", around " + std::to_string(around) +
                                 (back_side ? ", from inside" : ""));
                    }
}

void expect_white(float thickness)
{
    test::EveryNth some(7);
    for_all(thickness, [&](const Surface& s, const std::string& what) {
        if (!some.takes()) return;
        EXPECT_NEAR(furnace(s), 1, kWhite) << what;
    });
}

TEST(SmoothNormals, LetBodiesLoseNothing) { expect_white(1); }

TEST(SmoothNormals, LetPanesTransmitAllLight) { expect_white(0); }

TEST(SmoothNormals, SampledDirectionsFollowTheirDensity)
{
    test::EveryNth some(5);
    for (const float thickness : {0.0f, 1.0f})
        for_all(thickness, [&](const Surface& s, const std::string& what) {
            if (s.alpha < 0.4f || !some.takes()) return;  // the cells are wider than narrow lobes
            const double excess = test::direction_excess(
                20'000, 8,
                [&](Numbers& n) {
                    const float choice = n.one();
                    return sample_scatter(s, choice, n.square()).direction;
                },
                [&](Vec3f d) { return scatter_density(s, d); });
            EXPECT_LT(excess, 4.5) << what;
        });
}

// Each sample of a body goes to the side of the facet to which it is meant to go, and none is lost.
TEST(SmoothNormals, LetNoSampleOfABodyEndOnTheWrongSide)
{
    Numbers numbers(31);
    for_all(1, [&](const Surface& s, const std::string& what) {
        for (int i = 0; i < 200; ++i) {
            const float choice = numbers.one();
            const ScatterSample sample = sample_scatter(s, choice, numbers.square());
            EXPECT_GT(sample.weight.x, 0) << what;
            const float side = glm::dot(s.normal_geometric, sample.direction);
            EXPECT_EQ(side < 0, sample.lobe == Lobe::Transmission) << what;
        }
    });
}

}  // namespace
}  // namespace occam::shade
