#include "tests/bench/wave_files.h"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "base/box.h"
#include "base/error.h"

namespace occam::bench {

void write_wave_obj(const std::filesystem::path& file, int columns, int rows)
{
    std::ofstream out(file, std::ios::binary);
    char line[160];
    const auto put = [&](const char* format, auto... values) {
        out.write(line, std::snprintf(line, sizeof line, format, values...));
    };
    for (int j = 0; j <= rows; ++j)
        for (int i = 0; i <= columns; ++i) {
            const double x = 4.0 * i / columns - 2, z = 2.0 * j / rows - 1;
            put("v %.6f %.6f %.6f\n", x, 0.1 * std::sin(9 * x) * std::cos(7 * z), -z);
        }
    for (int j = 0; j <= rows; ++j)
        for (int i = 0; i <= columns; ++i) put("vt %.6f %.6f\n", double(i) / columns, double(j) / rows);
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) {
            const int a = j * (columns + 1) + i + 1, b = a + 1, c = b + columns + 1, d = c - 1;
            put("f %d/%d %d/%d %d/%d %d/%d\n", a, a, b, b, c, c, d, d);
        }
    if (!out.flush()) throw Error(file.string(), "cannot be written");
}

namespace {

struct WaveArrays {
    std::vector<Vec3f> positions, normals;
    std::vector<Vec2f> uvs;
    std::vector<std::uint32_t> indices;
};

WaveArrays wave_arrays(int columns, int rows)
{
    WaveArrays wave;
    for (int j = 0; j <= rows; ++j)
        for (int i = 0; i <= columns; ++i) {
            const float x = 4.0f * float(i) / float(columns) - 2, z = 2.0f * float(j) / float(rows) - 1;
            wave.positions.emplace_back(x, 0.1f * std::sin(9 * x) * std::cos(7 * z), -z);
            wave.normals.push_back(glm::normalize(
                Vec3f(-0.9f * std::cos(9 * x) * std::cos(7 * z), 1, -0.7f * std::sin(9 * x) * std::sin(7 * z))));
            wave.uvs.emplace_back(float(i) / float(columns), float(j) / float(rows));
        }
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) {
            const auto a = static_cast<std::uint32_t>(j * (columns + 1) + i), b = a + 1;
            const std::uint32_t d = a + static_cast<std::uint32_t>(columns) + 1, c = d + 1;
            wave.indices.insert(wave.indices.end(), {a, b, c, a, c, d});
        }
    return wave;
}

// Describes the arrays as one mesh, in the order in which they stand in the buffer.
nlohmann::json scene_of(const WaveArrays& wave, std::span<const std::size_t> bytes)
{
    using nlohmann::json;
    json views = json::array();
    std::size_t total = 0;
    for (const std::size_t size : bytes) {
        views.push_back({{"buffer", 0}, {"byteOffset", total}, {"byteLength", size}});
        total += size;
    }
    const auto accessor = [](int view, int component, std::size_t count, const char* type) {
        return json{{"bufferView", view}, {"componentType", component}, {"count", count}, {"type", type}};
    };
    json scene = {{"asset", {{"version", "2.0"}}},        {"scene", 0},
                  {"scenes", {{{"nodes", {0}}}}},         {"nodes", {{{"mesh", 0}}}},
                  {"buffers", {{{"byteLength", total}}}}, {"bufferViews", views}};
    scene["meshes"] = {
        {{"primitives", {{{"attributes", {{"POSITION", 0}, {"NORMAL", 1}, {"TEXCOORD_0", 2}}}, {"indices", 3}}}}}};
    scene["accessors"] = {accessor(0, 5126, wave.positions.size(), "VEC3"), accessor(1, 5126, wave.normals.size(), "VEC3"),
                          accessor(2, 5126, wave.uvs.size(), "VEC2"), accessor(3, 5125, wave.indices.size(), "SCALAR")};
    Box3f box;
    for (const Vec3f p : wave.positions) box.add(p);
    for (int axis = 0; axis < 3; ++axis) {
        scene["accessors"][0]["min"].push_back(box.lo[axis]);
        scene["accessors"][0]["max"].push_back(box.hi[axis]);
    }
    return scene;
}

}  // namespace

void write_wave_glb(const std::filesystem::path& file, int columns, int rows)
{
    const WaveArrays wave = wave_arrays(columns, rows);
    const auto bytes_of = [](const auto& list) { return list.size() * sizeof list[0]; };
    const std::array<std::size_t, 4> bytes = {bytes_of(wave.positions), bytes_of(wave.normals), bytes_of(wave.uvs),
                                              bytes_of(wave.indices)};
    const std::size_t total = bytes[0] + bytes[1] + bytes[2] + bytes[3];
    std::string text = scene_of(wave, bytes).dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');

    std::ofstream out(file, std::ios::binary);
    const auto put = [&](const void* data, std::size_t size) {
        out.write(static_cast<const char*>(data), static_cast<std::streamsize>(size));
    };
    const auto put_u32 = [&](std::size_t value) {
        const auto word = static_cast<std::uint32_t>(value);
        put(&word, sizeof word);
    };
    put("glTF", 4), put_u32(2), put_u32(12 + 8 + text.size() + 8 + total);
    put_u32(text.size()), put("JSON", 4), put(text.data(), text.size());
    put_u32(total), put("BIN", 4);
    put(wave.positions.data(), bytes[0]), put(wave.normals.data(), bytes[1]);
    put(wave.uvs.data(), bytes[2]), put(wave.indices.data(), bytes[3]);
    if (!out.flush()) throw Error(file.string(), "cannot be written");
}

void write_wave_stl(const std::filesystem::path& file, int columns, int rows)
{
    const WaveArrays wave = wave_arrays(columns, rows);
    std::ofstream out(file, std::ios::binary);
    const auto put = [&](const void* data, std::size_t size) {
        out.write(static_cast<const char*>(data), static_cast<std::streamsize>(size));
    };
    const std::string head(80, ' ');
    const auto triangles = static_cast<std::uint32_t>(wave.indices.size() / 3);
    put(head.data(), head.size()), put(&triangles, sizeof triangles);
    const Vec3f no_normal(0);
    const std::uint16_t no_attributes = 0;
    for (std::size_t i = 0; i < wave.indices.size(); ++i) {
        if (i % 3 == 0) put(&no_normal, sizeof no_normal);
        put(&wave.positions[wave.indices[i]], sizeof(Vec3f));
        if (i % 3 == 2) put(&no_attributes, sizeof no_attributes);
    }
    if (!out.flush()) throw Error(file.string(), "cannot be written");
}

}  // namespace occam::bench
