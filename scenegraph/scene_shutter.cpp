// The shutter: what moves while a frame's shutter is open, as poses at evenly spaced keys.
//
// record_shutter() lets the application pose the scene at every key. An edit announces itself before it writes
// (about_to_change() and its kin), so the recorder knows the value that held at all earlier keys, and only what is
// edited costs anything. Outside of a recording the same announcements drop the keys of what is edited.
#include <algorithm>
#include <bit>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "base/error_without_file.h"
#include "base/matrix.h"
#include "scenegraph/content_rules.h"
#include "scenegraph/scene_state.h"
#include "scenegraph/shutter.h"

namespace occam {

/// What the poses of a recording have changed so far: one entry for each key that is done.
struct Scene::State::Recorder {
    std::size_t keys_done = 0;
    std::unordered_map<NodeId, std::vector<NodeKey>> nodes;
    std::unordered_map<SkinId, std::size_t> skins;  ///< whose joints move, and how many they are
    std::unordered_map<CageId, std::vector<std::vector<Vec3f>>> cages;
    std::unordered_set<NodeId> moved;  ///< those of which all that depends on them is in these lists

    /// Returns the bytes that all keys so far and `more` of them take.
    std::size_t bytes_with(std::size_t more) const noexcept
    {
        const std::size_t keys_after = keys_done + more;
        std::size_t bytes = 0;
        for (const auto& [id, keys] : nodes)
            bytes += keys_after * (sizeof(NodeKey) + (keys.empty() ? 0 : keys.front().morph_weights.size() * sizeof(float)));
        for (const auto& [id, joints] : skins) bytes += keys_after * joints * sizeof(Mat4d);
        for (const auto& [id, keys] : cages) bytes += keys_after * (keys.empty() ? 0 : keys.front().size() * sizeof(Vec3f));
        return bytes;
    }
};

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// What moves while the shutter is open is refused if its keys take more bytes.
constexpr std::size_t kMostKeyBytes = std::size_t(1) << 30;

/// Returns whether all keys are the same, and that of mid-shutter, too, which is none of them if there are but two.
template <class T>
bool stand_still(const std::vector<T>& keys, const T& middle)
{
    return std::all_of(keys.begin(), keys.end(), [&](const T& key) { return key == middle; });
}

}  // namespace

bool Node::is_visible_in_shutter() const noexcept
{
    if (keys.empty()) return visible;
    // The last key is the end of the last segment, and shows nothing by itself.
    return std::any_of(keys.begin(), keys.end() - 1, [](const NodeKey& key) { return key.visible; });
}

Box3d box_in_parent(const Node& node) noexcept
{
    const auto placed = [&](const Mat4d& parent_from_node) {
        const Box3d box = transform_box(parent_from_node, node.bounds);
        if (!box.is_empty() || node.bounds.is_empty()) return box;
        return Box3d{Vec3d(-kInfinity), Vec3d(kInfinity)};  // what overflows may be anywhere, and is not forgotten
    };
    if (node.keys.empty()) return node.visible ? placed(node.parent_from_node) : Box3d();
    Box3d box;
    for (std::size_t k = 0; k < node.keys.size(); ++k)
        if (node.keys[k].visible || (k > 0 && node.keys[k - 1].visible)) box.add(placed(node.keys[k].parent_from_node));
    return box;
}

double largest_stretch_to_parent(const Node& node) noexcept
{
    if (node.keys.empty()) return largest_stretch(Mat3d(node.parent_from_node));
    double most = 0;
    for (const NodeKey& key : node.keys) most = std::max(most, largest_stretch(Mat3d(key.parent_from_node)));
    return most;
}

NodeKey Scene::State::key_of(const NodeRecord& node, NodeId id) const
{
    const SkinRecord* skin = skins.find(node.skin);
    return {node.parent_from_node, skin ? node_from_skin(id, *skin) : Mat4d(1), node.morph_weights, node.visible};
}

