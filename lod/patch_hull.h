// Fixed weights that bound any patch of one class, whatever its control points. The box and the speeds of a patch cost one
// pass over a table instead of a walk through the class's quadtree, which has dozens of squares near an extraordinary
// vertex.
//
// A bicubic square lies in the hull of its 16 Bezier points, and its derivatives lie in the hull of three times their
// differences, so one net gives both. What is not bicubic at the residual depth touches an extraordinary vertex; there a
// lattice of limit points replaces the net. A lattice knows nothing of what lies between its points, so nets follow
// semi-sharp creases until these are smooth, and the lattices lie below that depth.
//
// Memory   68 bytes for each control point on which a net or a lattice depends. A regular patch has one; a patch with one
//          extraordinary corner has some 10, and one for each of its sides.
// Threads  const once it is made.
#pragma once

#include <array>
#include <vector>

#include "base/prefetch.h"
#include "lod/patch_class.h"

namespace occam::lod {

struct PatchHull {
    static constexpr int kResidualDepth = 3;

    /// root   the root of a tree of the class
    PatchHull(const PatchClass& kind, const PatchClass::Node& root);

    /// Returns how many bytes it takes.
    std::size_t bytes() const noexcept;

    /// Groups of 16 points in four rows of four. Group g has the rows [first_rows[g], first_rows[g + 1]): row r holds the
    /// weights of control point controls[r] for all points of the group, from r * 16 on. Points that have no weight have no
    /// row.
    std::vector<float> weights;
    std::vector<std::uint32_t> controls, first_rows{0};
    /// The factors by which differences within a group are multiplied so that they bound speeds. A square has one along its
    /// rows [0] and one from row to row [1]; a group of borders has one for each row.
    std::vector<std::array<float, 4>> speeds;
    /// Groups [0, nets) are Bezier nets, rows along u, whose hull holds their square.
    std::size_t nets = 0;
    /// Groups [nets, squares) are 3 x 3 limit points of a square, with the last row and column repeated: their box holds the
    /// square once it is grown by kLatticeGrowth of its extent.
    std::size_t squares = 0;
    /// The groups from there on are borders of squares, one a row, as Bezier points or three limit points. Sides of one row
    /// share a group. A patch that is one square has none, because its net holds its borders.
    struct Side {
        std::uint16_t first = 0, count = 0;       ///< groups
        std::uint8_t first_row = 0, row_end = 4;  ///< rows in each of these groups
    };
    std::array<Side, 4> sides;  ///< 0: v = 0, 1: u = 1, 2: v = 1, 3: u = 0

    /// The number of `weights` that are prefetched: the tables of all classes do not fit into the near caches.
    static constexpr std::size_t kAhead = 16 * 16;
    void ask_for_first() const noexcept
    {
        for (std::size_t i = 0; i < kAhead; i += 16) prefetch(weights.data() + i);
    }

    bool is_one_square() const noexcept { return squares == speeds.size(); }

    /// A quadratic leaves the range of three of its equidistant values by at most an eighth of it, and a biquadratic that of
    /// nine by at most 9/32: the sum of its negative weights at (3/4, 3/4).
    static constexpr float kLatticeGrowth = 0.28125f;

private:
    struct Row;
    /// Adds a group with the weights of all control points.
    void add_group(const std::vector<float>& all);
    void add_borders(const std::vector<Row>& rows, std::size_t first);
    void add_nets(const PatchClass& kind, const PatchClass::Node& node, std::vector<const PatchClass::Node*>& residual);
    void add_lattice(const PatchClass& kind, const PatchClass::Node& square);
    void add_sides(const PatchClass& kind, const PatchClass::Node& root);
};

}  // namespace occam::lod
