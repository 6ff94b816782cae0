// The way from the root of the scene graph to what is placed there. It orders surfaces that lie in one place, whatever was
// added to the scene and removed from it before.
#pragma once

#include <compare>
#include <cstdint>

#include "base/hash.h"

namespace occam::lod {

struct GraphPath {
    const GraphPath* above = nullptr;  ///< null for the root
    std::uint64_t place = 0;           ///< its order among all that lies directly below `above`
    std::uint32_t depth = 0;
    std::uint32_t hash = 0;  ///< of all places on the way; those of removed siblings count, so it is for colours of views

    /// What lies directly below a node comes in this order: its cages, its children, and what it shows by instance_of.
    static std::uint64_t place_of_cage(std::size_t index) noexcept { return index; }
    static std::uint64_t place_of_child(std::uint32_t among_siblings) noexcept
    {
        return (std::uint64_t(1) << 32) + among_siblings;
    }
    static constexpr std::uint64_t kPlaceOfInstance = ~std::uint64_t(0);

    /// Returns a path that is one step longer. This one has to outlive it.
    GraphPath to(std::uint64_t next) const noexcept
    {
        return {this, next, depth + 1, static_cast<std::uint32_t>(mix_bits(hash ^ mix_bits(next)))};
    }
};

/// Compares paths step by step from the root. Paths in different trees over one scene may be equal.
inline std::strong_ordering operator<=>(const GraphPath& a, const GraphPath& b) noexcept
{
    const GraphPath *x = &a, *y = &b;
    while (x->depth > y->depth) x = x->above;
    while (y->depth > x->depth) y = y->above;
    std::strong_ordering order = a.depth <=> b.depth;
    for (; x != y; x = x->above, y = y->above)
        if (x->place != y->place) order = x->place <=> y->place;  // the step nearest to the root counts
    return order;
}

}  // namespace occam::lod
