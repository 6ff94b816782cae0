// Fixed weights that bound a patch of one class, whatever its control points are: its box and its speeds cost one pass over
// a table instead of a walk through the class's quadtree, which near an extraordinary vertex has dozens of squares.
//
// A bicubic square is in the hull of its 16 Bezier points, and its derivatives in that of three times the differences of
// these: so one net gives both. What is not bicubic at the residual depth touches an extraordinary vertex; there a lattice
// of limit points takes the net's place. A lattice knows nothing of what lies between its points, so semi-sharp creases are
// followed by nets until they are smooth, and the lattices lie below that.
//
// Memory   64 n bytes for each net or lattice of a patch of n control points: one for a regular patch, some 10 for one with
// an
//          extraordinary corner, and one for each of its sides.
// Threads  const once made.
#pragma once

#include <array>
#include <vector>

#include "base/prefetch.h"
#include "lod/patch_class.h"

namespace occam::lod {

struct PatchHull {
    static constexpr int kResidualDepth = 3;

    /// root   of a tree of the class
    PatchHull(const PatchClass& kind, const PatchClass::Node& root);

    /// Groups of 16 points, four rows of four: weights of control point k for all points of group g at (g * n + k) * 16.
    std::vector<float> weights;
    /// What differences within a group are to be multiplied by, so that they bound speeds: of a square, along its rows [0]
    /// and from row to row [1]; of borders, those along each row.
    std::vector<std::array<float, 4>> speeds;
    /// Groups [0, nets) are Bezier nets, rows along u, whose hull holds their square.
    std::size_t nets = 0;
    /// Groups [nets, squares) are 3 x 3 limit points of a square, the last row and column twice: their box holds it once
    /// grown by kLatticeGrowth of its extent.
    std::size_t squares = 0;
    /// From there on: borders of squares, a row each, Bezier points or three limit points. Sides of one row share a group.
    /// None for a patch that is one square: its net has them.
    struct Side {
        std::uint16_t first = 0, count = 0;       ///< groups
        std::uint8_t first_row = 0, row_end = 4;  ///< in each of these
    };
    std::array<Side, 4> sides;  ///< 0: v = 0, 1: u = 1, 2: v = 1, 3: u = 0

    /// Floats of `weights` that are asked for ahead: tables of all classes are more than the caches close by hold.
    static constexpr std::size_t kAhead = 16 * 16;
    void ask_for_first() const noexcept
    {
        for (std::size_t i = 0; i < kAhead; i += 16) prefetch(weights.data() + i);
    }

    bool is_one_square() const noexcept { return squares == speeds.size(); }

    /// A quadratic leaves the range of three equidistant values of its own by an eighth at most.
    static constexpr float kLatticeGrowth = 0.25f;

private:
    struct Row;
    void add_group(const std::vector<Row>& rows, std::size_t first);
    void add_nets(const PatchClass& kind, const PatchClass::Node& node, std::vector<const PatchClass::Node*>& residual);
    void add_lattice(const PatchClass& kind, const PatchClass::Node& square);
};

}  // namespace occam::lod
