// Bounds of a cage's clusters under any deformation by skins and morph targets.
//
// Space    boxes as in DeformBounds.
// Memory   28 bytes for each joint of a cluster, and 24 for each morph target.
// Threads  const once it is made.
#pragma once

#include "lod/clusters.h"
#include "scenegraph/deform_bounds.h"

namespace occam::lod {

class DeformedClusters {
public:
    DeformedClusters(const Cage& cage, const ClusterTree& clusters);

    /// Returns the bounds of all control points of the cluster's faces.
    DeformBounds operator[](std::uint32_t cluster) const noexcept { return table_[table_.size() - 1 - cluster]; }

private:
    DeformBoundsTable table_;  ///< from the last cluster to the first, because children come before their parents
};

}  // namespace occam::lod
