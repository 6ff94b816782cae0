// Adds, removes, places and finds the nodes of a scene. Where they hang and what they hold is changed in scene_links.cpp,
// the objects that they refer to are in scene_content.cpp, and bounds in scene_bounds.cpp.
#include "scenegraph/scene.h"

#include <cmath>

#include "base/error_without_file.h"
#include "scenegraph/content_rules.h"
#include "scenegraph/scene_state.h"

namespace occam {

namespace {

// Returns the rigid part of a matrix, because a camera does not scale. An axis that is scaled to zero follows from the
// others.
Mat4d rigid(const Mat4d& m)
{
    Vec3d back(m[2]);
    if (!(glm::length(back) > 0)) back = glm::cross(Vec3d(m[0]), Vec3d(m[1]));
    if (!(glm::length(back) > 0)) back = Vec3d(0, 0, 1);
    back = back / glm::length(back);
    Vec3d right = glm::cross(Vec3d(m[1]), back);
    if (!(glm::length(right) > 0)) right = Vec3d(m[0]) - back * glm::dot(Vec3d(m[0]), back);
    if (!(glm::length(right) > 0)) right = glm::cross(std::abs(back.y) < 0.9 ? Vec3d(0, 1, 0) : Vec3d(1, 0, 0), back);
    right = right / glm::length(right);
    return {Vec4d(right, 0), Vec4d(glm::cross(back, right), 0), Vec4d(back, 0), Vec4d(Vec3d(m[3]), 1)};
}

}  // namespace

std::uint32_t next_scene_generation() noexcept
{
    // The scene's number is multiplied by an odd number modulo 2^32, so all results differ, and neighbours lie far apart.
    static std::atomic<std::uint32_t> scenes{0};
    return scenes.fetch_add(1, std::memory_order_relaxed) * 0x9E3779B1u;
}

Scene::Scene() : state_(std::make_shared<State>()) { state_->root = state_->nodes.add({}); }
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;
Scene::~Scene() = default;

NodeId Scene::root() const noexcept { return state_->root; }

NodeId Scene::add_node(NodeId parent, NodeDesc desc)
{
    State& s = *state_;
    s.require_unrecorded();
    State::at(s.nodes, parent, "node");
    for (CageId id : desc.cages) State::at(s.cages, id, "cage");
    for (MaterialId id : desc.materials) State::at(s.materials, id, "material");
    if (desc.light) State::at(s.lights, desc.light, "light");
    if (desc.camera) State::at(s.cameras, desc.camera, "camera");
    if (desc.skin) State::at(s.skins, desc.skin, "skin");
    if (desc.instance_of) {
        State::at(s.nodes, desc.instance_of, "node");
        if (s.is_shown_by(parent, desc.instance_of)) throw State::shows_itself(desc.name);
    }
    if (!desc.matrix) check(desc.place, desc.name);
    check_morph_weights(desc.morph_weights, desc.name);
    const Mat4d parent_from_node = checked_affine(desc.matrix ? *desc.matrix : desc.place.matrix(), "a transform", "node",
                                                  desc.name);
    if (desc.matrix) desc.matrix = parent_from_node;

    State::NodeRecord record;
    static_cast<NodeDesc&>(record) = std::move(desc);
    record.parent = parent;
    record.added = next_identity();
    record.parent_from_node = parent_from_node;
    record.dirty = false;  // mark_dirty() stops at dirty nodes, so this one must be clean
    const NodeId id = s.nodes.add(std::move(record));
    Rollback added([&] {
        std::vector<NodeId>& siblings = s.nodes.find(parent)->children;
        if (!siblings.empty() && siblings.back() == id) siblings.pop_back();
        s.nodes.remove(id);
    });
    s.link_node(id);
    added.keep();
    s.mark_dirty(id);
    return id;
}

void Scene::State::link_node(NodeId id)
{
    const auto is_alive = [&](NodeId known) { return nodes.find(known) != nullptr; };
    NodeRecord& node = *nodes.find(id);
    std::vector<NodeId>& siblings = nodes.find(node.parent)->children;
    node.place_among_siblings = static_cast<std::uint32_t>(siblings.size());
    siblings.push_back(id);
    watch_contents(id, node);
    if (node.instance_of) nodes.find(node.instance_of)->instances.add(id, is_alive);
    if (!node.skin) return;
    skins.find(node.skin)->users.add(id, is_alive);
    link_user(id);
}

// The subtree is removed from its leaves up, without a list of what is left to do: a removal needs no memory.
void Scene::remove(NodeId id)
{
    State& s = *state_;
    s.require_unrecorded();
    State::at(s.nodes, id, "node");
    if (id == s.root) throw error_without_file("the root cannot be removed");
    s.mark_dirty(id);
    s.leave_parent(s.nodes.find(id)->parent, s.nodes.find(id)->place_among_siblings);
    for (NodeId at = id; at;) {
        State::NodeRecord& node = *s.nodes.find(at);
        if (!node.children.empty()) {
            const NodeId child = node.children.back();
            node.children.pop_back();
            if (child) at = child;
            continue;
        }
        const NodeId parent = at == id ? NodeId() : node.parent;
        s.remove_one(at);
        at = parent;
    }
}

// The caller has checked that no shutter is recorded.
void Scene::State::remove_one(NodeId id) noexcept
{
    NodeRecord& node = *nodes.find(id);
    about_to_move(id, node);
    // Instances elsewhere that show a part of the subtree lose it.
    for (NodeId instance : node.instances.ids())
        if (is_instance_of(instance, id)) mark_dirty(instance);
    place_changed(id, node);  // the node may be a joint of a skin that stays
    lose_links(node);
    std::vector<SkinId> made;
    if (const auto copy = posed.find(id); copy != posed.end()) {
        made.swap(copy->second.skins);
        posed.erase(copy);
    }
    const SkinId worn = node.skin;
    nodes.remove(id);
    lose_wearer(worn);
    // Skins that were made for a copy go with it, unless a node that hangs elsewhere wears them.
    for (const SkinId skin_of_copy : made) {
        SkinRecord* skin = skins.find(skin_of_copy);
        if (!skin) continue;
        if (!skin->users.those_that([&](NodeId user) { return wears(user, *skin); }).empty()) continue;
        drop_keys(*skin);
        skins.remove(skin_of_copy);
    }
}

const Node& Scene::node(NodeId id) const { return State::at(state_->nodes, id, "node"); }

void Scene::set_transform(NodeId id, const Trs& place)
{
    check(place, node(id).name);
    set_transform(id, place.matrix());
    Node& node = *state_->nodes.find(id);
    node.place = place;
    node.matrix.reset();
}

void Scene::set_transform(NodeId id, const Mat4d& parent_from_node)
{
    state_->require_editable();
    State::NodeRecord& node = State::at(state_->nodes, id, "node");
    const Mat4d affine = checked_affine(parent_from_node, "a transform", "node", node.name);
    state_->place(id, node, affine);
    if (node.rest) node.rest->place.reset();
    node.matrix = affine;
}

void Scene::State::place(NodeId id, NodeRecord& node, const Mat4d& parent_from_node)
{
    about_to_move(id, node);
    node.parent_from_node = parent_from_node;
    place_changed(id, node);
}

void Scene::set_visible(NodeId id, bool visible)
{
    state_->require_editable();
    State::NodeRecord& node = State::at(state_->nodes, id, "node");
    state_->about_to_change(id, node);
    if (node.visible == visible) return;
    node.visible = visible;
    state_->touch_in_parent(node);
    state_->mark_dirty(node.parent ? node.parent : id);
}

void Scene::set_seen_by(NodeId id, std::uint8_t ray_kinds)
{
    state_->require_editable();
    State::at(state_->nodes, id, "node").seen_by = ray_kinds;
}

void Scene::set_lit_by(NodeId id, LightGroups groups)
{
    state_->require_editable();
    State::at(state_->nodes, id, "node").lit_by = groups;
}

NodeId Scene::find_node(std::string_view name, NodeId below) const
{
    if (below) State::at(state_->nodes, below, "node");
    const auto is_below = [&](NodeId id) {
        while (id && id != below) id = state_->nodes.find(id)->parent;
        return id == below;
    };
    NodeId found;
    std::uint64_t earliest = ~std::uint64_t(0);
    state_->nodes.for_each([&](NodeId id, const State::NodeRecord& node) {
        if (node.added < earliest && node.name == name && is_below(id)) found = id, earliest = node.added;
    });
    return found;
}

Mat4d Scene::world_from_node(NodeId id) const
{
    const Node* n = &node(id);
    Mat4d m = n->parent_from_node;
    while ((n = find(n->parent))) m = n->parent_from_node * m;
    return m;
}

std::vector<NodeId> Scene::State::nodes_with_cameras() const
{
    std::vector<NodeId> found;
    cameras.for_each([&](CameraId id, const CameraRecord& camera) {
        for (const NodeId user : camera.users.ids())
            if (const NodeRecord* node = nodes.find(user); node && node->camera == id) found.push_back(user);
    });
    std::sort(found.begin(), found.end(), [&](NodeId a, NodeId b) { return nodes.find(a)->added < nodes.find(b)->added; });
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
}

std::optional<Camera> Scene::camera(std::string_view name) const
{
    for (const NodeId id : state_->nodes_with_cameras()) {
        if (!name.empty() && node(id).name != name) continue;
        return camera_of(id);
    }
    return std::nullopt;
}

std::optional<Camera> Scene::camera_of(NodeId id) const
{
    const CameraLens* lens = state_->cameras.find(node(id).camera);
    if (!lens) return std::nullopt;
    Camera camera{rigid(world_from_node(id)), *lens, {}};
    for (const Mat4d& key : world_from_node_keys(id)) camera.keys.push_back(rigid(key));
    return camera;
}

std::vector<std::string> Scene::camera_names() const
{
    std::vector<std::string> names;
    for (const NodeId id : state_->nodes_with_cameras()) names.push_back(node(id).name);
    return names;
}

}  // namespace occam
