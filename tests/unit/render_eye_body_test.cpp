// Tests of cameras within bodies that absorb light: their rays start in what the body takes.
#include "tests/support/body_stage.h"

namespace occam::test {
namespace {

Camera along_x(Vec3d eye) { return Camera::look_at(eye, eye + Vec3d(1, 0, 0), {0, 1, 0}, 0.001f); }

// An emissive or unlit box whose near side is half a length before the eye.
TEST(EyeInABody, SeesWhatIsInTheBodyThroughIt)
{
    for (const float ior : {1.0f, 1.5f})
        for (const bool is_unlit : {false, true})
            for (const IntegratorKind integrator : {IntegratorKind::Direct, IntegratorKind::Path}) {
                BodyStage stage;
                stage.settings.integrator = integrator;
                stage.put(triangle_box(), body_of(ior));
                Material thing = shining(3);
                if (is_unlit) {
                    thing = matte_of(1);
                    thing.unlit = true;
                }
                stage.put(triangle_box(), thing, {0.6, 0, 0}, Vec3d(0.1));
                expect_close(stage.seen(along_x({0, 0, 0})), (is_unlit ? 1.0f : 3.0f) * left_after(0.5), 1e-4);
            }
}

TEST(EyeInABody, SeesTheSkyThroughIt)
{
    // With reflectance r and the share t that is left after a width of 2, the internal reflections add up to
    // (1 - r) sqrt(t) / (1 - r t).
    for (const float ior : {1.0f, 1.0005f, 1.5f}) {
        BodyStage stage;
        stage.put(triangle_box(), body_of(ior));
        stage.scene.environment.radiance = Vec3f(1);
        stage.settings.width = stage.settings.height = 16;
        stage.settings.spp = 256;
        const float r = ior < 1.01f ? 0 : 0.04f;
        const Vec3f expected = (1 - r) * left_after(1) / (Vec3f(1) - r * left_after(2));
        expect_close(stage.seen(along_x({0, 0, 0})), expected, ior < 1.01f ? 1e-4 : 3e-3);
    }
}

// The lamp is within the body or without, above the eye.
TEST(EyeInABody, SeesAFloorInTheBodyAsItIsLitThroughIt)
{
    for (const IntegratorKind integrator : {IntegratorKind::Direct, IntegratorKind::Path})
        for (const double lamp : {0.75, 4.0}) {
            const auto seen = [&](bool has_body) {
                BodyStage stage;
                stage.settings.integrator = integrator;
                stage.put(level_square(5), matte_of(1), {0, -0.5, 0});
                stage.put(Light{"lamp", PointLight{Vec3f(1)}}, {0, lamp, 0});
                if (has_body) stage.put(triangle_box(), body_of(1), {}, {9, 1, 9});
                return stage.seen_from({0, 0.25, 0});
            };
            expect_close(seen(true) / seen(false), left_after(0.75 + std::min(lamp, 1.0) + 0.5), 1e-3);
        }
}

TEST(EyeInABody, SeesThroughALensAsThroughAPinhole)
{
    BodyStage stage;
    stage.put(triangle_box(), body_of(1.5f));
    stage.put(triangle_box(), shining(1), {0.6, 0, 0}, Vec3d(0.1, 0.5, 0.5));
    for (const float focus : {0.1f, 0.5f, 0.8f}) {
        Camera camera = along_x({0, 0, 0});
        camera.lens.radius = 0.001f;
        camera.lens.focus = focus;
        expect_close(stage.seen(camera), left_after(0.5), 1e-4);
    }
}

// The rays of an orthographic camera start on both sides of a face of the body.
TEST(EyeInABody, IsSoughtForEachRayThatStartsElsewhere)
{
    BodyStage stage;
    stage.put(triangle_box(), body_of(1.5f), {0, 0, -1});
    stage.put(triangle_box(), shining(1), {0.6, 0, 0}, Vec3d(0.1, 0.5, 0.5));
    Camera camera = along_x({0, 0, 0});
    camera.lens.orthographic = true;
    camera.lens.height = 0.5f;
    stage.settings.width = stage.settings.height = 8;
    const Image image = Renderer({.threads = 1}).render(stage.scene, camera, stage.settings);
    const auto& pixels = image.find("beauty")->pixels;
    for (std::size_t i = 0; i < 64; ++i) {
        const Vec3f expected = i % 8 < 4 ? left_after(0.5) : Vec3f(1);  // +z, which is without, is on the right
        expect_close({pixels[4 * i], pixels[4 * i + 1], pixels[4 * i + 2]}, expected, 1e-4);
    }
}

TEST(EyeInABody, ThatMovesIsWithinForAPartOfTheTime)
{
    for (const bool camera_moves : {true, false}) {
        BodyStage stage;
        const NodeId body = stage.put(triangle_box(), body_of(1.5f));
        stage.put(triangle_box(), shining(1), {0.6, 0, 0}, Vec3d(0.1, 0.5, 9));
        stage.settings.spp = 256;
        Camera camera = along_x({0, 0, camera_moves ? 1 : 0});
        if (camera_moves) {
            camera.keys = {along_x({0, 0, 0}).world_from_camera, along_x({0, 0, 2}).world_from_camera};
        } else {
            stage.scene.record_shutter(1, [&](double tau) {
                Trs place;
                place.translation = {0, 0, -2 * tau};
                stage.scene.set_transform(body, place);
            });
        }
        expect_close(stage.seen(camera), 0.5f * left_after(0.5) + Vec3f(0.5f), 5e-3);
    }
}

// Other bodies and opaque things lie above the eye, and an opaque box is about it.
TEST(EyeInABody, KnowsTheBodyBehindOtherThings)
{
    BodyStage stage;
    stage.put(triangle_box(), body_of(1.5f), {}, Vec3d(1, 40, 1));
    stage.put(triangle_box(), body_of(1.5f, {0.1f, 0.1f, 0.1f}), {0, 3, 0}, Vec3d(0.5));
    stage.put(triangle_box(), body_of(1.0f, {0.2f, 0.2f, 0.2f}), {0, -3, 0}, Vec3d(0.5));
    stage.put(triangle_box(), shining(1), {}, Vec3d(0.6));
    for (int k = 0; k < 40; ++k) stage.put(level_square(0.5), matte_of(1), {0, 6 + 0.5 * k, 0});
    expect_close(stage.seen(along_x({0, 0, 0})), left_after(0.6), 1e-4);
}

// The eye is beside a body, above or below it, behind a sheet that bounds nothing, or in a body that cameras do not see.
TEST(EyeInABody, TakesNothingOutsideOfIt)
{
    for (const Vec3d at : {Vec3d(0, 0, 3), Vec3d(0, 3, 0), Vec3d(0, -3, 0)})
        for (const double hand : {1.0, -1.0}) {
            BodyStage stage;
            stage.put(triangle_box(), body_of(1.5f), at, {hand, 1, 1});
            stage.put(triangle_box(), shining(1), {}, Vec3d(0.6));
            expect_close(stage.seen(along_x({0, 0, 0})), Vec3f(1), 1e-6);
        }
    BodyStage sheets, hidden;
    sheets.put(level_square(9), body_of(1.5f), {0, 0.2, 0});
    sheets.put(level_square(9), body_of(1.0f), {0, 0.4, 0});
    sheets.put(triangle_box(), shining(1), {}, Vec3d(0.6));
    expect_close(sheets.seen(along_x({0, 0, 0})), Vec3f(1), 1e-6);
    hidden.scene.set_seen_by(hidden.put(triangle_box(), body_of(1.5f)), std::uint8_t(RayKind::All & ~RayKind::Camera));
    hidden.put(triangle_box(), shining(1), {}, Vec3d(0.6));
    expect_close(hidden.seen(along_x({0, 0, 0})), Vec3f(1), 1e-6);
}

TEST(EyeInABody, IsTheSameInAnySizeOfTheWorldAndMirrored)
{
    for_sizes_and_hands([](double size, double hand) {
        BodyStage stage;
        Material m = body_of(1.3f);
        m.attenuation_distance = float(size);
        stage.put(triangle_box(), m, {}, Vec3d(hand, 1, 1) * size);
        stage.put(triangle_box(), shining(1), {}, Vec3d(0.6 * size));
        expect_close(stage.seen(along_x({0, 0, 0})), left_after(0.6), 1e-4);
    });
}

// The lens is cut by the surface of the body, so that each sample asks for itself.
TEST(EyeInABody, IsTheSameForAnyThreadsAndBudget)
{
    BodyStage stage;
    stage.put(torus(), body_of(1.3f), {}, Vec3d(2));
    stage.put(torus(), matte_of(0.7f), {2.2, 0, 0}, Vec3d(0.3));
    stage.scene.environment.radiance = Vec3f(1);
    stage.settings.width = 32;
    stage.settings.height = 18;
    stage.settings.spp = 4;
    Camera camera = Camera::look_at({2.7, 0.1, 0.3}, {0, 0, 0}, {0, 1, 0}, 1);
    camera.lens.radius = 0.3f;
    camera.lens.focus = 2;
    std::uint64_t checksum = 0;
    for (const int threads : {1, 3})
        for (const std::size_t memory : {std::size_t(1) << 30, Renderer({.threads = threads}).memory_floor(stage.scene)}) {
            Renderer renderer({.threads = threads, .memory_bytes = memory});
            const Image image = renderer.render(stage.scene, camera, stage.settings);
            EXPECT_GT(renderer.stats().rays.primary, 2u * 32 * 18 * 4);
            if (checksum == 0) checksum = image.checksum();
            EXPECT_EQ(image.checksum(), checksum) << threads << " threads, " << memory << " bytes";
        }
}

// A scene whose bodies absorb nothing takes no ray more than one without bodies.
TEST(EyeInABody, IsNotSoughtWhereNoBodyAbsorbs)
{
    const auto rays = [](float distance) {
        BodyStage stage;
        Material m = body_of(1.5f);
        m.attenuation_distance = distance;
        stage.put(triangle_box(), m);
        stage.put(triangle_box(), shining(1), {}, Vec3d(0.6));
        Renderer renderer({.threads = 1});
        renderer.render(stage.scene, along_x({0, 0, 0}), stage.settings);
        return renderer.stats().rays.primary;
    };
    EXPECT_EQ(rays(0), 4u * 4 * 16);
    EXPECT_GT(rays(1), rays(0));
    EXPECT_LE(rays(1), rays(0) + 8) << "it is sought once for a worker";
}

// Layers describe surfaces, and `ao` and the debug views show no colours of bodies.
TEST(EyeInABody, ChangesNoLayerNorView)
{
    const auto picture = [](float distance, View view, IntegratorKind integrator) {
        BodyStage stage;
        Material m = body_of(1.5f);
        m.attenuation_distance = distance;
        stage.put(triangle_box(), m, {}, Vec3d(2));
        stage.put(torus(), matte_of(0.5f), {}, Vec3d(0.5));
        stage.scene.environment.radiance = Vec3f(1);
        stage.settings.view = view;
        stage.settings.integrator = integrator;
        stage.settings.aovs = {Aov::Depth, Aov::Albedo, Aov::Normal};
        return Renderer({.threads = 1})
            .render(stage.scene, Camera::look_at({0, 1, 1}, {0, 0, 0}, {0, 1, 0}, 0.6f), stage.settings);
    };
    for (const View view : {View::Beauty, View::Normal})
        for (const IntegratorKind integrator : {IntegratorKind::Ao, IntegratorKind::Path}) {
            const Image clear = picture(0, view, integrator), murky = picture(1, view, integrator);
            for (const char* layer : {"depth", "albedo", "normal"}) {
                ASSERT_TRUE(clear.find(layer)) << layer;
                EXPECT_EQ(clear.find(layer)->pixels, murky.find(layer)->pixels) << layer;
            }
            const bool is_same = view != View::Beauty || integrator == IntegratorKind::Ao;
            EXPECT_EQ(clear.find("beauty")->pixels == murky.find("beauty")->pixels, is_same);
        }
}

}  // namespace
}  // namespace occam::test
