// Finds where the joints of skins are, and which nodes an edit of a joint affects.
//
// The base of a skin is the lowest node above all its joints. Moving the base, or a node above it, moves a character as a
// whole and leaves its pose as it is. The nodes between the joints and the base know the skin, so an edit that moves a joint
// finds the nodes that use the skin in O(depth). Where a node is hung elsewhere or removed, these links are out of date, and
// the next refit finds them again. A node that a skin no longer depends on still knows it, so an edit of that node marks the
// skin and its users for no reason. Joints that were removed do not count: their vertices stay where they are in the axes of
// the base. A skin without any joint deforms nothing, and the places of the nodes that wear it count.
#include <algorithm>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "base/error_without_file.h"
#include "base/matrix.h"
#include "scenegraph/content_rules.h"
#include "scenegraph/scene_state.h"

namespace occam {

NodeId Scene::State::lowest_common(NodeId a, NodeId b) const
{
    const auto depth = [&](NodeId id) {
        std::size_t d = 0;
        for (const NodeRecord* n = nodes.find(id); n; n = nodes.find(id)) id = n->parent, ++d;
        return d;
    };
    const auto climb = [&](NodeId id, std::size_t steps) {
        for (; steps > 0; --steps) id = nodes.find(id)->parent;
        return id;
    };
    const std::size_t da = depth(a), db = depth(b);
    a = climb(a, da > db ? da - db : 0);
    b = climb(b, db > da ? db - da : 0);
    while (a != b && nodes.find(a)) {
        a = nodes.find(a)->parent;
        b = nodes.find(b)->parent;
    }
    return nodes.find(a) ? a : NodeId();
}

Mat4d Scene::State::path(NodeId above, NodeId node, std::optional<std::size_t> key) const
{
    Mat4d m(1);
    for (const NodeRecord* n = nodes.find(node); n && node != above; n = nodes.find(node)) {
        m = (key && !n->keys.empty() ? n->keys[*key].parent_from_node : n->parent_from_node) * m;
        node = n->parent;
    }
    return m;
}

NodeId Scene::State::parent_of(NodeId id) const noexcept
{
    const NodeRecord* node = nodes.find(id);
    return node ? node->parent : NodeId();
}

NodeId Scene::State::base_of(const std::vector<NodeId>& joints) const
{
    const auto first = std::find_if(joints.begin(), joints.end(), [&](NodeId joint) { return nodes.find(joint); });
    if (first == joints.end()) return {};
    // The base is on the path from the first joint to the root, as high as a path from another joint meets it. Nodes that
    // one of these has passed lead to a place that is known, so each is visited once.
    std::vector<NodeId> path;
    std::unordered_map<NodeId, std::size_t> place_on_path;
    for (NodeId at = parent_of(*first); at; at = parent_of(at)) {
        place_on_path.emplace(at, path.size());
        path.push_back(at);
    }
    std::size_t highest = 0;
    std::unordered_set<NodeId> passed;
    for (const NodeId joint : joints) {
        if (!nodes.find(joint)) continue;
        if (!parent_of(joint)) return {};
        for (NodeId at = parent_of(joint); at && passed.insert(at).second; at = parent_of(at))
            if (const auto found = place_on_path.find(at); found != place_on_path.end()) {
                highest = std::max(highest, found->second);
                break;
            }
    }
    return highest < path.size() ? path[highest] : NodeId();
}

void Scene::State::find_parent_joints(SkinRecord& skin) const
{
    const std::vector<NodeId>& joints = skin.skin.joints;
    std::unordered_map<NodeId, int> nearest;  // the nearest joint at or above a node
    for (std::size_t j = 0; j < joints.size(); ++j) nearest.emplace(joints[j], static_cast<int>(j));
    skin.parent_joint.assign(joints.size(), -1);
    std::vector<NodeId> passed;
    for (std::size_t j = 0; j < joints.size(); ++j) {
        for (NodeId at = parent_of(joints[j]); at && at != skin.base; at = parent_of(at)) {
            if (const auto known = nearest.find(at); known != nearest.end()) {
                skin.parent_joint[j] = known->second;
                break;
            }
            passed.push_back(at);
        }
        for (; !passed.empty(); passed.pop_back()) nearest.emplace(passed.back(), skin.parent_joint[j]);
    }
}

void Scene::State::link_skin(SkinId id)
{
    SkinRecord& skin = *skins.find(id);
    skin.base = base_of(skin.skin.joints);
    find_parent_joints(skin);
    for (const NodeId at : nodes_of_skin(skin)) {
        NodeRecord& node = *nodes.find(at);
        if (!node.dependents) node.dependents = std::make_unique<Dependents>();
        node.dependents->skins.add(id, [&](SkinId other) { return skins.find(other) != nullptr; });
        node.dependents->marked_in = 0;
    }
    skin.dirty = skin.has_stale_keys = true;
    for (const NodeId user : skin.users.ids())
        if (wears(user, skin)) nodes.find(user)->has_stale_keys = nodes.find(user)->has_stale_links = true;
    skin.has_stale_links = false;
}

std::vector<NodeId> Scene::State::nodes_of_skin(const SkinRecord& skin) const
{
    std::vector<NodeId> found;
    std::unordered_set<NodeId> seen;
    for (NodeId at : skin.skin.joints)
        for (const NodeRecord* node = nodes.find(at); node && at != skin.base; node = nodes.find(at)) {
            if (!seen.insert(at).second) break;
            found.push_back(at);
            at = node->parent;
        }
    return found;
}

bool Scene::State::has_no_joint(const SkinRecord& skin) const noexcept
{
    const std::vector<NodeId>& joints = skin.skin.joints;
    return std::none_of(joints.begin(), joints.end(), [&](NodeId joint) { return nodes.find(joint) != nullptr; });
}

void Scene::State::link_user(NodeId id)
{
    NodeRecord& wearer = *nodes.find(id);
    const SkinRecord* skin = skins.find(wearer.skin);
    if (skin->has_stale_links) link_skin(wearer.skin);
    wearer.has_stale_links = !has_no_joint(*skin);
    if (!wearer.has_stale_links) return;
    const auto is_alive = [&](NodeId known) { return nodes.find(known) != nullptr; };
    const NodeId top = lowest_common(id, skin->base);
    for (const NodeId from : {id, skin->base})
        for (NodeId at = from; at && at != top; at = nodes.find(at)->parent) {
            NodeRecord& node = *nodes.find(at);
            if (!node.dependents) node.dependents = std::make_unique<Dependents>();
            node.dependents->users.add(id, is_alive);
            node.dependents->marked_in = 0;
        }
    wearer.has_stale_links = false;
}

void Scene::State::lose_links(const NodeRecord& node) noexcept
{
    if (!node.dependents) return;
    for (const SkinId id : node.dependents->skins.ids())
        if (SkinRecord* skin = skins.find(id)) skin->has_stale_links = true;
    for (const NodeId id : node.dependents->users.ids())
        if (NodeRecord* user = nodes.find(id)) user->has_stale_links = user->has_stale_keys = true;
}

bool Scene::State::is_worn(SkinRecord& skin) const noexcept
{
    return skin.users.has_any_that([&](NodeId user) { return wears(user, skin); });
}

bool Scene::State::wears(NodeId id, const SkinRecord& skin) const noexcept
{
    const NodeRecord* node = nodes.find(id);
    return node && skins.find(node->skin) == &skin;
}

Mat4d Scene::State::node_from_skin(NodeId id, const SkinRecord& skin, std::optional<std::size_t> key) const
{
    if (has_no_joint(skin)) return Mat4d(1);
    const NodeId top = skin.base ? lowest_common(id, skin.base) : NodeId();
    const Mat4d top_from_node = path(top, id, key);
    // What a node wears that is scaled to zero, along one axis at least, shows nothing, so all of its points may collapse.
    if (flattens(Mat3d(top_from_node))) return {Vec4d(0), Vec4d(0), Vec4d(0), Vec4d(0, 0, 0, 1)};
    return glm::inverse(top_from_node) * path(top, skin.base, key);
}

std::vector<Mat4d> Scene::State::poses_of(const SkinRecord& skin, std::optional<std::size_t> key) const
{
    const std::size_t count = skin.skin.joints.size();
    std::vector<Mat4d> base_from_joint(count);
    std::vector<bool> is_known(count, false);
    std::vector<std::size_t> todo;
    for (std::size_t j = 0; j < count; ++j) {
        // Parents are posed before their children. Most files list them in that order, so `todo` rarely holds more than one.
        for (std::size_t at = j; !is_known[at];) {
            todo.push_back(at);
            if (skin.parent_joint[at] < 0) break;
            at = static_cast<std::size_t>(skin.parent_joint[at]);
        }
        for (; !todo.empty(); todo.pop_back()) {
            const std::size_t at = todo.back();
            const int above = skin.parent_joint[at];
            const NodeId joint = skin.skin.joints[at];
            base_from_joint[at] = above < 0 ? path(skin.base, joint, key)
                                            : base_from_joint[static_cast<std::size_t>(above)] *
                                                  path(skin.skin.joints[static_cast<std::size_t>(above)], joint, key);
            is_known[at] = true;
        }
    }
    std::vector<Mat4d> poses(count);
    for (std::size_t j = 0; j < count; ++j) {
        const bool is_alive = nodes.find(skin.skin.joints[j]) != nullptr;
        const Mat4d& from_joint = base_from_joint[j];
        poses[j] = !is_alive                           ? Mat4d(1)
                   : skin.skin.joint_from_mesh.empty() ? from_joint
                                                       : from_joint * skin.skin.joint_from_mesh[j];
    }
    return poses;
}

void Scene::State::place_changed(NodeId id, NodeRecord& node) noexcept
{
    // The box of the node is in its own axes and stays valid, so the parent is marked. Only the root has no parent.
    touch_in_parent(node);
    mark_dirty(node.parent ? node.parent : id);
    if (!node.dependents || std::exchange(node.dependents->marked_in, round) == round) return;
    note_looked_at(node.dependents->skins.ids().size() + node.dependents->users.ids().size());
    for (const SkinId s : node.dependents->skins.those_that([&](SkinId skin) { return skins.find(skin) != nullptr; })) {
        skins.find(s)->dirty = true;
        mark_users_dirty(*skins.find(s));
    }
    const auto wears_one = [&](NodeId user) { return nodes.find(user) && skins.find(nodes.find(user)->skin); };
    for (const NodeId user : node.dependents->users.those_that(wears_one)) mark_dirty(user);
}

SkinId Scene::add(Skin skin)
{
    state_->require_editable();
    for (NodeId joint : skin.joints) State::at(state_->nodes, joint, "node");
    if (!skin.joint_from_mesh.empty() && skin.joint_from_mesh.size() != skin.joints.size())
        throw error_without_file("a skin needs one inverse bind matrix a joint, or none", naming("skin", skin.name));
    for (Mat4d& m : skin.joint_from_mesh) m = checked_affine(m, "an inverse bind matrix", "skin", skin.name);
    return state_->add_skin(std::move(skin));
}

SkinId Scene::State::add_skin(Skin skin)
{
    SkinRecord record;
    record.skin = std::move(skin);
    const SkinId id = skins.add(std::move(record));
    Rollback added([&] { skins.remove(id); });
    link_skin(id);
    added.keep();
    return id;
}

void Scene::remove(SkinId id)
{
    state_->require_unrecorded();
    State::SkinRecord& skin = State::at(state_->skins, id, "skin");
    state_->drop_keys(skin);
    state_->mark_users_dirty(skin);
    for (const NodeId user : skin.users.ids())
        if (state_->wears(user, skin)) state_->nodes.find(user)->has_stale_keys = true;
    state_->skins.remove(id);
}

void Scene::set_skin(NodeId id, SkinId skin)
{
    state_->require_unrecorded();
    State::NodeRecord& node = State::at(state_->nodes, id, "node");
    if (skin) State::at(state_->skins, skin, "skin");
    if (node.skin == skin) return;
    const SkinId before = node.skin;
    Rollback worn([&, is_stale = node.has_stale_links] {
        node.skin = before;
        node.has_stale_links = is_stale;
    });
    node.skin = skin;
    if (skin) {
        const auto is_alive = [&](NodeId known) { return state_->nodes.find(known) != nullptr; };
        state_->skins.find(skin)->users.add(id, is_alive);
        state_->link_user(id);
    }
    worn.keep();
    state_->about_to_change(id, node);  // it drops the keys, which needs no memory outside of a recording
    state_->mark_dirty(id);
    state_->lose_wearer(before);
}

void Scene::set_morph_weights(NodeId id, std::vector<float> weights)
{
    state_->require_editable();
    State::NodeRecord& node = State::at(state_->nodes, id, "node");
    check_morph_weights(weights, node.name);
    state_->about_to_change(id, node);
    if (node.rest) node.rest->weights.reset();
    if (node.morph_weights == weights) return;
    node.morph_weights = std::move(weights);
    state_->mark_dirty(id);
}

const Skin& Scene::skin(SkinId id) const { return State::at(state_->skins, id, "skin").skin; }
const SkinSlot* Scene::find(SkinId id) const noexcept { return state_->skins.find(id); }

}  // namespace occam
