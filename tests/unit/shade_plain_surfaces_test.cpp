#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <vector>

#include "shade/surface.h"
#include "tests/support/furnace.h"
#include "tests/support/statistics.h"

namespace occam::shade {
namespace {

using test::direction;

// Returns materials that are the same everywhere.
std::vector<Material> plain_materials()
{
    std::vector<Material> all(8);
    all[1].metallic = 1;
    all[1].roughness = 0.2f;
    all[2].metallic = 0.4f;
    all[2].base_color = {0.9f, 0.5f, 0.1f, 0.3f};
    all[2].alpha_mode = AlphaMode::Blend;
    all[3].base_color.w = 0.2f;
    all[3].alpha_mode = AlphaMode::Mask;
    all[4].unlit = true;
    all[5].roughness = 1;
    all[5].specular = 0;
    all[5].emission = {2, 1, 0};
    all[6].ior = 2.4f;
    all[6].specular_color = {0.2f, 1, 1};
    all[7].base_color = {-1, 1e30f, std::nanf(""), 1};
    return all;
}

TEST(PlainSurfaces, HaveTheBitsOfSurfacesThatAreEvaluatedAtEachHit)
{
    test::Numbers numbers(5);
    const TextureStore textures(1 << 20);
    const std::vector<Material> materials = plain_materials();
    PlainSurfaces known;
    for (int i = 0; i < 400; ++i) {
        ShadePoint p;
        p.material = &materials[std::size_t(i) % materials.size()];
        p.position = Vec3d(numbers.one(), numbers.one(), numbers.one());
        p.to_eye = direction(0.02f + 0.98f * numbers.one(), 6 * numbers.one());
        p.normal_shading = direction(0.1f + 0.9f * numbers.one(), 6 * numbers.one());
        p.self_distance = numbers.one();
        p.to_start = Vec3f(numbers.one(), 0, 0);
        p.back_side = i % 3 == 0;
        if (i % 5 == 0) p.color = {0.5f, 1, 1, 1};
        const Surface own = evaluate(p, textures), plain = evaluate(p, textures, known);
        const auto same = [](Vec3f a, Vec3f b) { return std::memcmp(&a, &b, sizeof a) == 0; };
        EXPECT_TRUE(same(own.normal, plain.normal) && same(own.base_color, plain.base_color)) << i;
        EXPECT_TRUE(same(own.diffuse, plain.diffuse) && same(own.f0, plain.f0)) << i;
        EXPECT_TRUE(same(own.emission, plain.emission) && same(own.transmittance, plain.transmittance)) << i;
        EXPECT_EQ(own.position, plain.position);
        EXPECT_EQ(own.start({0, 0, 1}), plain.start({0, 0, 1}));
        EXPECT_EQ(own.opacity, plain.opacity);
        EXPECT_EQ(own.alpha, plain.alpha);
        EXPECT_EQ(own.f90, plain.f90);
        EXPECT_EQ(own.unlit, plain.unlit);
        EXPECT_EQ(own.is_matte, plain.is_matte);
    }
}

TEST(PlainSurfaces, LeaveOutWhatDependsOnThePlaceOrTheEye)
{
    const TextureStore textures(1 << 20);
    std::vector<Material> materials(6);
    materials[0].clearcoat = 0.5f;
    materials[1].transmission = 1;
    materials[2].sheen_color = {1, 1, 1};
    materials[3].anisotropy = 0.5f;
    materials[4].normal_texture.texture = TextureId{0, 1};
    materials[5].bump_texture.texture = TextureId{0, 1};
    PlainSurfaces known;
    for (const Material& material : materials) EXPECT_EQ(known.find(material, textures), nullptr);
}

}  // namespace
}  // namespace occam::shade
