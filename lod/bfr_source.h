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
/// uv_set   the texture coordinates that are meant; -1: the positions
std::unique_ptr<const LimitSource> limit_source(const SurfaceFactory& factory, PatchRef patch,
                                                std::span<const std::uint32_t> controls, int uv_set);

}  // namespace occam::lod