void Scene::State::about_to_change(NodeId id, NodeRecord& node)
{
    if (!recorder) return drop_keys(id, node);
    if (!recorder->nodes.contains(id))
        recorder->nodes.emplace(id, std::vector<NodeKey>(recorder->keys_done, key_of(node, id)));
}

void Scene::State::about_to_move(NodeId id, NodeRecord& node)
{
    if (!recorder && things_with_keys == 0) return;
    about_to_change(id, node);
    if (!node.dependents || (recorder && recorder->moved.contains(id))) return;
    note_looked_at(node.dependents->skins.ids().size() + node.dependents->users.ids().size());
    for (const SkinId skin_id : node.dependents->skins.ids()) {
        SkinRecord* skin = skins.find(skin_id);
        if (!skin) continue;
        if (recorder) recorder->skins.try_emplace(skin_id, skin->skin.joints.size());
        else lose_keys(*skin);
    }
    for (const NodeId user_id : node.dependents->users.ids())
        if (NodeRecord* user = nodes.find(user_id)) {
            if (recorder) about_to_change(user_id, *user);
            else user->has_stale_keys = true;
        }
    if (recorder) recorder->moved.insert(id);
}

void Scene::State::about_to_write(CageId id, CageRecord& cage)
{
    if (!recorder) return drop_keys(cage);
    if (cage.is_deformed())
        throw error_without_file("a cage with a skin or morph targets keeps its vertices while a shutter is recorded",
                                 naming("cage", cage.cage.name));
    if (!recorder->cages.contains(id))
        recorder->cages.emplace(id, std::vector<std::vector<Vec3f>>(recorder->keys_done, cage.cage.positions));
}

void Scene::State::drop_keys(NodeId id, NodeRecord& node) noexcept
{
    if (node.keys.empty()) return;
    node.keys.clear();
    --things_with_keys;
    touch_in_parent(node);
    mark_dirty(id);
    if (!node.dependents) return;
    for (const SkinId skin_id : node.dependents->skins.ids())
        if (SkinRecord* skin = skins.find(skin_id)) lose_keys(*skin);
    for (const NodeId user_id : node.dependents->users.ids())
        if (NodeRecord* user = nodes.find(user_id)) {
            user->has_stale_keys = true;
            mark_dirty(user_id);
        }
}

void Scene::State::drop_keys(SkinRecord& skin) noexcept
{
    if (skin.key_poses.empty()) return;
    skin.key_poses.clear();
    --things_with_keys;
    mark_users_dirty(skin);
}

void Scene::State::lose_keys(SkinRecord& skin) noexcept
{
    if (things_with_keys == 0) return;
    skin.has_stale_keys = true;
    mark_users_dirty(skin);
    if (!is_worn(skin)) drop_keys(skin);
}

void Scene::State::lose_wearer(SkinId id) noexcept
{
    SkinRecord* skin = skins.find(id);
    if (!skin || skin->key_poses.empty()) return;
    if (is_worn(*skin)) return;
    drop_keys(*skin);
    skin->has_stale_keys = true;
}

// A cage with keys is neither skinned nor morphed, so without them its bounds need no memory.
void Scene::State::drop_keys(CageRecord& cage) noexcept
{
    if (cage.key_positions.empty()) return;
    cage.key_positions.clear();
    --things_with_keys;
    find_bounds(cage);
    mark_users_dirty(cage);
}

