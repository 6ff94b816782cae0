// Finds the faces of a cage whose surfaces OpenSubdiv cannot make, or not without memory that is not its own.
//
// This header is private to lod/.
#pragma once

#include <opensubdiv/far/topologyLevel.h>

namespace occam::lod {

/// Returns whether the surface of a face of a Catmull-Clark cage has to be taken from the cage refined once. OpenSubdiv 3.5
/// overwrites memory, or reads what it never wrote, in two cases (Bfr::IrregularPatchBuilder, Far::SourcePatch):
///
/// - There are more sharp edges around the face than it has room for.
/// - Two faces close around a corner of the face, and another corner lies at a border. A border is an edge that does not
///   have exactly two faces of one orientation, or a seam of texture coordinates if there are creases. After one refinement,
///   no face has two such corners.
///
/// has_creases   whether the cage has any
bool is_unsafe(const OpenSubdiv::Far::TopologyLevel& level, int face, bool has_creases);

/// Returns whether a face is the base of a tetrahedron or a pyramid that has another face at one of its other edges. In the
/// fan of three triangles around one corner of the base, and of that alone, this edge is a border at both ends. OpenSubdiv
/// 3.5 finds the ends in one place and joins them, as if there were no border (Bfr::IrregularPatchBuilder).
bool joins_border(const OpenSubdiv::Far::TopologyLevel& level, int face);

/// Returns whether two faces close around some vertex: they share both of their edges there, with no other face. The vertex
/// may belong to other faces, too.
bool has_pairs(const OpenSubdiv::Far::TopologyLevel& level);

}  // namespace occam::lod
