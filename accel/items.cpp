#include "accel/items.h"

#include <algorithm>
#include <limits>

#include "accel/phase_one.h"
#include "base/cancellation.h"
#include "base/stopwatch.h"
#include "lod/hit_filter.h"

namespace occam::accel {
namespace {

constexpr std::uint32_t kMostAskedFor = 4;  // patches of a face whose classes are requested ahead
constexpr std::size_t kMaxParts = 1024;     // most parts of an igrid; n-gons of thousands of corners never share one

// These are rough costs of intersecting an item, in steps of the tree. Only the surface area heuristic uses them.
float cost_of_blocks(int blocks) { return 3.0f + 0.25f * float(blocks); }
// Faces that are not opened yet cost more than the items that they become, so that planes separate them from visible ones.
float cost_of_faces(std::uint32_t faces) { return 3.0f + float(faces) * 4.0f; }
constexpr float kCostOfRegion = 10;

/// Returns the level from which on a patch has few enough quads to share an igrid with its neighbours.
int small_from(const lod::PatchScale& scale)
{
    const auto exponent = [&](int level) { return scale.inside(0, level) + scale.inside(1, level); };
    if (exponent(lod::kCoarsestLevel) > LatticeBuilder::kSmallExponent) return Item::kNever;
    // Both sides are halved from level to level, so the sum of the exponents falls by two.
    int level = std::clamp((scale.k[0] + scale.k[1] - LatticeBuilder::kSmallExponent) / 2 - 1, lod::kFinestLevel,
                           lod::kCoarsestLevel);
    while (exponent(level) > LatticeBuilder::kSmallExponent) ++level;
    return level;
}

std::int8_t level_bound(int level) { return static_cast<std::int8_t>(std::clamp<int>(level, Item::kAlways, Item::kNever)); }

// Returns a pair up to which the region consists of whole quads, and in which the pieces of the patch's sides that it
// touches are no longer than it is. A region is needed up to the pair at which the larger one around it is one tile, and
// has to hold there: so sides that are much shorter than the patch are left out, and those of a region around which the
// larger one is a tile at no pair.
int pair_of_whole_pieces(const lod::PatchScale& scale, const lod::PatchRegion& region) noexcept
{
    constexpr int kTile = lod::TileRef::kSideExponent, kMostBelow = kTile - 2;
    int level = Item::kNever + 1;
    const int depth[2] = {region.du, region.dv};
    const std::uint32_t at[2] = {region.iu, region.iv};
    for (int axis : {0, 1}) {
        const int d = depth[axis];
        const int least = scale.inside(axis, lod::kCoarsestLevel);
        if (d > least) level = std::min(level, scale.k[axis] - d);
        if (least - (d - 1) > kTile) continue;
        // Sides 0 and 2 lie along u, where v is 0 and 1; sides 1 and 3 along v, where u is 1 and 0.
        const int first = axis == 0 ? 0 : 3, second = axis == 0 ? 2 : 1, other = 1 - axis;
        for (const int side : {first, second}) {
            const bool touches = side == first ? at[other] == 0 : at[other] + 1 == 1u << depth[other];
            const int k = scale.side_k[std::size_t(side)];
            if (touches && d > scale.side_least[std::size_t(side)] && k >= scale.k[axis] - kMostBelow)
                level = std::min(level, k - d);
        }
    }
    return level - 1;
}

/// This range holds for faces that do not change from level to level.
constexpr PairRange kAllPairs{lod::kFinestLevel, lod::kCoarsestLevel};

}  // namespace

Items::Items(const FrameState& frame, Arena& arena, lod::Dicer& dicer, TraceCounters& counters, bool splits_in_space)
    : frame_(frame),
      arena_(arena),
      dicer_(dicer),
      counters_(counters),
      lattices_(dicer),
      meshes_(splits_in_space),
      items_(arena),
      grids_(arena)
{
}

std::vector<ItemIndex> Items::base_patches()
{
    std::vector<ItemIndex> list;
    for (ItemIndex i = 0; i < items_.size(); ++i) {
        const Item::Kind kind = items_[i].kind;
        if (kind == Item::Region || kind == Item::Faces || !open(i, lod::kFinestLevel)) list.push_back(i);
    }
    return list;
}

bool Items::open(ItemIndex i, int pair)
{
    if (items_[i].first_part != Item::kClosed) return true;
    throw_if_cancelled();
    if (items_[i].kind == Item::Leaf && !items_[i].cluster) {
        measure(i);
        if (is_final(i, pair)) return false;
    }
    const Item item = items_[i];
    const auto first = static_cast<std::uint32_t>(items_.size());
    switch (item.kind) {
        case Item::SceneNode:
            open_node(*static_cast<const PlacedNode*>(item.subject));
            break;
        case Item::Children:
            open_children(*static_cast<const PlacedNode*>(item.subject), item.index);
            break;
        case Item::Unmade: {
            const PlacedNode& at = *static_cast<const PlacedNode*>(item.subject);
            const Node& node = *frame_.scene->find(at.id);
            add_cage(at, node, node.cages[item.index], item.index);
            break;
        }
        case Item::Cluster:
            open_cluster(item.cage(), item.index);
            break;
        case Item::Leaf:
            for (const PatchInfo& patch : item.cluster->patches)
                add_region(item.cage(), item.cluster, patch, {patch.ref, 0, 0, 0, 0});
            break;
        case Item::Region:
            open_region(item);
            break;
        case Item::Faces:
            break;  // final for all pairs
    }
    items_[i].first_part = first;
    items_[i].part_count = static_cast<std::uint32_t>(items_.size()) - first;
    return true;
}

void Items::add_cluster(const lod::PosedCage& cage, std::uint32_t cluster)
{
    const lod::ClusterTree::Node& node = cage.clusters->node(cluster);
    Item item;
    item.kind = node.left != 0 ? Item::Cluster : cage.topology ? Item::Leaf : Item::Faces;
    item.subject = &cage;
    item.index = cluster;
    set_boxes_at_keys(item, cage, [&](int key) { return box_of(cage.at_key(key), cluster); });
    item.cost = cost_of_faces(node.end - node.begin);
    if (item.kind == Item::Faces) {
        item.cost = cost_of_blocks(static_cast<int>(node.end - node.begin + 7) / 8);
        item.final_from = Item::kAlways;
        counters_.faces_touched += node.end - node.begin;
    }
    if (!item.box.is_empty()) items_.push_back(item);
}

void Items::open_cluster(const lod::PosedCage& cage, std::uint32_t cluster)
{
    const std::uint32_t left = cage.clusters->node(cluster).left;
    add_cluster(cage, left);
    add_cluster(cage, left + 1);
}

void Items::measure(ItemIndex leaf)
{
    const lod::PosedCage& cage = items_[leaf].cage();
    const lod::ClusterTree::Node& node = cage.clusters->node(items_[leaf].index);
    counters_.faces_touched += node.end - node.begin;
    std::size_t count = 0;
    for (std::uint32_t k = node.begin; k < node.end; ++k) {
        const std::uint32_t face = cage.clusters->face(k);
        if (!cage.topology->is_seen(face)) continue;
        const std::uint32_t subs = cage.topology->patches_of(face);
        for (std::uint32_t sub = 0; sub < std::min(subs, kMostAskedFor); ++sub) lod::Dicer::ask_for(cage, {face, sub});
        count += subs;
    }
    ClusterInfo& info = *arena_.make<ClusterInfo>();
    info.patches = arena_.make_array<PatchInfo>(count);
    std::size_t n = 0;
    int quads = 0;
    Box3f boxes[lod::kMostSegments + 1];
    for (std::uint32_t k = node.begin; k < node.end; ++k) {
        const std::uint32_t face = cage.clusters->face(k);
        for (std::uint32_t sub = 0; cage.topology->is_seen(face) && sub < cage.topology->patches_of(face); ++sub) {
            PatchInfo& patch = info.patches[n++];
            patch.ref = {face, sub};
            patch.scale = dicer_.scale(cage, patch.ref);
            set_bounds(patch, cage, boxes);
            info.same_from = std::max(info.same_from, patch.scale.coarsest());
            info.small_from = std::max(info.small_from, small_from(patch.scale));
            quads += 1 << LatticeBuilder::kSmallExponent;
        }
    }
    Item& item = items_[leaf];
    item.cluster = &info;
    item.final_from = count > kMaxParts ? Item::kNever : level_bound(info.small_from);
    item.cost = cost_of_blocks(quads / 4 + 1);
    if (count > 0) set_boxes_at_keys(item, cage, [&](int key) { return to_tree(cage, key, boxes[key]); });
}

void Items::set_bounds(PatchInfo& patch, const lod::PosedCage& cage, Box3f* all)
{
    set_boxes_at_keys(patch, cage, [&](int key) {
        const Box3f box = dicer_.bounds(cage.at_key(key), patch.scale, {patch.ref, 0, 0, 0, 0}, lod::kCoarsestLevel);
        all[key].add(box);
        return to_tree(cage, key, box);
    });
}

void Items::add_region(const lod::PosedCage& cage, ClusterInfo* cluster, const PatchInfo& patch,
                       const lod::PatchRegion& region)
{
    const lod::PatchScale& scale = patch.scale;
    Item item;
    item.kind = Item::Region;
    item.subject = &cage;
    item.cluster = cluster;
    item.patch = &patch;
    item.region = region;
    item.cost = kCostOfRegion;
    // The region is one tile from the level on at which neither of its sides has more quads than a tile.
    int from = lod::kFinestLevel - 1;
    const int depth[2] = {region.du, region.dv};
    for (int axis : {0, 1})
        if (scale.inside(axis, lod::kCoarsestLevel) - depth[axis] > lod::TileRef::kSideExponent) from = Item::kNever;
        else from = std::max(from, scale.k[axis] - depth[axis] - lod::TileRef::kSideExponent);
    item.final_from = level_bound(from <= cage.finest_level() ? Item::kAlways : from);
    const bool is_one_level = frame_.levels.mode == lod::LevelMode::PerInstance;
    const int holds_to = is_one_level ? Item::kNever : pair_of_whole_pieces(scale, region),
              coarsest = is_one_level ? std::max(cage.level, cage.finest_level())
                                      : std::min(holds_to + 1, lod::kCoarsestLevel);
    item.holds_to = level_bound(holds_to);
    if (region.du == 0 && region.dv == 0) static_cast<ShutterBox&>(item) = patch;
    else
        set_boxes_at_keys(item, cage, [&](int key) {
            return to_tree(cage, key, dicer_.bounds(cage.at_key(key), scale, region, coarsest));
        });
    items_.push_back(item);
}

void Items::open_region(const Item& item)
{
    // The longer side is halved, or both are, so that regions are about as wide as high.
    const lod::PatchRegion& r = item.region;
    const int u = item.patch->scale.k[0] - r.du, v = item.patch->scale.k[1] - r.dv;
    const int across = u >= v ? 2 : 1, down = v >= u ? 2 : 1;
    for (std::uint32_t j = 0; j < std::uint32_t(down); ++j)
        for (std::uint32_t i = 0; i < std::uint32_t(across); ++i)
            add_region(item.cage(), item.cluster, *item.patch,
                       {r.patch, r.iu * across + i, r.iv * down + j, r.du + across - 1, r.dv + down - 1});
}

/// Returns whether the item's patch, or all patches of its cluster, are in the one igrid of the cluster.
bool Items::shares(const Item& item, int pair) const noexcept
{
    return item.kind == Item::Leaf || (may_share(item) && pair >= item.cluster->small_from);
}
bool Items::may_share(const Item& item) const noexcept
{
    return item.kind == Item::Region && item.cluster->patches.size() <= kMaxParts;
}

PairRange Items::range(ItemIndex i, int pair) const noexcept
{
    const Item& item = items_[i];
    if (item.kind == Item::Faces || frame_.levels.mode == lod::LevelMode::PerInstance) return kAllPairs;
    const int finest = item.cage().finest_level();
    if (pair < finest) {
        // Up to the finest level all is the same, but the patches of a cluster may have one igrid or several.
        const bool may_be_one = item.kind == Item::Leaf || may_share(item);
        const int small = may_be_one ? item.cluster->small_from : lod::kFinestLevel;
        return pair >= small ? PairRange{small, finest - 1} : PairRange{lod::kFinestLevel, std::min(small, finest) - 1};
    }
    if (shares(item, pair)) {
        const int same = item.cluster->same_from;
        return pair >= same ? PairRange{std::max(same, finest), lod::kCoarsestLevel} : PairRange{pair, pair};
    }
    // At coarser pairs than `last` the patch is in the cluster's igrid instead.
    const int same = item.patch->scale.coarsest(),
              last = may_share(item) ? item.cluster->small_from - 1 : lod::kCoarsestLevel;
    return pair >= same ? PairRange{std::max(same, finest), last} : PairRange{pair, pair};
}

// An igrid that serves several pairs has one level, whichever of them asked for it first.
int Items::level_of(const Item& item, PairRange pairs) const noexcept
{
    if (item.kind == Item::Faces) return 0;
    if (frame_.levels.mode == lod::LevelMode::PerInstance) return std::max(item.cage().level, item.cage().finest_level());
    return std::max(pairs.finest, item.cage().finest_level());
}

IGrid& Items::grid(ItemIndex i, int pair)
{
    const Item& item = items_[i];
    const PairRange pairs = range(i, pair);
    const int level = level_of(item, pairs);
    const bool is_shared = shares(item, pair_of(item, pair));
    GridKey key{&item, pairs.finest, 0, 0};
    lod::TileRef tile;
    if (is_shared) {
        key.subject = item.cluster;
    } else if (item.kind == Item::Region) {
        // Finds the tile that holds the region.
        const lod::PatchRates rates = item.patch->scale.rates(level);
        const auto first = [](std::uint32_t n, int rate, int depth) {
            return rate >= depth ? n << (rate - depth) : n >> (depth - rate);
        };
        tile = lod::Dicer::tile(item.patch->ref, item.patch->scale, level, first(item.region.iu, rates.u, item.region.du),
                                first(item.region.iv, rates.v, item.region.dv));
        key = {item.patch, pairs.finest, tile.i0, tile.j0};
    }
    IGrid*& grid = grids_[key];
    if (!grid) {
        const Stopwatch watch(counters_.dice_seconds);
        const auto micropolygons = [&] { return lattices_.micropolygons + meshes_.micropolygons; };
        const std::uint64_t before = micropolygons();
        grid = build(item, {item.cage().diced(), pairs, level, may_have_holes(item, is_shared)}, is_shared, tile);
        ++counters_.grids;
        const std::uint64_t made = micropolygons() - before;
        counters_.micropolygons += made;
        if (item.kind == Item::Faces) return *grid;
        counters_.diced += made;
        counters_.micropolygons_of_level[std::clamp(level, lod::kFinestLevel, lod::kCoarsestLevel) -
                                         TraceCounters::kFinestLevel] += made;
    }
    return *grid;
}

bool Items::may_have_holes(const Item& item, bool is_shared) const noexcept
{
    const lod::HitFilter* const filter = frame_.shading.filter;
    if (!filter) return false;
    const lod::PosedCage& cage = item.cage();
    const auto is_passed = [&](std::uint32_t face) {
        const Material& material = *material_of(*frame_.scene, cage, face);
        return material.alpha_mode == AlphaMode::Mask || filter->hides_back(material);
    };
    if (item.kind == Item::Faces)
        return std::ranges::any_of(cage.clusters->faces(cage.clusters->node(item.index)), is_passed);
    if (!is_shared) return is_passed(item.patch->ref.face);
    return std::ranges::any_of(item.cluster->patches, is_passed, [](const PatchInfo& patch) { return patch.ref.face; });
}

IGrid* Items::build(const Item& item, const GridSubject& of, bool is_shared, const lod::TileRef& tile)
{
    if (item.kind == Item::Faces) {
        const std::span<const std::uint32_t> faces = of.cage.clusters->faces(of.cage.clusters->node(item.index));
        return meshes_.build(of, faces, common_material(*frame_.scene, of.cage, faces), arena_);
    }
    const bool is_one_level = frame_.levels.mode == lod::LevelMode::PerInstance || of.pairs.coarsest < of.level;
    const int coarser = is_one_level ? of.level : of.level + 1;
    parts_.clear();
    if (is_shared)
        for (const PatchInfo& patch : item.cluster->patches)
            parts_.push_back({lod::Dicer::tile(patch.ref, patch.scale, of.level, 0, 0), patch.scale.rates(coarser)});
    else parts_.push_back({tile, item.patch->scale.rates(coarser)});
    return lattices_.build(of, parts_, arena_);
}

}  // namespace occam::accel
