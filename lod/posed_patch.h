// A patch with posed control points, which evaluates limit points and tangents.
//
// Space    the cage's dicing frame; parameters of the patch, [0, 1].
// Memory   its vectors are reused from patch to patch, since a dicer keeps its posed patches; nothing here is in an arena.
// Threads  one at a time, as for the dicer that owns it.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "lod/bicubic.h"
#include "lod/patch_hull.h"
#include "lod/posed_cage.h"

namespace occam::lod {

struct SurfacePoint {
    Vec3f p, du, dv;
};

/// A grid of parameters: (u0 + i * step_u, v0 + j * step_v), i < columns, j < rows. All are dyadic and so exact.
struct ParameterGrid {
    float u0 = 0, v0 = 0, step_u = 1, step_v = 1;
    int columns = 2, rows = 2;
};

class PosedPatch {
public:
    /// Poses the control points of a patch of the cage.
    void set(const PosedCage& cage, PatchRef patch);
    /// Takes the values of a UV set instead, as the x and y of points.
    void set_uv(const PosedCage& cage, PatchRef patch, int uv_set);

    /// Writes the points at `grid` to rows of `stride` floats at x, y, z.
    void points(const ParameterGrid& grid, float* x, float* y, float* z, int stride);
    /// Writes points and both tangents (with respect to the patch's parameter) to 9 arrays of rows, p.x .. dv.z.
    void points_and_tangents(const ParameterGrid& grid, float* const out[9], int stride);

    /// Computes points of a curve with v (or u, if along_v) fixed and the other parameter t0 + i * step, i < out.size();
    /// step is not 0.
    void curve(bool along_v, float fixed, float t0, float step, std::span<Vec3f> out);
    Vec3f point(float u, float v);

    /// Returns the largest speed that the curve along a side may have (sides as in Topology::side). It is a strict bound for
    /// bicubic pieces; next to an extraordinary vertex it comes from chords of sixteenths.
    float side_speed(int side);
    /// Computes the same for the whole patch along u and along v.
    void speeds(float& along_u, float& along_v);

    /// Returns a box of all points with u0 <= u <= u1, v0 <= v <= v1. It holds the Bezier points of the pieces there; next
    /// to an extraordinary vertex, the corners of the smallest squares, grown by their extent. For the whole patch it comes
    /// from PatchHull.
    Box3f bounds(float u0, float u1, float v0, float v1);

private:
    struct Piece {
        const float* weights;  ///< the matrix of its class
        bool is_relative;      ///< it was multiplied by the patch's points less the first one, and by its moves
        PieceControls controls;
    };

    /// Forgets everything that was made for the last patch.
    void forget();
    /// moves   how many of the last control points are moves (PatchControls::move_count)
    void make_room(std::size_t count, std::size_t moves = 0);
    void set_linear_uv(const PosedCage& cage, PatchRef patch, int uv_set);
    // What these functions return stays valid until one of them is called again.
    const PieceControls& piece(const PatchClass::Node& node);
    /// Returns the control points of a piece, which may lack a constant in each row (or column, if along_v): their
    /// differences are exact where those of piece() are rounded.
    const PieceControls& differences(const PatchClass::Node& node, bool along_v);
    /// Returns whether derivatives along an axis of a piece need differences().
    bool needs_differences(int depth);
    const PieceControls* find_piece(const float* weights, bool is_relative) const noexcept;
    /// Returns whether the patch is small beside its distance from the origin.
    bool is_far();
    SurfacePoint direct(const PatchClass::Node& leaf, float u, float v);
    /// A part of a grid: columns i0 <= i < i1 and rows j0 <= j < j1.
    struct GridPart {
        int i0, i1, j0, j1;
    };
    /// Rows of `stride` floats in each of several arrays, one for each coordinate.
    struct Rows {
        float* const* out;
        int stride;
    };
    /// Points of a curve, as curve() is asked for them.
    struct CurvePoints {
        bool along_v;
        float fixed, t0, step;
        Vec3f* out;
    };
    template <bool kTangents>
    void fill(const PatchClass::Node& node, const ParameterGrid& grid, const GridPart& part, const Rows& rows);
    template <bool kTangents>
    void fill_piece(const PatchClass::Node& node, const ParameterGrid& grid, const GridPart& part, const Rows& rows);
    /// Writes the points i0 <= i < i1.
    void fill_curve(const PatchClass::Node& node, const CurvePoints& curve, int i0, int i1);
    struct Points {
        vfloat4x4 x, y, z;
    };
    Points points(const PatchHull& hull, std::size_t group) const;
    /// Computes the box and the speeds, once.
    void measure();
    /// Returns the largest coordinate of a control point.
    float reach();
    void bounds_below(const PatchClass::Node& node, float u0, float u1, float v0, float v1, Box3f& box);

    const PatchClass* kind_ = nullptr;
    std::size_t count_ = 0;         ///< number of control points
    std::size_t point_count_ = 0;   ///< how many of them, the first ones, are points and no moves
    std::vector<float> x_, y_, z_;  ///< control points, with room for more
    std::vector<Piece> pieces_;     ///< made so far
    std::vector<float> rows_;
    bool is_measured_ = false;
    enum class Distance : unsigned char { Unknown, Near, Far } distance_ = Distance::Unknown;
    float reach_ = -1;  ///< negative: not known yet
    Box3f box_;
    float speed_u_ = 0, speed_v_ = 0;
    std::array<float, 4> side_speed_{};  ///< negative: not known yet
};

}  // namespace occam::lod
