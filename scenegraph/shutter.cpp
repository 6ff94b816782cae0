#include "scenegraph/shutter.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <span>
#include <unordered_map>
#include <unordered_set>

#include "scenegraph/posed_faces.h"
#include "scenegraph/shown_nodes.h"

namespace occam {
namespace {

// A placement, and its matrices at all keys if it or what is above it moves.
struct Place {
    NodeId id;
    std::vector<Mat4d> world_keys;
    Mat4d world_from_node;

    const Mat4d& at(std::size_t key) const noexcept { return world_keys.empty() ? world_from_node : world_keys[key]; }
};

template <class Visit>
void for_each_corner(const Box3d& box, Visit&& visit)
{
    if (box.is_empty()) return;
    for (int c = 0; c < 8; ++c)
        visit(Vec3d(c & 1 ? box.hi.x : box.lo.x, c & 2 ? box.hi.y : box.lo.y, c & 4 ? box.hi.z : box.lo.z));
}

// Vectors that are added to points, and the matrices that move them at all keys.
struct Offsets {
    Box3d box;
    std::vector<Mat4d> frames;
};

// A key within a segment, between the keys at its ends.
struct Segment {
    std::size_t key, first, last;
    template <class Values>
    auto chord(const Values& at) const
    {
        const double share = double(key - first) / double(last - first);
        return at[first] + (at[last] - at[first]) * share;
    }
};

// Finds the fewest segments that all paths shown to it allow.
class SegmentCount {
public:
    SegmentCount(int most, const PathTolerance& tolerance) : most_(std::size_t(most)), tolerance_(tolerance) {}
    std::size_t most() const noexcept { return most_; }
    int needed() const noexcept { return static_cast<int>(needed_); }
    bool is_decided() const noexcept { return needed_ == most_; }

    /// Takes a path: its position at each key.
    void add_path(const std::vector<Vec3d>& at)
    {
        // A path that strays with few segments may stray no more, and less, with more of them.
        while (needed_ < most_ &&
               any_key([&](const Segment& s) { return glm::distance(at[s.key], s.chord(at)) > allowed(s, at[s.key]); }))
            needed_ *= 2;
    }
    /// Takes the points of a box that moves by a matrix at each key, plus one vector of each of the other boxes, which moves
    /// by a matrix of its own.
    void add_box(const std::vector<Mat4d>& frames, const Box3d& box, std::span<const Offsets> offsets)
    {
        const auto off = [&](const std::vector<Mat4d>& at, const Segment& s) { return at[s.key] - s.chord(at); };
        while (needed_ < most_ && any_key([&](const Segment& s) {
                   double added = 0;
                   for (const Offsets& of : offsets) {
                       double longest = 0;
                       for_each_corner(of.box, [&, m = Mat3d(off(of.frames, s))](Vec3d p) {
                           longest = std::max(longest, glm::length(m * p));
                       });
                       added += longest;
                   }
                   bool is_far = false;
                   for_each_corner(box, [&, m = off(frames, s)](Vec3d p) {
                       is_far |= glm::length(transform_vector(m, p) + Vec3d(m[3])) + added >
                                 allowed(s, transform_point(frames[s.key], p));
                   });
                   return is_far;
               }))
            needed_ *= 2;
    }
    /// Takes the normal of a face: what it is at each key.
    void add_normals(const std::vector<Vec3d>& at)
    {
        while (needed_ < most_ && any_key([&](const Segment& s) { return !is_near_normal(s.chord(at), at[s.key]); }))
            needed_ *= 2;
    }
    /// Takes the visibility of a node, which changes only at the keys of segments.
    void add_visibility(const std::vector<NodeKey>& keys)
    {
        while (needed_ < most_ && any_key([&](const Segment& s) { return keys[s.key].visible != keys[s.first].visible; }))
            needed_ *= 2;
    }

private:
    /// Returns whether a key within one of the segments that are needed so far has a property.
    template <class Has>
    bool any_key(Has&& has) const
    {
        const std::size_t step = most_ / needed_;
        for (std::size_t key = 0; key < most_; ++key)
            if (key % step != 0 && has(Segment{key, key / step * step, key / step * step + step})) return true;
        return false;
    }

    /// Returns how far a point may be from its path at the key.
    double allowed(const Segment& s, Vec3d point) const noexcept
    {
        return tolerance_.at(point, double(s.key) / double(most_));
    }

