#include "io/import/gltf_far_nodes.h"

#include <unordered_map>
#include <unordered_set>

#include "scenegraph/far_places.h"

namespace occam::import {

namespace {

// Holds what is shown, by whether it lies beyond the largest coordinate. Skinned meshes are placed by their joints, whose
// matrices do not count here.
struct Placements {
    explicit Placements(const Scene& scene)
    {
        scene.for_each_placement([&](NodeId id, const Node& node, const Mat4d& world_from_node) {
            Box3d box;
            if (!node.skin)
                for (const CageId cage : node.cages) box.add(transform_box(world_from_node, scene.cage(cage).bounds));
            const FarPlaces::Place place = places.add(box);
            const bool has_other_use = node.skin || node.light || node.camera;
            if (has_other_use || place == FarPlaces::Place::Near) needed.push_back(id);
            if (place == FarPlaces::Place::Far || place == FarPlaces::Place::Lost) far.push_back(id);
        });
    }
    bool vanish() const { return places.hide_near() || (places.has_lost() && places.has_near()); }

    std::vector<NodeId> far, needed;
    FarPlaces places;
};

}  // namespace

void leave_out_far_nodes(Scene& scene, const std::vector<NodeId>& nodes, Report& report)
{
    const Placements placements(scene);
    if (!placements.vanish()) return;
    std::unordered_map<NodeId, std::size_t> index_of;
    for (std::size_t n = 0; n < nodes.size(); ++n) index_of.emplace(nodes[n], n);
    std::unordered_set<NodeId> needed;  // with what is above them
    for (NodeId id : placements.needed)
        for (; scene.find(id) && needed.insert(id).second;) id = scene.node(id).parent;
    for (const NodeId id : placements.far) {
        const auto known = index_of.contains(id) ? index_of.find(id) : index_of.find(scene.node(id).parent);
        const std::string where = known == index_of.end() ? std::string() : "nodes[" + std::to_string(known->second) + "]";
        if (needed.contains(id)) {
            report.warn("the scene vanishes beside a node that reaches beyond 1e16", where);
            continue;
        }
        report.warn("a node is left out that reaches beyond 1e16: the rest of the scene would vanish beside it", where);
        scene.set_visible(id, false);
    }
}

}  // namespace occam::import
