#include "accel/items.h"

#include <algorithm>
#include <bit>

#include "accel/stopwatch.h"
#include "lod/level_choice.h"
#include "scenegraph/base/hash.h"

namespace occam::accel {
namespace {

constexpr float kBoxUlps = 4;      // what boxes of items are grown by: two for rounding them, two for the culling rule
constexpr int kMaxSceneDepth = 256;

// Rough costs of meeting an item, in steps of the tree: for the surface area heuristic alone.
float cost_of_blocks(int blocks) { return 3.0f + 0.25f * float(blocks); }
float cost_of_faces(std::uint32_t faces) { return 3.0f + float(faces) * 0.5f; }

}  // namespace

Items::Items(const FrameState& frame, Arena& arena, lod::Dicer& dicer, TraceCounters& counters)
    : frame_(frame), arena_(arena), dicer_(dicer), counters_(counters), builder_(dicer), items_(arena)
{
}

ItemIndex Items::restart()
{
    items_.clear();
    const Scene& scene = *frame_.scene;
    PlacedNode* root = arena_.make<PlacedNode>();
    *root = {scene.root(), scene.node(scene.root()).parent_from_node, kFnvStart, nullptr, 0};
    Item item;
    item.box = frame_.bounds;
    item.subject = root;
    items_.push_back(item);
    return 0;
}

Box3f Items::to_tree(const lod::PosedCage& cage, const Box3f& box) const
{
    const Vec3d shift = cage.anchor - frame_.anchor;
    return outward_float({Vec3d(box.lo) + shift, Vec3d(box.hi) + shift}, Vec3d(0), kBoxUlps);
}

Box3f Items::box_of(const lod::PosedCage& cage, const Box3f& object_box) const
{
    const Box3d box = transform_box(cage.world_from_object(), {Vec3d(object_box.lo), Vec3d(object_box.hi)});
    return outward_float(box, frame_.anchor, kBoxUlps);
}

void Items::open(ItemIndex i)
{
    if (items_[i].first_part != Item::kClosed) return;
    const Item item = items_[i];
    const auto first = static_cast<std::uint32_t>(items_.size());
    switch (item.kind) {
        case Item::SceneNode: open_node(*static_cast<const PlacedNode*>(item.subject)); break;
        case Item::Cluster: open_cluster(item.cage(), item.index); break;
        default: open_patch(item.cage(), *item.tiles); break;
    }
    items_[i].first_part = first;
    items_[i].part_count = static_cast<std::uint32_t>(items_.size()) - first;
}

void Items::add_cage(const PlacedNode& at, const Node& node, CageId id, std::size_t place)
{
    const CageSlot* slot = frame_.scene->find(id);
    if (!slot || slot->cage.face_count() == 0 || slot->bounds.is_empty()) return;
    const lod::CageTables& tables = frame_.topologies->get(*slot);
    lod::PosedCage& cage = *arena_.make<lod::PosedCage>();
    cage.slot = slot;
    cage.topology = tables.topology.get();
    cage.clusters = tables.clusters.get();
    cage.node = &node;
    cage.node_id = at.id;
    cage.key = mix_bits(at.key + place + 1);
    cage.place(at.world_from_node, slot->bounds);
    if (cage.topology) cage.level = lod::choose_level(frame_.levels, cage);
    Item item;
    item.kind = Item::Cluster;
    item.subject = &cage;
    item.box = box_of(cage, cage.clusters->node(0).box);
    item.cost = cost_of_faces(static_cast<std::uint32_t>(slot->cage.face_count()));
    if (!item.box.is_empty()) items_.push_back(item);
}

void Items::open_node(const PlacedNode& at)
{
    const Node* node = frame_.scene->find(at.id);
    if (!node) return;
    for (std::size_t c = 0; c < node->cages.size(); ++c) add_cage(at, *node, node->cages[c], c);
    if (at.depth == kMaxSceneDepth) return;
    const auto add = [&](NodeId id, const Mat4d& world, std::uint64_t place) {
        const Node* below = frame_.scene->find(id);
        if (!below || below->bounds.is_empty()) return;
        PlacedNode* placed = arena_.make<PlacedNode>();
        *placed = {id, world, mix_bits(at.key ^ mix_bits(place)), &at, at.depth + 1};
        const Box3d box = transform_box(world, below->bounds);
        Item item;
        item.subject = placed;
        item.box = outward_float(box, frame_.anchor, kBoxUlps);
        item.cost = 8;
        items_.push_back(item);
    };
    for (const NodeId child : node->children) {
        const Node* below = frame_.scene->find(child);
        if (below && below->visible) add(child, at.world_from_node * below->parent_from_node, child.slot);
    }
    if (node->instance_of) add(node->instance_of, at.world_from_node, ~std::uint64_t(0) - node->instance_of.slot);
}

void Items::open_cluster(const lod::PosedCage& cage, std::uint32_t cluster)
{
    const lod::ClusterTree::Node& node = cage.clusters->node(cluster);
    if (node.left != 0) {
        for (const std::uint32_t child : {node.left, node.left + 1}) {
            const auto& below = cage.clusters->node(child);
            Item item;
            item.kind = Item::Cluster;
            item.subject = &cage;
            item.index = child;
            item.box = box_of(cage, below.box);
            item.cost = cost_of_faces(below.end - below.begin);
            if (!item.box.is_empty()) items_.push_back(item);
        }
        return;
    }
    counters_.faces_touched += node.end - node.begin;
    if (!cage.topology) {
        Item item;
        item.kind = Item::Faces;
        item.subject = &cage;
        item.index = cluster;
        item.box = box_of(cage, node.box);
        item.cost = cost_of_blocks(static_cast<int>(node.end - node.begin + 7) / 8);
        items_.push_back(item);
        return;
    }
    small_.clear();
    Box3f small_box;
    int small_quads = 0;
    for (std::uint32_t k = node.begin; k < node.end; ++k) {
        const std::uint32_t face = cage.clusters->face(k);
        if (!cage.topology->is_seen(face)) continue;
        for (std::uint32_t sub = 0; sub < cage.topology->patches_of(face); ++sub) {
            const lod::PatchRef patch{face, sub};
            const lod::PatchRates rates = dicer_.rates(cage, patch);
            const lod::TileRef whole{patch, rates, 0, 0, static_cast<std::uint16_t>(1 << rates.u), static_cast<std::uint16_t>(1 << rates.v)};
            if (rates.u + rates.v > IGridBuilder::kSmallExponent) {
                add_patch_part(cage, whole);
                continue;
            }
            small_.push_back(whole);
            small_box.add(dicer_.bounds(cage, whole));
            small_quads += whole.columns * whole.rows;
        }
    }
    // A part's number has 15 bits in an igrid's ids; n-gons of thousands of corners make several soups.
    constexpr std::size_t kMaxParts = 1024;
    for (std::size_t first = 0; first < small_.size(); first += kMaxParts) {
        const std::size_t count = std::min(kMaxParts, small_.size() - first);
        const std::span<lod::TileRef> tiles = arena_.make_array<lod::TileRef>(count);
        std::copy_n(small_.begin() + static_cast<std::ptrdiff_t>(first), count, tiles.begin());
        Item item;
        item.kind = Item::SmallPatches;
        item.subject = &cage;
        item.tiles = tiles.data();
        item.index = static_cast<std::uint32_t>(count);
        item.box = to_tree(cage, small_box);
        item.cost = cost_of_blocks(small_quads / 4 + 1);
        items_.push_back(item);
    }
}

void Items::add_patch_part(const lod::PosedCage& cage, const lod::TileRef& part)
{
    const bool is_tile = part.columns <= lod::TileRef::kMaxSide && part.rows <= lod::TileRef::kMaxSide;
    Item item;
    item.kind = is_tile ? Item::Tile : Item::Patch;
    item.subject = &cage;
    item.tiles = arena_.make<lod::TileRef>(part);
    item.index = 1;
    item.box = to_tree(cage, dicer_.bounds(cage, part));
    const int quads = part.columns * part.rows;
    item.cost = is_tile ? cost_of_blocks(quads / 8) : 4.0f * float(std::bit_width(unsigned(quads) / 128));
    items_.push_back(item);
}

void Items::open_patch(const lod::PosedCage& cage, const lod::TileRef& part)
{
    // Sides that are too long are halved.
    const auto halves = [](std::uint16_t side) { return side > lod::TileRef::kMaxSide ? 2 : 1; };
    const int across = halves(part.columns), down = halves(part.rows);
    for (int j = 0; j < down; ++j)
        for (int i = 0; i < across; ++i) {
            lod::TileRef piece = part;
            piece.columns = static_cast<std::uint16_t>(part.columns / across);
            piece.rows = static_cast<std::uint16_t>(part.rows / down);
            piece.i0 = static_cast<std::uint16_t>(part.i0 + i * piece.columns);
            piece.j0 = static_cast<std::uint16_t>(part.j0 + j * piece.rows);
            add_patch_part(cage, piece);
        }
}

IGrid& Items::grid(ItemIndex i)
{
    if (items_[i].grid) return *items_[i].grid;
    const Stopwatch watch(counters_.dice_seconds);
    const Item item = items_[i];
    const std::uint64_t before = builder_.micropolygons;
    IGrid* grid = nullptr;
    switch (item.kind) {
        case Item::Tile: grid = builder_.build_tile(item.cage(), *item.tiles, arena_); break;
        case Item::SmallPatches: grid = builder_.build_patches(item.cage(), {item.tiles, item.index}, arena_); break;
        default: {
            const auto& node = item.cage().clusters->node(item.index);
            std::uint32_t faces[lod::ClusterTree::kLeafFaces];
            for (std::uint32_t k = node.begin; k < node.end; ++k) faces[k - node.begin] = item.cage().clusters->face(k);
            grid = builder_.build_triangles(item.cage(), {faces, node.end - node.begin}, arena_);
        }
    }
    ++counters_.grids;
    const std::uint64_t made = builder_.micropolygons - before;
    counters_.micropolygons += made;
    counters_.micropolygons_of_level[item.cage().level - TraceCounters::kFinestLevel] += made;
    items_[i].grid = grid;
    return *grid;
}

}  // namespace occam::accel
