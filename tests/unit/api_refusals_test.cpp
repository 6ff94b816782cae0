// Tests of directions, choices and numbers that applications give, at the ends of what is allowed and beyond.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/unit_vector.h"
#include "occam/occam.h"
#include "tests/support/shape_builders.h"
#include "tests/support/temp_folder.h"

namespace occam {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <class Call>
std::string error_of(Call&& call)
{
    try {
        call();
    } catch (const Error& error) {
        return error.what();
    }
    return "no Error";
}

TEST(UnitVector, LengthsMayBeAny)
{
    const Vec3d way(3, -4, 12), unit = way / 13.0;
    for (const int exponent : {-1020, -600, 0, 600, 1019}) {
        const Vec3d found = unit_vector(way * std::ldexp(1.0, exponent));
        EXPECT_EQ(found, unit) << exponent;
    }
    EXPECT_EQ(unit_vector({0, 5e-324, 0}), Vec3d(0, 1, 0));
    for (const Vec3d none : {Vec3d(0), Vec3d(0, kInfinity, 0), Vec3d(0, 1, NAN)}) EXPECT_EQ(unit_vector(none), Vec3d(0));
}

TEST(CameraDirections, UpMayHaveAnyLengthButHasToBeADirection)
{
    const auto looking = [](Vec3d up) { return Camera::look_at({0, 0, 5}, {0, 0, 0}, up, 0.7f).world_from_camera; };
    const auto fitting = [](Vec3d up) { return CameraFit(ViewFrom::Front, up, 0.7f, 1).camera().world_from_camera; };
    for (const double length : {1e-300, 1e-200, 1e200, 1e300}) {
        EXPECT_EQ(looking({0, length, 0}), looking({0, 1, 0})) << length;
        EXPECT_EQ(fitting({0, length, 0}), fitting({0, 1, 0})) << length;
    }
    EXPECT_EQ(Camera::look_at({0, 0, 1e200}, {0, 0, 0}, {0, 1, 0}, 0.7f).eye(), Vec3d(0, 0, 1e200));
    for (const Vec3d none : {Vec3d(0), Vec3d(NAN, 1, 0), Vec3d(0, kInfinity, 0)}) {
        EXPECT_NE(error_of([&] { looking(none); }).find("the direction up must be finite and not zero"), std::string::npos);
        EXPECT_NE(error_of([&] { fitting(none); }).find("a direction must be finite and not zero (up)"), std::string::npos);
        EXPECT_THROW(Camera::look_at(none, none, {0, 1, 0}, 0.7f), Error);
    }
}

TEST(CameraDirections, AViewAlongUpIsFoundAtAnyLength)
{
    EXPECT_TRUE(is_along({0, 3, 0}, {0, 1e-200, 0}));
    EXPECT_TRUE(is_along({1, 2, 3}, {-3, -6, -9}));
    EXPECT_FALSE(is_along({0, 3, 1e-3}, {0, 1e-200, 0}));
    EXPECT_FALSE(is_along({1e200, 0, 0}, {0, 1e-200, 0}));
}

TEST(Query, ASurfaceAtTheEndOfARayIsWithinIt)
{
    Scene scene;
    NodeDesc desc;
    desc.cages = {scene.add(test::creased_cube(0))};
    scene.add_node(scene.root(), desc);
    const Query query(scene, Camera::look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 0.8f));
    for (int i = 0; i < 100; ++i) {
        const Vec3d from(0.1, 0.2, 3 + 0.37 * i), way(0.001 * i, -0.01, -1);
        const std::optional<Hit> hit = query.closest(from, way);
        if (!hit) continue;
        EXPECT_TRUE(query.closest(from, way, hit->distance)) << i;
        EXPECT_TRUE(query.closest(from, way, hit->distance * (1 + 1e-8))) << i;
        EXPECT_TRUE(query.is_occluded({from, way, hit->distance})) << i;
        EXPECT_FALSE(query.closest(from, way, hit->distance * (1 - 1e-6))) << i;
    }
    EXPECT_FALSE(query.closest({0, 0, 5}, {0, 0, -1}, 0));
    EXPECT_FALSE(query.closest({0, 0, 5}, {0, 0, -1}, -1));
    EXPECT_TRUE(query.closest({0, 0, 5}, {0, 0, -1}, 1e300));
}

TEST(Query, PickThrowsAfterTheEndWhateverItIsAsked)
{
    Scene scene;
    Query query(scene, Camera());
    EXPECT_FALSE(query.pick(NAN, 0, 10));
    const std::string waits = error_of([&] { scene.add_node(scene.root(), NodeDesc()); });
    EXPECT_NE(waits.find("Query::end()"), std::string::npos) << waits;
    query.end();
    EXPECT_THROW(query.pick(NAN, 0, 10), Error);
    EXPECT_THROW(query.pick(0, 0, 10), Error);
}

