// Files of every format are broken in every place: each number is replaced, each file is cut off, bytes are changed. Each is
// refused in one line that names the file, or loads and can be rendered.
#include <gtest/gtest.h>

#include <cctype>

#include "base/hash.h"
#include "tests/support/campaign.h"
#include "tests/support/file_outcome.h"
#include "tests/support/gltf_scene.h"
#include "tests/support/temp_folder.h"

namespace occam::test {
namespace {

/// Makes a glTF with a bit of everything: coordinates, colours, a skin, a morph target, clips, a camera, lights, a material,
/// and a sparse accessor.
Gltf everything()
{
    Gltf g = square(R"(, "material": 0, "targets": [{"POSITION": 2}])");
    g.put<float>({0, 0, 0.5f, 0, 0, 0.5f, 0, 0, 0, 0, 0, 0});                    // 2: morph target
    g.put<float>({0, 0, 1, 0, 1, 1, 0, 1});                                      // 3: coordinates
    g.put<std::uint8_t>({0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0});       // 4: joints
    g.put<float>({1, 0, 0, 0, 0.5f, 0.5f, 0, 0, 0, 1, 0, 0, 0.2f, 0.8f, 0, 0});  // 5: weights
    g.put<float>({0, 0.5f, 1});                                                  // 6: times
    g.put<float>({0, 0, 0, 1, 0, 0.6f, 0, 0.8f, 0, 0, 0, 1});                    // 7: rotations
    g.put<float>({0, 0.5f, 1});                                                  // 8: weights over time
    g.put<float>(
        {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});  // 9: binds
    g.put<std::uint16_t>({1});       // 10: sparse index
    g.put<float>({1.5f, 0, 0.25f});  // 11: sparse value
    const auto floats = [](int view, int count, const char* type) {
        return R"({"bufferView": )" + std::to_string(view) + R"(, "componentType": 5126, "count": )" +
               std::to_string(count) + R"(, "type": ")" + type + R"(", "min": [0], "max": [1]})";
    };
    const auto plain = [&](int view, int count, const char* type) {
        std::string text = floats(view, count, type);
        return text.substr(0, text.find(", \"min\"")) + "}";
    };
    std::string sparse = plain(2, 4, "VEC3");
    sparse.pop_back();
    g.accessor(sparse +
               R"(, "min": [0, 0, 0], "max": [1.5, 0, 0.5],
        "sparse": {"count": 1, "indices": {"bufferView": 10, "componentType": 5123},
        "values": {"bufferView": 11}}})");
    g.accessor(plain(3, 4, "VEC2"));
    g.accessor(R"({"bufferView": 4, "componentType": 5121, "count": 4, "type": "VEC4"})");
    g.accessor(plain(5, 4, "VEC4"));
    g.accessor(floats(6, 3, "SCALAR"));
    g.accessor(plain(7, 3, "VEC4"));
    g.accessor(plain(8, 3, "SCALAR"));
    g.accessor(plain(9, 2, "MAT4"));
    g.meshes =
        R"({"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 3, "JOINTS_0": 4, "WEIGHTS_0": 5}, "indices": 1,
        "material": 0, "mode": 4, "targets": [{"POSITION": 2}]}], "weights": [0.25]})";
    g.nodes = R"({"mesh": 0, "skin": 0, "name": "body"}, {"translation": [0, 0, 0.5], "children": [2], "name": "hip"},
        {"rotation": [0, 0, 0, 1], "scale": [1, 1, 1], "name": "knee"}, {"camera": 0, "translation": [0, 0, 4]},
        {"matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 2, 0, 1], "extensions": {"KHR_lights_punctual": {"light": 0}}})";
    g.more = R"(, "scene": 0, "scenes": [{"nodes": [0, 1, 3, 4]}],
        "skins": [{"joints": [1, 2], "inverseBindMatrices": 9, "skeleton": 1}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1, "zfar": 100, "aspectRatio": 1.5}}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.4, 0.2, 1], "metallicFactor": 0.5,
            "roughnessFactor": 0.3},
            "emissiveFactor": [0.1, 0, 0], "alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": true}],
        "animations": [{"channels": [{"sampler": 0, "target": {"node": 2, "path": "rotation"}},
            {"sampler": 1, "target": {"node": 0, "path": "weights"}}],
            "samplers": [{"input": 6, "output": 7, "interpolation": "LINEAR"}, {"input": 6, "output": 8}]}],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "spot", "intensity": 20, "color": [1, 0.9, 0.8],
            "range": 30, "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.6}}]}})";
    return g;
}

const char* const kObj =
    "v -1 -1 0\nv 1 -1 0\nv 1 1 0.5\nv -1 1 0 0.5 0.25 1\nv 0 0 2\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0.5 1\n"
    "vn 0 0 1\no lid\ns 1\nf 1/1/1 2/2/1 3/3/1 4/4/1\nf -5 -4 -1\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"
    "t crease 2/1/0 0 1 2.5\nt corner 1/1/0 2 3\nt hole 1/0/0 1\n";
