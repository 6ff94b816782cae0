// Tests of headers of OpenEXR files that would lead the library astray.
#include <gtest/gtest.h>

#include <fstream>

#include "base/error.h"
#include "io/exr_file.h"
#include "io/texture/decode.h"
#include "io/texture/image_header.h"
#include "io/texture/tiled_file.h"
#include "tests/support/temp_folder.h"

namespace occam::test {
namespace {

// The library reads most attributes without a look at their lengths. A wrong one made it take the next attribute from the
// middle of another, and ask for as much memory as stood there.
TEST(ExrHeader, AttributesWhoseLengthsAreNotThoseOfTheirTypesAreRefused)
{
    const TempFolder folder;
    MipImage image(9, 9);
    image.build_levels();
    TiledFile::write(image, TextureRole::Color, folder.path() / "a.tx");
    std::ifstream in(folder.path() / "a.tx", std::ios::binary);
    const std::string good(std::istreambuf_iterator<char>(in), {});
    ImageBytes whole(folder.path() / "a.tx");
    EXPECT_FALSE(is_cut_off_exr(whole));
    for (const std::string type : {"chlist", "box2i", "compression", "lineOrder", "float", "v2f", "tiledesc"})
        for (const int change : {-1, 1, 3}) {
            std::string bytes = good;
            const std::size_t at = bytes.rfind('\0' + type + '\0') + type.size() + 2;
            bytes[at] = static_cast<char>(bytes[at] + change);
            std::ofstream(folder.path() / "b.tx", std::ios::binary) << bytes;
            ImageBytes file(folder.path() / "b.tx");
            EXPECT_TRUE(is_cut_off_exr(file)) << type << ' ' << change;
        }
}

// The library makes room for a tile when it opens a file, so the size of tiles is known before.
TEST(ExrHeader, HugeTilesAreRefused)
{
    const TempFolder folder;
    MipImage image(9, 9);
    image.build_levels();
    TiledFile::write(image, TextureRole::Color, folder.path() / "a.tx");
    std::fstream file(folder.path() / "a.tx", std::ios::binary | std::ios::in | std::ios::out);
    const std::string bytes(std::istreambuf_iterator<char>(file), {});
    constexpr std::size_t kBeforeHeight = 4 + 4;  // the attribute's length and the tiles' width
    const std::string before = std::string("tiledesc") + '\0';
    file.seekp(std::streamoff(bytes.find(before) + before.size() + kBeforeHeight + 2));
    file.put(0x20);  // 2^21 + 64 rows
    file.close();
    ImageBytes changed(folder.path() / "a.tx");
    const auto head = read_exr_head(changed);
    ASSERT_TRUE(head);
    EXPECT_EQ(head->tile_width, 64);
    EXPECT_EQ(head->tile_height, (1 << 21) + 64);
    Texture texture;
    texture.path = folder.path() / "a.tx";
    try {
        const TextureSource source(texture);
        ADD_FAILURE() << "it was opened";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("larger tiles than are read: 64 x 2097216"), std::string::npos)
            << error.what();
    }
}

}  // namespace
}  // namespace occam::test
