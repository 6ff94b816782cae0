// Tests of ambient occlusion beside what lets light pass straight on: rays from the camera and to the sky pass it alike.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/body_stage.h"

namespace occam::test {
namespace {

constexpr double kFar = 1000, kNear = 3;  // half a side of a pane

// Shows a floor under a pane at a height of 1.
Vec3f floor_under(const Material& pane, double eye, double half)
{
    BodyStage stage;
    stage.put(level_square(50), matte_of(1));
    stage.put(level_square(1), pane, {0, 1, 0}, Vec3d(half, 1, half));
    stage.settings.integrator = IntegratorKind::Ao;
    stage.settings.spp = 256;
    return stage.seen(Camera::look_at({0, eye, 0}, {0, 0, 0}, {0, 0, -1}, 0.05f));
}

Material pane_of(Vec3f color)
{
    Material m = body_of(1);
    m.thickness = 0;
    m.base_color = Vec4f(color, 1);
    return m;
}

// The pane passes its colour but for a little that it mirrors. From below, the floor sees the sky through it. From above, it
// is the floor with that light, in the same colour again, and what does not pass the pane is seen on it.
TEST(AmbientOcclusion, IsSeenThroughAPaneAsItComesThroughIt)
{
    const Vec3f color(1, 0.2f, 0.2f);
    const Vec3f below = floor_under(pane_of(color), 0.6, kFar);
    expect_close(below, color * below.x, 0.02);
    EXPECT_GT(below.x, 0.85f);
    const Vec3f above = floor_under(pane_of(color), kNear, kFar);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(above[c], 1 - color[c] + color[c] * below[c], 0.06f) << c;
}

// The same way through a body counts, be the eye above it or in it.
TEST(AmbientOcclusion, IsTakenByTheBodyInWhichTheEyeIs)
{
    for (const double eye : {5.0, 0.2}) {
        BodyStage stage;
        stage.put(level_square(1), matte_of(1), {0, -0.5, 0});
        stage.put(triangle_box(), body_of(1));
        stage.settings.integrator = IntegratorKind::Ao;
        stage.settings.spp = 64;
        stage.settings.ao_distance = 0.25f;  // all rays stay in the body
        const Vec3f seen = stage.seen(Camera::look_at({0, eye, 0}, {0, 0, 0}, {0, 0, -1}, 0.05f));
        expect_close(seen, left_after((eye > 1 ? 1.5 : 0.7) + 0.25), 1e-3);
    }
}

// A body that does not bend light is such a pane, and takes light on the way besides. An opaque pane shows itself alone, and
// a blended one its own share, as before.
TEST(AmbientOcclusion, IsTakenByBodiesAndOpaquePanes)
{
    BodyStage stage;
    stage.put(level_square(50), matte_of(1));
    stage.put(triangle_box(), body_of(1), {0, 1.01, 0}, {1000, 1, 1000});
    stage.settings.integrator = IntegratorKind::Ao;
    stage.settings.spp = 256;
    const Vec3f seen = stage.seen(Camera::look_at({0, 5, 0}, {0, 0, 0}, {0, 0, -1}, 0.05f));
    for (int c = 0; c < 3; ++c) {
        // The floor lies behind a way of 2, and rays to the sky take as much or more.
        EXPECT_LT(seen[c], left_after(4)[c]) << c;
        EXPECT_GT(seen[c], left_after(7)[c]) << c;
    }
    expect_close(floor_under(matte_of(0.5f), kNear, kFar), Vec3f(1), 1e-4);
    expect_close(floor_under(matte_of(0.5f), 0.6, kFar), Vec3f(0), 1);
    Material sheet = matte_of(0.5f);
    sheet.alpha_mode = AlphaMode::Blend;
    sheet.base_color.w = 0.5f;
    expect_close(floor_under(sheet, 0.6, kFar), Vec3f(0.5f), 0.02);
    expect_close(floor_under(sheet, kNear, kFar), Vec3f(0.75f), 0.02);
}

}  // namespace
}  // namespace occam::test
