// Changes where the nodes of a scene hang, and what they hold.
#include <unordered_set>

#include "base/error_without_file.h"
#include "scenegraph/content_rules.h"
#include "scenegraph/scene_state.h"

namespace occam {

// The skins and the skinned nodes for which a moved node lies between a joint, or the skinned node, and the base of the
// skin. With the node's parent, the base of such a skin may change. What they were registered with before still knows them,
// which costs later edits of it some marks.
class Scene::State::MovedSkins {
public:
    MovedSkins(State& state, NodeId moved) : state_(state)
    {
        const NodeRecord& node = *state.nodes.find(moved);
        if (!node.dependents) return;
        std::unordered_set<NodeId> known_users;
        const auto add_user = [&](NodeId id) {
            const NodeRecord* user = state.nodes.find(id);
            if (user && state.skins.find(user->skin) && known_users.insert(id).second) users_.push_back(id);
        };
        for (const NodeId id : node.dependents->users.ids()) add_user(id);
        std::unordered_set<SkinId> known;
        for (const SkinId id : node.dependents->skins.ids()) {
            const SkinRecord* skin = state.skins.find(id);
            if (!skin || !known.insert(id).second) continue;
            const std::vector<NodeId> known_by = state.nodes_of_skin(*skin);
            if (std::find(known_by.begin(), known_by.end(), moved) == known_by.end()) continue;
            skins_.push_back({id, skin->base, skin->parent_joint});
            for (const NodeId user : skin->users.ids()) add_user(user);
        }
    }

    /// Finds the bases again, and registers skins and nodes with what lies below these.
    void link()
    {
        for (const SkinLinks& links : skins_) state_.link_skin(links.id);
        for (const NodeId id : users_) state_.link_user(id);
    }
    /// Takes back what link() changed.
    void unlink() noexcept
    {
        for (SkinLinks& links : skins_) {
            SkinRecord& skin = *state_.skins.find(links.id);
            skin.base = links.base;
            skin.parent_joint.swap(links.parent_joint);
        }
    }
    /// Marks what has to be posed again.
    void mark() noexcept
    {
        for (const SkinLinks& links : skins_) {
            SkinRecord& skin = *state_.skins.find(links.id);
            skin.dirty = skin.has_stale_keys = true;
            skin.has_stale_base = false;
        }
        for (const NodeId id : users_) {
            state_.nodes.find(id)->has_stale_keys = true;
            state_.mark_dirty(id);
        }
    }

private:
    struct SkinLinks {
        SkinId id;
        NodeId base;
        std::vector<int> parent_joint;
    };

    State& state_;
    std::vector<SkinLinks> skins_;
    std::vector<NodeId> users_;
};

Error Scene::State::shows_itself(const std::string& name)
{
    return error_without_file("a node cannot show itself, as its own child or as an instance", name);
}

void Scene::set_parent(NodeId id, NodeId parent)
{
    State& s = *state_;
    s.require_unrecorded();
    State::NodeRecord& node = State::at(s.nodes, id, "node");
    std::vector<NodeId>& siblings = State::at(s.nodes, parent, "node").children;
    if (id == s.root) throw error_without_file("the root has no parent");
    if (s.is_shown_by(parent, id)) throw State::shows_itself(node.name);

    State::MovedSkins skins(s, id);
    siblings.push_back(id);
    const NodeId parent_before = std::exchange(node.parent, parent);
    const std::uint32_t place_before = std::exchange(node.place_among_siblings,
                                                     static_cast<std::uint32_t>(siblings.size() - 1));
    Rollback moved([&] {
        skins.unlink();
        siblings.pop_back();
        node.parent = parent_before;
        node.place_among_siblings = place_before;
    });
    skins.link();
    moved.keep();
    s.about_to_move(id, node);
    s.leave_parent(parent_before, place_before);
    s.mark_dirty(parent_before);
    s.mark_dirty(parent);
    s.touch_in_parent(node);
    skins.mark();
}

void Scene::set_cages(NodeId id, std::vector<CageId> cages)
{
    State& s = *state_;
    s.require_unrecorded();
    State::NodeRecord& node = State::at(s.nodes, id, "node");
    for (const CageId cage : cages) State::at(s.cages, cage, "cage");
    const auto is_alive = [&](NodeId known) { return s.nodes.find(known) != nullptr; };
    for (const CageId cage : cages) s.cages.find(cage)->users.add(id, is_alive);
    node.cages = std::move(cages);
    s.mark_dirty(id);
}

void Scene::set_materials(NodeId id, std::vector<MaterialId> materials)
{
    state_->require_editable();
    State::NodeRecord& node = State::at(state_->nodes, id, "node");
    for (MaterialId material : materials) State::at(state_->materials, material, "material");
    node.materials.swap(materials);
    Rollback changed([&] { node.materials.swap(materials); });
    state_->watch_contents(id, node);
    changed.keep();
    state_->mark_dirty(id);
}

void Scene::set_light(NodeId id, LightId light)
{
    state_->require_editable();
    State::NodeRecord& node = State::at(state_->nodes, id, "node");
    if (light) State::at(state_->lights, light, "light");
    Rollback changed([&, before = std::exchange(node.light, light)] { node.light = before; });
    state_->watch_contents(id, node);
    changed.keep();
    state_->mark_dirty(id);
}

void Scene::set_camera(NodeId id, CameraId camera)
{
    state_->require_editable();
    State::NodeRecord& node = State::at(state_->nodes, id, "node");
    const auto is_alive = [&](NodeId known) { return state_->nodes.find(known) != nullptr; };
    if (camera) State::at(state_->cameras, camera, "camera").users.add(id, is_alive);
    node.camera = camera;
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
