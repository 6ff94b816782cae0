// The importers of scene files: glTF 2.0 and GLB, OBJ with MTL and subdivision tags, PLY, OFF and STL.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "scenegraph/scene.h"

namespace occam {

/// Says whether polygons are the cage of a Catmull-Clark surface where glTF's extras.occam says nothing of it: always,
/// never, or as the file says. With Auto only two kinds are subdivided: an OBJ file with subdivision tags, and what glTF's
/// extras.occam names. All other polygons are rendered as they are, with the file's normals, or without those flat or smooth
/// as the smoothing groups (`s`) of an OBJ say.
enum class Subdivide : unsigned char { Auto, On, Off };

struct LoadOptions {
    Subdivide subdivide = Subdivide::Auto;
    bool strict = false;    ///< what would be a counted warning is an Error
    std::string variant{};  ///< materials of this variant (KHR_materials_variants); empty: those of the file itself
};

/// Describes a format of scene files.
struct SceneFormat {
    std::string_view extensions;  ///< in lower case, with spaces between
    std::string_view name;
    std::string_view contents;  ///< what is read
    std::string_view up;        ///< which way is up where a file has no camera: "y", or "z" as in printing and machining
    Scene (*load)(const std::filesystem::path& file, const LoadOptions& options);
};
/// Returns all formats: one row each. To add one, add its loader and its row (io/import/import.cpp).
std::span<const SceneFormat> scene_formats() noexcept;
/// Returns the format that the extension of a file names, or null.
const SceneFormat* scene_format_of(const std::filesystem::path& file);
/// The same, for a file that is to be read. Throws Error if it is not there, is no file, is empty, or has no such extension.
const SceneFormat& required_scene_format(const std::filesystem::path& file);

/// Reads a scene; the file's extension selects the format. Throws Error with file, element and reason. What was repaired is
/// in Scene::warnings, what was chosen in Scene::notes.
Scene load(const std::filesystem::path& file, const LoadOptions& options = {});

}  // namespace occam