    std::size_t most_, needed_ = 1;
    PathTolerance tolerance_;
};

// Shows the normals of a cage whose vertices move against each other, but for those of triangles, which are not
// interpolated. Of a displaced cage it shows the paths of points at both ends of what displacement may add. They go with the
// normal, which turns even if vertices move along straight lines.
//
// position_at   returns a vertex at a key
template <class PositionAt>
void add_normals(SegmentCount& count, const Place& place, const Cage& cage, PositionAt&& position_at)
{
    if (cage.scheme == Scheme::Triangles) return;
    std::vector<Vec3d> normals(count.most() + 1), out(normals), in(normals);
    for (const FaceVertices face : some_faces(cage)) {
        if (count.is_decided()) return;
        for (std::size_t k = 0; k < normals.size(); ++k)
            normals[k] = face_normal(face, [&](std::uint32_t v) { return position_at(k, v); });
        count.add_normals(normals);
        if (!cage.is_displaced()) continue;
        for (std::size_t k = 0; k < normals.size(); ++k) {
            const Vec3d offset = normals[k] * double(cage.displacement->bound), at = position_at(k, face[0]);
            out[k] = transform_point(place.at(k), at + offset);
            in[k] = transform_point(place.at(k), at - offset);
        }
        count.add_path(out);
        count.add_path(in);
    }
}

// Shows the paths of a cage that nothing deforms.
void add_rigid_cage(SegmentCount& count, const Place& place, const CageSlot& slot)
{
    if (!place.world_keys.empty()) count.add_box(place.world_keys, slot.bounds, {});
    if (slot.key_positions.empty()) return;
    std::vector<Vec3d> path(count.most() + 1);
    for (std::size_t v = 0; v < slot.cage.positions.size() && !count.is_decided(); ++v) {
        for (std::size_t k = 0; k < path.size(); ++k)
            path[k] = transform_point(place.at(k), Vec3d(slot.key_positions[k][v]));
        count.add_path(path);
    }
    add_normals(count, place, slot.cage, [&](std::size_t k, std::uint32_t v) { return Vec3d(slot.key_positions[k][v]); });
}

// The morph targets of a placed cage.
struct Morphs {
    std::vector<std::size_t> moving;           ///< those whose weights change
    std::vector<std::vector<double>> weights;  ///< of each of them, at each key
    Box3d still{Vec3d(0), Vec3d(0)};           ///< what the others add to a vertex
    std::vector<std::span<const float>> all;   ///< the weights of all targets, at each key

