#include "io/import/import.h"

#include <algorithm>
#include <new>

#include "io/extensions.h"
#include "io/import/gltf.h"
#include "io/import/obj.h"
#include "io/import/polygon_files.h"
#include "io/import/report.h"

namespace occam {

namespace import {

void finish(Scene& scene, const Report& report)
{
    if (report.is_strict() && !scene.warnings.empty()) throw Error(report.name(), scene.warnings.front());
    std::vector<std::string> lines = report.lines();
    scene.warnings.insert(scene.warnings.begin(), lines.begin(), lines.end());
    scene.files.insert(scene.files.end(), report.files().begin(), report.files().end());
}

namespace {

constexpr SceneFormat kFormats[] = {
    {".gltf .glb", "glTF 2.0", "nodes, meshes, skins, morph targets, clips, cameras, materials, textures, lights", "y",
     load_gltf},
    {".obj", "Wavefront OBJ",
     "polygons, normals, texture coordinates, colours of vertices, MTL materials, subdivision tags (`t crease`, "
     "`t corner`, ...)",
     "y", load_obj},
    {".ply", "Stanford PLY",
     "polygons, normals, texture coordinates, colours of vertices or faces; text and both binary forms", "y", load_ply},
    {".off", "OFF", "polygons, normals, texture coordinates, colours of vertices or faces; text", "y", load_off},
    {".stl", "STL", "triangles; text and binary", "z", load_stl},
};

/// Refuses what is no file with something in it, before its name is looked at.
void require_file(const std::filesystem::path& file)
{
    std::error_code error;
    const std::filesystem::file_status status = std::filesystem::status(file, error);
    if (status.type() == std::filesystem::file_type::not_found) throw Error(file.string(), "no such file");
    if (error) throw Error(file.string(), "cannot be read: " + error.message());
    if (std::filesystem::is_directory(status)) throw Error(file.string(), "is a folder; name a scene file in it");
    if (std::filesystem::is_regular_file(status) && std::filesystem::file_size(file, error) == 0)
        throw Error(file.string(), "the file is empty");
}

void require_variant(const Scene& scene, const std::filesystem::path& file, const std::string& name)
{
    if (name.empty() || std::find(scene.variants.begin(), scene.variants.end(), name) != scene.variants.end()) return;
    std::string known;
    for (const std::string& variant : scene.variants) known += (known.empty() ? "it has " : ", ") + variant;
    throw Error(file.string(), "has no variant of that name; " + (known.empty() ? "it has none" : known), name);
}

}  // namespace

}  // namespace import

std::span<const SceneFormat> scene_formats() noexcept { return import::kFormats; }

const SceneFormat* scene_format_of(const std::filesystem::path& file) { return find_by_extension(scene_formats(), file); }

const SceneFormat& required_scene_format(const std::filesystem::path& file)
{
    import::require_file(file);
    if (const SceneFormat* format = scene_format_of(file)) return *format;
    throw Error(file.string(), "not a scene file that is known: " + extensions_of(scene_formats()), extension_of(file));
}

Scene load(const std::filesystem::path& file, const LoadOptions& options)
{
    const SceneFormat& format = required_scene_format(file);
    try {
        Scene scene = format.load(file, options);
        import::require_variant(scene, file, options.variant);
        return scene;
    } catch (const Error& error) {
        if (!error.file().empty()) throw;
        throw Error(file.string(), error.what());  // the file's content breaks a rule of the scene graph
    } catch (const std::bad_alloc&) {
        throw Error(file.string(), "there is not enough memory for what it declares", {}, Error::Kind::Output);
    } catch (const std::exception& error) {
        throw Error(file.string(), std::string("not readable: ") + error.what());
    }
}

}  // namespace occam
