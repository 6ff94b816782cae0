// A place in a table over [0, 1] whose nodes are evenly spaced.
//
// Space    none.
// Threads  any.
#pragma once

#include <algorithm>

namespace occam::shade {

/// Lies between two neighbouring nodes of a table.
struct TablePlace {
    int below = 0;
    float share = 0;  ///< weight of the node above
};

/// Returns the place of x among the nodes, of which there are two or more. What lies outside of [0, 1] counts as its nearer
/// end, and what is not a number counts as 0.
inline TablePlace table_place(float x, int nodes) noexcept
{
    const float at = (x > 0 ? std::min(x, 1.0f) : 0.0f) * static_cast<float>(nodes - 1);
    const int below = std::min(static_cast<int>(at), nodes - 2);
    return {below, at - static_cast<float>(below)};
}

}  // namespace occam::shade
