// Polygons as a file gives them, before it is decided whether they are a cage or triangles.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/import/far_positions.h"
#include "io/import/import.h"
#include "io/import/report.h"
#include "scenegraph/cage.h"

namespace occam::import {

/// An index that a file left out or that is out of range; sanitize() drops what uses it.
inline constexpr std::uint32_t kNoIndex = 0xffffffff;

/// Holds the polygons of a file. `cage` has face_sizes and the scheme CatmullClark; its uv_sets may have kNoIndex where a
/// corner has no coordinates.
struct Polygons {
    Cage cage;
    std::vector<Vec3f> normals;
    std::vector<std::uint32_t> normal_indices;  ///< one a corner, kNoIndex for none; empty: no normals
    std::vector<std::uint32_t> smoothing;       ///< the smoothing group of each face, 0 for flat; empty: all are flat
    FarPositions far;                           ///< positions in double, if the file has so many digits
    Vec3d place{0};                             ///< where the cage is, after place_far()
    bool is_tagged = false;                     ///< the file says something about subdivision
    bool has_libraries = false;                 ///< the file names libraries of materials, be they read or not
};

/// Makes the positions relative to the middle of their box, if they are so far from the origin beside its size that floats
/// lose much of the shape.
void place_far(Polygons& polygons);

/// Holds what settle() made of polygons, and the line that reports the choice; the line is empty where there was no choice.
struct Settled {
    Cage cage;
    std::string note;
    Vec3d place{0};
};

/// Makes a cage or triangles, as `subdivide` says; Auto makes a cage if there is a subdivision tag. The scheme comes from
/// the prefix of the cage's name, as for the shapes of OpenSubdiv: `bilinear_` gives Scheme::Bilinear; `loop_` throws Error,
/// since there is no such scheme here (with Auto it is a warning, and the faces are rendered as they are); every other name
/// gives Catmull-Clark. Positions that are far from the origin and have not been placed are a warning.
Settled settle(Polygons polygons, Subdivide subdivide, Report& report);
/// Adds such a cage to the scene, as a node below its root that has the cage's name.
void add_settled(Scene& scene, Settled settled);

/// Gives a normal to every corner for which the file has none: the normal of its face if the face is flat, else the mean
/// over the faces of its smoothing group around the vertex, weighted with their angles. Adds nothing if the file
/// has no normals and all faces are flat.
void complete_normals(Polygons& polygons);

/// Makes a mesh of Scheme::Triangles. Faces are cut into triangles (convex ones as a fan or by halves, others by ear
/// clipping), holes are left out, and vertices with several normals are split. A concave face is cut as if it were convex,
/// with a warning, if it has too many corners or the faces before it took too long; one that crosses itself is a warning,
/// too.
Cage triangulate(Polygons polygons, Report& report);

/// Says how a polygon was cut.
enum class CutPolygon : unsigned char {
    Whole,       ///< its triangles cover it
    Crossing,    ///< it crosses itself, seen along its normal, so that its triangles may leave it
    AsConvex,    ///< it is concave and has more corners than ear clipping is used for: its triangles may leave it
    WithoutEars  ///< it is concave, and the budget for ear clipping is used up: its triangles may leave it
};

/// Limits the time that ear clipping takes for all polygons of a file together, since it takes the square of the corners for
/// each. It is counted in looks at a corner, so that it does not depend on the machine.
class EarBudget {
public:
    explicit EarBudget(std::uint64_t looks) : left_(looks) {}
    /// Returns the budget of a file of so many corners, which is larger for files that are large themselves.
    static EarBudget of_file(std::size_t corners) { return EarBudget(std::max(kLeast, kForACorner * corners)); }

    bool is_used_up() const noexcept { return left_ == 0; }
    void take(std::uint64_t looks) noexcept { left_ -= std::min(looks, left_); }

private:
    static constexpr std::uint64_t kLeast = std::uint64_t(1) << 31, kForACorner = 256;
    std::uint64_t left_;
};

/// Appends size() - 2 triangles to `out`, as triples of indices into `corners`. The polygon may have several corners in one
/// place, as one that goes to a hole and back has; some of the triangles may have no area.
CutPolygon cut_polygon(std::span<const Vec3f> corners, EarBudget& budget, std::vector<std::uint32_t>& out);

}  // namespace occam::import
