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

void write_wave_glb(const std::filesystem::path& file, int columns, int rows)
{
    const std::size_t vertices = std::size_t(columns + 1) * std::size_t(rows + 1),
                      quads = std::size_t(columns) * std::size_t(rows);
    std::vector<Vec3f> positions, normals;
    std::vector<Vec2f> uvs;
    std::vector<std::uint32_t> indices;
    for (int j = 0; j <= rows; ++j)
        for (int i = 0; i <= columns; ++i) {
            const float x = 4.0f * float(i) / float(columns) - 2, z = 2.0f * float(j) / float(rows) - 1;
            positions.emplace_back(x, 0.1f * std::sin(9 * x) * std::cos(7 * z), -z);
            normals.push_back(glm::normalize(
                Vec3f(-0.9f * std::cos(9 * x) * std::cos(7 * z), 1, -0.7f * std::sin(9 * x) * std::sin(7 * z))));
            uvs.emplace_back(float(i) / float(columns), float(j) / float(rows));
        }
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) {
            const auto a = static_cast<std::uint32_t>(j * (columns + 1) + i), b = a + 1;
            const std::uint32_t d = a + static_cast<std::uint32_t>(columns) + 1, c = d + 1;
            indices.insert(indices.end(), {a, b, c, a, c, d});
        }

    using nlohmann::json;
    const std::size_t bytes[] = {positions.size() * sizeof positions[0], normals.size() * sizeof normals[0],
                                 uvs.size() * sizeof uvs[0], indices.size() * sizeof indices[0]};
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
    scene["accessors"] = {accessor(0, 5126, vertices, "VEC3"), accessor(1, 5126, vertices, "VEC3"),
                          accessor(2, 5126, vertices, "VEC2"), accessor(3, 5125, quads * 6, "SCALAR")};
    Box3f box;
    for (const Vec3f p : positions) box.add(p);
    for (int axis = 0; axis < 3; ++axis) {
        scene["accessors"][0]["min"].push_back(box.lo[axis]);
        scene["accessors"][0]["max"].push_back(box.hi[axis]);
    }
    std::string text = scene.dump();
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
    put(positions.data(), bytes[0]), put(normals.data(), bytes[1]), put(uvs.data(), bytes[2]), put(indices.data(), bytes[3]);
    if (!out.flush()) throw Error(file.string(), "cannot be written");
}

}  // namespace occam::bench
