// Tests of frames that find out, while they are made, that a texture cannot be read.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "occam/occam.h"
#include "tests/support/command_test.h"
#include "tests/support/shape_builders.h"

namespace occam {
namespace {

namespace fs = std::filesystem;

// Changes a byte in the middle of a PNG, so that its head is right and decoding it fails, or changes it back. That lies
// where the number of a picture does not look.
void flip_a_byte_of(const fs::path& png)
{
    std::string bytes = test::text_of(png);
    char& middle = bytes[bytes.size() / 2];
    middle = static_cast<char>(~middle);
    std::ofstream(png, std::ios::binary) << bytes;
}

void write_noise(const fs::path& png)
{
    constexpr int kLength = 320;
    Image image(kLength, kLength);
    std::uint32_t state = 1;
    for (float& value : image.add_layer("beauty", {"R", "G", "B"}).pixels)
        value = float((state = state * 1664525 + 1013904223) >> 8) / float(1 << 24);
    image.write(png);
    ASSERT_GT(fs::file_size(png), std::uintmax_t(200'000));
}

struct Unreadable : test::CommandTest {
    const fs::path png() const { return folder / "noise.png"; }

    void SetUp() override
    {
        test::CommandTest::SetUp();
        write_noise(png());
        flip_a_byte_of(png());
    }

    // A plain square fills the picture. A textured one before it is so small that few samples see it.
    Scene scene(double side) const
    {
        Scene scene;
        NodeDesc desc;
        desc.cages = {scene.add(test::textured_square())};
        scene.add_node(scene.root(), desc);
        Texture texture;
        texture.path = png();
        Material material;
        material.base_color_texture.texture = scene.add(std::move(texture));
        Cage small = test::textured_square();
        small.materials = {scene.add(material)};
        desc.cages = {scene.add(std::move(small))};
        desc.matrix = test::moved(0.9, -0.9, 0.1) *
                      Mat4d(Vec4d(side, 0, 0, 0), Vec4d(0, side, 0, 0), Vec4d(0, 0, 1, 0), Vec4d(0, 0, 0, 1));
        scene.add_node(scene.root(), desc);
        return scene;
    }
};

std::string error_of(const Job& job)
{
    try {
        job.stats();
    } catch (const Error& error) {
        return error.what();
    }
    return {};
}

TEST_F(Unreadable, ATextureEndsTheFrameWhenItIsLookedUp)
{
    Scene broken = scene(0.1);
    const Camera camera = Camera::framing(broken.bounds());
    for (const bool progressive : {false, true}) {
        Renderer renderer({.threads = 2});
        const Job job = renderer.start(broken, camera,
                                       {.width = 128, .height = 128, .spp = 4096, .progressive = progressive});
        EXPECT_NE(error_of(job).find("noise.png"), std::string::npos) << error_of(job);
        EXPECT_LT(job.progress().fraction, 0.1) << "the rest of the picture was made for nothing";
        EXPECT_THROW(job.image(), Error);
    }
}

// What was made since the texture proved unreadable would show in the picture that goes on.
TEST_F(Unreadable, ATextureLeavesTheSamplesThatWereMadeBefore)
{
    Scene broken = scene(0.004);
    const Camera camera = Camera::framing(broken.bounds());
    const Settings settings{.width = 128, .height = 128, .spp = 64, .progressive = true};
    Renderer renderer({.threads = 2});
    std::string checkpoint;
    {
        const Job job = renderer.start(broken, camera, settings);
        ASSERT_NE(error_of(job).find("noise.png"), std::string::npos);
        ASSERT_GT(job.progress().fraction, 0) << "the first samples do not see the texture";
        ASSERT_LT(job.progress().fraction, 1);
        checkpoint = job.checkpoint();
    }
    ASSERT_FALSE(checkpoint.empty());
    flip_a_byte_of(png());
    Scene whole = scene(0.004);
    const Job resumed = Renderer().start(whole, camera, settings, checkpoint);
    Renderer at_once;
    const Image expected = at_once.render(whole, camera, settings);
    const auto &p = resumed.image().layers()[0].pixels, &q = expected.layers()[0].pixels;
    ASSERT_EQ(p.size(), q.size());
    EXPECT_EQ(std::memcmp(p.data(), q.data(), p.size() * sizeof(float)), 0);
    EXPECT_EQ(resumed.stats().image.samples, at_once.stats().image.samples);
}

// What was tested with a stand-in for a displacement would be another surface.
TEST_F(Unreadable, ADisplacementEndsTheTestOfClosedness)
{
    Scene broken;
    Texture texture;
    texture.path = png();
    Cage cage = test::torus();
    cage.uv_sets.push_back({.values = {{0.5f, 0.5f}}, .indices = std::vector<std::uint32_t>(cage.face_vertices.size(), 0)});
    Displacement& displacement = cage.displacement.emplace();
    displacement.texture.texture = broken.add(std::move(texture));
    displacement.scale = 0.01f;
    displacement.bound = 0.01f;
    test::place(broken, broken.add(std::move(cage)), {0, 0, 0});
    EXPECT_THROW(verify(broken, {.rays = 1, .largest_rate = 4}), Error);
    std::ostringstream out;
    EXPECT_THROW(replay(broken, {}, "origin 1 0 0, direction 1 0 0, footprint 0.1 0", out), Error);
    flip_a_byte_of(png());
    const std::vector<VerifiedCage> reports = verify(broken, {.rays = 1, .largest_rate = 4});
    EXPECT_EQ(reports[0].rays, 512u) << reports[0].not_testable;
}

// A frame does not end because of a texture that its scene no longer has.
TEST_F(Unreadable, ATextureThatIsRemovedIsForgotten)
{
    Scene broken = scene(0.1);
    const Camera camera = Camera::framing(broken.bounds());
    const Settings settings{.width = 16, .height = 16, .spp = 4};
    Renderer renderer({.threads = 1});
    EXPECT_THROW(renderer.render(broken, camera, settings), Error);
    Scene plain;
    NodeDesc desc;
    desc.cages = {plain.add(test::textured_square())};
    plain.add_node(plain.root(), desc);
    renderer.render(plain, camera, settings);
    EXPECT_TRUE(renderer.stats().complete);
}

// A renderer and a query that could not read a file read it again once it is repaired.
TEST_F(Unreadable, ATextureIsReadAgainOnceItIsRepaired)
{
    const std::string damaged = test::text_of(png());
    Scene broken = scene(1);
    const Camera camera = Camera::framing(broken.bounds());
    const Settings settings{.width = 16, .height = 16, .spp = 4};
    Renderer renderer({.threads = 1});
    EXPECT_THROW(renderer.render(broken, camera, settings), Error);
    EXPECT_THROW(renderer.render(broken, camera, settings), Error) << "it is damaged as before";
    std::ofstream(png(), std::ios::binary) << damaged.substr(0, 100);
    EXPECT_THROW(renderer.render(broken, camera, settings), Error) << "its head cannot be read";
    std::ofstream(png(), std::ios::binary) << damaged;
    flip_a_byte_of(png());
    const Image picture = renderer.render(broken, camera, settings);
    EXPECT_EQ(picture.checksum(), Renderer({.threads = 1}).render(broken, camera, settings).checksum());
}

TEST_F(Unreadable, AMaskIsReadAgainByAQueryOnceItIsRepaired)
{
    Scene scene;
    Texture texture;
    texture.path = png();
    Material mask;
    mask.alpha_mode = AlphaMode::Mask;
    mask.base_color_texture.texture = scene.add(std::move(texture));
    Cage square = test::textured_square();
    square.materials = {scene.add(mask)};
    test::place(scene, scene.add(std::move(square)), Vec3d(0));
    const Camera camera = Camera::framing(scene.bounds());
    constexpr int kSide = 64;
    Query query(scene, camera, kSide);
    const auto pick = [&] { return query.pick(kSide / 2, kSide / 2, kSide).has_value(); };
    EXPECT_THROW(pick(), Error);
    query.begin(camera);
    EXPECT_THROW(pick(), Error) << "it is damaged as before";
    flip_a_byte_of(png());
    query.begin(camera);
    EXPECT_TRUE(pick());
}

TEST_F(Unreadable, ATextureLeavesACheckpointBesideNoPicture)
{
    // Of the triangle, which fills the picture, few samples see a textured one in its middle.
    std::ofstream(folder / "a.obj") << "mtllib a.mtl\nv -9 -9 0\nv 9 -9 0\nv 0 9 0\nf 1 2 3\nv -0.06 0 0.1\nv 0.06 0 0.1\n"
                                       "v 0 0.12 0.1\nvt 0 0\nusemtl noise\nf 4/1 5/1 6/1\n";
    std::ofstream(folder / "a.mtl") << "newmtl noise\nmap_Kd noise.png\n";
    const std::vector<std::string> words{"render", "a.obj", "-o",    "a.exr", "--size", "96x64",
                                         "--spp",  "64",    "--exr", "float", "--seed", "1"};
    const auto with = [&](std::vector<std::string> more) {
        more.insert(more.begin(), words.begin(), words.end());
        return run(more);
    };
    const test::Outcome failed = with({"--checkpoint", "on"});
    EXPECT_EQ(failed.exit_code, test::kBadInput);
    EXPECT_NE(failed.err.find("noise.png"), std::string::npos) << failed.err;
    EXPECT_NE(failed.err.find("a.exr.checkpoint holds what was made until then"), std::string::npos) << failed.err;
    EXPECT_FALSE(fs::exists(folder / "a.exr"));
    ASSERT_TRUE(fs::exists(folder / "a.exr.checkpoint"));
    flip_a_byte_of(png());
    const test::Outcome resumed = with({"--resume", "--progress", "plain"});
    EXPECT_EQ(resumed.exit_code, test::kDone) << resumed.err;
    EXPECT_NE(resumed.err.find("going on"), std::string::npos) << resumed.err;
    const std::vector<float> pixels = Image::read(folder / "a.exr").layer(0).pixels;
    ASSERT_EQ(with({}).exit_code, test::kDone);
    EXPECT_EQ(Image::read(folder / "a.exr").layer(0).pixels, pixels);
}

}  // namespace
}  // namespace occam
