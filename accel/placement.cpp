#include "accel/placement.h"

#include <algorithm>
#include <vector>

#include "base/cancellation.h"
#include "lod/posed_cage.h"

namespace occam::accel {

std::uint32_t visible_in(const Node& node, int segments) noexcept
{
    if (segments == 0 || node.keys.empty()) return node.visible ? lod::PosedCage::kAllSegments : 0;
    std::uint32_t seen = 0;
    for (int k = 0; k < segments; ++k)
        if (node.keys[static_cast<std::size_t>(k)].visible) seen |= 1u << k;
    const std::uint32_t all = segments == lod::kMostSegments ? ~0u : (1u << segments) - 1;
    return seen == all ? lod::PosedCage::kAllSegments : seen;
}

bool moves_in_parent(const Node& node) noexcept
{
    return std::any_of(node.keys.begin(), node.keys.end(),
                       [&](const NodeKey& key) { return key.parent_from_node != node.parent_from_node; });
}

namespace {

// Opens the graph as far as it has few nodes. The children of the others count by their boxes as a whole, and where even
// these are many, the box of all of them does. What it visits follows from the graph alone, so the box does not depend on
// how the scene came to be.
class DicedBounds {
public:
    explicit DicedBounds(const Scene& scene) noexcept : scene_(scene) {}

    /// Returns the box of a placed node in its parent's axes.
    Box3d placed(NodeId id, const Node& node, int depth)
    {
        const Box3d own = below(id, node, depth);
        if (own.is_empty()) return own;
        if (node.keys.empty()) return transform_box(node.parent_from_node, own);
        Box3d box;
        for (const NodeKey& key : node.keys) box.add(transform_box(key.parent_from_node, own));
        return box;
    }

private:
    static constexpr std::size_t kMostVisits = 4096, kMostBoxes = 65536;
    static constexpr int kMostDepth = 64;

    /// Returns the box of what a node shows, in its own axes.
    Box3d below(NodeId id, const Node& node, int depth)
    {
        if (!node.contents.has(Contents::Subdivided)) return {};
        const std::size_t children = scene_.child_count(id);
        const bool opens = depth < kMostDepth && children < visits_left_;
        std::size_t& left = opens ? visits_left_ : boxes_left_;
        if (children >= left) return node.bounds;
        left -= children + 1;
        Box3d box;
        for (const CageId cage : node.cages)
            if (const CageSlot* slot = scene_.find(cage);
                slot && (slot->is_on_demand() || slot->cage.scheme != Scheme::Triangles))
                box.add(cage_bounds(node, *slot, scene_.find(node.skin)));
        for (const NodeId child : node.children)
            if (const Node* there = scene_.find(child); there && there->contents.has(Contents::Subdivided))
                box.add(!opens                           ? box_in_parent(*there)
                        : there->is_visible_in_shutter() ? placed(child, *there, depth + 1)
                                                         : Box3d());
        if (const Node* shown = scene_.find(node.instance_of); shown && shown->contents.has(Contents::Subdivided))
            box.add(opens ? below(node.instance_of, *shown, depth + 1) : shown->bounds);
        return box;
    }

    const Scene& scene_;
    std::size_t visits_left_ = kMostVisits, boxes_left_ = kMostBoxes;
};

}  // namespace

Box3d bounds_of_diced(const Scene& scene)
{
    const Node& root = scene.node(scene.root());
    return root.is_visible_in_shutter() ? DicedBounds(scene).placed(scene.root(), root, 0) : Box3d();
}

void for_each_placement(const Scene& scene, Contents::Kinds kinds,
                        const std::function<void(const Node&, std::span<const Mat4d>)>& visit)
{
    const auto holds = [&](const Node* node) { return node && (kinds == 0 || node->contents.has(kinds)); };
    struct Place {
        NodeId id;
        std::vector<Mat4d> world_from_node;
        std::uint32_t seen;
    };
    const int segments = scene.shutter_segments();
    const auto below = [&](const Place& parent, NodeId id, const Node& child) {
        Place place{id, parent.world_from_node, parent.seen & visible_in(child, segments)};
        if (segments > 0 && moves_in_parent(child)) {
            place.world_from_node.resize(static_cast<std::size_t>(segments) + 1, parent.world_from_node.front());
            for (std::size_t k = 0; k < place.world_from_node.size(); ++k)
                place.world_from_node[k] = place.world_from_node[k] * child.keys[k].parent_from_node;
        } else {
            for (Mat4d& world : place.world_from_node) world = world * child.parent_from_node;
        }
        return place;
    };
    std::vector<Place> todo;
    std::size_t visits = 0;
    const Place world{{}, {Mat4d(1)}, lod::PosedCage::kAllSegments};
    todo.push_back(below(world, scene.root(), scene.node(scene.root())));
    while (!todo.empty()) {
        throw_if_cancelled();
        const Place place = std::move(todo.back());
        todo.pop_back();
        if (place.seen == 0) continue;
        const Node& node = scene.node(place.id);
        if (++visits > kMostListed) throw too_many_placements(node);
        visit(node, place.world_from_node);
        for (const NodeId child : node.children)
            if (const Node* there = scene.find(child); holds(there)) todo.push_back(below(place, child, *there));
        if (holds(scene.find(node.instance_of))) todo.push_back({node.instance_of, place.world_from_node, place.seen});
    }
}

}  // namespace occam::accel
