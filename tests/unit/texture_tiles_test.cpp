// Tests of texture files that are read tile by tile: `occam texture` makes them, and no texel depends on it.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfStringAttribute.h>
#include <ImfTileDescription.h>
#include <ImfTiledOutputFile.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <cstring>
#include <fstream>
#include <random>
#include <thread>

#include "base/error.h"
#include "io/texture/texture_store.h"
#include "io/texture/tile_cache.h"
#include "io/texture/tiled_file.h"
#include "render/image.h"
#include "scenegraph/scene.h"
#include "tests/support/campaign.h"
#include "tests/support/command_test.h"
#include "tests/support/statistics.h"
#include "tests/support/temp_folder.h"

namespace occam::test {
namespace {

float uniform(std::mt19937& random, float least, float most)
{
    return least + (most - least) * static_cast<float>(random() >> 8) * 0x1p-24f;
}

MipImage random_image(int width, int height)
{
    std::mt19937 random(7);
    MipImage image(width, height);
    std::vector<Vec4f> row(static_cast<std::size_t>(width));
    for (int y = 0; y < height; ++y) {
        for (Vec4f& texel : row)
            for (int c = 0; c < 4; ++c) texel[c] = uniform(random, -0.5f, 3);
        image.write_row(y, row);
    }
    image.build_levels();
    return image;
}

// One texel is looked up at random places, by all wrap modes and at all levels.
struct Places {
    std::mt19937 random{3};
    int level = 0;
    Vec2f st{0};
    TextureUse::Wrap wrap_s{}, wrap_t{};
    bool is_nearest = false;

