// The connectivity of a cage, kept by OpenSubdiv. Only lod/ and the benchmark of dicing include this header.
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

/// Returns the cage's connectivity as OpenSubdiv keeps it, not refined. Vertices for which OpenSubdiv would have several
/// limits are infinitely sharp corners there (lod/fan_limits.h).
std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> make_refiner(const Cage& cage);

/// Returns OpenSubdiv's name of a rule for texture coordinates.
OpenSubdiv::Sdc::Options::FVarLinearInterpolation linear_interpolation(FaceVaryingRule rule) noexcept;

/// Refines it once, with the connectivity of the finer level.
void refine_once(OpenSubdiv::Far::TopologyRefiner& refiner);

/// Returns a source of limit surfaces of that connectivity, which it borrows.
/// keeps   surfaces that are connected alike share their tables, which the factory keeps as long as it lives
std::unique_ptr<const SurfaceFactory> make_factory(const OpenSubdiv::Far::TopologyRefiner& refiner, bool keeps = true);

class ClassMemory;
class DerivedPoints;

struct Topology::Mesh {
    Mesh(const Cage& cage, ClassMemory& memory);
    ~Mesh();

    const OpenSubdiv::Far::TopologyLevel& level() const { return refiner->GetLevel(0); }

    bool bilinear;
    BoundaryRule boundary;
    bool shares_tables;  ///< whether surfaces that are connected alike do
    std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> refiner;
    std::unique_ptr<const SurfaceFactory> factory;
    std::unique_ptr<const SurfaceFactory> creased_factory;  ///< keeps nothing, so that tables are freed with their surface
    std::vector<std::uint32_t> vertex_owner;                ///< owning face of each vertex: the lowest with a limit surface
    /// The vertex's corner in that face; 0xff means that it has to be searched, in a face of more corners.
    std::vector<std::uint8_t> vertex_corner;
    std::vector<std::uint32_t> edge_owner;
    std::unique_ptr<const DerivedPoints> derived;  ///< null unless some face or vertex is large
};

/// Describes what Bfr sees around a patch, as words: equal keys have equal limit stencils, control point by control point.
///
/// For each corner of the face the key holds sharpness, border, and the faces around it in order. Each of these has its
/// size, its vertices, numbered in the order in which they first occur, and the sharpness of its edges at the corner.
struct Neighbourhood {
    std::vector<std::uint32_t> key;
    std::vector<std::uint32_t> controls;  ///< vertex (or UV value) of each number
    int crease_depth = 0;                 ///< as PatchClass has it
};
Neighbourhood neighbourhood(const OpenSubdiv::Far::TopologyLevel& level, PatchRef patch, bool bilinear, int uv_set);

/// Returns a key that is the same for faces whose surfaces share their tables in a factory that keeps them: it does not
/// depend on the corner at which polygons around them begin.
std::vector<std::uint32_t> tables_key(const OpenSubdiv::Far::TopologyLevel& level, std::uint32_t face, bool bilinear,
                                      int uv_set);

/// Returns about how many bytes OpenSubdiv takes for the connectivity of a level.
std::size_t bytes_of(const OpenSubdiv::Far::TopologyLevel& level) noexcept;

/// Returns about how many bytes a surface takes: of an irregular one, OpenSubdiv keeps the weights of all control points for
/// each point of its refined patches.
std::size_t bytes_of(const OpenSubdiv::Bfr::Surface<double>& surface) noexcept;

}  // namespace occam::lod
