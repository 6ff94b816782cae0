// Visits what a scene shows without visiting every placement: instances of instances are soon more than can be counted.
//
// Threads  any number, while nothing edits the scene. The function throws Cancelled if the thread is asked to stop.
#pragma once

#include <cstdint>
#include <vector>

#include "base/cancellation.h"
#include "scenegraph/child_boxes.h"
#include "scenegraph/scene.h"

namespace occam {

/// Calls visit(NodeId, const Node&) once for every node that has a placement that Scene::for_each_placement visits. With
/// `kinds`, subtrees that hold none of these kinds of Contents are left out; the scene must then be refitted.
template <class Visit>
void for_each_shown_node(const Scene& scene, std::uint8_t kinds, Visit&& visit)
{
    std::vector<bool> is_known;
    std::vector<NodeId> todo;
    std::vector<std::uint32_t> found;
    const auto add = [&](NodeId id, bool is_instance) {
        const Node* node = scene.find(id);
        if (!node || !(is_instance || node->is_visible_in_shutter())) return;
        if (kinds != 0 && !node->contents.has(kinds)) return;
        if (id.slot >= is_known.size()) is_known.resize(std::size_t(id.slot) * 2 + 1);
        if (!is_known[id.slot]) todo.push_back(id);
        is_known[id.slot] = true;
    };
    add(scene.root(), false);
    while (!todo.empty()) {
        throw_if_cancelled();
        const NodeId id = todo.back();
        todo.pop_back();
        const Node& node = scene.node(id);
        visit(id, node);
        const ChildBoxes* boxes = kinds != 0 ? scene.child_boxes(id) : nullptr;
        if (boxes) {
            found.clear();
            boxes->find(kinds, found);
            for (const std::uint32_t child : found) add(node.children[child], false);
        } else {
            for (const NodeId child : node.children) add(child, false);
        }
        add(node.instance_of, true);
    }
}

}  // namespace occam
