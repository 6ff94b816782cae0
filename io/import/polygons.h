// Polygons as a file brings them, before it is settled whether they are a cage or triangles.
#pragma once

#include "io/import/import.h"
#include "scenegraph/cage.h"

namespace occam::import {

/// An index that a file left out, or that points nowhere: sanitize() drops what uses it.
inline constexpr std::uint32_t kNoIndex = 0xffffffff;

/// `cage` has face_sizes and scheme CatmullClark, its colours, if any, one a vertex; its uv_sets may have kNoIndex where a
/// corner has no coordinates.
struct Polygons {
    Cage cage;
    std::vector<Vec3f> normals;
    std::vector<std::uint32_t> normal_indices;  ///< one a corner, kNoIndex for none; empty: no normals
    bool is_tagged = false;                     ///< the file says something about subdivision
};

/// Cages or triangles, as `subdivide` says; Auto: a cage if there is a subdivision tag or a face of four corners or more.
Cage settle(Polygons polygons, Subdivide subdivide);

/// Scheme::Triangles: faces are cut into triangles (convex ones as a fan, others by ears), holes left out, vertices with
/// several normals split.
Cage triangulate(Polygons polygons);

/// Appends size() - 2 triangles to `out`, as triples of indices into `corners`.
void cut_polygon(std::span<const Vec3f> corners, std::vector<std::uint32_t>& out);

}  // namespace occam::import
