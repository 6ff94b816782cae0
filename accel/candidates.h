// The items among which a lazy node of a tree chooses its children: they are opened, largest first, until there are enough.
//
// Both trees grow from items in the same way (accel/kd_tree.h, accel/bvh.h); what they make of them differs.
#pragma once

#include <vector>

#include "accel/tree_leaf.h"

namespace occam::accel {

struct Candidate {
    Box3f box;  ///< clipped to the node
    ItemIndex item;
    float cost;
    bool is_final;
};

class Candidates : public std::vector<Candidate> {
public:
    /// The effort of opening any item; see Items::effort.
    static constexpr int kAnyEffort = 2;

    explicit Candidates(Items& items) : items_(items) {}

    /// Starts with the parts of these items that lie in a node's box. Final is what rays of the pair meet as one igrid.
    void start(const Box3f& box, std::span<const ItemIndex> items, int pair);
    /// Opens the largest of those items that cost the least effort to open. Returns false if there is none of at most
    /// `most_effort`.
    bool open_largest(int most_effort);
    /// Makes the list of a leaf, for the pairs to which it applies. All candidates are final.
    TreeLeaf leaf(Arena& arena) const;
    /// Returns the pair up to which all boxes are right.
    int holds_to() const noexcept;

private:
    void add(ItemIndex item);

    Items& items_;
    Box3f within_;
    int pair_ = 0;
};

}  // namespace occam::accel
