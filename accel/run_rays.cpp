// Sends packets of rays and single rays through the tree.
#include <bit>
#include <cstddef>

#include "accel/moving_igrid.h"
#include "accel/narration.h"
#include "accel/tracer_state.h"
#include "base/cancellation.h"

namespace occam::accel {
namespace {

/// The number of a leaf's entries that are met between two looks at the request to stop.
constexpr std::size_t kEntriesBetweenChecks = 1024;

}  // namespace

template <int kParts>
bool Tracer::State::fits_packet(std::span<const Ray> rays, const vmasks<kParts>& enters, const vfloats<kParts>& t_in,
                                const vfloats<kParts>& t_out) noexcept
{
    const std::size_t n = rays.size();
    // A ray that misses the scene gets the table of one that does not, so that it asks for no additional pairs.
    const auto one = static_cast<std::size_t>(std::countr_zero(bits(enters)));
    Reach reach[kParts * kLanes]{};
    for (std::size_t i = 0; i < n; ++i) reach[i] = reach_of(rays[bits(enters) >> i & 1 ? i : one]);
    vfloats<kParts> of[4];
    gather_four(reach, n, 0, of);
    const auto of_one = [&](const vfloats<kParts>& x) {
        float lanes[kParts * kLanes];
        x.store(lanes);
        return vfloats<kParts>(lanes[one]);
    };
    return packet_levels<kParts>().set({of[0], of[1], of[3]}, select(enters, t_in, of_one(t_in)),
                                       select(enters, t_out, of_one(t_out)), of[2], frame.levels);
}

/// Returns the times of rays, in the lanes of `Times`.
template <class Times>
Times times_of(std::span<const Ray> rays) noexcept
{
    if constexpr (!Times::kMoves) return {};
    else {
        using F = typename Times::Lanes;
        if constexpr (std::is_same_v<F, float>) return Times(rays.front().time);
        else {
            alignas(32) float time[sizeof(F) / sizeof(float)];
            for (std::size_t i = 0; i < std::size(time); ++i) time[i] = rays[std::min(i, rays.size() - 1)].time;
            return Times(F::load(time));
        }
    }
}

/// Eight boxes of a leaf that start with an entry, which stand still or move.
template <class F, class Times>
class LeafGroup {
public:
    /// has_boxes_of_nodes   whether the rays were tested against the box around the leaf
    LeafGroup(const TreeLeaf& leaf, std::size_t first, const Times& times, bool has_boxes_of_nodes) noexcept
        : leaf_(leaf),
          boxes_(leaf.boxes + first / kBoxGroup * kBoxGroupFloats),
          times_(times),
          is_tested_(has_boxes_of_nodes && leaf.entries.size() == 1)
    {
    }

    OCCAM_ALWAYS_INLINE unsigned in_boxes(const RaysAsOne<F>& as_one, float end, float* begin) const noexcept
    {
        if (is_tested_) {
            if (begin) begin[0] = -FLT_MAX;
            return 1;
        }
        if constexpr (Times::kMoves)
            if (leaf_.keys.segments > 0) return keyed().in_boxes(as_one, end, begin);
        return as_one.in_boxes(boxes_, end, begin);
    }
    /// Returns which rays enter a box of the group, and the bounds of its igrid, which is null if it is not made.
    template <class Enter>
    OCCAM_ALWAYS_INLINE MaskOf<F> enter(Enter&& enter, int box, const F& far, const TreeLeaf::Entry* made) const noexcept
    {
        if constexpr (Times::kMoves)
            if (leaf_.keys.segments > 0) {
                const MaskOf<F> inside = is_tested_ ? MaskOf<F>(true) : enter(Moving{keyed(), box}, far);
                return made ? inside & enter(made->bounds, far) : inside;
            }
        return made ? enter(made->bounds, far) : enter(GridBounds{get_box(boxes_ + box, 0), {}}, far);
    }

private:
    /// A box as it is at each ray's own time.
    struct Moving {
        KeyedBoxes<F> group;
        int box;
        void clip_to(const TreeRay<F>& ray, F& t_near, F& t_far) const noexcept { group.clip_to(ray, box, t_near, t_far); }
    };
    auto keyed() const noexcept { return KeyedBoxes<F>(boxes_, leaf_.stride(), leaf_.keys, times_); }

