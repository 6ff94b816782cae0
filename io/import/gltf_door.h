// Validation of glTF: the rules that a file must keep before anything reads it.
//
// The rules are those of the glTF 2.0 specification (Khronos, 2021) and the schemas of the extensions that we know.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "io/import/report.h"

namespace occam::import {

/// Replaces the URI of the buffer that lies in the binary chunk.
inline constexpr const char* kBinaryChunk = "<binary chunk>";

/// Holds a document that has passed validation.
struct CheckedGltf {
    /// The document, with kBinaryChunk in place of the binary chunk's URI and one buffer for each file; empty if nothing was
    /// replaced.
    std::string json;
    std::map<std::string, std::size_t> files;  ///< for each decoded URI, the bytes that its buffer reads
};

/// Checks the JSON against the schema: types, required properties, ranges, and that every index names something. What a
/// renderer can do without (an unknown property, a wrong hint) becomes a warning; everything else throws Error.
CheckedGltf check_gltf(std::string_view json_text, bool is_glb, Report& report);

}  // namespace occam::import
