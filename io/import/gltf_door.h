// Validation of glTF: the rules that a file must keep before anything reads it.
//
// The rules are those of the glTF 2.0 specification (Khronos, 2021) and the schemas of the extensions that we know.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "io/import/gltf_buffers.h"
#include "io/import/report.h"

namespace occam::import {

/// The attribute that stands for the indices of a primitive where tinygltf would refuse them.
inline constexpr const char* kIndicesAttribute = "<indices>";

/// Holds a document that has passed validation.
struct CheckedGltf {
    /// The document, changed so that tinygltf reads it rightly: each file has one buffer, whose URI is a name of ours, whole
    /// numbers that would be cut to 32 bits have a point, and kIndicesAttribute stands for some indices.
    std::string json;
    std::map<std::string, BufferSource> buffers;  ///< by these names
};

/// Checks the JSON against the schema: types, required properties, ranges, and that every index names something. What a
/// renderer can do without (an unknown property, a wrong hint) becomes a warning; everything else throws Error.
CheckedGltf check_gltf(std::string_view json_text, bool is_glb, Report& report);

}  // namespace occam::import
