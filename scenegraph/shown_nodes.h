// Visits what a scene shows without visiting every placement: instances of instances are soon more than can be counted.
//
// Threads  any number, while nothing edits the scene. The functions throw Cancelled if the thread is asked to stop.
#pragma once

#include <cstdint>
#include <unordered_set>
#include <vector>

#include "base/cancellation.h"
#include "scenegraph/child_boxes.h"
#include "scenegraph/scene.h"

namespace occam {

/// Tells which nodes may hold what, by the contents of a scene that is refitted; else any node may hold anything.
class Holders {
public:
    explicit Holders(const Scene& scene) : scene_(scene), is_summed_(!scene.node(scene.root()).dirty) {}

    bool may_hold(const Node& node, Contents::Kinds kinds) const noexcept { return !is_summed_ || node.contents.has(kinds); }
    /// Calls visit(NodeId) for children of a node in their order, among them all that may hold one of these kinds of
    /// Contents; 0: for all children. Handles of children that were removed are null.
    template <class Visit>
    void for_each_child(NodeId id, Contents::Kinds kinds, Visit&& visit) const
    {
        const Node& node = scene_.node(id);
        const ChildBoxes* boxes = is_summed_ && kinds != 0 ? scene_.child_boxes(id) : nullptr;
        std::vector<std::uint32_t> found;
        if (boxes) boxes->find(kinds, found);
        for (const std::uint32_t child : found) visit(node.children[child]);
        if (!boxes)
            for (const NodeId child : node.children) visit(child);
    }

private:
    const Scene& scene_;
    bool is_summed_;
};

/// Calls visit(NodeId, const Node&) once for every node that has a placement that Scene::for_each_placement visits. With
/// `kinds`, subtrees that hold none of these kinds of Contents are left out, if the scene is refitted.
template <class Visit>
void for_each_shown_node(const Scene& scene, Contents::Kinds kinds, Visit&& visit)
{
    std::vector<bool> is_known;
    std::vector<NodeId> todo;
    const Holders holders(scene);
    const auto add = [&](NodeId id, bool is_instance) {
        const Node* node = scene.find(id);
        if (!node || !(is_instance || node->is_visible_in_shutter())) return;
        if (kinds != 0 && !holders.may_hold(*node, kinds)) return;
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
        holders.for_each_child(id, kinds, [&](NodeId child) { add(child, false); });
        add(node.instance_of, true);
    }
}

/// Calls visit(NodeId) for what a node shows itself: its children that are visible, and what it is an instance of.
template <class Visit>
void for_each_shown_below(const Scene& scene, const Node& node, Visit&& visit)
{
    for (const NodeId id : node.children)
        if (const Node* child = scene.find(id); child && child->is_visible_in_shutter()) visit(id);
    if (scene.find(node.instance_of)) visit(node.instance_of);
}

/// Calls visit(NodeId, const Node&) once for every node that has a placement, after all that the node shows. What is summed
/// up so counts instances of instances, which may be more than can be visited.
template <class Visit>
void for_each_shown_node_bottom_up(const Scene& scene, Visit&& visit)
{
    struct Step {
        NodeId id;
        bool is_below_done;
    };
    std::vector<Step> todo;
    std::unordered_set<NodeId> known;
    if (scene.node(scene.root()).is_visible_in_shutter()) todo.push_back({scene.root(), false});
    while (!todo.empty()) {
        throw_if_cancelled();
        const Step step = todo.back();
        todo.pop_back();
        const Node& node = scene.node(step.id);
        if (step.is_below_done) {
            visit(step.id, node);
        } else if (known.insert(step.id).second) {
            todo.push_back({step.id, true});
            for_each_shown_below(scene, node, [&](NodeId id) { todo.push_back({id, false}); });
        }
    }
}

}  // namespace occam
