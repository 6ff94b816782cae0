// All patches that are connected alike: how their limit surface follows from their control points.
//
// A Catmull-Clark patch away from extraordinary vertices is bicubic, and so is a quarter of any patch that does not touch
// one, at every depth (Stam 1998; Nießner et al. 2012). So a class is a quadtree over the patch's unit square whose leaves
// are bicubic *pieces*, each with a matrix that makes the 16 control points of the piece from the patch's n. Which squares
// are bicubic is found by trying: 16 limit stencils of OpenSubdiv's Bfr, in double, determine the piece, others test it.
// What still is not bicubic at kDeepest touches an extraordinary vertex: there a point has a limit stencil of its own.
//
// A point's bits depend on class, parameter and control points alone, never on the level that asks: one rule (locate) says
// to which piece a parameter belongs.
//
// Memory   grown on demand, freed with the Topology; a piece takes 64 n bytes.
// Threads  reading is free of locks; growing takes the class's mutex.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "lod/bicubic.h"

namespace occam::lod {

/// Weights of a point and of both tangents for each control point: made by OpenSubdiv in double.
struct LimitStencil {
    std::vector<double> p, du, dv;
};

/// Where stencils come from: the limit surface of one patch that stands for its class.
class LimitSource {
public:
    virtual ~LimitSource() = default;
    /// u, v in [0, 1] of the patch. Sizes `out` to the class's control points. Thread-safe.
    virtual void evaluate(double u, double v, LimitStencil& out) const = 0;
};

/// A limit point as a sum over few control points.
struct PointStencil {
    std::vector<std::uint32_t> controls;
    std::vector<float> weights;
};

struct PatchHull;

class PatchClass {
public:
    static constexpr int kDeepest =
        6;  ///< beyond it squares only have stencils of their points; finer pieces would serve rates above 64

    /// A square of the quadtree.
    struct Node {
        enum Kind : unsigned char { Unknown, Bicubic, Split, Direct };
        float u0 = 0, v0 = 0;
        int depth = 0;  ///< side 2^-depth
        std::atomic<Kind> kind{Unknown};
        bool is_plain = false;  ///< Bicubic: control point i is the patch's own order[i] (a regular patch)
        std::array<std::uint8_t, 16> order{};
        std::unique_ptr<float[]>
            weights;  ///< Bicubic: n * 16, piece point fastest. Direct: corners 0..3, each 3 * n (p, du, dv)
        std::unique_ptr<Node[]> children;  ///< Split: (u, v) halves at v * 2 + u

        float size() const noexcept;
    };

    PatchClass(int control_count, std::unique_ptr<const LimitSource> source);
    ~PatchClass();

    int control_count() const noexcept { return control_count_; }

    /// The square itself, looked into: never Unknown.
    const Node& resolve(const Node& node) const
    {
        return node.kind.load(std::memory_order_acquire) == Node::Unknown ? look_into(node) : node;
    }
    const Node& root() const { return resolve(root_); }
    /// The leaf that (u, v) belongs to: a parameter on a border belongs to the upper side, 1 to the last.
    const Node& locate(float u, float v) const;

    /// Limit stencil of a point in a Direct leaf: from the leaf's table at its corners, else evaluated now.
    /// rows     3 * n floats: p, du, dv, with respect to the patch's [0, 1]
    void direct_rows(const Node& leaf, float u, float v, float* rows) const;
    LimitStencil limit(double u, double v) const;
    /// The limit point at u = corner & 1, v = corner >> 1; made when it is first asked for.
    const PointStencil& corner(int corner) const;

    /// What bounds the whole patch; made when it is first asked for.
    const PatchHull& hull() const
    {
        const PatchHull* made = hull_made_.load(std::memory_order_acquire);
        return made ? *made : make_hull();
    }

private:
    const Node& look_into(const Node& node) const;
    const PatchHull& make_hull() const;
    void classify(Node& node) const;
    bool fit_bicubic(Node& node) const;
    void fill_direct(Node& node) const;

    int control_count_;
    std::unique_ptr<const LimitSource> source_;
    mutable Node root_;
    mutable std::mutex mutex_;
    mutable std::once_flag hull_once_;
    mutable std::unique_ptr<const PatchHull> hull_;
    mutable std::atomic<const PatchHull*> hull_made_ = nullptr;
    mutable std::array<std::once_flag, 4> corner_once_;
    mutable std::array<PointStencil, 4> corners_;
};

}  // namespace occam::lod
