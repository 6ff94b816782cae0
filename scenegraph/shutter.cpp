#include "scenegraph/shutter.h"

#include <cmath>
#include <unordered_map>

namespace occam {
namespace {

// A placement, and its matrices at all keys if it or what is above it moves.
struct Place {
    NodeId id;
    std::vector<Mat4d> world_keys;
    Mat4d world_from_node;

    const Mat4d& at(std::size_t key) const noexcept { return world_keys.empty() ? world_from_node : world_keys[key]; }
};

double longest_axis(const Mat4d& m) noexcept
{
    return std::sqrt(std::max(
        {glm::dot(Vec3d(m[0]), Vec3d(m[0])), glm::dot(Vec3d(m[1]), Vec3d(m[1])), glm::dot(Vec3d(m[2]), Vec3d(m[2]))}));
}

template <class Visit>
void for_each_corner(const Box3d& box, Visit&& visit)
{
    if (box.is_empty()) return;
    for (int c = 0; c < 8; ++c)
        visit(Vec3d(c & 1 ? box.hi.x : box.lo.x, c & 2 ? box.hi.y : box.lo.y, c & 4 ? box.hi.z : box.lo.z));
}

// Finds the fewest segments that all paths shown to it allow.
class SegmentCount {
public:
    SegmentCount(int most, const PathTolerance& tolerance) : most_(std::size_t(most)), tolerance_(tolerance) {}
    std::size_t most() const noexcept { return most_; }
    int needed() const noexcept { return static_cast<int>(needed_); }
    bool is_decided() const noexcept { return needed_ == most_; }

    /// Takes a path: its position at each key.
    template <class At>
    void add_path(At&& at)
    {
        // A path that strays with few segments may stray no more, and less, with more of them.
        while (needed_ < most_ && strays<Vec3d>(at, [&](std::size_t key, double d) { return d > tolerance_.at(at(key)); }))
            needed_ *= 2;
    }
    /// Takes a number that changes: a change of 1 moves points near `where` by at most `reach`.
    template <class At>
    void add_number(At&& at, double reach, Vec3d where)
    {
        const double allowed = tolerance_.at(where);
        while (needed_ < most_ && strays<double>(at, [&](std::size_t, double d) { return d * reach > allowed; }))
            needed_ *= 2;
    }

private:
    static double length(Vec3d v) noexcept { return glm::length(v); }
    static double length(double v) noexcept { return std::abs(v); }

    template <class Value, class At, class IsFar>
    bool strays(At&& at, IsFar&& is_far) const
    {
        const std::size_t step = most_ / needed_;
        for (std::size_t first = 0; first < most_; first += step) {
            const Value from = at(first), to = at(first + step);
            for (std::size_t k = 1; k < step; ++k) {
                const Value chord = from + (to - from) * (double(k) / double(step));
                if (is_far(first + k, length(at(first + k) - chord))) return true;
            }
        }
        return false;
    }