TEST(Animation, AMomentJustBeforeALoopIsItsFirstOne)
{
    EXPECT_EQ(looped({0, 1}, -1e-20), 0);
    EXPECT_EQ(looped({0, 1}, 1), 0);
    EXPECT_EQ(looped({2, 5}, 2 - 1e-16), 2);
    EXPECT_EQ(looped({0, 1}, -0.25), 0.75);
}

TEST(Choices, ThatDoNotExistAreRefused)
{
    Scene scene;
    const auto refuses = [&](auto content) { EXPECT_THROW(scene.add(std::move(content)), Error); };
    Cage cage = test::creased_cube(0);
    EXPECT_NO_THROW(scene.add(cage));
    const auto with = [&](auto change) {
        Cage changed = cage;
        change(changed);
        return changed;
    };
    refuses(with([](Cage& c) { c.scheme = Scheme(9); }));
    refuses(with([](Cage& c) { c.boundary = BoundaryRule(9); }));
    refuses(with([](Cage& c) { c.face_varying = FaceVaryingRule(77); }));
    refuses(with([](Cage& c) { c.displacement.emplace().space = Displacement::Space(3); }));
    refuses(with([](Cage& c) { c.displacement.emplace().texture.wrap_t = TextureUse::Wrap(3); }));
    Material material;
    material.alpha_mode = AlphaMode(7);
    refuses(material);
    material.alpha_mode = AlphaMode::Blend;
    material.normal_texture.wrap_s = TextureUse::Wrap(3);
    refuses(material);
    Texture texture;
    texture.role = TextureRole(2);
    refuses(texture);
    AreaLight area;
    area.shape = AreaLight::Shape(9);
    refuses(Light{"area", area});
    Clip clip;
    clip.channels.resize(1);
    clip.channels[0].interpolation = Channel::Interpolation(200);
    refuses(clip);
    clip.channels[0].interpolation = Channel::Interpolation::Linear;
    clip.channels[0].path = Channel::Path(4);
    refuses(clip);
    EXPECT_THROW(framing(scene, 1, ViewFrom(9)), Error);
    for (const Aov aov : {Aov(20), Aov(40), Aov(255)})
        EXPECT_THROW(Renderer({.threads = 1}).render(scene, Camera(), {.width = 4, .height = 4, .aovs = aov}), Error);
    const test::TempFolder folder;
    const Image image = Renderer({.threads = 1}).render(scene, Camera(), {.width = 4, .height = 4, .spp = 1});
    EXPECT_THROW(image.write(folder.path() / "a.png", {.tonemap = Tonemap(9)}), Error);
    EXPECT_NO_THROW(image.write(folder.path() / "a.png", {.tonemap = Tonemap::Filmic}));
}

TEST(Api, NumbersOfWorkersAreNotBelow0)
{
    EXPECT_THROW(Renderer({.threads = -1}), Error);
    EXPECT_THROW(Renderer({.workers_a_tree = -1}), Error);
    EXPECT_NO_THROW(Renderer({.threads = 0, .workers_a_tree = 0}));
}

// An application may add layers step by step.
TEST(Api, SetsOfLayersHaveAName)
{
    static_assert(std::is_same_v<occam::AovSet, decltype(Settings::aovs)>);
    occam::AovSet aovs;
    for (const Aov aov : {Aov::Depth, Aov::Normal}) aovs |= aov;
    EXPECT_TRUE(aovs.has(Aov::Normal));
}

TEST(Api, AWarningOfATextureWithoutANameHasASubject)
{
    Scene scene;
    Texture texture;
    texture.width = texture.height = 1;
    texture.pixels = {Vec4f(NAN, 1, 1, 1)};
    Material material;
    material.base_color_texture.texture = scene.add(std::move(texture));
    Cage square = test::textured_square();
    square.materials = {scene.add(material)};
    NodeDesc desc;
    desc.cages = {scene.add(std::move(square))};
    scene.add_node(scene.root(), desc);
    Renderer renderer({.threads = 1});
    renderer.render(scene, framing(scene), {.width = 4, .height = 4, .spp = 1});
    ASSERT_FALSE(renderer.stats().warnings.empty());
    EXPECT_EQ(renderer.stats().warnings.front().find("a texture without a name: texels that are not finite"), 0u)
        << renderer.stats().warnings.front();
}

