// Tests that a glTF of a few megabytes whose lists would take gigabytes is refused.
#include <gtest/gtest.h>

#include <string>

#include "tests/support/gltf_scene.h"
#include "tests/support/import_errors.h"

namespace occam::test {
namespace {

std::string many(const std::string& element, std::size_t count)
{
    std::string text = element;
    text.reserve(count * (element.size() + 1));
    for (std::size_t i = 1; i < count; ++i) text += "," + element;
    return text;
}

TEST(ImportSizes, ListsOfEmptyElementsThatWouldTakeGigabytesAreRefused)
{
    const TempFolder folder;
    Gltf g = square();
    const std::string nodes = g.nodes;
    g.nodes = nodes + "," + many("{}", 20'000);
    EXPECT_EQ(error_of(g.write(folder)), "");
    g.nodes = nodes + "," + many("{}", 1'500'000);
    EXPECT_NE(error_of(g.write(folder)).find("MB of memory, far more than 4"), std::string::npos);
    EXPECT_NE(error_of(g.write(folder)).find("(nodes)"), std::string::npos);
    g.nodes = nodes;
    g.more = R"(, "materials": [)" + many("{}", 800'000) + "]";
    EXPECT_NE(error_of(g.write(folder)).find("(materials)"), std::string::npos);
}

TEST(ImportSizes, CagesOfManyStylesOfOneMeshAreCounted)
{
    const TempFolder folder;
    Gltf g = square();
    g.meshes = R"({"primitives": [)" + many(R"({"attributes":{"POSITION":0},"indices":1})", 20'000) + "]}";
    g.nodes.clear();
    int styles = 0;
    for (const char* scheme : {"none", "bilinear"})
        for (const char* rule : {"corners-plus1", "corners-plus2", "corners-only", "boundaries", "all", "none"})
            for (const char* boundary : {"edge-and-corner", "edge-only", "none"}) {
                g.nodes += (styles++ > 0 ? "," : "") + std::string(R"({"mesh":0,"extras":{"occam":{"scheme":")") + scheme +
                           R"(","face_varying":")" + rule + R"(","boundary":")" + boundary + R"("}}})";
            }
    EXPECT_NE(error_of(g.write(folder)).find("the file asks for too many copies of what it holds once (meshes[0])"),
              std::string::npos);
}

TEST(ImportSizes, PrimitivesOfTooManyMorphTargetsAreRefused)
{
    const TempFolder folder;
    const auto with = [&](std::size_t targets) {
        return error_of(square(R"(, "targets": [)" + many(R"({"POSITION": 0})", targets) + "]").write(folder));
    };
    EXPECT_EQ(with(8192), "");
    EXPECT_NE(with(8193).find("has more than 8192 morph targets (meshes[0].primitives[0])"), std::string::npos);
}

}  // namespace
}  // namespace occam::test
