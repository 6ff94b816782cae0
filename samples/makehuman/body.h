// MakeHuman's body and the clothes that come with it: meshes as Catmull-Clark cages, its 163 bones as nodes, its weights as
// a skin.
//
// Space    decimetres, y up, facing +z; bones at rest have the mesh's axes.
#pragma once

#include <occam/occam.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace sample {

struct Bone {
    std::string name;
    int parent = -1;       ///< by index; parents come first
    occam::Vec3d head{0};  ///< at rest
    occam::NodeId node{};
};

struct Body {
    occam::NodeId node;  ///< holds the whole body
    std::vector<Bone> bones;
    std::map<std::string, int> bone_of;  ///< by name
    double sole = 0;                     ///< y of the lowest vertex at rest
};

/// Adds the body below the scene's root. `shape` is the file of a morph target, which is applied in full. Throws
/// occam::Error.
Body add_body(occam::Scene& scene, const std::filesystem::path& folder, const std::string& shape, occam::Vec3f clothes);

}  // namespace sample
