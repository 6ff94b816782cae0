// Splits triangles into two parts by the surface area heuristic, again and again, for trees over meshes.
//
// Planes are tried at the borders of bins along all three axes (Wald 2007). A few triangles that are large compared with the
// whole, as walls are beside props, are first separated from the others, so that no box of small triangles is as large as a
// wall.
//
// Threads  const functions of their arguments; they move faces within the span.
#pragma once

#include <cstdint>
#include <span>

#include "base/box.h"

namespace occam::lod {

/// A triangle's box and its index. Its eight words are read at once.
struct alignas(32) BoxedFace {
    Box3f box;
    std::uint32_t face = 0;
    std::uint32_t unused = 0;  ///< so that copies are of two times sixteen bytes: parts that overlap wait for each other
};

/// The number of triangles that are tested at once. The cost of a part is counted in blocks of this size.
inline constexpr std::size_t kFacesOfABlock = 8;

struct FaceSplit {
    std::size_t count = 0;  ///< faces of the first part, which now come first
    bool pays = false;      ///< whether rays test fewer blocks than without the split
};

/// Splits two or more faces into two parts. Neither is empty or has more than `most` faces, which is at least half of them.
FaceSplit split_faces(std::span<BoxedFace> faces, std::size_t most) noexcept;

}  // namespace occam::lod
