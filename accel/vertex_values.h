// Phase one at the vertices of igrids, and its values at a hit (Djeu et al. 2011, sec. 5.3; who makes them:
// lod/vertex_shader.h).
//
// A level's values lie on a lattice of their own: every 2^kCoarser-th vertex of M_l along either side (Burns et al. 2010
// shade coarser than they dice), and the corners of patches that have fewer. It is a function of (patch, level), as M_l is;
// so what a ray sees fully coarse in one pair is what it sees fully fine in the next. At a hit both levels' values, bilinear
// in the patch's parameter, are mixed by the hit's own blend: that of its vertices, interpolated.
//
// Memory   the worker's arena, for each level of a tile when a hit first asks; flushed with its igrid.
#pragma once

#include "accel/hit.h"

namespace occam::accel {

inline constexpr int kCoarser = 1;

/// Sets hit.phase_one at a place of a lattice's part, in quads of its tile from the tile's corner; hit.blend and
/// hit.material are set. Nothing is made where the patch is a single quad: its vertices, which no other patch shares, would
/// be more than hits.
void add_vertex_values(IGrid& grid, std::uint32_t part, Vec2d at, const PhaseOneTools& tools, SurfaceHit& hit);

}  // namespace occam::accel
