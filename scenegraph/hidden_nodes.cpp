#include "scenegraph/hidden_nodes.h"

#include <unordered_map>
#include <vector>

#include "base/cancellation.h"
#include "scenegraph/child_boxes.h"

namespace occam {

std::unordered_set<NodeId> nodes_hidden_from(const Scene& scene, std::uint8_t rays, std::uint8_t kinds)
{
    struct Step {
        NodeId id;
        std::uint8_t seen_by;
    };
    std::vector<Step> todo;
    std::unordered_map<NodeId, std::uint8_t> seen_by;  // in all placements that were found
    const bool is_summed = !scene.node(scene.root()).dirty;
    const auto add = [&](NodeId id, std::uint8_t above, bool is_instance) {
        const Node* node = scene.find(id);
        if (!node || !(is_instance || node->is_visible_in_shutter())) return;
        if (is_summed && !node->contents.has(kinds)) return;
        const auto in_placement = static_cast<std::uint8_t>(above & node->seen_by);
        const auto [known, is_new] = seen_by.try_emplace(id, in_placement);
        if (!is_new && (known->second & in_placement) == known->second) return;  // nothing new for what is below it
        known->second &= in_placement;
        todo.push_back({id, known->second});
    };
    add(scene.root(), RayKind::All, false);
    std::vector<std::uint32_t> found;
    while (!todo.empty()) {
        throw_if_cancelled();
        const Step step = todo.back();
        todo.pop_back();
        const Node& node = scene.node(step.id);
        if (const ChildBoxes* boxes = is_summed ? scene.child_boxes(step.id) : nullptr) {
            found.clear();
            boxes->find(kinds, found);
            for (const std::uint32_t child : found) add(node.children[child], step.seen_by, false);
        } else {
            for (const NodeId child : node.children) add(child, step.seen_by, false);
        }
        add(node.instance_of, step.seen_by, true);
    }
    std::unordered_set<NodeId> hidden;
    for (const auto& [id, kinds_of_rays] : seen_by)
        if ((kinds_of_rays & rays) != rays) hidden.insert(id);
    return hidden;
}

}  // namespace occam
