// A cage's faces in a tree of boxes, so that a cage of any size is opened step by step.
//
// Built from topology and rest positions; the boxes follow when positions change. A face's box holds its control points'
// (the surface lies in their hull: the weights of subdivision are not negative; val-2 vertices leave it by 4e-7, hence the
// pad).
//
// Space    object axes.   Memory   28 bytes a node, 4 a face.   Threads  const after refit().
#pragma once

#include <cstdint>
#include <vector>

#include "scenegraph/cage.h"

namespace occam::lod {

class ClusterTree {
public:
    static constexpr std::uint32_t kLeafFaces = 16;

    struct Node {
        Box3f box;
        std::uint32_t begin = 0, end = 0;  ///< faces() of the node
        std::uint32_t left = 0;            ///< children at left and left + 1; 0: a leaf
    };

    explicit ClusterTree(const Cage& cage);

    /// New boxes for new positions.
    void refit(const Cage& cage);

    const Node& node(std::uint32_t i) const noexcept { return nodes_[i]; }
    std::uint32_t node_count() const noexcept { return static_cast<std::uint32_t>(nodes_.size()); }
    std::uint32_t face(std::uint32_t i) const noexcept { return order_[i]; }

private:
    std::vector<Node> nodes_;           ///< 0 the root; children after their parents
    std::vector<std::uint32_t> order_;  ///< faces along a Morton curve
    std::vector<std::uint32_t> first_corner_;
};

}  // namespace occam::lod
