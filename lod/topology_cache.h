// Keeps the topology and the cluster tree of each cage of a scene from frame to frame.
//
// Cages that are connected alike share a topology, wherever their vertices are, so that the matrices of a crowd stay in the
// processor's caches.
//
// Threads  any worker may call get(): the first caller for a cage builds, and others wait for that cage only.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "lod/cage_curvature.h"
#include "lod/clusters.h"
#include "lod/deformed_clusters.h"
#include "lod/topology.h"
#include "scenegraph/scene.h"

namespace occam::lod {

struct CageTables {
    std::unique_ptr<const CageSlot> made;      ///< the polygons of a cage on demand; null for others
    std::shared_ptr<const Topology> topology;  ///< null for Scheme::Triangles
    std::unique_ptr<ClusterTree> clusters;
    std::unique_ptr<DeformedClusters> deformed_clusters;  ///< null if no skin and no morph target deforms the cage
    CageCurvature curvature;
};

class TopologyCache {
public:
    TopologyCache();
    ~TopologyCache();

    /// Returns the cage's tables, and makes them if they are new or its positions have changed. Throws what CageSlot::made()
    /// throws.
    const CageTables& get(const CageSlot& slot);
    /// Returns what was repaired in the scene's cages on demand that are made by now, in the order in which they were added.
    /// The scene must be one of those for which prune() keeps tables.
    std::vector<std::string> repairs(const Scene& scene) const;
    /// Returns the bytes of the tables of all patch classes (class_memory.h).
    std::size_t class_bytes() const noexcept;
    /// Forgets cages that none of the scenes has. Workers may call get() for cages of these scenes meanwhile.
    void prune(std::span<const Scene* const> scenes);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace occam::lod
