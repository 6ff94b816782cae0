// A cage's faces in a tree of boxes, so that a cage of any size is opened step by step.
//
// The tree is built from topology and rest positions; the boxes follow when positions change. A cage is halved along a
// Morton curve. A triangle mesh is parted by the surface area heuristic (lod/face_split.h), since its faces may differ
// much in size: a leaf becomes one igrid. A face's box holds its control points'
// (the surface lies in their hull: the weights of subdivision are not negative; val-2 vertices leave it by 4e-7, hence the
// pad).
//
// Space    object axes.   Memory   28 bytes a node, 4 a face.   Threads  const after refit().
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "scenegraph/cage.h"

namespace occam::lod {

class ClusterTree {
public:
    static constexpr std::uint32_t kLeafFaces = 16;   ///< of a cage, at most
    static constexpr std::uint32_t kMeshFaces = 256;  ///< of a leaf of a triangle mesh, at most

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
    /// Returns the faces of a node.
    std::span<const std::uint32_t> faces(const Node& of) const noexcept
    {
        return std::span(order_).subspan(of.begin, of.end - of.begin);
    }

private:
    void halve_along_curve(const Cage& cage);
    void part_by_area(const Cage& cage);

    std::vector<Node> nodes_;           ///< 0 the root; children after their parents
    std::vector<std::uint32_t> order_;  ///< faces of the leaves, leaf after leaf
    std::vector<std::uint32_t> first_corner_;
};

}  // namespace occam::lod
