// Tests of maps that hold directions: each has the axes of its own texture coordinates, however a scene is written, and
// also while the surface moves; and of what phase one makes between vertices.
#include <gtest/gtest.h>

#include <glm/ext/matrix_transform.hpp>

#include <cmath>
#include <functional>
#include <glm/ext/matrix_transform.hpp>
#include <utility>
#include <vector>

#include "render/shade_point.h"
#include "shade/surface.h"
#include "tests/support/textured_floor.h"

namespace occam::test {
namespace {

constexpr float kQuarter = 1.57079633f;

// A texture of one direction, as a normal map and a map of strokes have it.
TextureUse map_of(Scene& scene, Vec3f direction)
{
    TextureUse use;
    use.texture = scene.add(texture_of([&](float, float) { return Vec4f(direction * 0.5f + 0.5f, 1); }));
    return use;
}

// Adds coordinates of another set, by those of the first.
void add_second_set(Cage& cage, const std::function<Vec2f(Vec2f)>& of)
{
    UvSet second = cage.uv_sets.front();
    for (Vec2f& uv : second.values) uv = of(uv);
    cage.uv_sets.push_back(second);
}

// What is seen of a floor from aside at some places, at these times of a shutter in which it turns once about its normal.
std::vector<shade::Surface> surfaces(Scene& scene, const Cage& floor, bool at_vertices, double turns = 0)
{
    NodeDesc node;
    node.cages = {scene.add(floor)};
    const NodeId id = scene.add_node(scene.root(), node);
    if (turns != 0)
        scene.record_shutter(8, [&](double tau) {
            scene.set_transform(id, glm::rotate(Mat4d(1), turns * tau * 6.283185307179586, Vec3d(0, 1, 0)));
        });
    FloorTracer traced(scene, at_vertices);
    std::vector<shade::Surface> seen;
    for (int k = 0; k < 20; ++k) {
        accel::Ray ray;
        ray.origin = {-1.11 + 0.113 * k, 2, 1.03 - 0.101 * k};
        ray.direction = glm::normalize(Vec3f(0.2f, -1, 0.1f));
        ray.footprint = {0.05f, 0};
        ray.time = 0.05f * float(k);
        accel::SurfaceHit hit;
        traced.tracer.closest({&ray, 1}, {&hit, 1});
        EXPECT_TRUE(hit.is_hit());
        EXPECT_EQ(hit.phase_one_channels > 0, at_vertices);
        seen.push_back(shade::evaluate(render::shade_point(ray, hit, 1), traced.textures));
    }
    return seen;
}

TEST(MapAxes, OfACoatAreThoseOfItsOwnCoordinatesWhateverTheOtherMapHas)
{
    for (const float rotation : {0.0f, 0.7f}) {
        const auto seen = [&](bool has_flat_map) {
            Scene scene;
            Material m;
            m.clearcoat = 1;
            m.clearcoat_normal_texture = map_of(scene, glm::normalize(Vec3f(0.5f, 0.1f, 1)));
            m.clearcoat_normal_texture.rotation = rotation;
            m.clearcoat_normal_texture.uv_set = 1;
            if (has_flat_map) m.normal_texture = map_of(scene, {0, 0, 1});
            Cage floor = floor_of(scene.add(m), Scheme::Bilinear);
            add_second_set(floor, [](Vec2f uv) { return Vec2f(0.3f * uv.x - uv.y, uv.x + 0.2f * uv.y); });
            return surfaces(scene, floor, false);
        };
        const auto alone = seen(false), beside_another = seen(true);
        for (std::size_t i = 0; i < alone.size(); ++i) {
            EXPECT_LT(alone[i].coat_normal.y, 0.95f) << "the map tilts it";
            EXPECT_LT(glm::distance(alone[i].coat_normal, beside_another[i].coat_normal), 1e-5f) << i << ' ' << rotation;
        }
    }
}

// A transform of the texture and the same transform of the coordinates are one scene written in two ways.
TEST(MapAxes, OfStrokesTurnWithTheTransformOfTheirTexture)
{
    const TextureUse by{{}, 0, {0.1f, 0.2f}, {2, -0.5f}, kQuarter / 2};
    const auto seen = [&](bool is_baked) {
        Scene scene;
        Material m;
        m.anisotropy = 0.8f;
        m.anisotropy_texture = map_of(scene, {0.8f, 0.6f, 1});
        if (!is_baked) {
            m.anisotropy_texture.offset = by.offset;
            m.anisotropy_texture.scale = by.scale;
            m.anisotropy_texture.rotation = by.rotation;
        }
        Cage floor = floor_of(scene.add(m), Scheme::Bilinear);
        for (Vec2f& uv : floor.uv_sets.front().values)
            if (is_baked) uv = scaled_and_rotated(by, uv) + by.offset;
        return surfaces(scene, floor, false);
    };
    const auto transformed = seen(false), baked = seen(true);
    for (std::size_t i = 0; i < baked.size(); ++i) {
        EXPECT_NEAR(glm::length(baked[i].tangent), 1, 1e-5f);
        EXPECT_LT(glm::distance(transformed[i].tangent, baked[i].tangent), 1e-3f) << i;
    }
}

// What passes a clear pane is what its surface does not reflect, which strokes would change.
TEST(MapAxes, PanesHaveNoStrokesHoweverClearTheyAre)
{
    for (const float roughness : {0.02f, 0.04f, 0.06f, 0.5f})
        for (const float transmission : {0.0f, 0.3f, 1.0f})
            for (const float white : {0.0f, 1.0f}) {
                Scene scene;
                Material m;
                m.base_color = Vec4f(Vec3f(white), 1);
                m.anisotropy = 0.8f;
                m.roughness = roughness;
                m.transmission = transmission;
                for (const shade::Surface& s : surfaces(scene, floor_of(scene.add(m), Scheme::Bilinear), false))
                    EXPECT_EQ(s.tangent != Vec3f(0), transmission == 0) << roughness << ' ' << white;
            }
}

TEST(MapAxes, OfBumpsTurnWithASurfaceThatMovesAlsoBetweenVertices)
{
    const auto seen = [&](bool at_vertices) {
        Scene scene;
        Material m;
        m.bump_texture.texture = scene.add(texture_of([](float x, float y) {
            return Vec4f(0.5f + 0.25f * std::sin(4 * kQuarter / kTexels * (x + 0.3f * y)), 0, 0, 1);
        }));
        m.bump_scale = 2;
        return surfaces(scene, floor_of(scene.add(m), Scheme::Bilinear), at_vertices, 1);
    };
    const auto at_hits = seen(false), at_vertices = seen(true);
    float tilt = 0;
    for (std::size_t i = 0; i < at_hits.size(); ++i) {
        tilt = std::max(tilt, 1 - at_hits[i].normal.y);
        EXPECT_LT(glm::distance(at_hits[i].normal, at_vertices[i].normal), 0.04f) << i;
    }
    EXPECT_GT(tilt, 0.1f);
}

// Under transparent texels a file may have any colour; half of the vertices of this floor have such texels about them.
TEST(PhaseOneBetweenVertices, WhatLiesUnderTransparentTexelsIsNotSeen)
{
    Scene scene;
    Material m;
    m.unlit = true;
    m.alpha_mode = AlphaMode::Blend;
    m.base_color_texture.texture = scene.add(texture_of([](float x, float y) {
        const bool is_seen = (int(x) / 7 + int(y) / 7) % 2 == 0;
        return is_seen ? Vec4f(1) : Vec4f(0, 0, 0, 0);
    }));
    int partly = 0;
    for (const shade::Surface& s : surfaces(scene, floor_of(scene.add(m), Scheme::Bilinear), true)) {
        if (s.opacity == 0) continue;
        partly += s.opacity < 1;
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(s.base_color[c], 1, 1e-4f) << s.opacity;
    }
    EXPECT_GT(partly, 5);
}

}  // namespace
}  // namespace occam::test