// What a camera is made with and what a frame accepts is the same.
TEST(Api, AnglesOfViewAreThoseThatFramesAccept)
{
    const auto looks = [](float fov) { return Camera::look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, fov); };
    for (const float fov : {0.0f, -1.0f, 9e-6f, 3.1412f, 4.0f, std::nanf(""), float(kInfinity)}) {
        const std::string rule = "the angle of view must be from 0.00001 to 3.14 radians";
        EXPECT_NE(error_of([&] { looks(fov); }).find(rule), std::string::npos) << fov;
        EXPECT_NE(error_of([&] { CameraFit(ViewFrom::Front, {0, 1, 0}, fov, 1); }).find(rule), std::string::npos) << fov;
    }
    Scene scene;
    test::place(scene, scene.add(test::torus()), Vec3d(0));
    Renderer renderer({.threads = 1});
    for (const float fov : {kNarrowestView, kWidestView}) {
        EXPECT_NO_THROW(CameraFit(ViewFrom::Front, {0, 1, 0}, fov, 1));
        EXPECT_NO_THROW(renderer.render(scene, looks(fov), {.width = 4, .height = 4, .spp = 1})) << fov;
    }
}

TEST(Api, AnAspectIsFiniteAndAbove0)
{
    Scene scene;
    const Box3d box{Vec3d(-1), Vec3d(1)};
    for (const float aspect : {0.0f, -1.0f, std::nanf(""), float(kInfinity)}) {
        const std::string rule = "the aspect must be finite and above 0";
        EXPECT_NE(error_of([&] { framing(scene, aspect); }).find(rule), std::string::npos) << aspect;
        EXPECT_NE(error_of([&] { Camera::framing(box, aspect); }).find(rule), std::string::npos) << aspect;
        EXPECT_NE(error_of([&] {
                      CameraFit(ViewFrom::Front, {0, 1, 0}, 0.7f, aspect);
                  }).find(rule),
                  std::string::npos)
            << aspect;
    }
}

TEST(Api, RefusalsOfSizesAreSentences)
{
    Scene scene;
    const Camera camera = framing(scene);
    const std::string rule = "it must be from 1 to 65536 pixels";
    for (const int side : {0, -5, 65537}) {
        const auto records = [&] {
            record_shutter(
                scene, [](double) {}, [&] { return camera; }, side);
        };
        EXPECT_NE(error_of(records).find(rule), std::string::npos) << side;
        EXPECT_NE(error_of([&] { Query(scene, camera, side); }).find(rule), std::string::npos) << side;
        EXPECT_NE(error_of([&] { Query(scene, camera).pick(1, 1, side); }).find(rule), std::string::npos) << side;
    }
}

// A name that is neither a member nor an option cannot be looked up, and what is out of a range that is stated is named.
TEST(Api, RefusalsNameTheMemberAndItsValue)
{
    Scene scene;
    const Camera camera = framing(scene);
    const auto refused = [&](const Settings& settings) {
        return error_of([&] { Renderer().render(scene, camera, settings); });
    };
    EXPECT_EQ(refused({.filter_radius = 16.5f}), "expected from 0 to 16 pixels, not 16.5 (filter_radius)");
    EXPECT_EQ(refused({.ao_distance = -1}), "expected 0 or more, world length, not -1 (ao_distance)");
    EXPECT_EQ(refused({.width = 0, .height = 7}), "expected from 1 to 65536 pixels a side, not 0x7 (size)");
    EXPECT_EQ(error_of([] { Renderer(Resources{.workers_a_tree = -2}); }), "expected 0 or more, not -2 (workers_a_tree)");
    EXPECT_EQ(error_of([&] { Query(scene, camera, 0); }), "it must be from 1 to 65536 pixels, not 0 (image_height)");
    Renderer renderer;
    Job job = renderer.start(scene, camera, {.width = 4, .height = 4, .spp = 1}, "x");
    EXPECT_EQ(error_of([&] { job.stats(); }), "the checkpoint was not made by this version");
    EXPECT_EQ(error_of([] { Image::check_writable(""); }), "the name of the file is empty");
    EXPECT_EQ(error_of([] { Image(1, 1).write(""); }), "the name of the file is empty");
}

