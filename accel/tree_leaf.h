// Holds what the leaves of both trees list (accel/kd_tree.h, accel/bvh.h): items, their boxes, and their igrids once a ray
// has entered these boxes.
#pragma once

#include "accel/items.h"

namespace occam::accel {

inline constexpr int kBoxGroup = BoxTree::kGroup, kBoxGroupFloats = BoxTree::kFloats;

/// Writes a box among boxes that lie side by side in groups of eight: eight lo.x, eight lo.y, ..., eight hi.z (the layout of
/// BoxTree). A single group may have shorter rows.
inline void set_box(float* groups, std::size_t place, const Box3f& box, int row = kBoxGroup) noexcept
{
    float* to = groups + BoxTree::offset(place);
    for (int a = 0; a < 3; ++a) {
        to[a * row] = box.lo[a];
        to[(a + 3) * row] = box.hi[a];
    }
}
inline Box3f get_box(const float* groups, std::size_t place, int row = kBoxGroup) noexcept
{
    const float* at = groups + BoxTree::offset(place);
    return {{at[0], at[row], at[2 * row]}, {at[3 * row], at[4 * row], at[5 * row]}};
}

/// Holds the keys of boxes that move: they divide an interval of the shutter evenly, and the boxes are linear between them.
struct KeySpan {
    int segments = 0;               ///< 0: nothing moves, and one box holds for all times
    float begin = 0, per_time = 0;  ///< key k is at begin + k / per_time
    int row = kBoxGroup;            ///< floats in a row of a group: 1, 2 or 4 where a leaf has so few boxes

    /// Returns the number of floats from a key to the next one, for so many boxes.
    std::size_t stride(std::size_t boxes) const noexcept
    {
        return (boxes + kBoxGroup - 1) / kBoxGroup * (kBoxGroupFloats / kBoxGroup) * static_cast<std::size_t>(row);
    }
};

/// Lists the igrids of a leaf for a range of pairs.
struct TreeLeaf {
    /// An entry is smaller than a cache line and holds all bounds that are tested before the igrid is read.
    struct Entry {
        IGrid* grid = nullptr;  ///< null until a ray enters the item's box; published
        GridBounds bounds;      ///< bounds of the igrid, written before it is published
        ItemIndex item = 0;
        std::uint32_t visible_in = lod::PosedCage::kAllSegments;  ///< as Items::visible_segments
    };
    PairRange pairs{1, 0};  ///< the pairs for which it holds; empty while nothing is known
    std::span<Entry> entries;
    /// Boxes of the entries' items, in groups of eight. In a tree of one worker the box of an igrid replaces that of its
    /// item.
    float* boxes = nullptr;
    KeySpan keys{};  ///< if the boxes move, all groups of the first key come first, then those of the next one

    /// Returns the number of floats from one key to the next.
    std::size_t stride() const noexcept { return keys.stride(entries.size()); }
};

}  // namespace occam::accel
