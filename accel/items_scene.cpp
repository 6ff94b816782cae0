// Opens the nodes of the scene graph: what they show, placed and posed for one frame.
#include <unordered_map>

#include "accel/items.h"
#include "accel/placement.h"
#include "base/hash.h"
#include "lod/cage_motion.h"
#include "lod/pose_cage.h"
#include "scenegraph/child_boxes.h"
#include "scenegraph/content_rules.h"

namespace occam::accel {
namespace {

constexpr float kCostOfNode = 8;
constexpr float kCostOfUnmade = 1000;  // cost of a cage that is not made yet, in steps of the tree

}  // namespace

ItemIndex Items::restart()
{
    items_.clear();
    grids_.clear();
    const Scene& scene = *frame_.scene;
    PlacedNode* root = arena_.make<PlacedNode>();
    const Node& top = scene.node(scene.root());
    *root = {scene.root(), frame_.scale.placed(top.parent_from_node), {}, nullptr, {}, top.seen_by, top.lit_by};
    const PlacedNode world{{}, frame_.scale.placed(Mat4d(1)), {}, nullptr, {}, 0, 0};
    root->at_keys = child_at_keys(world, top);
    root->visible_in = visible_in(top, frame_.segments);
    Item item;
    item.box = frame_.bounds;
    item.subject = root;
    items_.push_back(item);
    return 0;
}

std::string Items::name_of(ItemIndex i) const
{
    const Item& item = items_[i];
    if (item.kind != Item::SceneNode && item.kind != Item::Children && item.kind != Item::Unmade) {
        const lod::PosedCage& cage = item.cage();
        return cage.node->name.empty() && !cage.slot->cage.name.empty() ? naming("cage", cage.slot->cage.name)
                                                                        : naming(*cage.node);
    }
    // Instances often have no name of their own.
    const PlacedNode* at = static_cast<const PlacedNode*>(item.subject);
    while (at->parent && frame_.scene->find(at->id)->name.empty()) at = at->parent;
    return naming(*frame_.scene->find(at->id));
}

std::string Items::name_of_largest() const
{
    std::unordered_map<const void*, std::size_t> counts;
    ItemIndex largest = 0;
    std::size_t most = 0;
    for (ItemIndex i = 0; i < items_.size(); ++i)
        if (const std::size_t count = ++counts[items_[i].subject]; count > most) most = count, largest = i;
    return items_.size() > 0 ? name_of(largest) : std::string();
}

void Items::set_box_of_node(Item& item, const PlacedNode& at, const Box3d& bounds)
{
    Box3d at_keys[lod::kMostSegments + 1], all;
    std::size_t count = 0;
    for (const Mat4d& world_from_node : at.matrices()) all.add(at_keys[count++] = transform_box(world_from_node, bounds));
    // Cages below may move along chords of fewer segments, and be that far from where the keys of the scene have them.
    const double off = count > 1 && !all.is_empty() ? lod::largest_motion_tolerance(frame_.levels, all) : 0;
    Box3f own[lod::kMostSegments + 1];
    for (std::size_t k = 0; k < count; ++k) own[k] = to_tree(at_keys[k], vertex_rounding(at_keys[k]) + off);
    set_boxes(item, {own, count});
}

std::span<const Mat4d> Items::child_at_keys(const PlacedNode& parent, const Node& child)
{
    const auto count = static_cast<std::size_t>(frame_.segments) + 1;
    const bool moves = frame_.segments > 0 && (!parent.at_keys.empty() || moves_in_parent(child));
    if (!moves) return {};
    const std::span<Mat4d> matrices = arena_.make_array<Mat4d>(count);
    for (std::size_t k = 0; k < count; ++k)
        matrices[k] = (parent.at_keys.empty() ? parent.world_from_node : parent.at_keys[k]) *
                      (child.keys.empty() ? child.parent_from_node : child.keys[k].parent_from_node);
    return matrices;
}

void Items::add_cage(const PlacedNode& at, const Node& node, CageId id, std::size_t place)
{
    const CageSlot* slot = frame_.scene->find(id);
    if (!slot || slot->bounds.is_empty() || (slot->cage.face_count() == 0 && !slot->is_on_demand())) return;
    const lod::CageTables& tables = frame_.topologies->get(*slot);
    if (tables.made) slot = tables.made.get();
    if (slot->cage.face_count() == 0) return;
    const lod::CagePlacement placement{*slot,         node,
                                       at.id,         frame_.scene->find(node.skin),
                                       at.matrices(), frame_.segments,
                                       at.seen_by,    at.lit_by,
                                       at.visible_in, at.path.to(lod::GraphPath::place_of_cage(place)),
                                       at.instance};
    lod::for_each_size(placement, frame_.levels, {tables, frame_.textures, arena_, counters_.deform},
                       [&](const lod::PosedCage& cage) { add_cluster(cage, 0); });
}

void Items::open_node(const PlacedNode& at)
{
    const Node* node = frame_.scene->find(at.id);
    if (!node) return;
    for (std::size_t c = 0; c < node->cages.size(); ++c) {
        const CageSlot* slot = frame_.scene->find(node->cages[c]);
        if (!slot || !slot->is_on_demand()) {
            add_cage(at, *node, node->cages[c], c);
            continue;
        }
        Item item;
        item.kind = Item::Unmade;
        item.subject = &at;
        item.index = static_cast<std::uint32_t>(c);
        set_box_of_node(item, at, slot->bounds);
        item.cost = kCostOfUnmade;
        if (!item.box.is_empty()) items_.push_back(item);
    }
    // The tree over many children is opened where rays go, so that a frame costs nothing for the other children.
    const ChildBoxes* boxes = frame_.scene->child_boxes(at.id);
    if (boxes && node->children.size() > ChildBoxes::kMostAtOnce) {
        add_children(at, *boxes, ChildBoxes::kRoot);
    } else {
        for (const NodeId child : node->children) add_child(at, child);
    }
    if (node->instance_of)
        add_placed(at, node->instance_of, {at.world_from_node, at.at_keys, at.visible_in}, lod::GraphPath::kPlaceOfInstance);
}

void Items::add_placed(const PlacedNode& parent, NodeId id, const Placement& placement, std::uint64_t place)
{
    const Node* below = frame_.scene->find(id);
    if (!below || below->bounds.is_empty()) return;
    PlacedNode* placed = arena_.make<PlacedNode>();
    *placed = {id,
               placement.world_from_node,
               parent.path.to(place),
               &parent,
               place == lod::GraphPath::kPlaceOfInstance ? parent.id : parent.instance,
               static_cast<std::uint8_t>(parent.seen_by & below->seen_by),
               parent.lit_by & below->lit_by,
               placement.at_keys,
               placement.visible_in};
    Item item;
    item.subject = placed;
    set_box_of_node(item, *placed, below->bounds);
    item.cost = kCostOfNode;
    items_.push_back(item);
}

void Items::add_child(const PlacedNode& parent, NodeId id)
{
    const Node* child = frame_.scene->find(id);
    const std::uint32_t seen_in = child ? parent.visible_in & visible_in(*child, frame_.segments) : 0;
    if (seen_in == 0) return;
    add_placed(parent, id, {parent.world_from_node * child->parent_from_node, child_at_keys(parent, *child), seen_in},
               lod::GraphPath::place_of_child(child->place_among_siblings));
}

void Items::add_children(const PlacedNode& parent, const ChildBoxes& boxes, std::uint32_t at)
{
    if (boxes.box(at).is_empty()) return;
    Item item;
    item.kind = Item::Children;
    item.subject = &parent;
    item.index = at;
    set_box_of_node(item, parent, boxes.box(at));
    item.cost = kCostOfNode * static_cast<float>(boxes.blocks_below(at) * ChildBoxes::kBlock);
    items_.push_back(item);
}

void Items::open_children(const PlacedNode& parent, std::uint32_t at)
{
    const ChildBoxes& boxes = *frame_.scene->child_boxes(parent.id);
    if (!boxes.is_block(at)) {
        add_children(parent, boxes, 2 * at);
        add_children(parent, boxes, 2 * at + 1);
        return;
    }
    const Node& node = *frame_.scene->find(parent.id);
    for (const std::uint32_t child : boxes.children(at)) add_child(parent, node.children[child]);
}

}  // namespace occam::accel
