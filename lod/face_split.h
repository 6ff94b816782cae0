// Triangles are parted in two by the surface area heuristic, over and over: for trees over meshes.
//
// Planes are tried at the ends of bins along all three axes (Wald 2007). A few triangles that are large beside the whole,
// as walls are beside props, are parted from the others first: no box of small triangles is then as large as a wall.
//
// Threads  const functions of their arguments; they move faces within the span.
#pragma once

#include <cstdint>
#include <span>

#include "base/box.h"

namespace occam::lod {

/// A triangle's box and its number.
struct BoxedFace {
    Box3f box;
    std::uint32_t face = 0;
};

/// Triangles that are tested at once: the cost of a part is counted in blocks of so many.
inline constexpr std::size_t kFacesOfABlock = 8;

struct FaceSplit {
    std::size_t count = 0;  ///< faces of the first part, which come first now
    bool pays = false;      ///< whether rays meet fewer blocks than without the split
};

/// Parts two or more faces. Neither part has more than `most` faces, which is at least half of them, nor none.
FaceSplit split_faces(std::span<BoxedFace> faces, std::size_t most) noexcept;

}  // namespace occam::lod
