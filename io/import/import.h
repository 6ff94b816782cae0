// Scene files in: glTF 2.0 and GLB, OBJ with MTL and subdivision tags.
#pragma once

#include <filesystem>

#include "scenegraph/scene.h"

namespace occam {

/// Polygons as Catmull-Clark cages: always, never (polygons are triangulated), or as the file says. Auto: an OBJ with a
/// subdivision tag or any face of four corners or more that is the only content of its file is a cage; plain triangles are
/// not.
enum class Subdivide : unsigned char { Auto, On, Off };

struct LoadOptions {
    Subdivide subdivide = Subdivide::Auto;
    bool strict = false;  ///< what would be a counted warning is an Error
};

/// Reads a scene by its extension. Throws Error: file, element, reason. What could be mended is in Scene::warnings.
Scene load(const std::filesystem::path& file, const LoadOptions& options = {});

}  // namespace occam
