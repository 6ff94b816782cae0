// Limit stencils of a patch, by OpenSubdiv's Bfr.
//
// Threads  any, on the surfaces of one factory.
// This header is private to lod/.
#pragma once

#include <memory>
#include <span>

#include "lod/topology_mesh.h"

namespace occam::lod {

/// Evaluates a surface at (s, t) of its face; the weights are those of its control points, in its own order.
void evaluate(const OpenSubdiv::Bfr::Surface<double>& surface, double s, double t, LimitSource::Of of, LimitStencil& out);

/// Returns the stencils of one patch, with its control points renumbered as in `controls`.
/// uv_set    the texture coordinates that are meant; -1: the positions
/// account   if not null, it is told what the source takes beside a corner, when that is made, and outlives the source;
///           LimitSource::bytes() then leaves this out
std::unique_ptr<const LimitSource> limit_source(const SurfaceFactory& factory, PatchRef patch,
                                                std::span<const std::uint32_t> controls, int uv_set,
                                                ClassAccount* account = nullptr);

}  // namespace occam::lod
