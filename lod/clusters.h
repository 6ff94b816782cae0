// A tree of boxes over the faces of a cage or a mesh, so that even a large one is opened step by step.
//
// The tree is built from topology and rest positions. When positions change, the tree of a cage is built anew, and the boxes
// of a mesh follow (TopologyCache::get). A cage is halved along a Morton curve. A mesh is split by the surface area
// heuristic (lod/face_split.h), since the sizes of its faces may differ much, and a leaf becomes one igrid. A face's box
// holds its control points. The surface lies in their hull, because subdivision weights are not negative; near vertices of
// valence 2 it leaves the hull by 4e-7, which is why the boxes are padded.
//
// Space    object axes.
// Memory   36 bytes for each node, and 4 (for a mesh) or 8 for each face.
// Threads  const after refit().
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "scenegraph/cage.h"

namespace occam::lod {

class ClusterTree {
public:
    static constexpr std::uint32_t kLeafFaces = 16;    ///< most faces in a leaf of a cage
    static constexpr std::uint32_t kMeshFaces = 2048;  ///< most faces in a leaf of a mesh

    struct Node {
        Box3f box;
        std::uint32_t begin = 0, end = 0;  ///< the node's range in the order of faces
        std::uint32_t left = 0;            ///< children at left and left + 1; 0: a leaf
    };

    explicit ClusterTree(const Cage& cage);

    /// Updates the boxes for new positions.
    void refit(const Cage& cage);
    /// Computes the box of each node where the cage's vertices are elsewhere.
    /// boxes   as many as there are nodes
    void boxes_at(const Cage& cage, std::span<const Vec3f> positions, std::span<Box3f> boxes) const;

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

    std::vector<Node> nodes_;           ///< the root is 0; children come after their parents
    std::vector<std::uint32_t> order_;  ///< faces of the leaves, leaf after leaf
    std::vector<std::uint32_t> first_corner_;
};

}  // namespace occam::lod
