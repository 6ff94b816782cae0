// The limit surface of a small mesh, by OpenSubdiv's Bfr.
//
// Memory   its connectivity, and what Bfr keeps of the surfaces that were asked for.
// Threads  const calls from any thread.
// This header is private to lod/.
#pragma once

#include <memory>

#include "base/check.h"
#include "lod/topology_mesh.h"

namespace occam::lod {

class SmallSurface {
public:
    explicit SmallSurface(const Cage& mesh) : refiner_(make_refiner(mesh)), factory_(make_factory(*refiner_)) {}

    const OpenSubdiv::Far::TopologyLevel& level() const { return refiner_->GetLevel(0); }
    OpenSubdiv::Bfr::Surface<double> surface(int face) const
    {
        OpenSubdiv::Bfr::Surface<double> surface;
        OCCAM_CHECK_EQ(factory_->InitVertexSurface(face, &surface), true);
        return surface;
    }
    /// Returns the surface of the texture coordinates, which the mesh must have.
    OpenSubdiv::Bfr::Surface<double> uv_surface(int face) const
    {
        OpenSubdiv::Bfr::Surface<double> surface;
        OCCAM_CHECK_EQ(factory_->InitFaceVaryingSurface(face, &surface, 0), true);
        return surface;
    }
    /// Returns about how many bytes the connectivity of the mesh takes.
    std::size_t bytes() const noexcept { return bytes_of(level()); }

private:
    std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> refiner_;
    std::unique_ptr<const SurfaceFactory> factory_;
};

}  // namespace occam::lod
