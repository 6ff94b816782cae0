#include <iostream>
#include <nlohmann/json.hpp>

#include "arguments.h"
#include "base/error_without_file.h"
#include "base/printable.h"
#include "io/texture/texture_store.h"

namespace occam::command {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(Vec3d v) { return {v.x, v.y, v.z}; }

// Returns what loading repaired or left out, and which images cannot be read; the images are decoded to find out. With
// `strict` the first one is an Error, as in loading.
std::vector<std::string> all_warnings(const Scene& scene, bool strict)
{
    TextureStore store(std::size_t(1) << 30);
    store.prepare(scene);
    store.decode_all();
    std::vector<std::string> of_images = store.errors();
    for (std::string& line : store.warnings()) of_images.push_back(std::move(line));
    if (strict && !of_images.empty()) throw error_without_file(of_images.front());
    std::vector<std::string> lines = scene.warnings;
    lines.insert(lines.end(), of_images.begin(), of_images.end());
    return lines;
}

Json describe(Scene& scene, const std::string& file, bool strict)
{
    const Scene::Counts counts = scene.counts();
    const Box3d bounds = scene.bounds();
    const auto names = [&](const std::vector<ClipId>& ids) {
        Json list = Json::array();
        for (ClipId id : ids) list.push_back(scene.clip(id).name);
        return list;
    };
    Json box = nullptr;
    if (!bounds.is_empty()) box = {{"min", json_of(bounds.lo)}, {"max", json_of(bounds.hi)}};
    return {{"file", file},
            {"nodes", counts.nodes},
            {"cages", counts.cages},
            {"faces", counts.faces},
            {"placed_faces", scene.placed_faces()},
            {"materials", counts.materials},
            {"textures", counts.textures},
            {"lights", counts.lights},
            {"environment", scene.environment.radiance != Vec3f(0)},
            {"cameras", scene.camera_names()},
            {"skins", counts.skins},
            {"clips", names(scene.clips())},
            {"clips_together", names(scene.clips_together())},
            {"bounds", box},
            {"variants", scene.variants},
            {"notes", scene.notes},
            {"warnings", all_warnings(scene, strict)}};
}

void print_text(const Json& info)
{
    for (const auto& [key, value] : info.items()) {
        if (value.is_array()) {
            std::cout << key << ": " << value.size() << '\n';
            for (const Json& entry : value) std::cout << "  " << printable_line(entry.get<std::string>()) << '\n';
        } else if (value.is_object()) {
            std::cout << key << ": " << value["min"].dump() << " to " << value["max"].dump() << '\n';
        } else {
            std::cout << key << ": " << (value.is_string() ? printable_line(value.get<std::string>()) : value.dump())
                      << '\n';
        }
    }
}

}  // namespace

int run(const InfoArguments& a)
{
    Scene scene = open_scene(a);
    const Json info = describe(scene, a.scene.empty() ? "built-in" : a.scene.string(), a.load.strict);
    if (a.json) std::cout << info.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
    else print_text(info);
    std::cout.flush();
    if (!std::cout) throw error_without_file("standard output cannot be written", {}, Error::Kind::Output);
    return 0;
}

}  // namespace occam::command
