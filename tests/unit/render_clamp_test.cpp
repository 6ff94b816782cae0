// Tests of what the limit of scattered light counts: what comes to the pixel, whatever dims it on its way.
#include <gtest/gtest.h>

#include "tests/support/body_stage.h"

namespace occam::test {
namespace {

enum class Cover { None, Glass, Sheet, Water };
constexpr Cover kCovers[] = {Cover::Glass, Cover::Sheet, Cover::Water};

constexpr float kHalf = 1e5f;  // so that next to no light comes from beside the cover

Cage level_square_at(float height, bool faces_down)
{
    Cage cage;
    cage.scheme = Scheme::Triangles;
    cage.positions = {{-kHalf, height, -kHalf}, {-kHalf, height, kHalf}, {kHalf, height, kHalf}, {kHalf, height, -kHalf}};
    if (faces_down) cage.face_vertices = {0, 2, 1, 0, 3, 2};
    else cage.face_vertices = {0, 1, 2, 0, 2, 3};
    return cage;
}

// A wall beside a floor, of which a camera sees the wall. Above both lies what passes `share` of the light.
BodyStage wall_and_floor(Cover cover, float share)
{
    BodyStage stage;
    stage.put(level_square(kHalf), matte_of(0.8f));
    Cage wall;
    wall.scheme = Scheme::Triangles;
    wall.positions = {{-20, 0, 0}, {20, 0, 0}, {20, 4, 0}, {-20, 4, 0}};
    wall.face_vertices = {0, 1, 2, 0, 2, 3};
    stage.put(wall, matte_of(0.8f));

    Material m = body_of(1, Vec3f(share));
    m.specular = 0;
    if (cover == Cover::Glass) {
        m.thickness = 0;
        m.base_color = Vec4f(share, share, share, 1);
    }
    if (cover == Cover::Sheet) {
        m = matte_of(0);
        m.alpha_mode = AlphaMode::Blend;
        m.base_color.w = 1 - share;
    }
    if (cover != Cover::None) stage.put(level_square_at(6, false), m);
    if (cover == Cover::Water) stage.put(level_square_at(5, true), m);
    stage.settings.spp = 256;
    stage.settings.width = 12;
    stage.settings.height = 8;
    return stage;
}

float wall_of(BodyStage& stage) { return stage.seen(Camera::look_at({0, 2, 5}, {0, 2, 0}, {0, 1, 0}, 0.3f)).x; }

float wall_in_the_sun(Cover cover, float share, float clamp)
{
    BodyStage stage = wall_and_floor(cover, share);
    constexpr float kBehind = 5;  // what the sun brings behind the cover
    stage.put({.kind = SunLight{Vec3f(kBehind / (cover == Cover::None ? 1 : share))}});
    stage.settings.clamp = clamp;
    stage.settings.bounces = 1;
    return wall_of(stage);
}

// A share of 1e-5 lets rays pass by chance, and each of them stands for a hundred.
TEST(Clamp, CountsWhatASunBringsBehindPanesLeavesAndWater)
{
    const float free = wall_in_the_sun(Cover::None, 1, 0);
    ASSERT_GT(free, 0.3f);
    EXPECT_FLOAT_EQ(wall_in_the_sun(Cover::None, 1, 2), free);
    for (const Cover cover : kCovers)
        for (const float share : {0.05f, 0.002f, 1e-5f})
            for (const float clamp : {0.0f, 2.0f})
                EXPECT_NEAR(wall_in_the_sun(cover, share, clamp), free, (share < 1e-3f ? 0.1f : 0.001f) * free)
                    << int(cover) << ", " << share << ", " << clamp;
}

// What comes there is limited, as it is without the cover.
TEST(Clamp, LimitsTheSameBehindThem)
{
    const float limited = wall_in_the_sun(Cover::None, 1, 0.1f);
    ASSERT_LT(limited, 0.5f * wall_in_the_sun(Cover::None, 1, 0));
    for (const Cover cover : kCovers)
        for (const float share : {0.05f, 0.002f})
            EXPECT_NEAR(wall_in_the_sun(cover, share, 0.1f), limited, 0.001f * limited) << int(cover) << ", " << share;
}

// Rays that are scattered at the wall and the floor find the sky, of which they pass the cover by chance.
TEST(Clamp, CountsWhatASkyBringsThere)
{
    const auto wall = [](Cover cover, float clamp, int bounces, bool has_emitter) {
        constexpr float kShare = 0.05f, kBehind = 1;
        BodyStage stage = wall_and_floor(cover, kShare);
        stage.scene.environment.radiance = Vec3f(kBehind / kShare);
        if (has_emitter) stage.put(unit_square(), shining(1e-6f), {500, 0, 500});
        stage.settings.clamp = clamp;
        stage.settings.bounces = bounces;
        return wall_of(stage);
    };
    for (const int bounces : {1, 2}) {
        for (const bool has_emitter : {false, true})
            for (const Cover cover : kCovers) {
                const float all = wall(cover, 0, bounces, has_emitter);
                EXPECT_NEAR(wall(cover, 2, bounces, has_emitter), all, 0.002f * all)
                    << int(cover) << ", " << bounces << ", " << has_emitter;
            }
    }
}

}  // namespace
}  // namespace occam::test
