// What lives from frame to frame for each cage of a scene: its topology and its cluster tree.
//
// Cages that are connected alike share a topology, wherever their vertices are: a crowd's matrices stay in the processor's
// caches.
//
// Threads  get() from any worker: the first to ask builds, others wait for that cage only. prune() and refit() between
// frames.
#pragma once

#include <memory>

#include "lod/clusters.h"
#include "lod/deformed_clusters.h"
#include "lod/topology.h"
#include "scenegraph/scene.h"

namespace occam::lod {

struct CageTables {
    std::unique_ptr<const CageSlot> made;      ///< of a cage on demand: its polygons; null for others
    std::shared_ptr<const Topology> topology;  ///< null for Scheme::Triangles
    std::unique_ptr<ClusterTree> clusters;
    std::unique_ptr<DeformedClusters> deformed_clusters;  ///< null if no skin and no morph target deforms the cage
};

class TopologyCache {
public:
    TopologyCache();
    ~TopologyCache();

    /// Tables of the cage, made now if they are new or its positions changed since. Throws what CageSlot::made() throws.
    const CageTables& get(const CageSlot& slot);
    /// Forgets cages that the scene no longer has. Between frames.
    void prune(const Scene& scene);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace occam::lod
