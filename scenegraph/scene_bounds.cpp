// Which bounds an edit puts out of date, and how they are brought up to date.
#include <unordered_set>

#include "scenegraph/scene_state.h"

namespace occam {

void Scene::State::mark_dirty(NodeId id)
{
    std::vector<NodeId> todo{id};
    while (!todo.empty()) {
        NodeRecord* node = nodes.find(todo.back());
        todo.pop_back();
        for (; node && !node->dirty; node = nodes.find(node->parent)) {
            node->dirty = true;
            for (NodeId instance : node->instances.ids()) todo.push_back(instance);
        }
    }
}

void Scene::State::mark_users_dirty(const CageRecord& cage)
{
    for (NodeId user : cage.users.ids()) mark_dirty(user);
}

bool Scene::State::is_shown_by(NodeId below, NodeId above) const
{
    std::vector<NodeId> todo{below};
    std::unordered_set<NodeId> seen;
    while (!todo.empty()) {
        NodeId id = todo.back();
        todo.pop_back();
        for (const NodeRecord* node = nodes.find(id); node; id = node->parent, node = nodes.find(id)) {
            if (id == above) return true;
            if (!seen.insert(id).second) break;
            for (NodeId instance : node->instances.ids()) todo.push_back(instance);
        }
    }
    return false;
}

void Scene::State::refit_node(NodeRecord& node) const
{
    Box3d bounds;
    for (CageId id : node.cages)
        if (const CageRecord* cage = cages.find(id)) bounds.add(cage->bounds);
    for (NodeId id : node.children)
        if (const Node* child = nodes.find(id); child && child->visible)
            bounds.add(transform_box(child->parent_from_node, child->bounds));
    if (const Node* target = nodes.find(node.instance_of)) bounds.add(target->bounds);
    node.bounds = bounds;
    node.dirty = false;
}

// Depth first without recursion, since a stranger's tree may be deep. add_node() keeps the graph free of cycles; a node
// that is reached twice is clean the second time.
void Scene::refit()
{
    struct Step {
        NodeId id;
        bool children_are_done;
    };
    State& s = *state_;
    std::vector<Step> todo{{s.root, false}};
    while (!todo.empty()) {
        const Step step = todo.back();
        todo.pop_back();
        State::NodeRecord* node = s.nodes.find(step.id);
        if (!node || !node->dirty) continue;
        if (step.children_are_done) {
            s.refit_node(*node);
            continue;
        }
        todo.push_back({step.id, true});
        for (NodeId child : node->children) todo.push_back({child, false});
        if (node->instance_of) todo.push_back({node->instance_of, false});
    }
}

Box3d Scene::bounds()
{
    refit();
    const Node& top = node(root());
    return top.visible ? transform_box(top.parent_from_node, top.bounds) : Box3d();
}

}  // namespace occam
