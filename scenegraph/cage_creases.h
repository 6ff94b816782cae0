// Removes creases that OpenSubdiv cannot handle.
#pragma once

#include "scenegraph/cage.h"

namespace occam {

/// Drops the creases at the vertices of some faces, which make OpenSubdiv 3.5 overwrite its own sharp edges and read memory
/// that it never wrote (Bfr::IrregularPatchBuilder). Such a face has a vertex that it shares with only one other face, and
/// it also touches a border (of the surface, or a seam of texture coordinates). Expects indices in range. Returns the number
/// of dropped creases; those on a border edge do not count, because a border is sharp anyway.
std::size_t drop_crowded_creases(Cage& cage);

/// Drops the creases at vertices that two faces share and nothing else touches, unless both edges there are infinitely
/// sharp. OpenSubdiv 3.5 loses semi-sharp creases there (Bfr::SurfaceFactory), and writes past the end of its arrays where
/// one of the two edges becomes smooth before the other (Far::SourcePatch). Expects indices in range. Returns the number of
/// dropped creases.
std::size_t drop_creases_of_two_faces(Cage& cage);

}  // namespace occam
