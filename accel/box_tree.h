// Holds the boxes of an igrid: a complete binary tree without pointers, at each key of the igrid's motion.
//
// Memory   an arena.
#pragma once

#include <algorithm>
#include <bit>
#include <limits>

#include "base/arena.h"
#include "base/box.h"

namespace occam::accel {

/// Holds the boxes of a complete binary tree without pointers, in groups of eight: eight lo.x, eight lo.y, ..., eight
/// hi.z, so that values that are read together lie together. The leaves come first, then a spare slot, then the nodes
/// above them, starting with the root. So the eight nodes of the fourth row form a group, too.
struct BoxTree {
    static constexpr int kGroup = 8, kFloats = 6 * kGroup;

    int leaves = 0;  ///< a power of two
    float* data = nullptr;

    static constexpr int kFourthRow = 7;  ///< index of the first node of that row

    /// Returns the number of floats from a box at one key to the same box at the next key.
    std::ptrdiff_t floats_of_a_key() const noexcept { return std::ptrdiff_t(group_count()) * kFloats; }
    BoxTree at_key(int key) const noexcept { return {leaves, data + key * floats_of_a_key()}; }
    int first_leaf() const noexcept { return leaves - 1; }
    int node_count() const noexcept { return 2 * leaves - 1; }
    int group_count() const noexcept { return (2 * leaves + kGroup - 1) / kGroup; }
    /// Points at lo.x of a node; the next coordinate is kGroup floats further. Consecutive leaves lie side by side,
    /// starting at a multiple of eight.
    float* at(int node) const noexcept
    {
        const int place = node < first_leaf() ? leaves + 1 + node : node - first_leaf();
        return data + offset(static_cast<std::size_t>(place));
    }
    /// Returns the index of a box's lo.x among the groups.
    static constexpr std::size_t offset(std::size_t place) noexcept { return place / kGroup * kFloats + place % kGroup; }
    Box3f bounds() const noexcept { return {{lo(0, 0), lo(0, 1), lo(0, 2)}, {hi(0, 0), hi(0, 1), hi(0, 2)}}; }
    float& lo(int node, int axis) const noexcept { return at(node)[axis * kGroup]; }
    float& hi(int node, int axis) const noexcept { return at(node)[(axis + 3) * kGroup]; }
};

/// Makes a tree of at least `leaves` leaves from their boxes at each key, box_at(leaf, key); an empty box is never hit.
/// Boxes are grown by 2 ulps of their largest coordinate or, if there are several keys, by 4 ulps of the largest one of all
/// keys, because positions between keys are rounded too.
template <class BoxAt>
BoxTree make_box_tree(int leaves, int keys, Arena& arena, BoxAt&& box_at)
{
    constexpr float kInfinity = std::numeric_limits<float>::infinity(), kUlp = std::numeric_limits<float>::epsilon();
    BoxTree tree;
    tree.leaves = static_cast<int>(std::bit_ceil(static_cast<unsigned>(std::max(1, leaves))));
    const int groups = tree.group_count() * keys;
    tree.data = arena.make_array<float>(std::size_t(groups) * BoxTree::kFloats).data();
    for (int g = 0; g < groups; ++g) {
        float* group = tree.data + g * BoxTree::kFloats;
        std::fill_n(group, BoxTree::kFloats / 2, kInfinity);
        std::fill_n(group + BoxTree::kFloats / 2, BoxTree::kFloats / 2, -kInfinity);
    }
    const auto set = [](const BoxTree& at, int node, const Box3f& box, float pad) {
        for (int a = 0; a < 3; ++a) {
            at.lo(node, a) = box.lo[a] - pad;
            at.hi(node, a) = box.hi[a] + pad;
        }
    };
    for (int leaf = 0; leaf < leaves; ++leaf) {
        const Box3f first = box_at(leaf, 0);
        if (first.is_empty()) continue;
        const int node = tree.first_leaf() + leaf;
        float largest = first.largest_coordinate();
        if (keys == 1) {
            set(tree, node, first, largest * 2 * kUlp);
            continue;
        }
        for (int key = 1; key < keys; ++key) largest = std::max(largest, box_at(leaf, key).largest_coordinate());
        for (int key = 0; key < keys; ++key) set(tree.at_key(key), node, box_at(leaf, key), largest * 4 * kUlp);
    }
    for (int key = 0; key < keys; ++key) {
        const BoxTree at = tree.at_key(key);
        for (int n = at.first_leaf() - 1; n >= 0; --n)
            for (int a = 0; a < 3; ++a) {
                at.lo(n, a) = std::min(at.lo(2 * n + 1, a), at.lo(2 * n + 2, a));
                at.hi(n, a) = std::max(at.hi(2 * n + 1, a), at.hi(2 * n + 2, a));
            }
    }
    return tree;
}

}  // namespace occam::accel