    void draw(int levels)
    {
        constexpr TextureUse::Wrap kWraps[] = {TextureUse::Wrap::Repeat, TextureUse::Wrap::Clamp, TextureUse::Wrap::Mirror};
        level = static_cast<int>(random() % static_cast<unsigned>(levels));
        st.x = uniform(random, -2, 3);
        st.y = uniform(random, -2, 3);
        wrap_s = kWraps[random() % 3];
        wrap_t = kWraps[random() % 3];
        is_nearest = random() % 4 == 0;
    }
};

TEST(TiledTextures, HaveTheTexelsOfTheImageInMemory)
{
    const TempFolder folder;
    for (const auto& [width, height] : {std::pair(1, 1), {64, 64}, {100, 37}, {65, 130}, {3, 200}, {300, 257}}) {
        const MipImage image = random_image(width, height);
        TiledFile::write(image, TextureRole::Color, folder.path() / "a.tx");
        TiledFile file(folder.path() / "a.tx", "a.tx", width, height);
        ASSERT_EQ(file.level_count(), image.level_count());
        for (const std::size_t limit : {std::size_t(1), std::size_t(1) << 30}) {
            TileCache cache(limit);
            Places at;
            for (int n = 0; n < 3000; ++n) {
                at.draw(image.level_count());
                const Vec4f expected = image.lookup(at.level, at.st, at.wrap_s, at.wrap_t, at.is_nearest);
                const Vec4f found = cache.lookup(file, at.level, at.st, at.wrap_s, at.wrap_t, at.is_nearest);
                ASSERT_EQ(std::memcmp(&found, &expected, sizeof found), 0)
                    << width << " x " << height << ", level " << at.level << ", at " << at.st.x << ' ' << at.st.y;
            }
        }
    }
}

TEST(TiledTextures, StayWithinTheirLimitAndAreReadOnceWhileTheyFit)
{
    const TempFolder folder;
    const MipImage image = random_image(1024, 512);
    TiledFile::write(image, TextureRole::Color, folder.path() / "a.tx");
    TiledFile file(folder.path() / "a.tx", "a.tx", 1024, 512);
    TileCache small(std::size_t(3) << 20), large(std::size_t(8) << 20);
    for (TileCache* cache : {&small, &large}) {
        Places at;
        for (int n = 0; n < (is_long() ? 20'000 : 5000); ++n) {
            at.draw(2);
            cache->lookup(file, at.level, at.st, at.wrap_s, at.wrap_t, at.is_nearest);
            ASSERT_LE(cache->bytes(), cache == &small ? std::size_t(3) << 20 : std::size_t(8) << 20);
        }
    }
    EXPECT_EQ(large.tiles_read(), 16u * 8 + 8 * 4);
    EXPECT_GT(small.tiles_read(), large.tiles_read());
}

TEST(TiledTextures, AreLookedUpByManyThreads)
{
    const TempFolder folder;
    const MipImage image = random_image(512, 512);
    TiledFile::write(image, TextureRole::Color, folder.path() / "a.tx");
    TiledFile file(folder.path() / "a.tx", "a.tx", 512, 512);
    TileCache cache(std::size_t(1) << 20);
    std::atomic<int> wrong = 0;
    {
        std::vector<std::jthread> threads;
        for (unsigned t = 0; t < 4; ++t)
            threads.emplace_back([&, t] {
                Places at;
                at.random.seed(t);
                for (int n = 0; n < 2000; ++n) {
                    at.draw(image.level_count());
                    const Vec4f found = cache.lookup(file, at.level, at.st, at.wrap_s, at.wrap_t, at.is_nearest);
                    wrong += found != image.lookup(at.level, at.st, at.wrap_s, at.wrap_t, at.is_nearest);
                }
            });
    }
    EXPECT_EQ(wrong, 0);
}

// A file may be damaged, or change between two lookups. The texture is then grey, and an error names it.
TEST(TiledTextures, AFileThatIsDamagedOrExchangedIsAnError)
{
    const TempFolder folder;
    TiledFile::write(random_image(600, 600), TextureRole::Color, folder.path() / "a.tx");
    TiledFile::write(random_image(300, 600), TextureRole::Color, folder.path() / "b.tx");
    const std::string good = text_of(folder.path() / "a.tx");
    std::string torn = good;
    std::fill(torn.begin() + std::ptrdiff_t(torn.size() / 3), torn.end() - 4, '\x5a');
    for (const std::string& bytes :
         {text_of(folder.path() / "b.tx"), good.substr(0, good.size() / 2), torn, std::string()}) {
        std::ofstream(folder.path() / "c.tx", std::ios::binary) << good;
        Scene scene;
        Texture texture;
        texture.path = folder.path() / "c.tx";
        texture.name = "c.tx";
        const TextureId id = scene.add(texture);
        TextureStore store(std::size_t(1) << 30);
        store.prepare(scene);
        std::ofstream(folder.path() / "c.tx", std::ios::binary | std::ios::trunc) << bytes;
        TextureUse use;
        use.texture = id;
        EXPECT_FALSE(store.has_failed());
        bool is_grey = false;
        for (int n = 0; n < 100; ++n)
            is_grey |= store.sample(use, Vec2f(0.1f * float(n % 10), 0.01f * float(n)), 0) == Vec4f(0.5f, 0.5f, 0.5f, 1);
        EXPECT_TRUE(is_grey);
        EXPECT_TRUE(store.has_failed());
        ASSERT_EQ(store.errors().size(), 1u);
        EXPECT_EQ(store.errors()[0].find("c.tx: "), 0u) << store.errors()[0];
    }
}

// Writes a file of one value that says it is one of Occam's, as another program might.
void write_foreign(const std::filesystem::path& file, Imf::LevelMode mode, std::uint16_t value)
{
    constexpr int kSide = TextureTile::kSide;
    Imf::Header header(kSide, kSide);
    header.setTileDescription({kSide, kSide, mode, Imf::ROUND_DOWN});
    header.insert("occam_texture", Imf::StringAttribute("1"));
    Imf::FrameBuffer buffer;
    std::vector<std::uint16_t> values(std::size_t(kSide) * kSide, value);
    for (const char* name : {"R", "G", "B", "A"}) {
        header.channels().insert(name, Imf::Channel(Imf::HALF));
        buffer.insert(name,
                      Imf::Slice(Imf::HALF, reinterpret_cast<char*>(values.data()), 2, 2 * kSide, 1, 1, 0, true, true));
    }
    Imf::TiledOutputFile out(file.c_str(), header);
    out.setFrameBuffer(buffer);
    for (int level = 0; level < out.numLevels(); ++level) out.writeTile(0, 0, level);
}

// Holds a file as the only texture of a scene.
struct OneTexture {
    Scene scene;
    TextureStore store;
    TextureUse use;

    explicit OneTexture(const std::filesystem::path& file, TextureRole role = TextureRole::Color,
                        std::size_t cap = std::size_t(1) << 30)
        : store(cap)
    {
        Texture texture;
        texture.path = file;
        texture.role = role;
        use.texture = scene.add(texture);
        store.prepare(scene);
    }
};

// Nothing that looks textures up expects numbers that are not finite.
TEST(TiledTextures, HaveFiniteTexels)
{
    const TempFolder folder;
    const std::pair<std::uint16_t, float> values[] = {
        {0x7e00, 0.0f}, {0xfc01, 0.0f}, {0x7c00, 65504.0f}, {0xfc00, -65504.0f}};
    for (const auto& [half, expected] : values) {
        write_foreign(folder.path() / "a.tx", Imf::MIPMAP_LEVELS, half);
        const OneTexture texture(folder.path() / "a.tx");
        for (const float width : {0.0f, 0.2f, 1.0f})
            EXPECT_EQ(texture.store.sample(texture.use, Vec2f(0.4f), width), Vec4f(expected)) << half;
        EXPECT_LE(texture.store.bytes(), 45000u) << "it is not in tiles";
    }
}

// A program that keeps attributes which it does not know may write another form.
TEST(TiledTextures, FilesOfAnotherFormAreDecodedAsAWhole)
{
    const TempFolder folder;
    write_foreign(folder.path() / "a.tx", Imf::ONE_LEVEL, 0x3800);
    const OneTexture texture(folder.path() / "a.tx");
    EXPECT_EQ(texture.store.sample(texture.use, Vec2f(0.4f), 1.0f), Vec4f(0.5f));
    EXPECT_TRUE(texture.store.errors().empty());
    EXPECT_EQ(texture.store.bytes(), MipImage::bytes_of(64, 64));
}

TEST(TiledTextures, MadeForAnotherRoleHaveAWarning)
{
    const TempFolder folder;
    for (const TextureRole made : {TextureRole::Color, TextureRole::Data})
        for (const TextureRole used : {TextureRole::Color, TextureRole::Data}) {
            TiledFile::write(random_image(9, 9), made, folder.path() / "a.tx");
            EXPECT_EQ(OneTexture(folder.path() / "a.tx", used).store.warnings().size(), made == used ? 0u : 1u);
        }
}

TEST(TiledTextures, DecodingAllFindsADamagedTile)
{
    const TempFolder folder;
    TiledFile::write(random_image(600, 600), TextureRole::Color, folder.path() / "a.tx");
    std::string bytes = text_of(folder.path() / "a.tx");
    std::fill(bytes.end() - std::ptrdiff_t(bytes.size() / 3), bytes.end() - std::ptrdiff_t(bytes.size() / 4), '\x5a');
    OneTexture good(folder.path() / "a.tx");
    good.store.decode_all();
    EXPECT_TRUE(good.store.errors().empty());
    std::ofstream(folder.path() / "a.tx", std::ios::binary) << bytes;
    OneTexture bad(folder.path() / "a.tx");
    bad.store.decode_all();
    EXPECT_EQ(bad.store.errors().size(), 1u);
}

// A file that became a pipe would wait for a writer for ever.
TEST(TiledTextures, AFileThatBecameAPipeIsAnError)
{
    const TempFolder folder;
    const std::filesystem::path file = folder.path() / "a.tx";
    TiledFile::write(random_image(100, 100), TextureRole::Color, file);
    const OneTexture texture(file);
    std::filesystem::remove(file);
    ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);
    EXPECT_EQ(texture.store.sample(texture.use, Vec2f(0.4f), 0), Vec4f(0.5f, 0.5f, 0.5f, 1));
    EXPECT_EQ(texture.store.errors().size(), 1u);
}

// The images that are not tiled share what the tiles leave, and tiles that were read stay while other textures change.
TEST(TiledTextures, StandBesideOthersInOneMemory)
{
    const TempFolder folder;
    const MipImage image = random_image(512, 512);
    TiledFile::write(image, TextureRole::Color, folder.path() / "a.tx");
    Texture tiled, plain;
    tiled.path = folder.path() / "a.tx";
    plain.pixels.assign(512 * 512, Vec4f(0.25f));
    plain.width = plain.height = 512;
    const std::size_t whole = MipImage::bytes_of(512, 512);
    for (const std::size_t cap : {2 * whole, whole + whole / 2, whole}) {
        Scene scene;
        TextureUse use, other;
        use.texture = scene.add(tiled);
        other.texture = scene.add(plain);
        TextureStore store(cap);
        store.prepare(scene);
        EXPECT_EQ(store.warnings().empty(), cap > whole) << "three quarters of the cap are for the image that is not tiled";
        EXPECT_EQ(store.sample(use, Vec2f(0.3f), 0), image.lookup(0, Vec2f(0.3f), use.wrap_s, use.wrap_t, false));
        EXPECT_EQ(store.sample(other, Vec2f(0.3f), 0), Vec4f(0.25f));
        const std::size_t before = store.bytes();
        scene.add(
            Texture{.name = "small", .role = {}, .path = {}, .encoded = {}, .pixels = {Vec4f(1)}, .width = 1, .height = 1});
        store.prepare(scene);
        EXPECT_EQ(store.bytes(), before);
    }
}

// More files than a process may open are read all the same.
TEST(TiledTextures, MayBeMoreThanCanBeOpen)
{
    const TempFolder folder;
    const MipImage image = random_image(70, 5);
    Scene scene;
    std::vector<TextureId> ids;
    for (int i = 0; i < (is_long() ? 1200 : 500); ++i) {
        Texture texture;
        texture.path = folder.path() / (std::to_string(i) + ".tx");
        texture.name = texture.path.filename();
        if (i == 0) TiledFile::write(image, TextureRole::Color, texture.path);
        else std::filesystem::create_hard_link(folder.path() / "0.tx", texture.path);
        ids.push_back(scene.add(texture));
    }
    rlimit before{};
    ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
    const rlimit few{std::min<rlim_t>(before.rlim_cur, is_long() ? 600 : 400), before.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &few), 0);
    TextureStore store(std::size_t(1) << 20);
    store.prepare(scene);
    for (const float u : {0.1f, 0.99f})
        for (const TextureId id : ids) {
            TextureUse use;
            use.texture = id;
            EXPECT_EQ(store.sample(use, Vec2f(u), 0), image.lookup(0, Vec2f(u), use.wrap_s, use.wrap_t, false));
        }
    setrlimit(RLIMIT_NOFILE, &before);
    EXPECT_TRUE(store.errors().empty());
    EXPECT_TRUE(store.warnings().empty()) << "nothing is halved";
}

class TextureCommand : public CommandTest {
protected:
    // Writes a square whose colour is a file.
    void write_square(const std::string& name, const std::string& image) const
    {
        std::ofstream(folder / (name + ".mtl")) << "newmtl a\nKd 1 1 1\nmap_Kd " << image << '\n';
        std::ofstream(folder / (name + ".obj")) << "mtllib " << name << ".mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n"
                                                << "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3 4/4\n";
    }
    // Returns the picture of it.
    std::string picture_of(const std::string& name, const std::string& memory) const
    {
        const Outcome o = run({"render", name + ".obj", "-o", name + ".exr", "--size", "90x60", "--spp", "4", "-q",
                               "--texture-memory", memory, "--look-at=0,0,1.2,0,0,0", "--integrator", "direct"});
        EXPECT_EQ(o.exit_code, 0) << o.err;
        return text_of(folder / (name + ".exr"));
    }
};

TEST_F(TextureCommand, MakesFilesOfWhichAPictureIsTheSameInAnyMemory)
{
    render::Image noise(600, 400);
    test::Numbers numbers(3);
    for (float& value : noise.add_layer("beauty", {"R", "G", "B"}).pixels) value = numbers.one();
    noise.write(folder / "noise.png");
    ASSERT_EQ(run({"texture", "noise.png", "noise.tx"}).exit_code, 0);
    write_square("plain", "noise.png");
    write_square("tiled", "noise.tx");
    const auto pixels = [&](const std::string& a, const std::string& b) {
        return run({"compare", a + ".exr", b + ".exr", "--max-error", "0"}).exit_code;
    };
    picture_of("plain", "1G");
    for (const char* memory : {"1G", "64K"}) {
        picture_of("tiled", memory);
        EXPECT_EQ(pixels("plain", "tiled"), 0) << memory;
    }
    picture_of("plain", "64K");
    EXPECT_EQ(pixels("plain", "tiled"), 1) << "an image that is not tiled is halved";
}

TEST_F(TextureCommand, RefusesWhatItCannotReadOrWrite)
{
    EXPECT_EQ(run({"texture", "triangle.obj", "a.tx"}).exit_code, 2);
    EXPECT_EQ(run({"texture", "absent.png", "a.tx"}).exit_code, 2);
    ASSERT_EQ(run({"render", "triangle.obj", "-o", "a.png", "--size", "8x8", "-q"}).exit_code, 0);
    EXPECT_EQ(run({"texture", "a.png", "no/such/folder/a.tx"}).exit_code, 3);
    EXPECT_NE(run({"texture", "a.png", "a.png"}).exit_code, 0) << "it would replace its own input";
    EXPECT_FALSE(fs::exists(folder / "a.tx"));
    // With its arguments the other way around it would replace the image.
    ASSERT_EQ(run({"texture", "a.png", "a.tx"}).exit_code, 0);
    EXPECT_EQ(run({"texture", "a.png", "a.tx"}).exit_code, 0) << "its own files are replaced";
    const std::string before = text_of(folder / "a.png"), scene = text_of(folder / "triangle.obj");
    const Outcome turned = run({"texture", "a.tx", "a.png"});
    EXPECT_EQ(turned.exit_code, 2);
    EXPECT_NE(turned.err.find("a.png: is there already"), std::string::npos) << turned.err;
    EXPECT_EQ(text_of(folder / "a.png"), before);
    EXPECT_EQ(run({"texture", "a.tx", "triangle.obj"}).exit_code, 2);
    EXPECT_EQ(text_of(folder / "triangle.obj"), scene);
    EXPECT_EQ(run({"texture", "a.png"}).exit_code, 2);
}

}  // namespace
}  // namespace occam::test
