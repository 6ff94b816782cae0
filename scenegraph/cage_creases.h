// Creases that OpenSubdiv cannot take.
#pragma once

#include "scenegraph/cage.h"

namespace occam {

/// Where a face has a vertex that only it and one other face meet, and also touches a border (of the surface, or a seam of
/// texture coordinates), OpenSubdiv 3.5 writes its sharp edges over each other and reads what it never wrote
/// (Bfr::IrregularPatchBuilder). Creases at the vertices of such a face are dropped. Expects indices in range.
/// Returns how many; those on a border edge do not count: it is sharp anyway.
std::size_t drop_crowded_creases(Cage& cage);

}  // namespace occam
