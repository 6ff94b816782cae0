// Tests that what a small file names very many times is read once and kept once, or refused.
#include <gtest/gtest.h>

#include <functional>

#include "tests/support/bytes_read.h"
#include "tests/support/gltf_scene.h"
#include "tests/support/import_errors.h"

namespace occam::test {
namespace {

constexpr std::size_t kMega = 1'000'000;
constexpr const char* kCopies = "the copies that elements share out of the file take more than 512 MiB";
constexpr const char* kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

std::string list_of(int count, const std::function<std::string(int)>& element)
{
    std::string list;
    for (int i = 0; i < count; ++i) list += (i ? ", " : "") + element(i);
    return list;
}

// Returns one of many spellings of the name of a file.
std::string spelling(int number, const std::string& name)
{
    std::string text;
    for (int i = 0; i < number; ++i) text += "./";
    return text + name;
}

// Returns a glTF whose many buffers are one file, each with a spelling of its own and some bytes more than the one before.
// The positions are in the last buffer.
std::string with_buffers(int count, const std::string& accessor_more)
{
    const auto buffer = [&](int i) {
        return R"({"uri": ")" + spelling(i, "b.bin") + R"(", "byteLength": )" +
               std::to_string(kMega - std::size_t(count - 1 - i)) + "}";
    };
    return R"({"asset": {"version": "2.0"}, "nodes": [{"mesh": 0}], "buffers": [)" + list_of(count, buffer) +
           R"(], "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": )" + std::to_string(count - 1) +
           R"(, "byteOffset": 999964, "byteLength": 36}], "accessors": [{"componentType": 5126, "type": "VEC3", )" +
           accessor_more + R"(}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}]})";
}

TEST(RepeatedBuffers, OfOneFileAreReadOnce)
{
    const TempFolder folder;
    Gltf triangle;
    triangle.put<float>({0, 0, 0, 3, 0, 0, 0, 5, 0});
    folder.write("b.bin", std::string(kMega - 36, '\0') + triangle.bin);
    const auto file = folder.write("a.gltf",
                                   with_buffers(50, R"("bufferView": 1, "count": 3, "min": [0, 0, 0], "max": [3, 5, 0])"));
    const std::size_t before = bytes_read();
    const Scene scene = load(file);
    EXPECT_LT(bytes_read() - before, 2 * kMega);
    EXPECT_EQ(only_cage(scene).positions, (std::vector<Vec3f>{{0, 0, 0}, {3, 0, 0}, {0, 5, 0}}));
    EXPECT_TRUE(scene.warnings.empty());
}

TEST(RepeatedBuffers, OfOneFileCountOnceForWhatAccessorsExpandTo)
{
    const TempFolder folder;
    folder.write("b.bin", std::string(kMega, '\0'));
    const auto file = folder.write("a.gltf", with_buffers(50, R"("count": 50000000)"));
    EXPECT_NE(error_of(file).find("accessors expand to far more than the buffers hold"), std::string::npos);
}

TEST(RepeatedBuffers, ThatAreLongerThanTheirFileAreRefused)
{
    const TempFolder folder;
    folder.write("b.bin", std::string(kMega - 1, '\0'));
    EXPECT_NE(error_of(folder.write("a.gltf", with_buffers(2, R"("bufferView": 0, "count": 3)"))), "");
}

}  // namespace
}  // namespace occam::test
