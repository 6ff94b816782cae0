// A whole cage diced at one level: every micropolygon and closer of every patch, for tests that look at M_l as a mesh.
#pragma once

#include <vector>

#include "lod/dicer.h"
#include "lod/topology_cache.h"
#include "scenegraph/scene.h"

namespace occam::test {

struct MeshTriangle {
    Vec3f v[3];  ///< dicing frame
    bool is_closer = false;
};

/// Owns what a PosedCage borrows.
class DicedCage {
public:
    DicedCage(const Cage& cage, int level, const Mat4d& world_from_object = Mat4d(1));

    lod::PosedCage posed;
    lod::Dicer dicer;
    Arena arena;

    const lod::Topology& topology() const { return *posed.topology; }
    /// Every patch that is seen, as tiles of at most 16 x 16 quads.
    std::vector<lod::TileRef> tiles();
    std::vector<MeshTriangle> triangles();
    /// Sets and returns the coarsest level at which some patch has 2^exponent pieces along a side.
    int level_of_largest_exponent(int exponent);

private:
    Scene scene_;
    lod::TopologyCache cache_;
};

}  // namespace occam::test
