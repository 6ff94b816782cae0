// Bounds of a cage's clusters however skins and morph targets deform it.
//
// Space    boxes as DeformBounds.   Memory  28 bytes for each joint of a cluster, 24 for each morph target.   Threads const.
#pragma once

#include "lod/clusters.h"
#include "scenegraph/deform_bounds.h"

namespace occam::lod {

class DeformedClusters {
public:
    DeformedClusters(const Cage& cage, const ClusterTree& clusters);

    /// Of all control points of the cluster's faces.
    DeformBounds operator[](std::uint32_t cluster) const noexcept { return table_[table_.size() - 1 - cluster]; }

private:
    DeformBoundsTable table_;  ///< from the last cluster to the first: children come before their parents
};

}  // namespace occam::lod
