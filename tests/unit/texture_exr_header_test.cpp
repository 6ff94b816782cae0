// Tests of headers of OpenEXR files that would lead the library astray.
#include <gtest/gtest.h>

#include <fstream>

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

}  // namespace
}  // namespace occam::test