    const TreeLeaf& leaf_;
    const float* boxes_;
    const Times& times_;
    const bool is_tested_;
};

/// Intersects rays with the igrids that a node holds for the pairs [finest, coarsest]. enter(bounds, far) returns which rays
/// are inside the bounds somewhere before far, which is limit(). meet(leaf, number, pair, rays) intersects these rays with
/// the igrid of an entry, and returns false if the budget is exceeded.
template <class Tree, class NodeOf, class F, class Times, class Limit, class Enter, class Meet>
OCCAM_ALWAYS_INLINE LeafResult Tracer::State::meet_leaf(Tree& tree, NodeOf node, MaskOf<F> alive, F t_near, F t_far,
                                                        const PairSpans<F>& pairs, int finest, int coarsest,
                                                        std::size_t memory_bytes, const RaysAsOne<F>& as_one,
                                                        const Times& times, Limit&& limit, Enter&& enter, Meet&& meet)
{
    TreeLeaf& latest = tree.latest_leaf(node);
    const auto is_one = [&] { return finest == coarsest || (latest.pairs.has(finest) && latest.pairs.has(coarsest)); };
    if (!is_one()) pairs.narrow(alive, t_near, t_far, finest, coarsest);
    for (int pair = finest; pair <= coarsest; ++pair) {
        MaskOf<F> here = alive;
        if (!is_one()) here = alive & (max(t_near, pairs.in(pair, pair)) <= min(t_far, pairs.out(pair, pair)));
        if (none(here)) continue;
        TreeLeaf* leaf = latest.pairs.has(pair) ? &latest : tree.leaf(node, pair);
        if (!leaf) return LeafResult::Expanded;
        // A leaf that is the same for several pairs is tested once for all of them.
        const int last = std::min(leaf->pairs.coarsest, coarsest);
        if (pair == finest && last == coarsest) here = alive;
        else if (last > pair) here = alive & (max(t_near, pairs.in(pair, last)) <= min(t_far, pairs.out(pair, last)));
        F far = limit();
        for (std::size_t first = 0; first < leaf->entries.size(); first += kBoxGroup) {
            if (first % kEntriesBetweenChecks == kEntriesBetweenChecks - kBoxGroup) throw_if_cancelled();
            alignas(32) float begin[kBoxGroup];
            constexpr bool kIsOne = std::is_same_v<F, float>;
            const LeafGroup<F, Times> group(*leaf, first, times, std::is_same_v<Tree, Bvh>);
            unsigned maybe = group.in_boxes(as_one, highest(far), kIsOne ? begin : nullptr);
            while (maybe != 0) {
                int next = std::countr_zero(maybe);
                maybe &= maybe - 1;
                if constexpr (kIsOne) {
                    // A single ray is tested against the igrids in the order in which it enters them.
                    const int lowest_number = next;
                    for (unsigned others = maybe; others != 0; others &= others - 1)
                        if (const int other = std::countr_zero(others); begin[other] < begin[next]) next = other;
                    if (next != lowest_number) maybe ^= 1u << next | 1u << lowest_number;
                    if (!(begin[next] <= far)) break;
                }
                const std::size_t number = first + static_cast<std::size_t>(next);
                const TreeLeaf::Entry& entry = leaf->entries[number];
                const MaskOf<F> entering = here &
                                           group.enter(enter, next, far, read_published(entry.grid) ? &entry : nullptr);
                if (none(entering)) continue;
                if (!meet(*leaf, number, pair, entering)) return LeafResult::Abandoned;
                far = limit();
            }
        }
        pair = last;
    }
    return arena.bytes() <= memory_bytes ? LeafResult::Done : LeafResult::Abandoned;
}

template <class Way, int kParts, class Found>
Tracer::State::PacketResult Tracer::State::run_packet(std::span<const Ray> rays, const RayAxes& axes,
                                                      std::size_t memory_bytes, PacketQuery<Found, kParts>& query)
{
    using F = vfloats<kParts>;
    const std::size_t n = rays.size();
    TreeRay<F> kd;
    F start[4], shear[3], inverse[3], way[4];
    static_assert(offsetof(Ray, t_near) == offsetof(Ray, direction) + 3 * sizeof(float));
    gather_four(rays.data(), n, offsetof(Ray, direction), way);
    place_all(
        rays, way, [&](std::size_t) -> const FrameState& { return frame; }, start);
    set_shear(axes, way, shear);
    set_inverse(axes, way, inverse);
    /// Holds as many rays as there are lanes, in the frame of the cage whose igrid is being tested.
    struct HalfPacket {
        RayLanes lanes;
        RaysAsOne<vfloat> as_one;
        bool is_as_one_placed = false;
    };
    HalfPacket parts[kParts];
    for (int p = 0; p < kParts; ++p) {
        RayLanes& lanes = parts[p].lanes;
        lanes.kx = axes.kx;
        lanes.ky = axes.ky;
        lanes.kz = axes.kz;
        lanes.sx = shear[0].part[p];
        lanes.sy = shear[1].part[p];
        lanes.sz = shear[2].part[p];
        for (int a = 0; a < 3; ++a) lanes.inverse[a] = inverse[a].part[p];
    }
    kd.shift = start[3];
    for (int a = 0; a < 3; ++a) {
        kd.origin[a] = start[a];
        kd.inverse[a] = inverse[a];
        kd.negative[a] = axes.negative[a];
        kd.direction[a] = way[a];
    }
    const F t_near = way[3];
    F begin = t_near - kd.shift, end = query.limit() - kd.shift;
    begin = begin - (abs(t_near) + abs(kd.shift)) * F(4 * FLT_EPSILON);
    const auto limit = [&] { return query.limit() - kd.shift + (abs(query.limit()) + abs(kd.shift)) * F(4 * FLT_EPSILON); };
    clip(kd, frame.bounds, begin, end);

    const vmasks<kParts> enters = begin <= end;
    if (none(enters)) return PacketResult::Done;
    PairSpans<F> pairs{nullptr, kd.shift, 0, 0};
    if (frame.has_levels) {
        if (!fits_packet(rays, enters, kd.shift + begin, kd.shift + end)) return PacketResult::TooWide;
        lod::RayLevels<F>& levels = packet_levels<kParts>();
        pairs = {&levels, kd.shift, levels.finest, levels.coarsest};
    }

    const lod::PosedCage* here = nullptr;
    int blended = lod::kNoPair;
    ++visit;
    ++counters.packets;
    const RaysAsOne<F> as_one(kd, lowest(begin));
    const auto enter = [&](const auto& bounds, const F& far) __attribute__((always_inline))
    {
        F in = begin, out = far;
        if constexpr (!std::is_same_v<std::decay_t<decltype(bounds)>, GridBounds>) {
            bounds.clip_to(kd, in, out);
            return in <= out;
        } else {
            clip(kd, bounds.box, in, out);
            const vmasks<kParts> inside = in <= out;
            return none(inside) ? inside : inside & crosses(kd, bounds.slab, in, out);
        }
    };
    const auto meet = [&](const TreeLeaf& leaf, std::size_t number, int pair, vmasks<kParts> entering)
        __attribute__((always_inline))
    {
        IGrid* known = grid_of(leaf, number, pair, memory_bytes);
        if (!known) return false;
        IGrid& grid = *known;
        GridVisit& visited = mailboxes.of(grid);
        // An igrid that a ray enters in several cells is tested once.
        if (visited.packet != visit) visited = {visit, 0};
        if (grid.is_hidden) entering = entering & lanes_that_may_see<kParts>(rays, *grid.cage, frame.segments);
        const unsigned fresh = bits(entering) & ~visited.lanes;
        if (fresh == 0) return true;
        visited.lanes |= fresh;
        if (grid.cage != here) {
            here = grid.cage;
            blended = lod::kNoPair;
            F placed[4];
            place_all(
                rays, way, [&](std::size_t) -> const lod::PosedCage& { return *here; }, placed);
            for (int p = 0; p < kParts; ++p) {
                for (int a = 0; a < 3; ++a) parts[p].lanes.origin[a] = placed[a].part[p];
                parts[p].lanes.shift = placed[3].part[p];
                parts[p].is_as_one_placed = false;
            }
        }
        F from = t_near, to = FLT_MAX;
        if (pairs.levels && (!pairs.are_all_in(grid.pairs) || grid.blends())) {
            pairs.levels->make();
            from = max(from, pairs.levels->begin(grid.pairs.finest, grid.pairs.coarsest));
            to = pairs.levels->end(grid.pairs.finest, grid.pairs.coarsest);
            if (grid.blends() && blended != grid.pairs.finest) {
                blended = grid.pairs.finest;
                const lod::Blend<F> blend = pairs.levels->blend(blended);
                for (int p = 0; p < kParts; ++p) {
                    RayLanes& lanes = parts[p].lanes;
                    lanes.blend.set({blend.start.part[p], blend.scale.part[p]},
                                    {way[0].part[p], way[1].part[p], way[2].part[p]}, lanes.origin, lanes.shift);
                }
            }
        }
        for (int p = 0; p < kParts; ++p) {
            const unsigned of_part = fresh >> (p * kLanes) & ((1u << kLanes) - 1);
            if (of_part == 0) continue;
            HalfPacket& part = parts[p];
            PartOf<Found> some{query, p * kLanes};
            if (grid.segments > 0) {
                const std::size_t first = static_cast<std::size_t>(p) * kLanes;
                meet_moving(grid, {rays.subspan(first), part.lanes, kd.negative, {from.part[p], to.part[p]}}, of_part, some);
                continue;
            }
            if (std::popcount(of_part) >= kWorthAPacket) {
                IGridTracer(grid, part.lanes, kd.negative, {from.part[p], to.part[p]}, some)
                    .packet(entering.part[p], [&]() -> const RaysAsOne<vfloat>& {
                        if (!part.is_as_one_placed)
                            part.as_one = {part.lanes.origin, part.lanes.inverse, kd.negative, part.lanes.shift, -FLT_MAX};
                        part.is_as_one_placed = true;
                        return part.as_one;
                    });
                continue;
            }
            // Few rays are left: each is traced alone, with micropolygons in the lanes.
            for (unsigned left = of_part; left != 0; left &= left - 1) {
                const int lane = std::countr_zero(left);
                LaneOf<Found> one{some, lane};
                RayLanes ray = spread(part.lanes, lane);
                if (grid.blends()) ray.blend = spread(part.lanes.blend, lane);
                IGridTracer(grid, ray, kd.negative, {spread(from.part[p], lane), spread(to.part[p], lane)}, one)
                    .single(lane);
            }
        }
        return true;
    };
    auto& tree = lazy.tree<typename Way::Tree>();
    const auto times = times_of<typename Way::template Times<F>>(rays);
    const bool is_done = traverse(
        tree, kd, as_one, times, begin, end, pairs, counters, limit,
        [&](auto node, const vmasks<kParts>& alive, const F& near, const F& far, int finest, int coarsest) {
            return meet_leaf(tree, node, alive, near, far, pairs, finest, coarsest, memory_bytes, as_one, times, limit,
                             enter, meet);
        });
    return is_done ? PacketResult::Done : PacketResult::Abandoned;
}

template <class Way, class Found>
bool Tracer::State::run_single(const Ray& ray, const RayAxes& axes, std::size_t memory_bytes, SingleQuery<Found>& query)
{
    const PlacedOrigin start = place(ray, frame.anchor, frame.radius);
    TreeRay<float> kd;
    RayLanes lanes;
    vfloat direction[3];
    const float way[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
    float shear[3];
    set_shear(axes, way, shear);
    set_inverse(axes, way, kd.inverse);
    lanes.kx = axes.kx;
    lanes.ky = axes.ky;
    lanes.kz = axes.kz;
    lanes.sx = shear[0];
    lanes.sy = shear[1];
    lanes.sz = shear[2];
    kd.shift = start.shift;
    for (int a = 0; a < 3; ++a) {
        kd.origin[a] = start.origin[a];
        kd.negative[a] = axes.negative[a];
        lanes.inverse[a] = kd.inverse[a];
        kd.direction[a] = way[a];
        direction[a] = way[a];
    }
    const int lane = query.only;
    float begin = ray.t_near - kd.shift, end = query.t[lane] - kd.shift;
    begin = begin - (std::fabs(ray.t_near) + std::fabs(kd.shift)) * (4 * FLT_EPSILON);
    const auto limit = [&] {
        return query.t[lane] - kd.shift + (std::fabs(query.t[lane]) + std::fabs(kd.shift)) * (4 * FLT_EPSILON);
    };
    clip(kd, frame.bounds, begin, end);

    if constexpr (kIsObserved<Found>)
        if (query.narration) {
            query.narration->set_shift(kd.shift);
            if (!(begin <= end)) query.narration->scene_missed();
        }
    if (!(begin <= end)) return true;
    PairSpans<float> pairs{nullptr, kd.shift, 0, 0};
    if (frame.has_levels) {
        // A single ray has at most RayLevels::kMostOfRay pairs, for which the table always has room.
        const Reach reach = reach_of(ray);
        single_levels.set({reach.target_edge.a, reach.target_edge.b, reach.start}, kd.shift + begin, kd.shift + end,
                          reach.coordinate, frame.levels);
        pairs = {&single_levels, kd.shift, single_levels.finest, single_levels.coarsest};
    }
    if constexpr (kIsObserved<Found>)
        if (query.narration) {
            if (pairs.levels) query.narration->levels(single_levels);
            else query.narration->one_level_for_all();
        }

    const lod::PosedCage* here = nullptr;
    int blended = lod::kNoPair;
    ++visit;
    const RaysAsOne<float> as_one(kd, begin);
    const auto enter = [&](const auto& bounds, float far) {
        float in = begin, out = far;
        if constexpr (!std::is_same_v<std::decay_t<decltype(bounds)>, GridBounds>) {
            bounds.clip_to(kd, in, out);
            return in <= out;
        } else {
            clip(kd, bounds.box, in, out);
            return in <= out && crosses(kd, bounds.slab, in, out);
        }
    };
    const auto meet = [&](const TreeLeaf& leaf, std::size_t number, int pair, bool) {
        IGrid* known = grid_of(leaf, number, pair, memory_bytes);
        if (!known) return false;
        IGrid& grid = *known;
        GridVisit& visited = mailboxes.of(grid);
        if (visited.packet == visit || (grid.is_hidden && !may_see(ray, *grid.cage, frame.segments))) {
            if constexpr (kIsObserved<Found>) query.skips_igrid(grid, visited.packet == visit);
            return true;
        }
        visited.packet = visit;
        if constexpr (kIsObserved<Found>) query.enters_igrid();
        if (grid.cage != here) {
            here = grid.cage;
            blended = lod::kNoPair;
            const PlacedOrigin at = place(ray, here->anchor, here->radius);
            for (int a = 0; a < 3; ++a) lanes.origin[a] = at.origin[a];
            lanes.shift = at.shift;
        }
        float from = ray.t_near, to = FLT_MAX;
        if (pairs.levels && (!pairs.are_all_in(grid.pairs) || grid.blends())) {
            pairs.levels->make();
            from = max(from, pairs.levels->begin(grid.pairs.finest, grid.pairs.coarsest));
            to = pairs.levels->end(grid.pairs.finest, grid.pairs.coarsest);
            if (grid.blends() && blended != grid.pairs.finest) {
                blended = grid.pairs.finest;
                const lod::Blend<float> blend = pairs.levels->blend(blended);
                lanes.blend.set({blend.start, blend.scale}, direction, lanes.origin, lanes.shift);
            }
        }
        if (grid.segments > 0) meet_moving(grid, {{&ray, 1}, lanes, kd.negative, {from, to}}, query);
        else IGridTracer(grid, lanes, kd.negative, {from, to}, query).single(lane);
        if constexpr (kIsObserved<Found>)
            if (query.narration) {
                GridHit like{0, &grid, 0, {}, lod::key_time(ray.time, std::max(grid.segments, 1))};
                if (grid.blends()) like.blend = pairs.levels->blend(grid.pairs.finest);
                query.narration->igrid({like, lanes, direction, from, to}, query.offered, query.t[lane]);
            }
        return true;
    };
    auto& tree = lazy.tree<typename Way::Tree>();
    const auto times = times_of<typename Way::template Times<float>>({&ray, 1});
    const auto at_leaf = [&](auto node, bool alive, float near, float far, int finest, int coarsest) {
        return meet_leaf(tree, node, alive, near, far, pairs, finest, coarsest, memory_bytes, as_one, times, limit, enter,
                         meet);
    };
    if constexpr (kIsObserved<Found>)
        if (query.narration)
            return traverse(tree, kd, as_one, times, begin, end, pairs, counters, limit,
                            NarratedWalk{*query.narration, tree, kd, times, pairs, begin, limit, at_leaf});
    return traverse(tree, kd, as_one, times, begin, end, pairs, counters, limit, at_leaf);
}

template Tracer::State::PacketResult Tracer::State::run_packet<InKdTree, 1>(std::span<const Ray>, const RayAxes&,
                                                                            std::size_t, PacketQuery<Nearest, 1>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InKdTree, 2>(std::span<const Ray>, const RayAxes&,
                                                                            std::size_t, PacketQuery<Nearest, 2>&);
template bool Tracer::State::run_single<InKdTree>(const Ray&, const RayAxes&, std::size_t, SingleQuery<Nearest>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InKdTree, 1>(std::span<const Ray>, const RayAxes&,
                                                                            std::size_t, PacketQuery<NearestSome, 1>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InKdTree, 2>(std::span<const Ray>, const RayAxes&,
                                                                            std::size_t, PacketQuery<NearestSome, 2>&);
template bool Tracer::State::run_single<InKdTree>(const Ray&, const RayAxes&, std::size_t, SingleQuery<NearestSome>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InKdTree, 1>(std::span<const Ray>, const RayAxes&,
                                                                            std::size_t, PacketQuery<AnyHit, 1>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InKdTree, 2>(std::span<const Ray>, const RayAxes&,
                                                                            std::size_t, PacketQuery<AnyHit, 2>&);
template bool Tracer::State::run_single<InKdTree>(const Ray&, const RayAxes&, std::size_t, SingleQuery<AnyHit>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InBvh, 1>(std::span<const Ray>, const RayAxes&, std::size_t,
                                                                         PacketQuery<Nearest, 1>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InBvh, 2>(std::span<const Ray>, const RayAxes&, std::size_t,
                                                                         PacketQuery<Nearest, 2>&);
template bool Tracer::State::run_single<InBvh>(const Ray&, const RayAxes&, std::size_t, SingleQuery<Nearest>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InBvh, 1>(std::span<const Ray>, const RayAxes&, std::size_t,
                                                                         PacketQuery<NearestSome, 1>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InBvh, 2>(std::span<const Ray>, const RayAxes&, std::size_t,
                                                                         PacketQuery<NearestSome, 2>&);
template bool Tracer::State::run_single<InBvh>(const Ray&, const RayAxes&, std::size_t, SingleQuery<NearestSome>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InBvh, 1>(std::span<const Ray>, const RayAxes&, std::size_t,
                                                                         PacketQuery<AnyHit, 1>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InBvh, 2>(std::span<const Ray>, const RayAxes&, std::size_t,
                                                                         PacketQuery<AnyHit, 2>&);
template bool Tracer::State::run_single<InBvh>(const Ray&, const RayAxes&, std::size_t, SingleQuery<AnyHit>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InMovingBvh, 1>(std::span<const Ray>, const RayAxes&,
                                                                               std::size_t, PacketQuery<Nearest, 1>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InMovingBvh, 2>(std::span<const Ray>, const RayAxes&,
                                                                               std::size_t, PacketQuery<Nearest, 2>&);
template bool Tracer::State::run_single<InMovingBvh>(const Ray&, const RayAxes&, std::size_t, SingleQuery<Nearest>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InMovingBvh, 1>(std::span<const Ray>, const RayAxes&,
                                                                               std::size_t, PacketQuery<NearestSome, 1>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InMovingBvh, 2>(std::span<const Ray>, const RayAxes&,
                                                                               std::size_t, PacketQuery<NearestSome, 2>&);
template bool Tracer::State::run_single<InMovingBvh>(const Ray&, const RayAxes&, std::size_t, SingleQuery<NearestSome>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InMovingBvh, 1>(std::span<const Ray>, const RayAxes&,
                                                                               std::size_t, PacketQuery<AnyHit, 1>&);
template Tracer::State::PacketResult Tracer::State::run_packet<InMovingBvh, 2>(std::span<const Ray>, const RayAxes&,
                                                                               std::size_t, PacketQuery<AnyHit, 2>&);
template bool Tracer::State::run_single<InMovingBvh>(const Ray&, const RayAxes&, std::size_t, SingleQuery<AnyHit>&);
template bool Tracer::State::run_single<InKdTree>(const Ray&, const RayAxes&, std::size_t, SingleQuery<ObservedNearest>&);
template bool Tracer::State::run_single<InBvh>(const Ray&, const RayAxes&, std::size_t, SingleQuery<ObservedNearest>&);
template bool Tracer::State::run_single<InMovingBvh>(const Ray&, const RayAxes&, std::size_t, SingleQuery<ObservedNearest>&);

}  // namespace occam::accel
