#include "lod/topology_cache.h"

#include <algorithm>
#include <bit>
#include <mutex>
#include <unordered_map>
#include <utility>

#include "base/hash.h"
#include "lod/class_memory.h"

namespace occam::lod {
namespace {

// Returns all that a Topology is made from, as words: equal words give an equal topology.
std::vector<std::uint32_t> connectivity_of(const Cage& cage)
{
    std::vector<std::uint32_t> words{std::uint32_t(cage.scheme), std::uint32_t(cage.boundary),
                                     std::uint32_t(cage.face_varying), static_cast<std::uint32_t>(cage.positions.size())};
    const auto add = [&](const std::vector<std::uint32_t>& list) {
        words.push_back(static_cast<std::uint32_t>(list.size()));
        words.insert(words.end(), list.begin(), list.end());
    };
    add(cage.face_sizes);
    add(cage.face_vertices);
    add(cage.holes);
    words.push_back(static_cast<std::uint32_t>(cage.creases.size()));
    for (const Crease& c : cage.creases) words.insert(words.end(), {c.v0, c.v1, std::bit_cast<std::uint32_t>(c.sharpness)});
    words.push_back(static_cast<std::uint32_t>(cage.corners.size()));
    for (const Corner& c : cage.corners) words.insert(words.end(), {c.vertex, std::bit_cast<std::uint32_t>(c.sharpness)});
    for (const UvSet& set : cage.uv_sets) {
        words.push_back(static_cast<std::uint32_t>(set.values.size()));
        add(set.indices);
    }
    return words;
}

}  // namespace

struct TopologyCache::State {
    struct Shared {
        std::mutex mutex;  // held while the topology is made
        std::shared_ptr<const Topology> topology;
    };
    /// Returns the topology of cages that are connected like this one; other callers wait for it.
    std::shared_ptr<const Topology> topology_of(const Cage& cage)
    {
        std::shared_ptr<Shared> shared;
        {
            std::vector<std::uint32_t> words = connectivity_of(cage);
            const std::lock_guard lock(mutex);
            auto& found = topologies[std::move(words)];
            if (!found) found = std::make_shared<Shared>();
            shared = found;
        }
        const std::lock_guard making(shared->mutex);
        if (!shared->topology) shared->topology = std::make_shared<const Topology>(cage, classes);
        return shared->topology;
    }

    struct Entry {
        explicit Entry(CageId id) : cage(id) {}
        const CageId cage;
        std::mutex mutex;
        std::uint64_t positions_version = 0;
        CageTables tables;
    };
    std::shared_ptr<ClassMemory> classes = std::make_shared<ClassMemory>();
    std::mutex mutex;
    std::unordered_map<std::uint64_t, std::unique_ptr<Entry>> entries;
    std::unordered_map<std::vector<std::uint32_t>, std::shared_ptr<Shared>, WordsHash> topologies;
};

TopologyCache::TopologyCache() : state_(std::make_unique<State>()) {}
TopologyCache::~TopologyCache() = default;

const CageTables& TopologyCache::get(const CageSlot& asked)
{
    State::Entry* entry;
    {
        const std::lock_guard lock(state_->mutex);
        auto found = state_->entries.find(asked.identity);
        if (found == state_->entries.end())
            found = state_->entries.emplace(asked.identity, std::make_unique<State::Entry>(asked.id)).first;
        entry = found->second.get();
    }
    const std::lock_guard lock(entry->mutex);
    CageTables& tables = entry->tables;
    if (asked.is_on_demand() && !tables.made) tables.made = std::make_unique<const CageSlot>(asked.made());
    const CageSlot& slot = tables.made ? *tables.made : asked;
    if (slot.cage.face_count() == 0) return tables;
    if (!tables.clusters) {
        if (slot.cage.scheme != Scheme::Triangles) tables.topology = state_->topology_of(slot.cage);
        tables.clusters = std::make_unique<ClusterTree>(slot.cage);
    } else if (entry->positions_version != slot.positions_version) {
        // Which patches of a cage share an igrid, and so how a ray sees them, may not depend on where its vertices were in
        // earlier frames. The triangles of a mesh are the same in any igrid.
        if (tables.topology) *tables.clusters = ClusterTree(slot.cage);
        else tables.clusters->refit(slot.cage);
        tables.deformed_clusters.reset();
        tables.curvature.forget();
    }
    if (slot.is_deformed() && !tables.deformed_clusters)
        tables.deformed_clusters = std::make_unique<DeformedClusters>(slot.cage, *tables.clusters);
    entry->positions_version = slot.positions_version;
    return tables;
}

std::vector<std::string> TopologyCache::repairs(const Scene& scene) const
{
    // get() takes the first lock while it holds that of an entry.
    std::vector<std::pair<std::uint64_t, State::Entry*>> of_scene;
    {
        const std::lock_guard lock(state_->mutex);
        for (const auto& [identity, entry] : state_->entries) {
            const CageSlot* slot = scene.find(entry->cage);
            if (slot && slot->identity == identity && slot->is_on_demand()) of_scene.emplace_back(identity, entry.get());
        }
    }
    std::sort(of_scene.begin(), of_scene.end());
    std::vector<std::string> lines;
    for (const auto& [identity, entry] : of_scene) {
        const std::lock_guard lock(entry->mutex);
        if (const CageSlot* made = entry->tables.made.get())
            lines.insert(lines.end(), made->repairs.begin(), made->repairs.end());
    }
    return lines;
}

std::size_t TopologyCache::class_bytes() const noexcept { return state_->classes->bytes(); }

void TopologyCache::prune(std::span<const Scene* const> scenes)
{
    const auto is_gone = [&](const auto& entry) {
        return std::none_of(scenes.begin(), scenes.end(), [&](const Scene* scene) {
            const CageSlot* slot = scene->find(entry.second->cage);
            return slot && slot->identity == entry.first;
        });
    };
    const std::lock_guard lock(state_->mutex);
    if (std::erase_if(state_->entries, is_gone) == 0) return;
    std::erase_if(state_->topologies, [](const auto& entry) {
        // One that is being made, or is about to be, has another owner.
        return entry.second.use_count() == 1 && entry.second->topology.use_count() <= 1;
    });
}

}  // namespace occam::lod
