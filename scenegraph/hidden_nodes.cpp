#include "scenegraph/hidden_nodes.h"

#include <unordered_map>
#include <vector>

#include "scenegraph/shown_nodes.h"

namespace occam {

std::unordered_set<NodeId> nodes_hidden_from(const Scene& scene, std::uint8_t rays, Contents::Kinds kinds)
{
    struct Step {
        NodeId id;
        std::uint8_t seen_by;
    };
    std::vector<Step> todo;
    std::unordered_map<NodeId, std::uint8_t> seen_by;  // in all placements that were found
    const Holders holders(scene);
    const auto add = [&](NodeId id, std::uint8_t above, bool is_instance) {
        const Node* node = scene.find(id);
        if (!node || !(is_instance || node->is_visible_in_shutter())) return;
        if (!holders.may_hold(*node, kinds)) return;
        const auto in_placement = static_cast<std::uint8_t>(above & node->seen_by);
        const auto [known, is_new] = seen_by.try_emplace(id, in_placement);
        if (!is_new && (known->second & in_placement) == known->second) return;  // nothing new for what is below it
        known->second &= in_placement;
        todo.push_back({id, known->second});
    };
    add(scene.root(), RayKind::All, false);
    while (!todo.empty()) {
        throw_if_cancelled();
        const Step step = todo.back();
        todo.pop_back();
        holders.for_each_child(step.id, kinds, [&](NodeId child) { add(child, step.seen_by, false); });
        add(scene.node(step.id).instance_of, step.seen_by, true);
    }
    std::unordered_set<NodeId> hidden;
    for (const auto& [id, kinds_of_rays] : seen_by)
        if ((kinds_of_rays & rays) != rays) hidden.insert(id);
    return hidden;
}

}  // namespace occam