// A skin stays where its joints are, wherever the node moves. So a node that lost its keys, or got its skin after the
// recording, still follows those nodes that move it, and one whose path was edited follows what is left of their motion.
void Scene::State::keep_skin_in_place(NodeId id, NodeRecord& node, const SkinRecord& skin)
{
    if (things_with_keys == 0 || !(node.keys.empty() || node.has_stale_keys)) return;
    const NodeId top = skin.base ? lowest_common(id, skin.base) : NodeId();
    bool moves = !node.keys.empty();
    for (NodeId at : {id, skin.base})
        for (const NodeRecord* n = nodes.find(at); n && at != top; n = nodes.find(at)) {
            moves |= !n->keys.empty();
            at = n->parent;
        }
    if (!moves) return;
    std::vector<NodeKey> keys = node.keys;
    if (keys.empty()) keys.assign(std::size_t(shutter_segments) + 1, key_of(node, id));
    for (std::size_t k = 0; k < keys.size(); ++k) keys[k].node_from_skin = node_from_skin(id, skin, k);
    node.has_stale_keys = false;
    if (stand_still(keys, key_of(node, id))) {  // what moved it has stopped
        if (node.keys.empty()) return;
        node.keys.clear();
        --things_with_keys;
        touch_in_parent(node);
        return;
    }
    if (node.keys.empty()) {
        if (!node.is_listed_with_keys) nodes_with_keys.push_back(id);
        node.is_listed_with_keys = true;
        ++things_with_keys;
    }
    node.keys = std::move(keys);
}

void Scene::State::keep_own_keys(NodeId id, NodeRecord& node)
{
    for (NodeKey& key : node.keys) key.node_from_skin = Mat4d(1);
    if (!node.keys.empty() && stand_still(node.keys, key_of(node, id))) {
        node.keys.clear();
        --things_with_keys;
        touch_in_parent(node);
    }
    node.has_stale_keys = false;
}

void Scene::State::keep_skin_moving(SkinId id, SkinRecord& skin)
{
    if (!skin.has_stale_keys) return;
    const auto moves = [&] {
        const std::vector<NodeId> between = nodes_of_skin(skin);
        return std::any_of(between.begin(), between.end(), [&](NodeId at) { return !nodes.find(at)->keys.empty(); });
    };
    std::vector<std::vector<Mat4d>> keys;
    if (things_with_keys > 0 && moves())
        for (std::size_t k = 0; k <= std::size_t(shutter_segments); ++k) keys.push_back(poses_of(skin, k));
    if (!keys.empty() && stand_still(keys, poses_of(skin))) keys.clear();
    if (!keys.empty() && skin.key_poses.empty()) {
        if (!skin.is_listed_with_keys) skins_with_keys.push_back(id);
        skin.is_listed_with_keys = true;
        ++things_with_keys;
    } else if (keys.empty() && !skin.key_poses.empty()) {
        --things_with_keys;
    }
    skin.key_poses = std::move(keys);
    skin.has_stale_keys = false;
}

void Scene::State::take_key(Recorder& record)
{
    for (auto& [id, keys] : record.nodes) keys.push_back(key_of(*nodes.find(id), id));
    for (auto& [id, keys] : record.cages) keys.push_back(cages.find(id)->cage.positions);
    ++record.keys_done;
}

void Scene::State::store_keys(Recorder& record)
{
    // What needs memory comes first, so that all keys are stored or none.
    nodes_with_keys.reserve(record.nodes.size());
    cages_with_keys.reserve(record.cages.size());
    for (const auto& [id, keys] : record.cages) cages.find(id)->key_bounds.reserve(keys.size());
    for (auto& [id, keys] : record.nodes) {
        NodeRecord& node = *nodes.find(id);
        if (stand_still(keys, key_of(node, id))) continue;
        node.keys = std::move(keys);
        node.has_stale_keys = true;
        nodes_with_keys.push_back(id);
        node.is_listed_with_keys = true;
        touch_in_parent(node);
        mark_dirty(id);
    }
    for (auto& [id, keys] : record.cages) {
        CageRecord& cage = *cages.find(id);
        if (stand_still(keys, cage.cage.positions)) continue;
        cage.key_positions = std::move(keys);
        cages_with_keys.push_back(id);
        find_bounds(cage);
        mark_users_dirty(cage);
    }
    things_with_keys = nodes_with_keys.size() + cages_with_keys.size();
}

