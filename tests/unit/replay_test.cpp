// Tests of rays that are traced again and described: they are the rays of the picture and of the test of closedness.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include <algorithm>
#include <cstdlib>
#include <locale>
#include <sstream>

#include "command/replay_command.h"
#include "tests/support/command_test.h"
#include "tests/support/shape_builders.h"
#include "tests/support/textured_floor.h"
#include "verify/ray_line.h"

namespace occam {
namespace {

using namespace test;

// Returns a scene with a mirror, a pane of glass that lets light pass, a leaf with an alpha mask and a lamp.
Scene stage()
{
    Scene scene;
    Material mirror;
    mirror.name = "mirror";
    mirror.metallic = 1;
    mirror.roughness = 0.1f;
    Cage ring = torus();
    ring.materials = {scene.add(mirror)};
    place(scene, scene.add(std::move(ring)), {0, 0, 0});
    Material veil;
    veil.base_color = {0.9f, 0.5f, 0.2f, 0.5f};
    veil.alpha_mode = AlphaMode::Blend;
    Cage pane = floor_of(scene.add(veil), Scheme::Triangles);
    place(scene, scene.add(std::move(pane)), {0, 0.9, 0}, 0.5);
    place(scene, scene.add(floor_of(scene.add(Material()), Scheme::Triangles)), {0, -1, 0}, 3);
    add_lamp(scene, {1, 4, 2});
    return scene;
}

const Camera kCamera = Camera::look_at({0.5, 2, 4}, {0, 0, 0}, {0, 1, 0}, 0.8f);

TEST(Replay, AReplayedSampleHasTheBitsOfThePicture)
{
    for (const IntegratorKind kind : {IntegratorKind::Path, IntegratorKind::Direct, IntegratorKind::Ao}) {
        Scene scene = stage();
        Settings settings{.width = 24, .height = 16, .spp = 1, .integrator = kind};
        Renderer renderer({.threads = 2});
        const Image image = renderer.render(scene, kCamera, settings);
        const std::vector<float>& pixels = image.layers()[0].pixels;
        for (int y = 0; y < settings.height; ++y)
            for (int x = y % 3; x < settings.width; x += 3) {
                std::ostringstream out;
                const SampleColor color = renderer.replay(scene, kCamera, settings, {x, y}, out);
                const float* pixel = &pixels[static_cast<std::size_t>((y * settings.width + x) * 4)];
                ASSERT_EQ(Vec3f(pixel[0], pixel[1], pixel[2]), color.radiance) << x << ", " << y << '\n' << out.str();
                ASSERT_EQ(pixel[3], color.alpha) << x << ", " << y;
            }
    }
}

TEST(Replay, ASampleIsDescribedFromTheCameraToTheLight)
{
    Scene scene = stage();
    Renderer renderer({.threads = 1});
    std::ostringstream out;
    renderer.replay(scene, kCamera, {.width = 24, .height = 16, .spp = 4}, {12, 5, 3}, out);
    const std::string text = out.str();
    for (const char* part : {"sample 3 of pixel 12,5", "camera ray: origin (0.5, 2, 4)", "  levels ", "  node ", "  leaf ",
                             "    item ", "    igrid of node ", ": U ", ": hit at t ", "surface: node ",
                             "light sample: ", "shadow ray: ", "scattered by the ", "colour ("})
        EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' is missing in\n" << text;
}

// Behind sheets a ray ends by chance, and where it does the last line about it says so.
TEST(Replay, SaysWhatWasLeftToChance)
{
    Scene scene;
    Material veil;
    veil.base_color = {0.2f, 0.2f, 0.2f, 0.6f};
    veil.alpha_mode = AlphaMode::Blend;
    const CageId sheet = scene.add(floor_of(scene.add(veil), Scheme::Triangles));
    for (int i = 0; i < 12; ++i) place(scene, sheet, {0, -0.1 * i, 0}, 8);
    const Camera camera = Camera::look_at({0, 4, 0}, {0, 0, 0}, {0, 0, -1}, 0.5f);
    add_lamp(scene, {0, 2, 0});
    Renderer renderer({.threads = 1});
    int ended = 0;
    for (int x = 0; x < 16; ++x) {
        std::ostringstream out;
        renderer.replay(scene, camera, {.width = 16, .height = 16, .spp = 1, .bounces = 0}, {x, 8, 0}, out);
        const std::string text = out.str();
        EXPECT_NE(text.find(", the surface is lit: no"), std::string::npos) << text;
        EXPECT_NE(text.find("the shadow ray in direction "), std::string::npos) << text;
        if (text.find("  the background adds ") != std::string::npos) continue;
        ended += text.find(", the ray goes on: no") != std::string::npos;
        EXPECT_NE(text.find(", the ray goes on: no"), std::string::npos) << text;
    }
    EXPECT_GT(ended, 0);
}

/// The level of a hit is one of those that its ray sees, in world lengths as they are, whatever the frame's unit of length.
TEST(Replay, LevelsOfHitsAreThoseOfTheirRays)
{
    for (const double size : {1.0 / 512, 1.0, 512.0}) {
        Scene scene;
        Cage ring = torus(12, 8);
        ring.scheme = Scheme::CatmullClark;
        place(scene, scene.add(std::move(ring)), {0, 0, 0}, size);
        add_lamp(scene, Vec3d(1, 4, 2) * size);
        const Camera camera = Camera::look_at(Vec3d(0.5, 2, 4) * size, {0, 0, 0}, {0, 1, 0}, 0.8f);
        Renderer renderer({.threads = 1});
        int hits = 0;
        for (int x = 4; x < 20; ++x) {
            std::ostringstream out;
            renderer.replay(scene, camera, {.width = 24, .height = 16, .spp = 1}, {x, 8, 0}, out);
            std::istringstream lines(out.str());
            int finest = 1000, coarsest = -1000, level = 0;
            for (std::string line; std::getline(lines, line);) {
                if (line.find(" ray: ") != std::string::npos) finest = 1000, coarsest = -1000;
                if (std::sscanf(line.c_str(), "  levels %d and ", &level) == 1)
                    finest = std::min(finest, level), coarsest = std::max(coarsest, level);
                const std::size_t at = line.find(", level ");
                if (!line.starts_with("  hit: ") || at == std::string::npos) continue;
                level = std::atoi(line.c_str() + at + 8);
                ++hits;
                EXPECT_TRUE(level >= finest && level <= coarsest) << line << "\nsees " << finest << " to " << coarsest;
            }
        }
        EXPECT_GT(hits, 8) << size;
    }
}

TEST(Replay, SamplesThatThePictureDoesNotHaveAreRefused)
{
    Scene scene = stage();
    Renderer renderer({.threads = 1});
    const Settings settings{.width = 24, .height = 16, .crop_x0 = 0.5f, .spp = 4};
    std::ostringstream out;
    for (const PixelSample which : {PixelSample{24, 5, 0}, {11, 5, 0}, {12, 16, 0}, {12, -1, 0}, {12, 5, 4}, {12, 5, -1}})
        EXPECT_THROW(renderer.replay(scene, kCamera, settings, which, out), Error) << which.x << ',' << which.y;
    EXPECT_NO_THROW(renderer.replay(scene, kCamera, settings, {12, 5, 0}, out))
        << "the renderer and the scene are free again";
}

TEST(Replay, ViewsOfCostsShowEveryCameraRay)
{
    Scene scene = stage();
    Renderer renderer({.threads = 1});
    for (const render::ViewRow& row : render::kViews) {
        if (!row.is_cost) continue;
        const Image image = renderer.render(scene, kCamera, {.width = 24, .height = 16, .spp = 2, .view = row.view});
        const std::vector<float>& pixels = image.layers()[0].pixels;
        float brightest = 0;
        for (std::size_t i = 0; i < pixels.size(); i += 4) {
            EXPECT_NEAR(pixels[i + 3], 1, 1e-6f) << row.name << ": rays that hit nothing have a cost, too";
            for (std::size_t c = 0; c < 3; ++c) EXPECT_TRUE(pixels[i + c] >= 0 && pixels[i + c] <= 1.0001f) << row.name;
            brightest = std::max(brightest, pixels[i]);
        }
        EXPECT_GT(brightest, 0) << row.name;
    }
}

TEST(Replay, ALineOfARayHasAllItsBits)
{
    const RayLine line{3, {1.0 / 3, -2e-17, 1e30}, {0.6f, 0, -0.8f}, 1.0 / 7, -0.1f, 0.3f, -7};
    const RayLine read = read_ray_line(line.text());
    EXPECT_EQ(read.cage, line.cage);
    EXPECT_EQ(read.origin, line.origin);
    EXPECT_EQ(read.direction, line.direction);
    EXPECT_EQ(read.width, line.width);
    EXPECT_EQ(read.spread, line.spread);
    EXPECT_EQ(read.time, line.time);
    EXPECT_EQ(read.level, line.level);
    for (const char* wrong :
         {"", "origin 0 0 0", "origin 0 0, direction 0 0 1, footprint 1 0", "origin 0 0 0, direction 0 0 2, footprint 1 0",
          "origin 0 0 nan, direction 0 0 1, footprint 1 0", "origin 0 0 0, direction 0 0 1, footprint 1 0, time 2",
          "origin 0 0 0, direction 0 0 1, footprint 1 0, cage -1", "origin 0 0 0, direction 0 0 1, footprint 1 0, what 1",
          "origin 0 0 0, direction 0 0 1, footprint 1", "origin 0 0 0, direction 0 0 1, footprint 0 -1",
          "origin 0 0 0, direction 0 0 1, footprint -1 2", "origin 0 0 0, direction 0 0 1, footprint 1 0, level 0.5",
          "origin 0 0 0, direction 0 0 1, footprint 1 0, level 1e9"})
        EXPECT_THROW(read_ray_line(wrong), Error) << wrong;
}

// Writes 1234.5 as 1.234,5.
struct OtherNumbers : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
};

TEST(Replay, WritesNumbersAsInCWhateverTheLocaleOfTheApplication)
{
    struct Locale {
        std::locale before = std::locale::global(std::locale(std::locale::classic(), new OtherNumbers));
        ~Locale() { std::locale::global(before); }
    } const other;
    const RayLine line{1234, {1234.5, 0, 0}, {0, 0, 1}, 0.5, 0, 0};
    EXPECT_EQ(read_ray_line(line.text()).cage, line.cage) << line.text();
    EXPECT_EQ(read_ray_line(line.text()).origin, line.origin) << line.text();
    Scene scene;
    place(scene, scene.add(prism(4)), {0, 0, 0}, 0.5);
    std::ostringstream out;
    const Settings settings{.width = 2400, .height = 1600, .spp = 1};
    Renderer({.threads = 1}).replay(scene, kCamera, settings, {1200, 800, 0}, out);
    EXPECT_NE(out.str().find("of pixel 1200,800\n"), std::string::npos) << out.str();
    EXPECT_EQ(out.str().find("0,"), out.str().find("0,800")) << out.str();
    out << 1234;
    EXPECT_TRUE(out.str().ends_with("1.234")) << "the stream is as it was";
}

TEST(Replay, ARayOfTheTestOfClosednessIsTracedAgain)
{
    Scene scene;
    place(scene, scene.add(floor_of(scene.add(Material()), Scheme::Triangles)), {0, -1, 0}, 3);
    place(scene, scene.add(prism(7)), {0, 0, 0}, 0.5);
    std::size_t number = 0;
    while (!verify(scene, {.rays = 1})[number].not_testable.empty()) ++number;
    std::ostringstream out;
    RayLine inside{number, {0, 0, 0}, {0.6f, 0, -0.8f}, 0.01, 0.001f, 0};
    EXPECT_TRUE(replay(scene, {}, inside.text(), out));
    EXPECT_NE(out.str().find("The ray hits the cage."), std::string::npos) << out.str();
    RayLine away = inside;
    away.origin = {0, 0, -3};
    EXPECT_TRUE(replay(scene, {}, away.text(), out));
    EXPECT_NE(out.str().find("The ray starts outside of the surface"), std::string::npos) << out.str();
    for (const int level : {-30, -14, 20}) {
        RayLine other = away;
        other.level = level;
        EXPECT_THROW(replay(scene, {}, other.text(), out), Error) << level;
    }
    for (const std::size_t cage : {1 - number, std::size_t(2)}) {
        RayLine other = inside;
        other.cage = cage;
        EXPECT_THROW(replay(scene, {}, other.text(), out), Error) << cage;
    }
}

class ReplayCommand : public CommandTest {};

TEST_F(ReplayCommand, ASampleIsPrinted)
{
    const Outcome o = run({"render", "triangle.obj", "--size", "32x18", "--replay", "16,9"});
    EXPECT_EQ(o.exit_code, kDone) << o.err;
    EXPECT_NE(o.out.find("sample 0 of pixel 16,9"), std::string::npos) << o.out;
    EXPECT_NE(o.out.find(": hit at t "), std::string::npos) << o.out;
    const Outcome with_output = run({"render", "triangle.obj", "-o", "a.png", "--size", "32x18", "--replay", "16,9,2"});
    EXPECT_EQ(with_output.exit_code, kDone) << with_output.err;
    EXPECT_FALSE(fs::exists(folder / "a.png"));
    for (const char* where : {"32,9", "16,18", "16,9,16"}) {
        const Outcome refused = run({"render", "triangle.obj", "--size", "32x18", "--replay", where});
        EXPECT_EQ(refused.exit_code, kBadInput) << where;
        EXPECT_EQ(std::count(refused.err.begin(), refused.err.end(), '\n'), 1) << refused.err;
    }
    for (const char* where : {"16", "16,9,1,1", "-1,9", "a,b"})
        EXPECT_EQ(run({"render", "triangle.obj", "--replay", where}).exit_code, kBadInput) << where;
    EXPECT_EQ(run({"render", "triangle.obj"}).exit_code, kBadInput) << "without --replay a picture has to be named";
}

// The command that is printed for a ray that escapes works in a shell, whatever the name of the file.
TEST_F(ReplayCommand, ACommandThatIsPrintedTracesTheRay)
{
    for (const std::string file : {"it's a box.obj", "-box.obj"}) {
        std::ofstream(folder / file)
            << "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n"
               "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
        std::vector<std::string> words = {"anything", "verify", "--subdivide", "on", "--rays", "1000", "--seed=3", "--json"};
        if (file[0] == '-') words.push_back("--");
        words.push_back(file);
        std::vector<char*> argv;
        for (std::string& word : words) argv.push_back(word.data());
        const RayLine line{0, {0.1, 0, 0}, {0, 0.6f, 0.8f}, 0.01, -0.001f, 0};
        std::string text = command::replay_command(command::words_of_scene(argv), line.text());
        EXPECT_EQ(text.find("occam verify "), 0u) << text;
        EXPECT_EQ(text.find("--rays"), std::string::npos) << text;
        EXPECT_EQ(text.find("--seed"), std::string::npos) << text;
        EXPECT_EQ(text.find("--json"), std::string::npos) << text;
        text.replace(0, 5, std::string("'") + occam_executable() + "'");
        std::ofstream(folder / "replay.sh") << "cd '" << folder.string() << "'\n" << text << " > replay.txt\n";
        ASSERT_EQ(std::system(("sh '" + (folder / "replay.sh").string() + "'").c_str()), 0) << text;
        EXPECT_NE(text_of(folder / "replay.txt").find("The ray hits the cage."), std::string::npos);
    }
}

}  // namespace
}  // namespace occam