TEST(Api, SettingsOfVerifyHaveRanges)
{
    Scene scene;
    std::ostringstream out;
    const Cage cage = test::torus(4, 4, false);
    const auto expect_refused = [&](const VerifySettings& settings, const char* rule) {
        for (const std::string& found :
             {error_of([&] { verify(cage, Mat4d(1), settings); }), error_of([&] { verify(scene, settings); }),
              error_of([&] { replay(scene, settings, "", out); })})
            EXPECT_NE(found.find(rule), std::string::npos) << found;
    };
    for (const int rate : {0, -1, 3, 512, 65536, std::numeric_limits<int>::max(), std::numeric_limits<int>::min()})
        expect_refused({.largest_rate = rate}, "it must be a power of two from 1 to 256, not ");
    for (const float overlap : {std::nanf(""), -1.0f, float(kInfinity), 1e30f})
        expect_refused({.overlap_ulps = overlap}, "it must be from 0 to 65536 ulps, not ");
    expect_refused({.rays = kMostVerifyRays + 1}, "there can be at most");
    expect_refused({.largest_rate = 3}, "not 3 (largest_rate)");
    expect_refused({.overlap_ulps = -1}, "(overlap_ulps)");
    for (const float overlap : {0.0f, kWidestVerifyOverlap}) {
        const VerifiedCage found = verify(cage, Mat4d(1), {.rays = 2'048, .largest_rate = 2, .overlap_ulps = overlap});
        EXPECT_TRUE(found.holds()) << overlap << ": " << found.escaped;
        EXPECT_GT(found.rays, 0u);
    }
    EXPECT_NO_THROW(verify(cage, Mat4d(1), {.rays = 0, .largest_rate = 1}));
}

TEST(Api, AnImageOfSidesBelow0HasNoLayers)
{
    const std::vector<std::string> channels{"R", "G", "B", "A"};
    constexpr int kMost = std::numeric_limits<int>::max();
    constexpr int kSides[][2] = {{-4, 4}, {4, -4}, {-4, -4}, {kMost, kMost}};
    for (const auto& [width, height] : kSides) {
        Image image(width, height);
        EXPECT_THROW(image.add_layer("beauty", channels), Error) << width << " x " << height;
        EXPECT_TRUE(image.layers().empty());
    }
    EXPECT_TRUE(Image(0, 4).add_layer("beauty", channels).pixels.empty());
    EXPECT_EQ(Image(3, 4).add_layer("beauty", channels).pixels.size(), 48u);
}

TEST(Api, AChannelWithoutKeysChangesNothing)
{
    for (const Channel::Path path : {Channel::Path::Translation, Channel::Path::Rotation}) {
        Channel channel;
        channel.path = path;
        channel.width = path == Channel::Path::Rotation ? 4 : 3;
        double values[4] = {1, 2, 3, 4};
        evaluate(channel, 0.5, {values, std::size_t(channel.width)});
        for (int i = 0; i < 4; ++i) EXPECT_EQ(values[i], i + 1);
        Scene scene;
        channel.target = scene.add_node(scene.root(), {.place = {.translation = {1, 2, 3}}});
        scene.pose(scene.add(Clip{"still", {channel}}), 0.5);
        EXPECT_EQ(scene.world_from_node(channel.target), test::moved(1, 2, 3));
    }
}

// Some messages had the name alone, "(wheel)", and some the kind as well.
TEST(Api, MessagesNameElementsByKindAndName)
{
    Scene scene;
    const NodeId node = scene.add_node(scene.root(), {.name = "wheel"}), nameless = scene.add_node(scene.root(), {});
    Cage square = test::textured_square();
    square.name = "tile";
    const CageId cage = scene.add(std::move(square));
    const auto ends_with = [](const std::string& text, const std::string& end) { return text.ends_with(end); };
    EXPECT_PRED2(ends_with, error_of([&] { scene.set_parent(node, node); }), " (node 'wheel')");
    EXPECT_PRED2(ends_with, error_of([&] { scene.set_parent(nameless, nameless); }), " (node)");
    EXPECT_PRED2(ends_with, error_of([&] { scene.copy(node, node); }), " (node 'wheel')");
    EXPECT_PRED2(ends_with, error_of([&] { scene.write_vertices(cage, {}); }), " (cage 'tile': 0 for 4)");
    EXPECT_PRED2(ends_with, error_of([&] {
                     OnDemandCage later;
                     later.name = "later";
                     scene.add(later);
                 }),
                 " (cage 'later')");
    EXPECT_PRED2(ends_with, error_of([&] {
                     Skin skin;
                     skin.name = "hide";
                     skin.joint_from_mesh = {Mat4d(1)};
                     scene.add(std::move(skin));
                 }),
                 " (skin 'hide')");
    Clip clip;
    clip.name = "walk";
    EXPECT_PRED2(ends_with, error_of([&] { scene.pose(scene.add(std::move(clip)), NAN); }), " (clip 'walk')");
    Texture texture;
    texture.name = "bark";
    texture.pixels = {Vec4f(1)};
    EXPECT_PRED2(ends_with, error_of([&] { scene.add(texture); }), " (texture 'bark')");
}

TEST(Api, ADeadImageOfTheEnvironmentIsSaidToBeThat)
{
    Scene scene;
    scene.environment.image = TextureId{77, 3};
    const std::string why = error_of([&] { Renderer().render(scene, Camera(), {.width = 4, .height = 4, .spp = 1}); });
    EXPECT_EQ(why, "the image must be a texture of the scene that was not removed (environment)");
}

}  // namespace
}  // namespace occam
