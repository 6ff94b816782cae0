// Builds igrids of faces of a triangle mesh.
//
// Memory   scratch is reused from igrid to igrid; the results lie in the given arena.
// Threads  one at a time.
#pragma once

#include <vector>

#include "accel/igrid.h"

namespace occam::accel {

class MeshBuilder {
public:
    /// splits_in_space   whether triangles may be cut (accel/spatial_split.h)
    explicit MeshBuilder(bool splits_in_space) { trees_.splits_in_space = splits_in_space; }

    /// material   the material of all these faces, or null if they have several
    MeshGrid* build(const GridSubject& of, std::span<const std::uint32_t> faces, const Material* material, Arena& arena);

    std::uint64_t micropolygons = 0;  ///< in all igrids so far

private:
    /// Poses the faces' corners, at each key.
    void set_corners(const lod::PosedCage& cage, std::span<const std::uint32_t> faces);
    std::vector<Vec3f> corners_;  ///< three per face, at each key, one after the other
    TriangleTreeBuilder trees_;
};

}  // namespace occam::accel
