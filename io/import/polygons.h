// Polygons as a file brings them, before it is settled whether they are a cage or triangles.
#pragma once

#include "io/import/import.h"
#include "io/import/report.h"
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
    std::vector<std::uint32_t> smoothing;       ///< the smoothing group of each face, 0 for flat; empty: all are flat
    bool is_tagged = false;                     ///< the file says something about subdivision
};

/// What settle() made of polygons, and the line that tells a person so; no line where there was no choice.
struct Settled {
    Cage cage;
    std::string note;
};

/// A cage or triangles, as `subdivide` says; Auto: a cage if there is a subdivision tag. The scheme is that which the name
/// of the cage begins with, as those of OpenSubdiv's shapes do: `bilinear_` gives Scheme::Bilinear, `loop_` throws Error
/// since there is no such scheme here (Auto: a warning, and its faces as they are); every other name gives Catmull-Clark.
Settled settle(Polygons polygons, Subdivide subdivide, Report& report);

/// Gives a normal to every corner that the file has none for: that of its face if the face is flat, else the mean over the
/// faces of its smoothing group around the vertex, weighted with their angles. Adds nothing where all faces are flat.
void complete_normals(Polygons& polygons);

/// Scheme::Triangles: faces are cut into triangles (convex ones as a fan or by halves, others by ears), holes left out,
/// vertices with several normals split. A concave face of too many corners is cut as if it were convex, with a warning.
Cage triangulate(Polygons polygons, Report& report);

/// Appends size() - 2 triangles to `out`, as triples of indices into `corners`. Returns false if the polygon is concave and
/// has more corners than are cut by ears, so that what it became may leave it.
bool cut_polygon(std::span<const Vec3f> corners, std::vector<std::uint32_t>& out);

}  // namespace occam::import
