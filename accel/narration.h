// Writes down what one ray does on its way through the scene, for people who look for a fault.
//
// The ray is traced by the templates that trace all rays (accel/run_rays.h). Where their query is an ObservedNearest, they
// call the functions below at each step; for all other queries these calls are not compiled.
//
// Space    Everything is written in world units: positions in world axes, and all intervals as the ray's own t.
#pragma once

#include <cstdint>
#include <map>
#include <ostream>
#include <span>
#include <type_traits>
#include <vector>

#include "accel/keyed_boxes.h"
#include "accel/queries.h"
#include "accel/ray_lanes.h"
#include "base/print.h"

namespace occam::accel {

/// A hit that the kernel found in an igrid.
struct OfferedHit {
    std::uint32_t id;
    float t;
    bool is_hole;  ///< the surface has a hole there, so the ray goes on
    bool is_back;  ///< the ray goes on because it comes from behind, and the frame hides this back
};

/// Describes a ray at an igrid that it was tested against.
struct RayAtGrid {
    const GridHit& like;  ///< has the igrid, and the ray's blend and time there; its hit does not count
    const RayLanes& ray;  ///< the same ray in all lanes
    const vfloat (&direction)[3];
    float t_near, t_end;  ///< hits have to lie in (t_near, t_end]
};

class Narration {
public:
    /// The stream and the frame are borrowed.
    Narration(std::ostream& out, const FrameState& frame);

    /// Says which intervals the following functions get: t of the tree plus this is t of the ray.
    void set_shift(float shift) noexcept { shift_ = shift; }
    void scene_missed();
    /// Writes one line for each pair of levels that the ray may see, with its interval and its blend.
    void levels(lod::RayLevels<float>& levels);
    void one_level_for_all();
    /// Writes that the ray enters a node, and the interval in which it is there.
    void node(std::uint64_t node, bool is_interior, float in, float out);
    /// Writes the box of an entry of a leaf.
    /// in, out   the part of the ray inside of the box; empty if the ray misses it
    void box(const TreeLeaf::Entry& entry, const Box3f& box, float in, float out, bool crosses_slab);
    void tested_before(const IGrid& grid);
    void hidden(const IGrid& grid);
    /// Writes what the kernel found in an igrid: the triangles that were hit, and those that were missed by least.
    void igrid(const RayAtGrid& at, std::span<const OfferedHit> offered, float nearest);

private:
    int number_of(std::uint64_t node);
    double world(float frame_length) const noexcept;
    double ray_t(float tree_t) const noexcept { return world(tree_t + shift_); }
    void name(const IGrid& grid);

    std::ostream& out_;
    const Precision digits_;
    double to_world_;
    int exponent_;  ///< a level of the frame is that many levels coarser in the world
    Vec3d anchor_;
    float shift_ = 0;
    std::map<std::uint64_t, int> numbers_;  ///< of nodes, in the order in which the ray enters them
};

/// Holds the nearest hit so far, counts what it costs, and tells a narration, unless that is null.
struct ObservedNearest : Nearest {
    Narration* narration = nullptr;
    RayCost cost;
    std::vector<OfferedHit> offered;  ///< by the igrid that is being tested

    void offer(int lane, float found, IGrid& on, std::uint32_t number)
    {
        if (narration) {
            const bool passes = is_hole(lane, found, on, number),
                       from_behind = passes && passes_back(*holes, lane, found, on, number);
            offered.push_back({number, found, passes && !from_behind, from_behind});
        }
        Nearest::offer(lane, found, on, number);
    }
    void tested(int triangles) noexcept { cost.tests += static_cast<std::uint64_t>(triangles); }
    void enters_igrid() noexcept
    {
        offered.clear();
        ++cost.igrids;
    }
    void skips_igrid(const IGrid& skipped, bool is_tested)
    {
        if (narration && is_tested) narration->tested_before(skipped);
        else if (narration) narration->hidden(skipped);
    }
};
template <class Found>
inline constexpr bool kIsObserved = std::is_base_of_v<ObservedNearest, Found>;

/// Tells a narration what a single ray finds in a tree, and does at leaves what AtLeaf does without a narration.
template <class Tree, class Times, class Limit, class AtLeaf>
struct NarratedWalk {
    Narration& narration;
    Tree& tree;
    const TreeRay<float>& ray;
    const Times& times;
    const PairSpans<float>& pairs;
    float begin;  ///< where the ray enters the scene
    const Limit& limit;
    const AtLeaf& at_leaf;

    template <class NodeOf>
    void enters(NodeOf node, bool is_interior, float in, float out) const
    {
        // A lazy node is written when it is known whether it is a leaf.
        if (is_interior) write(node, true, in, out);
    }

    template <class NodeOf>
    void write(NodeOf node, bool is_interior, float in, float out) const
    {
        if constexpr (std::is_pointer_v<NodeOf>)
            narration.node(reinterpret_cast<std::uintptr_t>(node), is_interior, in, out);
        else narration.node(node, is_interior, in, out);
    }

    template <class NodeOf>
    LeafResult operator()(NodeOf node, bool alive, float near, float far, int finest, int coarsest) const
    {
        for (int pair = finest; pair <= coarsest; ++pair) {
            if (finest < coarsest && !(std::max(near, pairs.in(pair, pair)) <= std::min(far, pairs.out(pair, pair))))
                continue;
            const TreeLeaf* leaf = tree.leaf(node, pair);
            if (!leaf) return LeafResult::Expanded;
            write(node, false, near, far);
            for (std::size_t k = 0; k < leaf->entries.size(); ++k) box_of(*leaf, k);
            pair = std::max(pair, std::min(leaf->pairs.coarsest, coarsest));
        }
        return at_leaf(node, alive, near, far, finest, coarsest);
    }

private:
    void box_of(const TreeLeaf& leaf, std::size_t k) const
    {
        const TreeLeaf::Entry& entry = leaf.entries[k];
        const bool is_known = read_published(entry.grid) != nullptr;
        float in = begin, out = limit();
        Box3f box = is_known ? entry.bounds.box : get_box(leaf.boxes, k, leaf.keys.row);
        if constexpr (Times::kMoves)
            if (leaf.keys.segments > 0) {
                const KeyedBoxes<float, true> group(leaf.boxes + k / kBoxGroup * kBoxGroupFloats, leaf.stride(), leaf.keys,
                                                    times);
                const int place = static_cast<int>(k % kBoxGroup);
                group.clip_to(ray, place, in, out);
                if (!is_known) return narration.box(entry, group.box(place), in, out, true);
            }
        clip(ray, box, in, out);
        narration.box(entry, box, in, out, !is_known || !(in <= out) || crosses(ray, entry.bounds.slab, in, out));
    }
};
// Clang 14 deduces no arguments of aggregates.
template <class Tree, class Times, class Limit, class AtLeaf>
NarratedWalk(Narration&, Tree&, const TreeRay<float>&, const Times&, const PairSpans<float>&, float, const Limit&,
             const AtLeaf&) -> NarratedWalk<Tree, Times, Limit, AtLeaf>;

}  // namespace occam::accel
