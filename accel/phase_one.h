// Runs phase one of shading on the parts of igrids (Djeu et al. 2011, sec. 5.3).
#pragma once

#include "accel/build_lock.h"
#include "accel/frame_state.h"
#include "accel/igrid.h"
#include "accel/trace_counters.h"
#include "base/arena.h"
#include "lod/dicer.h"

namespace occam::accel {

/// The values that phase one makes for a level lie at every 2^kCoarser-th vertex of it (accel/vertex_values.h).
inline constexpr int kCoarser = 1;

/// Holds the inputs of phase one.
struct PhaseOneTools {
    const FrameState& frame;
    lod::Dicer& dicer;
    Arena& arena;
    TraceCounters& counters;
    Building* building;  ///< locked while phase one runs; null if no other thread uses these igrids
};

/// Returns the material of a face of a placed cage.
const Material* material_of(const Scene& scene, const lod::PosedCage& cage, std::uint32_t face) noexcept;
/// Returns the material of all these faces, of which there is at least one, or null if they have several.
const Material* common_material(const Scene& scene, const lod::PosedCage& cage,
                                std::span<const std::uint32_t> faces) noexcept;
/// Runs phase one on a part of an igrid, unless another thread has done so in the meantime.
void shade_part(const IGrid& grid, IGridPart& part, const PhaseOneTools& tools);
/// Runs phase one on all parts of an igrid that nothing has hit yet.
void shade_parts(LatticeGrid& grid, const PhaseOneTools& tools);

}  // namespace occam::accel
