// The statements of an OBJ file that tinyobjloader's callbacks do not report: subdivision tags, smoothing groups, material
// libraries, and elements that are not rendered.
#pragma once

#include <string>
#include <vector>

#include "io/import/far_positions.h"
#include "io/import/report.h"
#include "scenegraph/cage.h"

namespace occam::import {

struct ObjStatements {
    std::vector<std::string> material_libraries;  ///< the rest of each mtllib line
    std::vector<std::uint32_t> smoothing;         ///< the group (`s`) of each face, 0 for flat; empty: no face has one
    /// Vertices (`v`), texture coordinates (`vt`) and normals (`vn`) that have a number which is not finite.
    std::vector<std::size_t> positions_not_finite, uvs_not_finite, normals_not_finite;
    std::size_t positions = 0, uvs = 0, normals = 0, faces = 0, corners = 0;  ///< how many the file has
    FarPositions far;
    bool is_tagged = false;
};

/// Puts creases, corners, holes and the boundary rule into `cage`. They have the form `t name ints/floats/strings
/// values...`, 0-based, as in OpenSubdiv's shapes. Indices are checked later, by sanitize(): they count all faces of the
/// file. In `text`, lines that belong together are joined and comments behind statements become blanks. Throws Error if a
/// number is missing or malformed.
ObjStatements scan_obj_statements(std::string& text, Cage& cage, Report& report);

}  // namespace occam::import