    std::size_t most_, needed_ = 1;
    PathTolerance tolerance_;
};

// Shows the paths of a placed cage.
void add_cage(SegmentCount& count, const Place& place, const Node& node, const CageSlot& slot, const SkinSlot* skin)
{
    const auto key_of = [&](std::size_t k) { return node.keys.empty() ? nullptr : &node.keys[k]; };
    if (!slot.is_deformed()) {
        for_each_corner(slot.bounds, [&](Vec3d p) {
            if (!place.world_keys.empty()) count.add_path([&](std::size_t k) { return transform_point(place.at(k), p); });
        });
        if (slot.key_positions.empty()) return;
        for (std::size_t v = 0; v < slot.cage.positions.size() && !count.is_decided(); ++v)
            count.add_path([&](std::size_t k) { return transform_point(place.at(k), Vec3d(slot.key_positions[k][v])); });
        return;
    }
    const DeformBounds deform = slot.deform[0];
    const bool is_skinned = skin && slot.cage.skin.sets > 0;
    const bool moves = !place.world_keys.empty() || !node.keys.empty() || (skin && !skin->key_poses.empty());
    if (!moves) return;
    const auto frame = [&](std::size_t k, std::size_t joint) {
        if (!is_skinned) return place.at(k);
        const Mat4d& from_skin = key_of(k) ? key_of(k)->node_from_skin : node.node_from_skin;
        const std::vector<Mat4d>& poses = skin->key_poses.empty() ? skin->mesh_poses : skin->key_poses[k];
        return joint < poses.size() ? place.at(k) * from_skin * poses[joint] : place.at(k) * from_skin;
    };
    const auto add_box = [&](const Box3f& box, std::size_t joint) {
        std::vector<Mat4d> frames;
        for (std::size_t k = 0; k <= count.most(); ++k) frames.push_back(frame(k, joint));
        for_each_corner({Vec3d(box.lo), Vec3d(box.hi)},
                        [&](Vec3d p) { count.add_path([&](std::size_t k) { return transform_point(frames[k], p); }); });
    };
    if (is_skinned)
        for (const JointBox& joint : deform.joints) add_box(joint.box, joint.joint);
    else add_box(deform.rest, 0);
    if (node.keys.empty()) return;
    const Vec3d middle = transform_point(place.at(0), Vec3d(deform.rest.centre()));
    for (std::size_t m = 0; m < deform.offsets.size(); ++m) {
        const auto weight = [&](std::size_t k) {
            const std::vector<float>& own = node.keys[k].morph_weights.empty() ? slot.cage.morph_weights
                                                                               : node.keys[k].morph_weights;
            return m < own.size() ? double(own[m]) : 0.0;
        };
        const Box3f& offset = deform.offsets[m];
        if (offset.is_empty()) continue;
        const Vec3d reach = glm::max(glm::abs(Vec3d(offset.lo)), glm::abs(Vec3d(offset.hi)));
        count.add_number(weight, glm::length(reach) * longest_axis(place.at(0)), middle);
    }
}

}  // namespace

int needed_segments(const Scene& scene, const PathTolerance& tolerance)
{
    const int most = scene.shutter_segments();
    if (most == 0) return 0;
    SegmentCount count(most, tolerance);
    const auto place_below = [&](const Place& above, NodeId id, const Node& node) {
        Place place{id, {}, above.world_from_node * node.parent_from_node};
        if (above.world_keys.empty() && node.keys.empty()) return place;
        for (std::size_t k = 0; k <= std::size_t(most); ++k)
            place.world_keys.push_back(above.at(k) *
                                       (node.keys.empty() ? node.parent_from_node : node.keys[k].parent_from_node));
        return place;
    };
    const Node& root = scene.node(scene.root());
    std::unordered_map<NodeId, int> placements;
    std::vector<Place> todo;
    if (root.is_visible_in_shutter()) todo.push_back(place_below({{}, {}, Mat4d(1)}, scene.root(), root));
    while (!todo.empty() && !count.is_decided()) {
        const Place place = std::move(todo.back());
        todo.pop_back();
        if (++placements[place.id] > kMostPlacements) continue;
        const Node& node = scene.node(place.id);
        for (const CageId id : node.cages)
            if (const CageSlot* slot = scene.find(id)) add_cage(count, place, node, *slot, scene.find(node.skin));
        for (const NodeId child : node.children)
            if (const Node* c = scene.find(child); c && c->is_visible_in_shutter())
                todo.push_back(place_below(place, child, *c));
        if (scene.find(node.instance_of)) todo.push_back({node.instance_of, place.world_keys, place.world_from_node});
    }
    return count.needed();
}

std::unordered_set<NodeId> moving_nodes(const Scene& scene)
{
    std::unordered_set<NodeId> moving;
    if (scene.shutter_segments() == 0) return moving;
    struct Step {
        NodeId id;
        bool moves;
    };
    std::vector<Step> todo{{scene.root(), !scene.node(scene.root()).keys.empty()}};
    std::unordered_set<NodeId> still;
    while (!todo.empty()) {
        const Step step = todo.back();
        todo.pop_back();
        // A node that was found to move has been followed already, and a still one only once for placements that are still.
        if (moving.contains(step.id) || (!step.moves && still.contains(step.id))) continue;
        (step.moves ? moving : still).insert(step.id);
        const Node& node = scene.node(step.id);
        for (const NodeId child : node.children)
            if (const Node* c = scene.find(child)) todo.push_back({child, step.moves || !c->keys.empty()});
        if (scene.find(node.instance_of)) todo.push_back({node.instance_of, step.moves});
    }
    for (const NodeId id : still) {
        const Node& node = scene.node(id);
        const SkinSlot* skin = scene.find(node.skin);
        bool moves = skin && !skin->key_poses.empty();
        for (const CageId cage : node.cages)
            if (const CageSlot* slot = scene.find(cage)) moves |= !slot->key_positions.empty();
        if (moves) moving.insert(id);
    }
    return moving;
}

}  // namespace occam