const char* const kPly =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "property uchar red\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0 255\n1 0 0 128\n1 1 0 0\n0 1 0 7\n3 0 1 2\n3 0 2 3\n";
const char* const kOff = "OFF\n5 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0.5 0.5 1\n4 0 1 2 3\n3 0 1 4\n";
const char* const kStl =
    "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    "endsolid s\n";

/// Returns where the numbers of a text stand, as first character and one past the last. Numbers in strings of JSON do not
/// count.
std::vector<std::pair<std::size_t, std::size_t>> numbers_of(const std::string& text, bool is_json)
{
    std::vector<std::pair<std::size_t, std::size_t>> places;
    bool is_string = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (is_json && text[i] == '"') is_string = !is_string;
        const bool starts = std::isdigit(static_cast<unsigned char>(text[i])) || text[i] == '-';
        const bool is_word = i > 0 && (std::isalpha(static_cast<unsigned char>(text[i - 1])) || text[i - 1] == '_');
        if (is_string || !starts || is_word) continue;
        const std::size_t end = std::min(text.find_first_not_of("0123456789.e+-", i), text.size());
        places.push_back({i, end});
        i = end - 1;
    }
    return places;
}

class MadeFiles : public testing::Test {
protected:
    void expect_outcome(const std::string& name, const std::string& content, const std::string& what)
    {
        const auto file = folder_.write(name, content);
        const FileOutcome outcome = outcome_of(file);
        EXPECT_EQ(outcome.error.find('\n'), std::string::npos) << what << ": " << outcome.error;
        EXPECT_TRUE(outcome.error.empty() || outcome.error.find(name) != std::string::npos) << what << ": " << outcome.error;
        refused_ += !outcome.error.empty();
        ++tried_;
    }
    /// Replaces each number of a text by all replacements in the long campaigns, else by some.
    void replace_numbers(const std::string& name, const std::string& text, bool is_json, std::size_t one_in)
    {
        std::vector<const char*> values = {"-1", "0", "7", "4294967295", "-2147483649", "1e38", "1e39", "0.5", "1e-45", ""};
        if (is_json) values = {"-1", "0", "7", "4294967295", "1e39", "0.5", "\"x\"", "null", "[]", "{}"};
        else values.insert(values.end(), {"nan", "-inf", "x"});
        std::uint64_t n = 0;
        for (const auto& [first, end] : numbers_of(text, is_json))
            for (const char* value : values)
                if (is_long() || mix_bits(++n) % one_in == 0)
                    expect_outcome(name, text.substr(0, first) + value + text.substr(end),
                                   "the number at byte " + std::to_string(first) + " as '" + value + "'");
    }
    /// Cuts the file off at many places, and changes single bytes.
    void break_bytes(const std::string& name, const std::string& bytes, std::size_t step)
    {
        for (std::size_t n = 0; n < bytes.size(); n += is_long() ? 1 : step)
            expect_outcome(name, bytes.substr(0, n), "cut off at byte " + std::to_string(n));
        for (std::size_t n = 0; n < bytes.size(); n += is_long() ? 1 : step)
            for (const int flip : {0x01, 0x80, 0xff}) {
                std::string changed = bytes;
                changed[n] = static_cast<char>(changed[n] ^ flip);
                expect_outcome(name, changed, "byte " + std::to_string(n) + " with " + std::to_string(flip) + " flipped");
            }
    }

    TempFolder folder_;
    int tried_ = 0, refused_ = 0;
};

TEST_F(MadeFiles, WithABitOfEverythingLoadWithoutAWarning)
{
    const FileOutcome gltf = outcome_of(everything().write(folder_));
    EXPECT_EQ(gltf.error, "");
    EXPECT_TRUE(gltf.warnings.empty()) << gltf.warnings.front();
    for (const auto& [name, text] :
         {std::pair("a.obj", kObj), std::pair("a.ply", kPly), std::pair("a.off", kOff), std::pair("a.stl", kStl)})
        EXPECT_EQ(outcome_of(folder_.write(name, text)).error, "") << name;
}

TEST_F(MadeFiles, OfGltfWithAnyNumberReplacedAreRefusedInOneLineOrLoad)
{
    const Gltf g = everything();
    g.write(folder_);
    replace_numbers("broken.gltf", g.json(), true, 18);
    EXPECT_GT(refused_, tried_ / 4);
}

TEST_F(MadeFiles, OfGlbWithBrokenBytesAreRefusedInOneLineOrLoad) { break_bytes("broken.glb", everything().glb(), 111); }

TEST_F(MadeFiles, OfPolygonsWithAnyNumberReplacedAreRefusedInOneLineOrLoad)
{
    replace_numbers("broken.obj", kObj, false, 12);
    replace_numbers("broken.ply", kPly, false, 12);
    replace_numbers("broken.off", kOff, false, 12);
    replace_numbers("broken.stl", kStl, false, 12);
}

TEST_F(MadeFiles, OfPolygonsWithBrokenBytesAreRefusedInOneLineOrLoad)
{
    break_bytes("broken.obj", kObj, 33);
    break_bytes("broken.ply", kPly, 33);
    break_bytes("broken.off", kOff, 15);
    break_bytes("broken.stl", kStl, 33);
}

}  // namespace
}  // namespace occam::test