void Scene::record_shutter(int segments, const std::function<void(double tau)>& pose)
{
    const std::shared_ptr<State> kept = state_;  // `pose` may move the scene elsewhere, or assign to it
    State& s = *kept;
    s.require_unrecorded();
    if (segments < 1 || segments > kMaxShutterSegments || !std::has_single_bit(static_cast<unsigned>(segments)))
        throw error_without_file("a shutter has 1, 2, 4, 8, 16 or 32 segments", std::to_string(segments));
    if (!pose) throw error_without_file("a shutter needs something that poses the scene");
    clear_shutter();
    s.skins.for_each([&](SkinId, State::SkinRecord& skin) {
        for (const NodeId user : skin.users.ids())
            if (s.wears(user, skin) && (skin.has_stale_links || s.nodes.find(user)->has_stale_links)) s.link_user(user);
    });

    const auto pose_at = [&](double tau) {
        pose(tau);
        // If nothing else holds the content, there may be no scene any more to compare with.
        if (kept.use_count() == 1 || state_ != kept)
            throw error_without_file("while a shutter is recorded, its scene can neither be moved nor assigned to");
    };
    State::Recorder record;
    struct Recording {
        explicit Recording(State& state, State::Recorder& into) : state_(state) { state_.recorder = &into; }
        ~Recording() { state_.recorder = nullptr; }
        State& state_;
    };
    {
        const Recording recording(s, record);
        for (int key = 0; key <= segments; ++key) {
            pose_at(double(key) / segments);
            s.take_key(record);
            // What moves first at this key has just got all keys before it, too.
            if (record.bytes_with(static_cast<std::size_t>(segments - key)) > kMostKeyBytes)
                throw ShutterTooLarge(error_without_file("what moves while the shutter is open takes more than " +
                                                             std::to_string(kMostKeyBytes >> 20) + " MB with " +
                                                             std::to_string(segments) + " segments of its motion",
                                                         "--shutter-segments"));
        }
        pose_at(0.5);
    }
    s.require_editable();  // `pose` may have begun a frame
    s.store_keys(record);
    s.shutter_segments = segments;
    // The keys of skins follow from those of their joints, as they do after an edit.
    Rollback stored([&] { clear_shutter(); });
    for (const auto& [id, joints] : record.skins) {
        State::SkinRecord& skin = *s.skins.find(id);
        s.lose_keys(skin);
        if (s.is_worn(skin)) s.keep_skin_moving(id, skin);
    }
    stored.keep();
}

void Scene::clear_shutter()
{
    State& s = *state_;
    s.require_unrecorded();
    for (const NodeId id : s.nodes_with_keys)
        if (State::NodeRecord* node = s.nodes.find(id)) {
            s.drop_keys(id, *node);
            node->is_listed_with_keys = false;
        }
    for (const SkinId id : s.skins_with_keys)
        if (State::SkinRecord* skin = s.skins.find(id)) {
            s.drop_keys(*skin);
            skin->is_listed_with_keys = false;
        }
    for (const CageId id : s.cages_with_keys)
        if (State::CageRecord* cage = s.cages.find(id)) s.drop_keys(*cage);
    s.nodes_with_keys.clear();
    s.skins_with_keys.clear();
    s.cages_with_keys.clear();
    s.things_with_keys = 0;
    s.shutter_segments = 0;
}

int Scene::shutter_segments() const noexcept { return state_->things_with_keys > 0 ? state_->shutter_segments : 0; }

std::vector<Mat4d> Scene::world_from_node_keys(NodeId id) const
{
    std::vector<Mat4d> keys;
    bool moves = false;
    for (const Node* n = &node(id); n; n = find(n->parent)) moves |= !n->keys.empty();
    if (!moves) return keys;
    const auto world_at = [&](std::optional<std::size_t> key) {
        Mat4d m(1);
        for (const Node* n = &node(id); n; n = find(n->parent))
            m = (key && !n->keys.empty() ? n->keys[*key].parent_from_node : n->parent_from_node) * m;
        return m;
    };
    for (std::size_t k = 0; k <= std::size_t(shutter_segments()); ++k) keys.push_back(world_at(k));
    return stand_still(keys, world_at({})) ? std::vector<Mat4d>() : keys;
}

}  // namespace occam
