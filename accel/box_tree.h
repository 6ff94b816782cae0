// Holds the boxes of an igrid: a complete binary tree without pointers, at each key of the igrid's motion.
//
// Memory   an arena.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "base/arena.h"
#include "base/box.h"

namespace occam::accel {

/// Holds the boxes of a complete binary tree without pointers, in groups of eight: eight lo.x, eight lo.y, ..., eight
/// hi.z, so that values that are read together lie together. The leaves come first, then a spare slot, then the nodes
/// above them, starting with the root. So the eight nodes of the fourth row form a group, too.
///
/// A tree that moves is stored at each key, so it has only what rays read: the leaves, with shorter rows if they are fewer
/// than eight, the group of the fourth row if there are more than sixteen leaves, and the root, with rows of one float.
/// Eight floats are read from where a row begins; what comes after its own belongs to no box.
struct BoxTree {
    static constexpr int kGroup = 8, kFloats = 6 * kGroup;

    std::int16_t leaves = 0;   ///< a power of two
    std::int8_t row = kGroup;  ///< the number of floats in a row of leaves
    bool moves = false;
    std::int32_t floats_of_a_key = 0;  ///< from a box at one key to the same box at the next key
    float* data = nullptr;

    /// Returns a tree of at least so many leaves, without boxes.
    static BoxTree of(int least, bool moves) noexcept
    {
        const int leaves = static_cast<int>(std::bit_ceil(static_cast<unsigned>(std::max(1, least))));
        BoxTree tree{static_cast<std::int16_t>(leaves), kGroup, moves};
        tree.floats_of_a_key = (2 * leaves + kGroup - 1) / kGroup * kFloats;
        if (!moves) return tree;
        tree.row = static_cast<std::int8_t>(std::min(leaves, kGroup));
        tree.floats_of_a_key = 6 * (leaves > 1 ? leaves + 1 : 1) + (tree.has_fourth_row() ? kFloats : 0);
        return tree;
    }

    BoxTree at_key(int key) const noexcept
    {
        BoxTree tree = *this;
        tree.data += std::ptrdiff_t(key) * floats_of_a_key;
        return tree;
    }
    bool has_fourth_row() const noexcept { return leaves > 2 * kGroup; }
    // Each of these points at lo.x of a box; the next coordinate is a row further.
    /// Leaves lie side by side, starting at a multiple of eight.
    float* leaf(int i) const noexcept { return data + offset(static_cast<std::size_t>(i)); }
    /// The first of the eight nodes of the fourth row; the others follow it.
    float* fourth_row() const noexcept { return data + offset(static_cast<std::size_t>(moves ? leaves : leaves + kGroup)); }
    float* root() const noexcept
    {
        if (leaves == 1) return data;
        return data + (moves ? static_cast<std::size_t>(floats_of_a_key - 6) : offset(static_cast<std::size_t>(leaves) + 1));
    }
    /// Returns the number of floats in the row of the root.
    int root_row() const noexcept { return moves ? 1 : kGroup; }
    Box3f bounds() const noexcept { return box(root(), root_row()); }
    static Box3f box(const float* at, int row) noexcept
    {
        return {{at[0], at[row], at[2 * row]}, {at[3 * row], at[4 * row], at[5 * row]}};
    }

    /// Points at a box of a tree that stands still. The children of node n are 2n + 1 and 2n + 2; node 0 is the root.
    float* node(int n) const noexcept
    {
        return data + offset(static_cast<std::size_t>(n < leaves - 1 ? leaves + 1 + n : n - (leaves - 1)));
    }

