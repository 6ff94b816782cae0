// The findings of the fuzz targets, all repaired since, each reduced to a small case.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>

#include "io/exr_file.h"
#include "io/texture/texture_store.h"
#include "occam/occam.h"
#include "tests/support/picture_bytes.h"
#include "tests/support/temp_folder.h"
#include "tests/support/webp_files.h"

namespace occam::test {
namespace {

// Loads and renders the file, or refuses it: either is correct.
void pass_door(const std::filesystem::path& file)
{
    try {
        Scene scene = load(file);
        scene.refit();
        Renderer renderer({.threads = 1});
        renderer.render(scene, Camera::framing(scene.bounds()), {.width = 32, .height = 24, .spp = 1});
    } catch (const Error&) {
        return;
    }
}

// This file once led to a read past the end of an array: it has creases beside vertices of two faces, at a border.
TEST(FuzzFindings, ObjCreasesBesideAVertexOfTwoFaces)
{
    TempFolder folder;
    pass_door(folder.write("scene.obj",
                           "v -0.5 0 -1.75\nv 0 0 -1.75\nv 0 -0.5 -1.75\nv 0.5 0 -1.75\nv -0.5 0 -0.75\nv 0 0 -0.75\n"
                           "v 0 -0.5 -0.75\nv 0.5 0 -0.75\nf 1 2 3 7 6 5\nf 8 6 7 3 2 4\nt crease 2/1/0 1 2 5.0\n"
                           "t crease 2/1/0 2 6 5.0\nt crease 2/1/0 6 5 5.0\nt interpolateboundary 1/0/0 1\n"));
}

// This file once led to a control point without an index: coordinates that collapse to one, around a vertex of two faces.
TEST(FuzzFindings, ObjCoordinatesThatCollapseAroundAVertexOfTwoFaces)
{
    TempFolder folder;
    pass_door(folder.write("scene.obj",
                           "v -1.42 -0.5 -0.17\nv -1.08 -0.5 -0.17\nv -0.75 0 -0.17\nv -1.42 -0.5 0.17\n"
                           "v -1.08 -0.5 0.17\nv -0.75 0 0.17\nv -1.08 0.1 0\nv -1.2 0 0.5\n"
                           "f 2/1 7/1 4/1 1/1\nf 2/1 8/1 4/1 7/1\nf 2/1 3/1 6/1 5/1\n"));
}

// This file once led to a read at a random address: two triangles back to back close around a vertex that a third one
// shares.
TEST(FuzzFindings, ObjCreasesBesideAVertexWhereTwoOfThreeFacesClose)
{
    TempFolder folder;
    pass_door(folder.write("scene.obj",
                           "v -0.5 0 0\nv 0.5 -1 0\nv 0 0 0\nv 1 0 0\nv 1 1 0.2\nv 2 1 0.5\nf 3 4 5\nf 5 4 6\nf 5 4 3\n"
                           "f 1 2 3\nt crease 2/1/0 3 2 4.0\n"));
}

std::vector<std::string> errors_of_image(std::string_view file)
{
    Scene scene;
    Texture texture;
    const auto* first = reinterpret_cast<const std::byte*>(file.data());
    texture.encoded = std::make_shared<const std::vector<std::byte>>(first, first + file.size());
    scene.add(std::move(texture));
    TextureStore store(std::size_t(16) << 20);
    store.prepare(scene);
    store.decode_all();
    return store.errors();
}

// The readers of these two allocate the canvas that the header declares, when they are opened.
TEST(FuzzFindings, ImagesOfThirtyBytesDoNotDeclareGibibytes)
{
    const std::string_view images[] = {
        {"GIF89a\xff\xff\xff\xff\0\0\0-\x03\xfe\x7f\xff\0\0\0\x03\xfe\x01\x01\0", 24},
        {"GIF89a\0\x40\0\x20\0\0\0-\x03\xfe\x7f\xff\0\0\0\x03\xfe\x01\x01\0", 24},
        {"RIFF\x16\0\0\0WEBPVP8X\x0a\0\0\0\0\0\0\0\xff\x3f\0\xff\x3f\0", 30},
        {"RIFF\x16\0\0\0WEBPVP8L\x0a\0\0\0\x2f\xff\xff\xff\x0f\0\0\0\0\0", 30},
    };
    for (const std::string_view image : images) {
        const std::vector<std::string> errors = errors_of_image(image);
        ASSERT_EQ(errors.size(), 1u);
        EXPECT_TRUE(errors[0].find("larger than is read") != std::string::npos ||
                    errors[0].find("far more than the file holds") != std::string::npos)
            << errors[0];
    }
}

// A file that is cut off, or of which a byte is another one, is a picture or an error. The second file may also have a frame
// that does not lie on its canvas.
TEST(FuzzFindings, DamagedWebpFilesAreReadOrRefused)
{
    for (const std::string_view whole : {kWebpFile, kWebpAnimation}) {
        EXPECT_TRUE(errors_of_image(whole).empty());
        for (std::size_t length = 13; length < whole.size(); ++length)
            EXPECT_EQ(errors_of_image(whole.substr(0, length)).size(), 1u) << length;
        for (std::size_t at = 12; at < whole.size(); ++at)
            for (const unsigned change : {0x01u, 0x80u, 0xffu}) {
                std::string changed(whole);
                changed[at] = static_cast<char>(static_cast<unsigned char>(changed[at]) ^ change);
                EXPECT_LE(errors_of_image(changed).size(), 1u) << at;
            }
    }
}

// Sets numbers in the value of an attribute; -1 is that of its size.
std::string with_numbers(std::string file, std::string_view attribute, int first,
                         std::initializer_list<std::int32_t> numbers)
{
    std::size_t at = file.find(attribute) + attribute.size() + std::size_t(4 * (first + 1));
    for (const std::int32_t number : numbers) {
        std::memcpy(file.data() + at, &number, sizeof number);
        at += sizeof number;
    }
    return file;
}

// OpenEXR allocates what attributes and windows declare before it reads on.
TEST(FuzzFindings, OpenExrHeadersDoNotDeclareGibibytes)
{
    using namespace std::string_view_literals;
    PictureSpec spec;
    spec.width = spec.height = spec.full_width = spec.full_height = 4;
    spec.channels = {"R", "G", "B"};
    const std::vector<float> pixels(4 * 4 * 3, 0.5f);
    BytesInMemory encoded;
    ASSERT_EQ(write_exr(spec, {{{"comments", std::string("text")}}}, pixels.data(), encoded), "");
    ASSERT_TRUE(errors_of_image(encoded.all).empty());
    constexpr std::string_view kWindow = "dataWindow\0box2i\0"sv;
    const std::pair<std::string, const char*> files[] = {
        {with_numbers(encoded.all, "comments\0string\0"sv, -1, {0x70000000}), "is cut off"},
        {with_numbers(encoded.all, "comments\0string\0"sv, -1, {-2}), "is cut off"},
        {with_numbers(encoded.all, kWindow, 0, {0, 0, 29'000'000, 3}), "larger than is read: 29000001 x 4"},
        {with_numbers(encoded.all, kWindow, 0, {-500'000'000, -500'000'000, 500'000'000, 500'000'000}),
         "larger than is read"},
        {with_numbers(encoded.all, kWindow, 0, {0, 0, 16'000, 7'000}), "far more than the file holds"},
        {with_numbers(encoded.all, kWindow, 0, {5, 0, 2, 3}), "cannot be read"},
        {with_numbers(encoded.all, kWindow, 0, {0, 0, 0x7fffffff, 0x7fffffff}), "cannot be read"},
        {with_numbers(encoded.all, kWindow, 0, {0, 0, 3, 15'000}), "cannot be read"},
        {encoded.all.substr(0, encoded.all.find("screenWindowWidth")), "is cut off"},
    };
    for (const auto& [file, why] : files) {
        const std::vector<std::string> errors = errors_of_image(file);
        ASSERT_EQ(errors.size(), 1u) << why;
        EXPECT_NE(errors[0].find(why), std::string::npos) << errors[0];
        EXPECT_EQ(errors[0].find('\n'), std::string::npos) << errors[0];
    }
}

// The file has a colour profile of one tag, a text that is declared far longer than the profile.
std::string profile_past_its_end()
{
    std::string profile(128, '\0');
    const auto u32 = [](std::uint32_t value) {
        std::string bytes;
        for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 0xff);
        return bytes;
    };
    profile.replace(12, 12, "mntrRGB XYZ ");
    profile.replace(36, 4, "acsp");
    profile += u32(1) + "desc" + u32(144) + u32(40);
    profile += "mluc" + u32(0) + u32(1) + u32(12) + "enUS" + u32(0x00ffffff) + u32(28) + std::string(12, 'x');
    return profile.replace(0, 4, u32(static_cast<std::uint32_t>(profile.size())));
}

// OpenImageIO copies the text from beyond the profile's end.
TEST(FuzzFindings, ColourProfilesThatReachPastTheirEndAreNotRead)
{
    TempFolder folder;
    const std::string profile = profile_past_its_end(), path = (folder.path() / "image.jpg").string();
    OIIO::ImageSpec spec(8, 8, 3, OIIO::TypeDesc::UINT8);
    spec.attribute("ICCProfile", OIIO::TypeDesc(OIIO::TypeDesc::UINT8, static_cast<int>(profile.size())), profile.data());
    const std::vector<unsigned char> pixels(8 * 8 * 3, 128);
    const auto writer = OIIO::ImageOutput::create(path);
    ASSERT_TRUE(writer && writer->open(path, spec) && writer->write_image(OIIO::TypeDesc::UINT8, pixels.data()));
    writer->close();
    std::ifstream stream(path, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    ASSERT_NE(bytes.find("ICC_PROFILE"), std::string::npos);
    EXPECT_TRUE(errors_of_image(bytes).empty());
}

}  // namespace
}  // namespace occam::test
