// Tests of bodies that do not bend light, since their refractive index is near 1: they absorb it by the length of its way.
#include "tests/support/body_stage.h"
#include "tests/support/statistics.h"

namespace occam::test {
namespace {

constexpr IntegratorKind kLit[] = {IntegratorKind::Direct, IntegratorKind::Path};

const Camera kAlongAxis = Camera::look_at({0, 0, 60}, {0, 0, 0}, {0, 1, 0}, 0.01f);

TEST(StraightBodies, TakeLightByTheLengthOfTheWayAtAnyRoughness)
{
    for (const float ior : {0.9995f, 1.0f, 1.0005f, 1.001f})
        for (const float roughness : {0.0f, 0.04f, 0.5f, 1.0f})
            for (const IntegratorKind integrator : kLit) {
                BodyStage stage;
                Material m = body_of(ior);
                m.roughness = roughness;
                m.base_color = {0.25f, 1, 0.81f, 1};
                stage.put(triangle_box(), m);
                stage.scene.environment.radiance = Vec3f(1);
                stage.settings.integrator = integrator;
                expect_close(stage.seen(kAlongAxis), Vec3f(m.base_color) * left_after(2), 1e-4);
            }
}

TEST(StraightBodies, TakeTheSameInAnySizeOfTheWorldAndMirrored)
{
    for_sizes_and_hands([](double size, double hand) {
        BodyStage stage;
        Material m = body_of(1);
        m.attenuation_distance = float(size);
        stage.put(triangle_box(), m, {}, Vec3d(hand, 1, 1) * size);
        stage.scene.environment.radiance = Vec3f(1);
        expect_close(stage.seen(Camera::look_at({0, 0, 60 * size}, {0, 0, 0}, {0, 1, 0}, 0.01f)), left_after(2), 1e-4);
    });
}

TEST(StraightBodies, AreShadedAtVerticesAsAtHits)
{
    BodyStage stage;
    Cage cube = creased_cube(0);
    cube.scheme = Scheme::Bilinear;
    stage.put(cube, body_of(1));
    stage.scene.environment.radiance = Vec3f(1);
    stage.settings.shade_at = ShadeAt::Vertex;
    expect_close(stage.seen(kAlongAxis), left_after(2), 1e-4);
}

// Two boxes of a height of 2 and 1 lie between a floor and a camera or lamps. A sheet that lets half of the light pass is
// within the upper one. What the floor shows is compared with what it shows without the boxes.
TEST(StraightBodies, TakeLightOfEveryKindOfLightOnItsWayToAFloor)
{
    enum class Lamp { Point, Sun, Area, Mesh };
    constexpr Vec3f kOther{0.9f, 0.6f, 0.4f};
    for (const Lamp lamp : {Lamp::Point, Lamp::Sun, Lamp::Area, Lamp::Mesh})
        for (const float roughness : {0.0f, 0.1f, 1.0f}) {
            const auto floor = [&](bool has_bodies) {
                BodyStage stage;
                Material m = matte_of(0.8f);
                m.metallic = roughness < 1 ? 1.0f : 0.0f;
                m.roughness = roughness;
                stage.put(level_square(50), m, {0, -4, 0});
                Material sheet = matte_of(0);
                sheet.base_color.w = 0.5f;
                sheet.alpha_mode = AlphaMode::Blend;
                if (has_bodies) {
                    stage.put(triangle_box(), body_of(1), {0, 1, 0}, {40, 1, 40});
                    stage.put(level_square(40), sheet, {0, 0.25, 0});
                    stage.put(triangle_box(), body_of(1.0005f, kOther), {0, -1, 0}, {40, 0.5, 40});
                }
                const Vec3d above(0, 60, 0);
                if (lamp == Lamp::Point) stage.put(Light{"lamp", PointLight{Vec3f(1)}}, above);
                if (lamp == Lamp::Sun) stage.put(Light{"lamp", SunLight{Vec3f(1)}});
                if (lamp == Lamp::Area)
                    stage.put(Light{"lamp", AreaLight{AreaLight::Shape::Rectangle, Vec2f(2), Vec3f(6)}}, above);
                Cage shade = level_square(1);
                std::swap(shade.face_vertices[1], shade.face_vertices[2]);
                std::swap(shade.face_vertices[4], shade.face_vertices[5]);
                if (lamp == Lamp::Mesh) stage.put(shade, shining(6), above);
                stage.settings.integrator = IntegratorKind::Path;
                stage.settings.spp = 64;
                return stage.seen_from({0, -2.5, 0});
            };
            const bool is_sharp = roughness == 0 && (lamp == Lamp::Point || lamp == Lamp::Sun);
            if (is_sharp) continue;  // a mirror does not show a lamp without a size
            const Vec3f without = floor(false);
            EXPECT_GT(without.x, 0);
            // Paths are up to 0.2 % longer than the height, and the pictures have other random numbers.
            expect_close(floor(true) / without, 0.5f * left_after(2) * left_after(1, kOther), 0.02,
                         lamp == Lamp::Mesh ? "mesh" : "light");
        }
}

// The floor and a lamp are within the body or without. The camera looks down from 1 above it.
TEST(StraightBodies, TakeLightOnlyOnThePartOfItsWayThatIsWithin)
{
    for (const IntegratorKind integrator : kLit)
        for (const double floor : {-0.5, -1.0, -3.0})
            for (const double lamp : {-0.2, 0.5, 4.0}) {
                const auto seen = [&](bool has_body) {
                    BodyStage stage;
                    stage.settings.integrator = integrator;
                    stage.put(level_square(9), matte_of(1), {0, floor, 0});
                    stage.put(Light{"lamp", PointLight{Vec3f(1)}}, {0, lamp, 0});
                    // The box is larger where the floor would coincide with its lower side.
                    if (has_body)
                        stage.put(triangle_box(), body_of(1), {0, floor == -1 ? -0.25 : 0, 0},
                                  {9, floor == -1 ? 1.25 : 1, 9});
                    return stage.seen_from({0, 2, 0});
                };
                const double bottom = std::max(floor, -1.0);
                expect_close(seen(true) / seen(false), left_after((1 - bottom) + (std::min(lamp, 1.0) - bottom)), 1e-3);
            }
}

// Thirty boxes with gaps between them lie above a floor, which is seen and lit through all of them.
TEST(StraightBodies, MayBeManyBehindEachOther)
{
    const auto seen = [](bool has_bodies) {
        BodyStage stage;
        stage.put(level_square(9), matte_of(1));
        stage.put(Light{"lamp", PointLight{Vec3f(1)}}, {0, 90, 0});
        for (int k = 0; has_bodies && k < 30; ++k) stage.put(triangle_box(), body_of(1), {0, 1 + k, 0}, {9, 0.01, 9});
        return stage.seen_from({0, 80, 0});
    };
    expect_close(seen(true) / seen(false), left_after(2 * 30 * 0.02), 1e-3);
}

// A point under a layer of thickness d sees of a white sky 2 E3(a d), where E3 is the exponential integral.
TEST(StraightBodies, TakeLightOfTheSkyInAmbientOcclusion)
{
    BodyStage stage;
    stage.put(level_square(1), matte_of(1), {0, -2, 0});
    stage.put(triangle_box(), body_of(1), {}, {4000, 0.5, 4000});
    stage.settings.integrator = IntegratorKind::Ao;
    stage.settings.spp = 4096;
    Vec3d expected(0);
    constexpr int kSteps = 100'000;
    for (int i = 0; i < kSteps; ++i) {
        const double cosine = (i + 0.5) / kSteps;
        expected += Vec3d(left_after(1 / cosine)) * (2 * cosine / kSteps);
    }
    expect_close(stage.seen_from({0, -1, 0}), Vec3f(expected), 0.01);
}

TEST(StraightBodies, AreFollowedBehindTheFocusOfALens)
{
    for (const double focus : {59.5, 60.0, 60.75, 61.5}) {
        BodyStage stage;
        stage.put(triangle_box(), body_of(1));
        stage.scene.environment.radiance = Vec3f(1);
        Camera camera = kAlongAxis;
        camera.lens.radius = 0.01f;
        camera.lens.focus = float(focus);
        expect_close(stage.seen(camera), left_after(2), 1e-4);
    }
}

// At index 1.002 a ray is bent by at most a few thousandths, and hardly any light is reflected.
TEST(StraightBodies, LookAsThoseThatBendLightALittle)
{
    const auto picture = [&](float ior) {
        BodyStage stage;
        stage.put(torus_mesh(40, 20), body_of(ior));
        stage.scene.environment.radiance = Vec3f(1);
        stage.settings.width = stage.settings.height = 24;
        return stage.seen(Camera::look_at({1, 2, 3}, {0, 0, 0}, {0, 1, 0}, 0.6f));
    };
    const Vec3f straight = picture(1.0005f);
    expect_close(straight, picture(1.002f), 3e-3);
    EXPECT_LT(straight.x, 0.9f);
}

// What is not glass, and a coat or sheen over it, reflects what does not pass. Sheen over an opaque base loses light anyway.
TEST(StraightBodies, ThatAreGlassInPartAreWhiteInAWhiteSky)
{
    for (const float transmission : {0.3f, 1.0f})
        for (const float metallic : {0.0f, 0.5f})
            for (const float coat : {0.0f, 1.0f})
                for (const float sheen : {0.0f, 1.0f}) {
                    if (sheen > 0 && (metallic > 0 || transmission < 1)) continue;
                    BodyStage stage;
                    Material m = body_of(1);
                    m.attenuation_distance = 0;
                    m.transmission = transmission;
                    m.metallic = metallic;
                    m.roughness = 0.3f;
                    m.clearcoat = coat;
                    m.sheen_color = Vec3f(sheen);
                    m.sheen_roughness = 0.5f;
                    stage.put(triangle_box(), m);
                    stage.scene.environment.radiance = Vec3f(1);
                    stage.settings.width = stage.settings.height = 8;
                    stage.settings.spp = 64;
                    stage.settings.bounces = 64;
                    const Vec3f seen = stage.seen(Camera::look_at({2, 3, 4}, {0, 0, 0}, {0, 1, 0}, 0.3f));
                    expect_close(seen, Vec3f(1), 0.012);
                }
}

TEST(StraightBodies, TakeNothingFromRaysThatDoNotSeeThem)
{
    for (const std::uint8_t hidden_from : {RayKind::Camera, RayKind::Shadow}) {
        const auto seen = [&](bool has_body) {
            BodyStage stage;
            stage.settings.integrator = IntegratorKind::Direct;
            stage.put(level_square(9), matte_of(1), {0, -3, 0});
            stage.put(Light{"lamp", PointLight{Vec3f(1)}}, {0, 4, 0});
            if (has_body)
                stage.scene.set_seen_by(stage.put(triangle_box(), body_of(1), {}, {9, 1, 9}),
                                        std::uint8_t(RayKind::All & ~hidden_from));
            return stage.seen_from({0, 5, 0});
        };
        expect_close(seen(true) / seen(false), left_after(2), 1e-3);
    }
}

TEST(StraightBodies, HaveTheSameBitsForAnyThreadsAndBudget)
{
    BodyStage stage;
    stage.put(level_square(5), matte_of(0.7f), {0, -1, 0});
    stage.put(torus(), body_of(1));
    stage.put(torus(), body_of(1.0005f, {0.3f, 0.9f, 0.6f}), {1.2, 0.2, 0.3});
    stage.put(torus(), matte_of(0.5f), {-1, 0.2, 0.3});
    add_lamp(stage.scene, {0, 4, 0});
    stage.settings.width = 80;
    stage.settings.height = 45;
    stage.settings.spp = 4;
    const Camera camera = Camera::framing(stage.scene.bounds());
    std::uint64_t checksum = 0;
    for (const int threads : {1, 3})
        for (const std::size_t memory : {std::size_t(1) << 30, Renderer({.threads = threads}).memory_floor(stage.scene)}) {
            Renderer renderer({.threads = threads, .memory_bytes = memory});
            const Image image = renderer.render(stage.scene, camera, stage.settings);
            if (checksum == 0) checksum = image.checksum();
            EXPECT_EQ(image.checksum(), checksum) << threads << " threads, " << memory << " bytes";
        }
}

// The shares of the surface that bend light and that are not there lead into the body and out of it alike, and outside of it
// nothing is absorbed. So an index that hardly bends light makes the same picture as one that does not.
TEST(BlendedBodies, TakeLightWithinThemAloneAtAnyIndex)
{
    for (const float ior : {1.0005f, 1.002f, 1.02f})
        for (const float alpha : {0.1f, 0.5f, 1.0f})
            for (const double wall : {-1.1, -2.0, -9.0}) {
                BodyStage stage;
                Material m = body_of(ior);
                m.alpha_mode = AlphaMode::Blend;
                m.base_color.w = alpha;
                stage.put(triangle_box(), m, {0, 0, 0}, {20, 1, 20});
                stage.put(level_square(20), shining(1), {0, wall, 0});
                stage.settings.spp = 256;
                // At normal incidence the two sides of the box reflect 2e-4 of the light at an index of 1.02.
                expect_close(stage.seen_from({0, 9, 0}), left_after(2), 5e-3);
            }
}

// One side of a box lets light pass beside its glass: it is not there, or it is metal where it is.
TEST(BlendedBodies, AreLeftAndEnteredWhereTheyAreNotOfGlass)
{
    for (const float ior : {1.0f, 1.01f})
        for (const Vec2f alpha_and_metal : {Vec2f(0, 0), Vec2f(0.01f, 1)})
            for (const double wall : {-2.0, -5.0}) {
                BodyStage stage;
                Material m = body_of(ior);
                m.alpha_mode = AlphaMode::Blend;
                m.base_color.w = 0.5f;
                Material lower = m;
                lower.base_color.w = alpha_and_metal.x;
                lower.metallic = alpha_and_metal.y;
                Cage box = triangle_box();
                for (std::size_t corner = 0; corner < box.face_vertices.size(); corner += 3) {
                    const auto is_low = [&](std::size_t k) { return box.positions[box.face_vertices[corner + k]].y < 0; };
                    box.face_slots.push_back(is_low(0) && is_low(1) && is_low(2));
                }
                box.materials = {stage.scene.add(m), stage.scene.add(lower)};
                NodeDesc desc;
                desc.place.scale = {20, 1, 20};
                desc.cages = {stage.scene.add(std::move(box))};
                stage.scene.add_node(stage.scene.root(), desc);
                stage.put(level_square(20), shining(1), {0, wall, 0});
                stage.settings.spp = 256;
                expect_close(stage.seen_from({0, 9, 0}), left_after(2), 0.015);  // 0.01 of metal lets nothing pass
            }
}

// A film dims a floor behind it, and the way from there to a lamp that does not shine through it.
TEST(BlendedBodies, TakeNothingFromLightThatComesToASurfaceBehindThem)
{
    const auto seen = [](bool has_film) {
        BodyStage stage;
        Material m = body_of(1.05f);
        m.alpha_mode = AlphaMode::Blend;
        m.base_color.w = 0.5f;
        if (has_film) stage.put(triangle_box(), m, {0, 1, 0}, {0.1, 0.001, 0.1});
        stage.put(level_square(9), matte_of(0.8f));
        stage.put(Light{"lamp", PointLight{Vec3f(1)}}, {3, 0.5, 0});
        stage.settings.spp = 256;
        return stage.seen_from({0, 3, 0});
    };
    expect_close(seen(true) / seen(false), left_after(0.002), 5e-3);
}

// The lamp is within the body, above a floor that is within it too: shadow rays start and end there.
TEST(BlendedBodies, TakeLightOfShadowRaysThatCrossTheirGaps)
{
    const auto seen = [](float ior) {
        BodyStage stage;
        Material m = body_of(ior);
        m.alpha_mode = AlphaMode::Blend;
        m.base_color.w = 0.01f;
        stage.put(triangle_box(), m, {0, 1, 0}, {9, 0.5, 9});
        stage.put(level_square(9), matte_of(0.8f));
        stage.put(Light{"lamp", PointLight{Vec3f(1)}}, {0, 2, 0});
        stage.settings.spp = 1024;
        stage.settings.integrator = IntegratorKind::Direct;
        return stage.seen_from({0, 0.4, 0});
    };
    // Shadow rays do not pass the hundredth of each side that bends light.
    expect_close(seen(1.01f), seen(1.0005f) * 0.99f * 0.99f, 5e-3);
}

// The box leaves the view half-way.
TEST(StraightBodies, ThatMoveTakeLightWhereTheyAreAtEachMoment)
{
    BodyStage stage;
    const NodeId body = stage.put(triangle_box(), body_of(1));
    stage.scene.environment.radiance = Vec3f(1);
    stage.settings.spp = 256;
    stage.scene.record_shutter(1, [&](double tau) {
        Trs place;
        place.translation = {2 * tau, 0, 0};
        stage.scene.set_transform(body, place);
    });
    expect_close(stage.seen(Camera::look_at({0, 0, 60}, {0, 0, 0}, {0, 1, 0}, 0.0001f)), 0.5f * left_after(2) + Vec3f(0.5f),
                 5e-3);
}

}  // namespace
}  // namespace occam::test
