// Small glTF files that a test puts together.
#pragma once

#include <cstring>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <vector>

#include "scenegraph/scene.h"
#include "tests/support/temp_folder.h"

namespace occam::test {

/// Holds a glTF in parts. Parts that a test does not set are left out.
struct Gltf {
    std::string bin;  ///< the buffer, which is written to a file beside the glTF
    std::string buffer_views, accessors, meshes, nodes = "{}", more;
    std::string asset = R"({"version": "2.0"})";

    template <class T>
    std::size_t put(std::initializer_list<T> values)
    {
        bin.resize((bin.size() + 3) / 4 * 4);
        const std::size_t offset = bin.size();
        for (T v : values) {
            char raw[sizeof(T)];
            std::memcpy(raw, &v, sizeof(T));
            bin.append(raw, sizeof(T));
        }
        buffer_views += (buffer_views.empty() ? "" : ", ") + std::string(R"({"buffer": 0, "byteOffset": )") +
                        std::to_string(offset) + R"(, "byteLength": )" + std::to_string(bin.size() - offset) + "}";
        return offset;
    }
    void accessor(const std::string& text) { accessors += (accessors.empty() ? "" : ", ") + text; }

    std::string json(bool embedded = false) const
    {
        std::string text = R"({"asset": )" + asset + R"(, "nodes": [)" + nodes + "]";
        if (!bin.empty()) {
            text += R"(, "buffers": [{"byteLength": )" + std::to_string(bin.size()) +
                    (embedded ? "" : R"(, "uri": "data%20file.bin")") + "}]";
            text += R"(, "bufferViews": [)" + buffer_views + "]";
        }
        if (!accessors.empty()) text += R"(, "accessors": [)" + accessors + "]";
        if (!meshes.empty()) text += R"(, "meshes": [)" + meshes + "]";
        return text + more + "}";
    }
    /// Returns the scene as one file, with the buffer in the binary chunk.
    std::string glb() const
    {
        const auto u32 = [](std::size_t x) {
            std::string s;
            for (int i = 0; i < 4; ++i) s += static_cast<char>(x >> 8 * i & 0xff);
            return s;
        };
        const auto padded = [](std::string text, char filler) {
            text.resize((text.size() + 3) / 4 * 4, filler);
            return text;
        };
        const std::string text = padded(json(true), ' '), data = padded(bin, '\0');
        std::string body = u32(text.size()) + "JSON" + text;
        if (!data.empty()) body += u32(data.size()) + std::string("BIN\0", 4) + data;
        return "glTF" + u32(2) + u32(12 + body.size()) + body;
    }
    std::filesystem::path write(const TempFolder& folder, const std::string& name = "scene.gltf") const
    {
        folder.write("data file.bin", bin);
        return folder.write(name, json());
    }
};

/// Returns a unit square: its four corners, and the triangles 0 1 2 and 0 2 3.
inline Gltf square(const std::string& primitive_more = "")
{
    Gltf g;
    g.put<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
    g.put<std::uint16_t>({0, 1, 2, 0, 2, 3});
    g.accessor(
        R"({"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]})");
    g.accessor(R"({"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"})");
    g.meshes = R"({"primitives": [{"attributes": {"POSITION": 0}, "indices": 1)" + primitive_more + "}]}";
    g.nodes = R"({"mesh": 0})";
    return g;
}

/// Returns everything that is placed.
inline std::vector<const Cage*> cages(const Scene& scene)
{
    std::vector<const Cage*> list;
    scene.for_each_placement([&](NodeId, const Node& node, const Mat4d&) {
        for (CageId id : node.cages) list.push_back(&scene.cage(id).cage);
    });
    return list;
}

}  // namespace occam::test
