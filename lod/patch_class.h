// Describes all patches that are connected alike, and how their limit surface follows from their control points.
//
// A Catmull-Clark patch away from extraordinary vertices is bicubic, and so is a quarter of any patch that does not touch
// one, at every depth (Stam 1998; Nießner et al. 2012). So a class is a quadtree over the patch's unit square whose leaves
// are bicubic *pieces*, each with a matrix that makes the 16 control points of the piece from the patch's n. Trials find
// which squares are bicubic: 16 limit stencils of OpenSubdiv's Bfr, in double, determine the piece, and others test it. What
// still is not bicubic at the deepest level touches an extraordinary vertex: there each point has a limit stencil of its
// own.
//
// A crease of sharpness s rounds the surface off within 2^-s of the edge, so the tree of a patch with semi-sharp creases
// goes down to that depth, and the borders of squares are tested too, since a crease so narrow touches nothing else. Where
// the surface is cubic in one direction, the tree of sharp creases halves rectangles in the other direction alone: a crease
// then needs one strip for each power of two and not one square for each step along it.
//
// A derivative is the difference of control points of a piece times 2^depth, and so is its error if these are floats. So a
// deep piece has matrices of such differences, too, which are rounded after the subtraction.
//
// A point's bits depend on class, parameter and control points alone, never on the level: one rule (locate) says to which
// piece a parameter belongs.
//
// Memory   grows on demand and is freed with the Topology; a piece takes 68 bytes for each control point that it depends on,
//          which few do where creases have made it deep, and 64 more for each axis along which it is deep.
// Threads  reading needs no lock; growing locks the class's mutex.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "base/made_once.h"
#include "lod/bicubic.h"

namespace occam::lod {

/// The weights of each control point for a limit point and both tangents; OpenSubdiv makes them in double.
struct LimitStencil {
    std::vector<double> p, du, dv;
};

/// The source of stencils: the limit surface of one patch that represents its class.
class LimitSource {
public:
    virtual ~LimitSource() = default;

    /// What is evaluated; each tangent takes as long as the point.
    enum class Of { Point, PointAndTangents };
    /// Evaluates at u, v in [0, 1] of the patch, and sizes what it writes to the class's control points; with Of::Point it
    /// may leave the tangents as they are. It is thread-safe.
    virtual void evaluate(double u, double v, Of of, LimitStencil& out) const = 0;
    /// Returns about how many bytes the source takes.
    virtual std::size_t bytes() const noexcept = 0;
};

/// Counts the bytes of the tables of classes, for a limit that all classes share (lod/class_memory.h).
class ClassAccount {
public:
    virtual ~ClassAccount() = default;
    virtual void add(std::size_t bytes) noexcept = 0;
    virtual void remove(std::size_t bytes) noexcept = 0;
};

/// A limit point as a sum over few control points.
struct PointStencil {
    std::vector<std::uint32_t> controls;
    std::vector<float> weights;
};

struct PatchHull;

class PatchClass {
public:
    /// Beyond this depth squares have only stencils of their points, unless a crease needs deeper squares; finer pieces
    /// would serve rates above 64.
    static constexpr int kDeepest = 6;
    /// OpenSubdiv treats creases of this sharpness as infinitely sharp.
    static constexpr int kDeepestOfCreases = 10;
    static constexpr int kBelowCreases = 3;  ///< how much deeper trees of strips go

    /// Returns whether pieces of this depth along an axis have weights of differences along it. Without them a derivative
    /// has an error of some 2^(depth - 24) of the largest control point.
    static constexpr bool is_deep(int depth) noexcept { return depth > kDeepest; }