    Morphs(const Node& node, const CageSlot& slot, std::size_t keys)
    {
        const std::span<const Box3f> offsets = slot.deform[0].offsets;
        for (std::size_t k = 0; k < keys; ++k) {
            const std::vector<float>& own = node.keys.empty() ? node.morph_weights : node.keys[k].morph_weights;
            all.push_back(own.empty() ? slot.cage.morph_weights : own);
        }
        std::vector<float> constant(offsets.size(), 0);
        for (std::size_t m = 0; m < offsets.size(); ++m) {
            std::vector<double> at(keys);
            for (std::size_t k = 0; k < keys; ++k) at[k] = m < all[k].size() ? double(all[k][m]) : 0.0;
            if (std::adjacent_find(at.begin(), at.end(), std::not_equal_to<>()) == at.end()) {
                constant[m] = static_cast<float>(at[0]);
            } else if (!offsets[m].is_empty()) {
                moving.push_back(m);
                weights.push_back(std::move(at));
            }
        }
        still = morph_extent(offsets, constant);
    }
};

// Shows the paths of a placed cage that joints or morph targets may deform.
void add_deformed_cage(SegmentCount& count, const Place& place, const Node& node, const CageSlot& slot, const SkinSlot* skin)
{
    const bool is_skinned = skin && slot.cage.skin.sets > 0;
    const bool moves = !place.world_keys.empty() || !node.keys.empty() || (skin && !skin->key_poses.empty());
    if (!moves) return;
    const std::size_t keys = count.most() + 1;
    const Morphs morphs(node, slot, keys);
    const auto frame = [&](std::size_t k, std::size_t joint) {
        if (!is_skinned) return place.at(k);
        const Mat4d& from_skin = node.keys.empty() ? node.node_from_skin : node.keys[k].node_from_skin;
        const std::vector<Mat4d>& poses = skin->key_poses.empty() ? skin->mesh_poses : skin->key_poses[k];
        return joint < poses.size() ? place.at(k) * from_skin * poses[joint] : place.at(k) * from_skin;
    };
    const auto add_box = [&](const Box3f& box, std::size_t joint) {
        std::vector<Mat4d> frames;
        for (std::size_t k = 0; k < keys; ++k) frames.push_back(frame(k, joint));
        std::vector<Offsets> offsets;
        for (std::size_t m = 0; m < morphs.moving.size(); ++m) {
            const Box3f& of = slot.deform[0].offsets[morphs.moving[m]];
            offsets.push_back({{Vec3d(of.lo), Vec3d(of.hi)}, frames});
            for (std::size_t k = 0; k < keys; ++k) offsets.back().frames[k] *= morphs.weights[m][k];
        }
        const Vec3d off(slot.cage.is_displaced() ? double(slot.cage.displacement->bound) : 0.0);
        const Box3d moved{Vec3d(box.lo) + morphs.still.lo - off, Vec3d(box.hi) + morphs.still.hi + off};
        count.add_box(frames, moved, offsets);
    };
    const DeformBounds deform = slot.deform[0];
    if (!is_skinned) {
        add_box(deform.rest, 0);
        if (morphs.moving.empty()) return;
        return add_normals(count, place, slot.cage, [&](std::size_t k, std::uint32_t v) {
            return morphed(slot.cage, slot.cage.positions, morphs.all[k], v);
        });
    }
    for (const JointBox& joint : deform.joints)
        if (!count.is_decided()) add_box(joint.box, joint.joint);
}

bool moves_by_itself(const Scene& scene, const Node& node)
{
    const SkinSlot* skin = scene.find(node.skin);
    bool moves = skin && !skin->key_poses.empty();
    for (const CageId cage : node.cages)
        if (const CageSlot* slot = scene.find(cage)) moves |= !slot->key_positions.empty();
    return moves;
}

}  // namespace

int needed_segments(const Scene& scene, const PathTolerance& tolerance)
{
    const int most = scene.shutter_segments();
    if (most == 0) return 0;
    SegmentCount count(most, tolerance);
    const Holders holders(scene);
    std::unordered_map<NodeId, int> placements;
    int in_all = 0;
    // A node waits without its matrices, since a group may have very many children.
    struct Waiting {
        NodeId id;
        std::shared_ptr<const Place> above;
        bool is_instance;
    };
    std::vector<Waiting> todo;
    const auto push_child = [&](const std::shared_ptr<const Place>& above, NodeId id) {
        const Node* node = scene.find(id);
        const bool moves = node && (!above->world_keys.empty() || holders.may_hold(*node, Contents::Moving));
        if (!moves || !node->is_visible_in_shutter() || (!node->dirty && node->bounds.is_empty())) return;
        if (!node->keys.empty()) count.add_visibility(node->keys);
        todo.push_back({id, above, false});
    };
    const auto placed = [&](const Waiting& waiting) {
        const Place& above = *waiting.above;
        if (waiting.is_instance) return Place{waiting.id, above.world_keys, above.world_from_node};
        const Node& node = scene.node(waiting.id);
        Place place{waiting.id, {}, above.world_from_node * node.parent_from_node};
        for (std::size_t k = 0; k <= std::size_t(most) && !(above.world_keys.empty() && node.keys.empty()); ++k)
            place.world_keys.push_back(above.at(k) *
                                       (node.keys.empty() ? node.parent_from_node : node.keys[k].parent_from_node));
        return place;
    };
    push_child(std::make_shared<const Place>(Place{{}, {}, Mat4d(1)}), scene.root());
    while (!todo.empty() && !count.is_decided()) {
        const Waiting waiting = std::move(todo.back());
        todo.pop_back();
        if (++placements[waiting.id] > kMostPlacements && in_all >= kMostPlacementsInAll) continue;
        ++in_all;
        const auto shared = std::make_shared<const Place>(placed(waiting));
        const Place& place = *shared;
        const Node& node = scene.node(place.id);
        for (const CageId id : node.cages) {
            const CageSlot* slot = scene.find(id);
            if (slot && slot->is_deformed()) add_deformed_cage(count, place, node, *slot, scene.find(node.skin));
            else if (slot) add_rigid_cage(count, place, *slot);
        }
        const bool all_move = !place.world_keys.empty();
        holders.for_each_child(place.id, all_move ? 0 : Contents::Moving, [&](NodeId child) { push_child(shared, child); });
        const Node* shown = scene.find(node.instance_of);
        if (shown && (all_move || holders.may_hold(*shown, Contents::Moving)))
            todo.push_back({node.instance_of, shared, true});
    }
    return count.needed();
}

std::unordered_set<NodeId> moving_nodes(const Scene& scene, Contents::Kinds kinds)
{
    std::unordered_set<NodeId> moving;
    if (scene.shutter_segments() == 0) return moving;
    const Holders holders(scene);
    struct Step {
        NodeId id;
        bool moves;
    };
    std::vector<Step> todo;
    std::unordered_set<NodeId> still;
    const auto push = [&](NodeId id, bool moves_above) {
        const Node* node = scene.find(id);
        if (!node || !holders.may_hold(*node, kinds)) return;
        const bool moves = moves_above || !node->keys.empty();
        if (moves || holders.may_hold(*node, Contents::Moving)) todo.push_back({id, moves});
    };
    push(scene.root(), false);
    while (!todo.empty()) {
        const Step step = todo.back();
        todo.pop_back();
        // A node that was found to move has been followed already, and a still one only once for placements that are still.
        if (moving.contains(step.id) || (!step.moves && still.contains(step.id))) continue;
        (step.moves ? moving : still).insert(step.id);
        holders.for_each_child(step.id, step.moves ? kinds : Contents::Kinds(Contents::Moving),
                               [&](NodeId child) { push(child, step.moves); });
        push(scene.node(step.id).instance_of, step.moves);
    }
    for (const NodeId id : still) {
        const Node& node = scene.node(id);
        if (moves_by_itself(scene, node)) moving.insert(id);
    }
    return moving;
}

}  // namespace occam
