// Changes where the nodes of a scene hang, and what they hold.
#include <utility>

#include "base/error_without_file.h"
#include "scenegraph/content_rules.h"
#include "scenegraph/reachability.h"
#include "scenegraph/scene_state.h"

namespace occam {

Error Scene::State::shows_itself(const std::string& name)
{
    return error_without_file("a node cannot show itself, as its own child or as an instance", naming("node", name));
}

bool Scene::State::is_shown_by(NodeId below, NodeId above) const
{
    const auto if_alive = [&](NodeId id) { return nodes.find(id) ? id : NodeId(); };
    const auto shown = [&](NodeId id, std::size_t i) -> std::optional<NodeId> {
        const NodeRecord& node = *nodes.find(id);
        if (i == 0) return if_alive(node.instance_of);
        if (i > node.children.size()) return std::nullopt;
        return node.children[i - 1];
    };
    const auto showing = [&](NodeId id, std::size_t i) -> std::optional<NodeId> {
        const NodeRecord& node = *nodes.find(id);
        if (i == 0) return node.parent;
        if (i > node.instances.ids().size()) return std::nullopt;
        const NodeId instance = node.instances.ids()[i - 1];
        return is_instance_of(instance, id) ? instance : NodeId();
    };
    return leads_to(above, below, shown, showing);
}

void Scene::set_parent(NodeId id, NodeId parent)
{
    State& s = *state_;
    s.require_unrecorded();
    State::NodeRecord& node = State::at(s.nodes, id, "node");
    std::vector<NodeId>& siblings = State::at(s.nodes, parent, "node").children;
    if (id == s.root) throw error_without_file("the root has no parent");
    if (s.is_shown_by(parent, id)) throw State::shows_itself(node.name);

    siblings.push_back(id);  // no later step needs memory
    s.about_to_move(id, node);
    const NodeId parent_before = std::exchange(node.parent, parent);
    const std::uint32_t place_before = std::exchange(node.place_among_siblings,
                                                     static_cast<std::uint32_t>(siblings.size() - 1));
    s.leave_parent(parent_before, place_before);
    s.mark_dirty(parent_before);
    s.place_changed(id, node);
    s.lose_links(node);
}

template <class T>
void Scene::State::change_contents(NodeId id, T NodeDesc::*member, T value)
{
    NodeRecord& node = *nodes.find(id);
    std::swap(node.*member, value);
    Rollback changed([&] { std::swap(node.*member, value); });
    watch_contents(id, node);
    changed.keep();
    mark_dirty(id);
}

void Scene::set_cages(NodeId id, std::vector<CageId> cages)
{
    state_->require_unrecorded();
    State::at(state_->nodes, id, "node");
    for (const CageId cage : cages) State::at(state_->cages, cage, "cage");
    state_->change_contents(id, &NodeDesc::cages, std::move(cages));
}

void Scene::set_materials(NodeId id, std::vector<MaterialId> materials)
{
    state_->require_editable();
    State::at(state_->nodes, id, "node");
    for (MaterialId material : materials) State::at(state_->materials, material, "material");
    state_->change_contents(id, &NodeDesc::materials, std::move(materials));
}

void Scene::set_light(NodeId id, LightId light)
{
    state_->require_editable();
    State::at(state_->nodes, id, "node");
    if (light) State::at(state_->lights, light, "light");
    state_->change_contents(id, &NodeDesc::light, light);
}

void Scene::set_camera(NodeId id, CameraId camera)
{
    state_->require_editable();
    State::at(state_->nodes, id, "node");
    if (camera) State::at(state_->cameras, camera, "camera");
    state_->change_contents(id, &NodeDesc::camera, camera);
}

void Scene::State::show_instance(NodeId id, NodeId shown)
{
    NodeRecord* of = nodes.find(shown);
    if (of) of->instances.add(id, [&](NodeId known) { return nodes.find(known) != nullptr; });
    nodes.find(id)->instance_of = shown;
}

void Scene::set_instance_of(NodeId id, NodeId shown)
{
    State& s = *state_;
    s.require_unrecorded();
    const State::NodeRecord& node = State::at(s.nodes, id, "node");
    if (shown) {
        State::at(s.nodes, shown, "node");
        if (s.is_shown_by(id, shown)) throw State::shows_itself(node.name);
    }
    s.show_instance(id, shown);
    s.mark_dirty(id);
}

}  // namespace occam
