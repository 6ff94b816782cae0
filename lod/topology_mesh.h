// The connectivity of a cage, kept by OpenSubdiv: private to lod, and the only header of it that includes the library.
#pragma once

#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/bfr/surface.h>
#include <opensubdiv/bfr/surfaceFactoryCache.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

#include <shared_mutex>

#include "lod/topology.h"

namespace occam::lod {

using LockedCache = OpenSubdiv::Bfr::SurfaceFactoryCacheThreaded<std::shared_mutex, std::shared_lock<std::shared_mutex>,
                                                                 std::unique_lock<std::shared_mutex>>;
using SurfaceFactory = OpenSubdiv::Bfr::RefinerSurfaceFactory<LockedCache>;

/// The cage's connectivity as OpenSubdiv keeps it, not refined.
std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> make_refiner(const Cage& cage);

struct Topology::Mesh {
    explicit Mesh(const Cage& cage);

    const OpenSubdiv::Far::TopologyLevel& level() const { return refiner->GetLevel(0); }

    bool bilinear;
    std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> refiner;
    std::unique_ptr<const SurfaceFactory> factory;
    std::vector<std::uint32_t> vertex_owner;  ///< face of each vertex: the lowest with a limit surface
    std::vector<std::uint8_t> vertex_corner;  ///< and its corner there (0xff: of a face with more, search)
    std::vector<std::uint32_t> edge_owner;
};

/// What Bfr sees around a patch, as words: equal keys have equal limit stencils, control point by control point.
///
/// For each corner of the face: sharpness, border, and the faces around it in order, each with its size, its vertices as
/// numbers in the order of first meeting, and the sharpness of its edges at the corner.
struct Neighbourhood {
    std::vector<std::uint32_t> key;
    std::vector<std::uint32_t> controls;  ///< vertex (or UV value) of each number
    int crease_depth = 0;                 ///< as PatchClass has it
};
Neighbourhood neighbourhood(const OpenSubdiv::Far::TopologyLevel& level, PatchRef patch, bool bilinear, int uv_set);

/// The stencils of one patch by Bfr, its control points renumbered as in `controls`.
std::unique_ptr<const LimitSource> limit_source(const SurfaceFactory& factory, PatchRef patch,
                                                std::span<const std::uint32_t> controls, int uv_set);

}  // namespace occam::lod
