// Holds everything about a cage that does not depend on vertex positions: its patches, the owners of its curves and corners,
// and the classes of its patches.
//
// A face of four corners is one patch. Any other face has one patch a corner (OpenSubdiv's quad sub-faces): its (0, 0) is
// that vertex, u runs along the edge to the next vertex, and (1, 1) is the face's middle.
//
// Curves   the borders of patches: base edges first, then the inner curves of n-gons (from the middle of base edge j to the
//          face's middle). Each has one owner, and all patches along it take the owner's points (Djeu et al. 2011,
//          sec. 5.1.3, requires the same bits; evaluated from two sides they differ). The owner is the lowest face with a
//          limit surface.
// Corners  likewise: a vertex is evaluated at its lowest face.
//
// Memory   tables grow on demand: classes, 8 bytes for each patch and for each of its sets of coordinates, and some 60 + 4 n
//          bytes for each patch used, which has n control points. They are freed with the object.
// Threads  const calls from any thread; tables grow under a lock of this object.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "lod/patch_class.h"
#include "scenegraph/cage.h"

namespace occam::lod {

class ClassMemory;
struct Neighbourhood;

struct PatchRef {
    std::uint32_t face = 0;
    std::uint32_t sub = 0;
    friend bool operator==(PatchRef, PatchRef) = default;
};

/// A patch's class and its control points, as indices of the cage's vertices (or of the values of a UV set).
struct PatchControls {
    const PatchClass* kind = nullptr;
    std::span<const std::uint32_t> indices;
    bool are_derived = false;  ///< the indices are those of derived points (Topology::derive)
    /// How many of the last control points are moves of large vertices (lod/derived_points.h). Moves are vectors: the
    /// weights of all others add up to 1 for a point and to 0 for a derivative.
    std::uint32_t move_count = 0;
};

/// One side of a patch: the curve on which it lies, and the curve's parameters at 0 and 1 of the side's own lattice.
struct SideCurve {
    std::uint32_t curve = 0;
    float c0 = 0, c1 = 1;
};

/// A point of a patch where an owner evaluates, unless the point is a vertex of the cage.
struct PatchPoint {
    PatchRef patch;
    float u = 0, v = 0;
    friend bool operator==(PatchPoint, PatchPoint) = default;
};

class Topology {
public:
    /// cage     sanitized, Scheme::CatmullClark or Bilinear; borrowed for the call only
    /// memory   bounds the classes of several topologies together; without it this one has its own
    explicit Topology(const Cage& cage, std::shared_ptr<ClassMemory> memory = nullptr);
    ~Topology();

    std::uint32_t face_count() const noexcept { return face_count_; }
    std::uint32_t face_size(std::uint32_t face) const noexcept;
    /// Returns the index of the face's first corner in the cage's face_vertices.
    std::uint32_t first_corner(std::uint32_t face) const noexcept
    {
        return first_corner_.empty() ? 4 * face : first_corner_[face];
    }
    std::uint32_t patches_of(std::uint32_t face) const noexcept { return face_size(face) == 4 ? 1 : face_size(face); }
    /// Returns whether the face has a limit surface and is not a hole.
    bool is_seen(std::uint32_t face) const noexcept { return seen_[face] != 0; }

    /// Returns how many points are derived from the vertices, for patches near faces of very many corners and vertices of
    /// very many faces. It is 0 for most cages.
    std::size_t derived_count() const noexcept;
    /// Computes the derived points of all vertices, in their space.
    void derive(std::span<const Vec3f> vertices, std::span<Vec3f> out) const;

    const PatchControls& controls(PatchRef patch) const;
    /// The patch must not have linear coordinates.
    const PatchControls& uv_controls(PatchRef patch, int set) const;
    /// Returns whether texture coordinates are bilinear in the patches of a face, because it takes derived points.
    bool has_linear_uv(std::uint32_t face) const noexcept;
    /// Returns the class of a patch with a value at each corner, (0, 0) first and counter-clockwise, and bilinear weights.
    const PatchClass& linear_class() const noexcept;
    int uv_set_count() const noexcept { return uv_set_count_; }

    /// Returns side 0: v = 0, 1: u = 1, 2: v = 1, or 3: u = 0; its lattice runs with rising u or v.
    SideCurve side(PatchRef patch, int side) const noexcept;

    /// Returns where the owner of the curve evaluates its parameter c, 0 < c < 1. The ends of a base edge are vertices.
    /// Those of an inner curve are the middle of base_edge(curve) and the middle of the face, at (1, 1) of any of the face's
    /// patches.
    PatchPoint curve_point(std::uint32_t curve, float c) const noexcept;
    /// Returns the vertex at end 0 or 1 of a base edge.
    std::uint32_t end_vertex(std::uint32_t edge, int end) const noexcept;
    /// Returns the vertices of a face of four corners, in its orientation.
    std::array<std::uint32_t, 4> quad_vertices(std::uint32_t face) const noexcept;
    /// Returns where the owner of a vertex evaluates it: at a corner of a patch.
    PatchPoint vertex_point(std::uint32_t vertex) const noexcept;
    bool is_inner(std::uint32_t curve) const noexcept { return curve >= edge_count_; }
    /// Returns the base edge in whose middle an inner curve begins.
    std::uint32_t base_edge(std::uint32_t inner_curve) const noexcept;
    /// Returns the smallest exponent of the curve's rate: 1 where an n-gon splits a base edge into halves, else 0.
    int least_exponent(std::uint32_t curve) const noexcept;
    /// Returns whether a curve belongs to two patches of one owner (a base edge of an n-gon), so that its parameter 1/2 is a
    /// knot.
    bool has_middle_knot(std::uint32_t curve) const noexcept;

private:
    struct Mesh;
    struct Tables;

    std::uint32_t patch_index(PatchRef p) const noexcept;
    const PatchControls& make_controls(PatchRef patch, int uv_set) const;
    const PatchControls& make_derived_controls(PatchRef patch) const;
    /// Makes the class of a patch for vertices or a UV set. The lock of the tables is held.
    std::unique_ptr<const PatchClass> make_class(PatchRef patch, const Neighbourhood& around, int uv_set) const;
    /// Keeps the controls of a patch, unless it has some. The lock of the tables is held.
    const PatchControls& store(PatchRef patch, int uv_set, PatchControls record, std::vector<std::uint32_t> indices) const;

    std::unique_ptr<Tables> tables_;
    std::unique_ptr<const Mesh> mesh_;
    std::uint32_t face_count_ = 0, patch_count_ = 0, edge_count_ = 0, inner_count_ = 0;
    int uv_set_count_ = 0;
    std::vector<std::uint8_t> seen_;
    std::vector<std::uint32_t> first_patch_, first_corner_;  ///< empty when all faces are quads
};

}  // namespace occam::lod