    /// A square or a rectangle of the tree.
    struct Node {
        enum Kind : unsigned char { Unknown, Bicubic, Split, Direct };
        float u0 = 0, v0 = 0;
        int depth_u = 0, depth_v = 0;  ///< its sides are 2^-depth_u and 2^-depth_v
        bool may_halve_one_way = false;
        bool halves_u = false, halves_v = false;  ///< Split: which sides the children halve
        std::atomic<Kind> kind{Unknown};
        bool is_plain = false;  ///< Bicubic: control point i is the patch's own order[i] (a regular patch)
        std::array<std::uint8_t, 16> order{};
        /// Bicubic: those control points of the patch that the piece depends on.
        std::unique_ptr<std::uint32_t[]> controls;
        std::uint32_t control_count = 0;
        /// Bicubic: 16 weights of each of these, where the piece's point varies fastest; then as many for each axis along
        /// which the piece is deep, u first, of the points less the first one of their row (u) or column (v). Direct: for
        /// each of corners 0 to 3, 3 * n weights for p, du and dv.
        std::unique_ptr<float[]> weights;
        std::unique_ptr<Node[]> children;  ///< Split: the halves along u, then along v

        float size_u() const noexcept;
        float size_v() const noexcept;
        int child_count() const noexcept { return (halves_u ? 2 : 1) * (halves_v ? 2 : 1); }
        /// Returns the child in the lower or upper half of each side; a side that is not halved has one half only.
        const Node& child(int upper_u, int upper_v) const noexcept
        {
            return children[(halves_v ? upper_v * (halves_u ? 2 : 1) : 0) + (halves_u ? upper_u : 0)];
        }
    };

    /// crease_depth   the largest finite sharpness of the edges and vertices that shape the patch, rounded up; 0: none
    /// account        if not null, it is told what the tables take, and outlives the class
    PatchClass(int control_count, std::unique_ptr<const LimitSource> source, int crease_depth = 0,
               ClassAccount* account = nullptr);
    ~PatchClass();

    /// Counts bytes that belong to the class, such as those of its source, in the account.
    void count(std::size_t bytes) const noexcept;

    int control_count() const noexcept { return control_count_; }
    int crease_depth() const noexcept { return crease_depth_; }

    /// Determines the kind of the square if needed and returns the square itself, which is then never Unknown.
    const Node& resolve(const Node& node) const
    {
        return node.kind.load(std::memory_order_acquire) == Node::Unknown ? look_into(node) : node;
    }
    const Node& root() const { return resolve(root_); }
    /// Returns the leaf of (u, v): a parameter on a border belongs to the upper side, and the parameter 1 to the last leaf.
    const Node& locate(float u, float v) const;

    /// Computes the limit stencil of a point in a Direct leaf: at corners from the leaf's table, elsewhere by evaluation.
    /// rows     3 * n floats: p, du, dv, with respect to the patch's [0, 1]
    void direct_rows(const Node& leaf, float u, float v, float* rows) const;
    LimitStencil limit(double u, double v, LimitSource::Of of = LimitSource::Of::Point) const;
    /// Returns the limit point at u = corner & 1, v = corner >> 1; it is made when it is first needed.
    const PointStencil& corner(int corner) const;

    /// Returns what bounds the whole patch; it is made when it is first needed.
    const PatchHull& hull() const
    {
        const PatchHull* made = hull_.get();
        return made ? *made : make_hull();
    }

private:
    void discount(std::size_t bytes) const noexcept;
    /// Returns the bytes of what a node holds itself.
    std::size_t table_bytes(const Node& node) const noexcept;
    /// Returns the bytes of what a node and all below it hold.
    std::size_t tree_bytes(const Node& node) const noexcept;
    const Node& look_into(const Node& node) const;
    const PatchHull& make_hull() const;
    void classify(Node& node) const;
    bool fit_bicubic(Node& node) const;
    void store_weights(Node& node, const std::vector<double>& net) const;
    bool is_cubic_along(const Node& node, bool along_v) const;
    void fill_direct(Node& node) const;

    int control_count_, crease_depth_;
    std::unique_ptr<const LimitSource> source_;
    ClassAccount* account_;
    mutable std::atomic<std::size_t> counted_ = 0;  ///< bytes that the account was told
    mutable Node root_;
    mutable std::mutex mutex_;
    mutable MadeOnce<PatchHull> hull_;
    mutable std::array<MadeOnce<PointStencil>, 4> corners_;
};

}  // namespace occam::lod