    /// Returns the index of a box's lo.x among the groups.
    static constexpr std::size_t offset(std::size_t place) noexcept { return place / kGroup * kFloats + place % kGroup; }
};

/// Sets a box in a group whose rows have `row` floats, grown on all sides.
inline void set_box_in(float* to, int row, const Box3f& box, float pad = 0) noexcept
{
    for (int a = 0; a < 3; ++a) {
        to[a * row] = box.lo[a] - pad;
        to[(a + 3) * row] = box.hi[a] + pad;
    }
}
/// Sets `count` boxes that lie side by side in groups of eight, or in one group with shorter rows, to empty ones.
inline void clear_boxes(float* to, int row, int count) noexcept
{
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    for (int g = 0; g < count; g += row, to += 6 * row) {
        std::fill_n(to, 3 * row, kInfinity);
        std::fill_n(to + 3 * row, 3 * row, -kInfinity);
    }
}

/// Makes a tree of at least `leaves` leaves from their boxes, box_at(leaf); an empty box is never hit. Boxes are grown by 2
/// ulps of their largest coordinate.
template <class BoxAt>
BoxTree make_still_box_tree(int leaves, Arena& arena, BoxAt&& box_at)
{
    BoxTree tree = BoxTree::of(leaves, false);
    tree.data = arena.make_array<float>(static_cast<std::size_t>(tree.floats_of_a_key)).data();
    clear_boxes(tree.data, BoxTree::kGroup, 2 * tree.leaves);
    for (int leaf = 0; leaf < leaves; ++leaf) {
        const Box3f box = box_at(leaf);
        if (!box.is_empty())
            set_box_in(tree.leaf(leaf), BoxTree::kGroup, box,
                       box.largest_coordinate() * 2 * std::numeric_limits<float>::epsilon());
    }
    for (int n = tree.leaves - 2; n >= 0; --n)
        for (int row = 0; row < 6; ++row) {
            const float a = tree.node(2 * n + 1)[row * BoxTree::kGroup], b = tree.node(2 * n + 2)[row * BoxTree::kGroup];
            tree.node(n)[row * BoxTree::kGroup] = row < 3 ? std::min(a, b) : std::max(a, b);
        }
    return tree;
}

/// Makes a tree from boxes at each key, box_at(leaf, key). Boxes are grown by 4 ulps of the largest coordinate of all keys,
/// because positions between keys are rounded too.
template <class BoxAt>
BoxTree make_moving_box_tree(int leaves, int keys, Arena& arena, BoxAt&& box_at)
{
    BoxTree tree = BoxTree::of(leaves, true);
    const auto floats = static_cast<std::size_t>(tree.floats_of_a_key) * static_cast<std::size_t>(keys);
    tree.data = arena.make_array<float>(floats + BoxTree::kGroup).data();
    std::fill_n(tree.data + floats, BoxTree::kGroup, 0.0f);  // they are read with the last row
    for (int key = 0; key < keys; ++key) {
        clear_boxes(tree.at_key(key).data, tree.row, tree.leaves);
        if (tree.leaves > 1) clear_boxes(tree.at_key(key).root(), 1, 1);
        if (tree.has_fourth_row()) clear_boxes(tree.at_key(key).fourth_row(), BoxTree::kGroup, BoxTree::kGroup);
    }
    const auto add = [](float* to, int row, const Box3f& box) {
        Box3f all = BoxTree::box(to, row);
        all.add(box);
        set_box_in(to, row, all);
    };
    for (int leaf = 0; leaf < leaves; ++leaf) {
        float pad = 0;
        for (int key = 0; key < keys; ++key) {
            const Box3f box = box_at(leaf, key);
            if (!box.is_empty()) pad = std::max(pad, box.largest_coordinate() * 4 * std::numeric_limits<float>::epsilon());
        }
        for (int key = 0; key < keys; ++key) {
            const BoxTree at = tree.at_key(key);
            Box3f box = box_at(leaf, key);
            if (box.is_empty()) continue;
            box = {box.lo - pad, box.hi + pad};
            set_box_in(at.leaf(leaf), at.row, box);
            if (at.leaves > 1) add(at.root(), 1, box);
            if (at.has_fourth_row()) add(at.fourth_row() + leaf / (at.leaves / BoxTree::kGroup), BoxTree::kGroup, box);
        }
    }
    return tree;
}

}  // namespace occam::accel
