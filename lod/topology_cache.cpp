#include "lod/topology_cache.h"

#include <mutex>
#include <unordered_map>
#include <unordered_set>

namespace occam::lod {

struct TopologyCache::State {
    struct Entry {
        std::mutex mutex;
        std::uint64_t positions_version = 0;
        CageTables tables;
    };
    std::mutex mutex;
    std::unordered_map<std::uint64_t, std::unique_ptr<Entry>> entries;
};

TopologyCache::TopologyCache() : state_(std::make_unique<State>()) {}
TopologyCache::~TopologyCache() = default;

const CageTables& TopologyCache::get(const CageSlot& asked)
{
    State::Entry* entry;
    {
        const std::lock_guard lock(state_->mutex);
        auto& found = state_->entries[asked.identity];
        if (!found) found = std::make_unique<State::Entry>();
        entry = found.get();
    }
    const std::lock_guard lock(entry->mutex);
    CageTables& tables = entry->tables;
    if (asked.is_on_demand() && !tables.made) tables.made = std::make_unique<const CageSlot>(asked.made());
    const CageSlot& slot = tables.made ? *tables.made : asked;
    if (!tables.clusters) {
        if (slot.cage.scheme != Scheme::Triangles) tables.topology = std::make_unique<const Topology>(slot.cage);
        tables.clusters = std::make_unique<ClusterTree>(slot.cage);
    } else if (entry->positions_version != slot.positions_version) {
        tables.clusters->refit(slot.cage);
        tables.deformed_clusters.reset();
    }
    if (slot.is_deformed() && !tables.deformed_clusters)
        tables.deformed_clusters = std::make_unique<DeformedClusters>(slot.cage, *tables.clusters);
    entry->positions_version = slot.positions_version;
    return tables;
}

void TopologyCache::prune(const Scene& scene)
{
    const std::vector<std::uint64_t> identities = scene.cage_identities();
    const std::unordered_set<std::uint64_t> alive(identities.begin(), identities.end());
    const std::lock_guard lock(state_->mutex);
    std::erase_if(state_->entries, [&](const auto& entry) { return !alive.contains(entry.first); });
}

}  // namespace occam::lod
