// Finds the vertices of a cage for which OpenSubdiv has several limits.
//
// A vertex on two edges of more than two faces each, and on no border, lies between several fans of faces. Subdivision
// smooths it along these two edges, whatever the faces around it are, while Bfr knows the fan of one face only. Both agree
// if each fan runs from one of the two edges to the other. They do not if a fan ends at the edge at which it begins, or goes
// around the vertex without touching these edges; or if semi-sharp creases of different fans become smooth in the same step,
// of whose sharpness subdivision takes the mean.
//
// This header is private to lod/.
#pragma once

#include <opensubdiv/far/topologyLevel.h>

#include <vector>

namespace occam::lod {

/// Returns the vertices of a Catmull-Clark cage that have no limit in common for all of their faces, unless they are made
/// infinitely sharp corners. There are none in most cages.
std::vector<int> vertices_without_one_limit(const OpenSubdiv::Far::TopologyLevel& level);

}  // namespace occam::lod
