// Tests of how numbers are written in glTF files: with or without a point, and larger than 32 bits hold.
#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <utility>

#include "io/import/gltf_schema.h"
#include "scenegraph/content_hash.h"
#include "tests/support/gltf_scene.h"
#include "tests/support/import_errors.h"

namespace occam::test {
namespace {

// Returns the scene of a square with a material, in a node and in a scene of these texts.
Scene described(const TempFolder& folder, const std::string& material, const std::string& node = "",
                const std::string& scene = "")
{
    folder.write("h.png", "");
    Gltf g = square(R"(, "material": 0)");
    g.nodes = R"({"mesh": 0)" + node + "}";
    g.more = R"(, "images": [{"uri": "h.png"}], "textures": [{"source": 0}], "scene": 0, "scenes": [{"nodes": [0])" + scene +
             R"(}], "materials": [{"emissiveFactor": [1, 0.5, 0])" + material + "}]";
    return load(g.write(folder));
}

// JSON has one kind of number, and 5e9 is not wrapped to the 705032704 that 32 bits hold of it.
TEST(GltfNumbers, WholeNumbersOfExtensionsMayBeLargerThan32Bits)
{
    const TempFolder folder;
    int rules = 0;
    for (const import::Rule& rule : import::gltf_schema()) {
        const std::string_view object = rule.object;
        constexpr std::string_view kMaterial = "material/";
        const bool is_list = rule.kind == import::Rule::Kind::Numbers;
        const bool is_number = rule.kind == import::Rule::Kind::Number || rule.kind == import::Rule::Kind::Positive;
        if (!object.starts_with(kMaterial) || !(is_list || (is_number && rule.high > 1e10))) continue;
        ++rules;
        const auto with = [&](const std::string& number) {
            std::string value = number;
            for (int i = 1; is_list && i < static_cast<int>(rule.high); ++i) value += ", " + number;
            if (is_list) value = "[" + value + "]";
            const Scene scene = described(folder, R"(, "extensions": {")" + std::string(object.substr(kMaterial.size())) +
                                                      R"(": {")" + rule.key + R"(": )" + value + "}}");
            return std::pair(content_hash(scene), scene.warnings);
        };
        for (const char* number : {"5000000000", "3000000000", "18446744073709551616"})
            EXPECT_EQ(with(number), with(std::string(number) + ".0")) << rule.object << " " << rule.key << " " << number;
    }
    EXPECT_GT(rules, 8);
    const Scene bright = described(
        folder, R"(, "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 5000000000}})");
    EXPECT_EQ(bright.material(cages(bright).at(0)->materials.at(0)).emission, Vec3f(5e9f, 2.5e9f, 0));
}

TEST(GltfNumbers, WholeNumbersOfExtrasMayBeLargerThan32Bits)
{
    const TempFolder folder;
    const auto with = [&](const std::string& n, const std::string& index) {
        const Scene scene = described(
            folder, R"(, "extras": {"occam": {"bump": {"scale": )" + n + R"(, "texture": )" + index + "}}}",
            R"(, "extras": {"occam": {"scheme": "bilinear", "area_light": {"radiance": [1, )" + n + ", 1], \"size\": [" + n +
                R"(, 1]}, "displacement": {"texture": 0, "scale": )" + n + R"(, "bound": )" + n + "}}}",
            R"(, "extras": {"occam": {"environment": {"strength": )" + n + R"(, "rotation_deg": )" + n + "}}}");
        return std::pair(content_hash(scene), scene.warnings);
    };
    EXPECT_EQ(with("5000000000", "0"), with("5000000000.0", "0"));
    EXPECT_EQ(with("3000000000", "0"), with("3000000000.0", "0"));
    EXPECT_NE(with("5000000000", "0").first, with("705032704", "0").first);
    try {
        with("1", "4294967296");
        ADD_FAILURE() << "this is no index of the one texture";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("texture must be an index"), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace occam::test
