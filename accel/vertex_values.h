// Evaluates phase one at the vertices of igrids, and its values at a hit (Djeu et al. 2011, sec. 5.3;
// lod/vertex_shader.h makes the values).
//
// The values of a level lie on a lattice of their own: every 2^kCoarser-th vertex of M_l along either side (Burns et
// al. 2010 shade coarser than they dice), and the corners of patches that have fewer. The lattice is a function of
// (patch, level), as M_l is; so what a ray sees fully coarse in one pair is what it sees fully fine in the next. At a
// hit, the values of both levels, bilinear in the patch's parameter, are mixed by the hit's own blend, which is the
// interpolated blend of its vertices.
//
// Memory   The arena of the tree, for each level of a tile when a hit first asks; flushed with its igrid.
#pragma once

#include "accel/phase_one.h"
#include "accel/surface_hit.h"

namespace occam::accel {

/// Sets hit.phase_one at a place of a lattice's part, in quads of its tile from the tile's corner; hit.blend and
/// hit.material must be set. Nothing is made where the patch is a single quad: its vertices, which no other patch
/// shares, would outnumber the hits.
void add_vertex_values(LatticeGrid& grid, std::uint32_t part, Vec2d at, const PhaseOneTools& tools, SurfaceHit& hit);

}  // namespace occam::accel
