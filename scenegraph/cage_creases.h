// Removes creases that are no edges, and those that OpenSubdiv cannot handle.
#pragma once

#include "scenegraph/cage.h"

namespace occam {

/// Drops the creases whose two vertices are not the ends of an edge. Expects indices in range. Returns their number.
std::size_t drop_creases_off_edges(Cage& cage);

/// Drops the creases at vertices around which two faces close, or that two faces share and nothing else touches, unless
/// both edges there are infinitely sharp. OpenSubdiv 3.5 loses semi-sharp creases there (Bfr::SurfaceFactory), and writes
/// past the end of its arrays where one of the two edges becomes smooth before the other (Far::SourcePatch). Expects
/// indices in range. Returns the number of dropped creases.
std::size_t drop_creases_of_two_faces(Cage& cage);

}  // namespace occam
