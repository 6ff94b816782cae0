#include "accel/tracer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>

#include "accel/frame_state.h"
#include "accel/igrid_intersect.h"
#include "accel/lazy_tree.h"
#include "accel/leaf_boxes.h"
#include "accel/mailboxes.h"
#include "accel/packet.h"
#include "accel/traverse.h"

namespace occam::accel {
namespace {

constexpr int kPacket = 8;       // rays a packet; as many as lanes, but for the one-lane build, which has no packets
constexpr int kWorthAPacket = 5; // live rays below which single rays are faster (docs/performance.md)
constexpr std::size_t kNoLimit = ~std::size_t(0);

}  // namespace

struct Tracer::State {
    explicit State(std::unique_ptr<LazyTree> tree_of_its_own) : State(*tree_of_its_own) { own = std::move(tree_of_its_own); }
    explicit State(LazyTree& all)
        : lazy(all), frame(all.frame), budget(all.budget), arena(all.arena), tree(all.tree), gate(all.gate()), mailboxes(gate != nullptr)
    {
    }

    /// `seen`: the gate's flushes before it was found that there is too little room.
    void flush(std::uint64_t seen)
    {
        if (gate) gate->flush(seen, [&] { lazy.flush(); });
        else lazy.flush();
    }

    enum class PacketResult : unsigned char {
        Done,
        Abandoned,  ///< the budget was passed on the way
        TooWide     ///< the rays see too many pairs of levels to travel together
    };
    /// One group of rays with equal axes and octant.
    template <class Found>
    PacketResult run_packet(std::span<const Ray> rays, const RayAxes* axes, std::size_t limit_bytes, Query<Found, false>& query);
    /// False if the budget was passed on the way.
    template <class Found>
    bool run_single(const Ray& ray, const RayAxes& axes, std::size_t limit_bytes, Query<Found, true>& query);

    template <class F, class Limit, class Enter, class Meet>
    LeafResult meet_leaf(std::uint32_t node, MaskOf<F> alive, F t_near, F t_far, const PairSpans<F>& pairs, int finest, int coarsest,
                         std::size_t limit_bytes, const RaysAsOne<F>& as_one, Limit&& limit, Enter&& enter, Meet&& meet);
    bool is_per_ray() const noexcept { return frame.levels.mode != lod::LevelMode::PerInstance; }
    /// Makes the table of transitions of a packet of which `enters` are in the scene from t_in to t_out; false if its rays see too many
    /// pairs to travel together.
    bool fits_packet(std::span<const Ray> rays, vmask enters, vfloat t_in, vfloat t_out) noexcept;
    /// What a ray's levels are chosen by. A ray without a width has the camera's.
    lod::Footprint wanted_of(const Ray& ray) const noexcept
    {
        lod::Footprint f = ray.footprint;
        if (f.a <= 0 && f.b == 0) f = {frame.levels.pixel.at(static_cast<float>(glm::distance(ray.origin, frame.levels.eye))), frame.levels.pixel.b};
        if (frame.levels.mode == lod::LevelMode::Frozen && !(ray.kinds & RayKind::Camera)) f.b = 0;
        return frame.levels.wanted(f);
    }
    /// What a ray's table of transitions is made of, but for where it is in the scene.
    struct Reach {
        lod::Footprint wanted;
        float coordinate;  ///< the largest that the ray's arithmetic meets
        float unused = 0;  ///< four are loaded at a time
    };
    Reach reach_of(const Ray& ray) const noexcept
    {
        return {wanted_of(ray), std::max(static_cast<float>(glm::distance(ray.origin, frame.anchor)), frame.radius)};
    }

    /// Traces one group, and gives take(i, found, is_single) what each of its rays has met.
    template <class Found, class Take>
    bool run(std::size_t first, std::size_t count, std::size_t limit_bytes, Take&& take);
    /// fill(first, met) for each group: what sorted[first + i] has met, and, if kWithBlend, how it blends there.
    template <bool kWithBlend, class Fill>
    void find_nearest(std::span<const Ray> rays, Fill&& fill);

    /// Traces rays[first, first + count) by `run(first, count, limit)`, flushing and halving as the budget asks.
    template <class Run>
    void within_budget(std::size_t first, std::size_t count, Run&& run)
    {
        const auto fits = [&] {
            if (gate) gate->pass();
            const std::uint64_t seen = gate ? gate->flushes() : 0;
            if (run(first, count, budget)) return true;
            flush(seen);
            return false;
        };
        // Abandoned: what was built is dropped, and the same rays start again in an empty arena, at last one by one.
        if (fits() || fits()) return;
        if (count == 1) {
            run(first, 1, kNoLimit);
            return;
        }
        within_budget(first, count / 2, run);
        within_budget(first + count / 2, count - count / 2, run);
    }

    /// Sorts rays by direction, keeping their order otherwise, and calls run for runs of `sorted` that may travel together.
    template <class Run>
    void for_groups(std::span<const Ray> rays, Run&& run)
    {
        std::array<std::uint32_t, RayAxes::kBins + 1> begin{};
        axes.clear();
        for (const Ray& ray : rays) {
            axes.emplace_back(ray.direction);
            ++begin[axes.back().bin() + 1];
        }
        for (int b = 0; b < RayAxes::kBins; ++b) begin[b + 1] += begin[b];
        // Batches come in several sizes: what has been made stays, to be written over.
        if (sorted.size() < rays.size()) {
            sorted.resize(rays.size());
            place_of.resize(rays.size());
            sorted_axes.resize(rays.size(), RayAxes(Vec3f(0, 0, 1)));
        }
        for (std::uint32_t i = 0; i < rays.size(); ++i) {
            const std::uint32_t to = begin[axes[i].bin()]++;
            sorted[to] = rays[i];
            sorted_axes[to] = axes[i];
            place_of[to] = i;
        }
        const FlushGate::Inside inside(gate);
        for (std::size_t first = 0; first < rays.size();) {
            std::size_t end = first + 1;
            while (kLanes > 1 && end < rays.size() && end < first + kPacket && sorted_axes[end].group() == sorted_axes[first].group()) ++end;
            within_budget(first, end - first, run);
            first = end;
        }
        counters.rays += rays.size();
    }

    std::unique_ptr<LazyTree> own;  ///< null: the tree is shared
    LazyTree& lazy;
    const FrameState& frame;
    const std::size_t budget;
    Arena& arena;
    KdTree& tree;
    FlushGate* const gate;          ///< null unless the tree is shared
    TraceCounters counters;         ///< without those of building
    Mailboxes mailboxes;
    lod::RayLevels<vfloat> packet_levels;  ///< of the packet traced last
    lod::RayLevels<float> single_levels;   ///< of the ray traced last
    std::vector<Ray> sorted;            ///< the batch, by direction; and like those below, as long as the longest batch so far
    std::vector<RayAxes> axes, sorted_axes;
    std::vector<std::uint32_t> place_of;  ///< in the caller's order
    std::uint64_t visit = 0;
};

/// Meets what a node holds for pairs [finest, coarsest]. enter(bounds, far) says which rays are inside somewhere before
/// far, which is limit(); meet(leaf, number, pair, rays) meets the igrid of an entry with them.
template <class F, class Limit, class Enter, class Meet>
OCCAM_ALWAYS_INLINE LeafResult Tracer::State::meet_leaf(std::uint32_t node, MaskOf<F> alive, F t_near, F t_far, const PairSpans<F>& pairs, int finest, int coarsest,
                                    std::size_t limit_bytes, const RaysAsOne<F>& as_one, Limit&& limit, Enter&& enter, Meet&& meet)
{
    KdLeaf& latest = tree.latest_leaf(node);
    const auto is_one = [&] { return finest == coarsest || (latest.pairs.has(finest) && latest.pairs.has(coarsest)); };
    if (!is_one()) pairs.narrow(alive, t_near, t_far, finest, coarsest);
    for (int pair = finest; pair <= coarsest; ++pair) {
        MaskOf<F> here = alive;
        if (!is_one()) here = alive & (max(t_near, pairs.in(pair, pair)) <= min(t_far, pairs.out(pair, pair)));
        if (none(here)) continue;
        KdLeaf* leaf = latest.pairs.has(pair) ? &latest : tree.leaf(node, pair);
        if (!leaf) return LeafResult::Expanded;
        // What is the same for several pairs is met once for all of them.
        const int last = std::min(leaf->pairs.coarsest, coarsest);
        if (pair == finest && last == coarsest) here = alive;
        else if (last > pair) here = alive & (max(t_near, pairs.in(pair, last)) <= min(t_far, pairs.out(pair, last)));
        F far = limit();
        for (std::size_t first = 0; first < leaf->entries.size(); first += kBoxGroup) {
            unsigned maybe = as_one.in_boxes(leaf->boxes + first / kBoxGroup * kBoxGroupFloats, highest(far));
            for (; maybe != 0; maybe &= maybe - 1) {
                const std::size_t number = first + static_cast<std::size_t>(std::countr_zero(maybe));
                const KdLeaf::Entry& entry = leaf->entries[number];
                const MaskOf<F> entering = here & (read_published(entry.grid) ? enter(entry.bounds, far) : enter({get_box(leaf->boxes, number), {}}, far));
                if (none(entering)) continue;
                if (!meet(*leaf, number, pair, entering)) return LeafResult::Abandoned;
                far = limit();
            }
        }
        pair = last;
    }
    return arena.bytes() <= limit_bytes ? LeafResult::Done : LeafResult::Abandoned;
}

template <class Found>
Tracer::State::PacketResult Tracer::State::run_packet(std::span<const Ray> rays, const RayAxes* ax, std::size_t limit_bytes, Query<Found, false>& query)
{
    const std::size_t n = rays.size();
    PlacedOrigin placed[kPacket];
    const auto place_all = [&](Vec3d anchor, float radius, vfloat (&origin)[3], vfloat& shift) {
        for (std::size_t i = 0; i < n; ++i) placed[i] = place(rays[i], anchor, radius);
        vfloat four[4];
        gather_four(placed, n, 0, four);
        std::copy_n(four, 3, origin);
        shift = four[3];
    };
    KdRay<vfloat> kd;
    place_all(frame.anchor, frame.radius, kd.origin, kd.shift);
    RayLanes lanes;
    lanes.kx = ax->kx;
    lanes.ky = ax->ky;
    lanes.kz = ax->kz;
    vfloat shear[4], inverse[4], way[4];
    gather_four(ax, n, offsetof(RayAxes, shear), shear);
    gather_four(ax, n, offsetof(RayAxes, inverse), inverse);
    static_assert(offsetof(Ray, t_near) == offsetof(Ray, direction) + 3 * sizeof(float));
    gather_four(rays.data(), n, offsetof(Ray, direction), way);
    lanes.sx = shear[0];
    lanes.sy = shear[1];
    lanes.sz = shear[2];
    for (int a = 0; a < 3; ++a) {
        kd.inverse[a] = lanes.inverse[a] = inverse[a];
        kd.negative[a] = ax->negative[a];
        kd.direction[a] = way[a];
    }
    const vfloat t_near = way[3];
    vfloat begin = t_near - kd.shift, end = query.limit() - kd.shift;
    begin = begin - (abs(t_near) + abs(kd.shift)) * vfloat(4 * FLT_EPSILON);
    const auto limit = [&] { return query.limit() - kd.shift + (abs(query.limit()) + abs(kd.shift)) * vfloat(4 * FLT_EPSILON); };
    clip(kd, frame.bounds, begin, end);

    const vmask enters = begin <= end;
    if (none(enters)) return PacketResult::Done;
    PairSpans<vfloat> pairs{nullptr, kd.shift, 0, 0};
    if (is_per_ray()) {
        if (!fits_packet(rays, enters, kd.shift + begin, kd.shift + end)) return PacketResult::TooWide;
        pairs = {&packet_levels, kd.shift, packet_levels.finest, packet_levels.coarsest};
    }

    const lod::PosedCage* here = nullptr;
    int blended = lod::kNoPair;
    ++visit;
    ++counters.packets;
    const RaysAsOne<vfloat> as_one(kd, lowest(begin));
    RaysAsOne<vfloat> as_one_placed;  // in the frame of `here`, if
    bool is_as_one_placed = false;
    const auto placed_as_one = [&]() -> const RaysAsOne<vfloat>& {
        if (!is_as_one_placed) as_one_placed = {lanes.origin, lanes.inverse, kd.negative, lanes.shift, -FLT_MAX};
        is_as_one_placed = true;
        return as_one_placed;
    };
    const auto enter = [&](const GridBounds& bounds, vfloat far) __attribute__((always_inline)) {
        vfloat in = begin, out = far;
        clip(kd, bounds.box, in, out);
        const vmask inside = in <= out;
        return none(inside) ? inside : inside & crosses(kd, bounds.slab, in, out);
    };
    const auto meet = [&](const KdLeaf& leaf, std::size_t number, int pair, vmask entering) __attribute__((always_inline)) {
        IGrid* known = read_published(leaf.entries[number].grid);
        if (!known) {
            known = &lazy.grid(leaf, number, pair, counters.diced);
            if (arena.bytes() > limit_bytes) return false;
        }
        IGrid& grid = *known;
        GridVisit& visited = mailboxes.of(grid);
        if (visited.packet != visit) visited = {visit, 0};
        // A grid that a ray enters in several cells is met once.
        if (grid.seen_by != RayKind::All) entering = entering & lanes_of_kinds(rays, grid.seen_by);
        const unsigned fresh = bits(entering) & ~visited.lanes;
        if (fresh == 0) return true;
        visited.lanes |= fresh;
        if (grid.cage != here) {
            here = grid.cage;
            blended = lod::kNoPair;
            place_all(here->anchor, here->radius, lanes.origin, lanes.shift);
            is_as_one_placed = false;
        }
        vfloat from = t_near, to = FLT_MAX;
        if (pairs.levels && (!pairs.are_all_in(grid.pairs) || grid.blends())) {
            pairs.levels->make();
            from = max(from, pairs.levels->begin(grid.pairs.finest, grid.pairs.coarsest));
            to = pairs.levels->end(grid.pairs.finest, grid.pairs.coarsest);
            if (grid.blends() && blended != grid.pairs.finest) {
                blended = grid.pairs.finest;
                lanes.blend.set(pairs.levels->blend(blended), kd.direction, lanes.origin, lanes.shift);
            }
        }
        if (std::popcount(fresh) >= kWorthAPacket) {
            IGridTracer(grid, lanes, kd.negative, from, to, query).packet(entering, placed_as_one);
            return true;
        }
        // Few are left: each alone, across micropolygons.
        for (unsigned left = fresh; left != 0; left &= left - 1) {
            const int lane = std::countr_zero(left);
            LaneOf<Found> one{query, lane};
            RayLanes ray = spread(lanes, lane);
            if (grid.blends()) ray.blend = spread(lanes.blend, lane);
            IGridTracer(grid, ray, kd.negative, spread(from, lane), spread(to, lane), one).single(lane);
        }
        return true;
    };
    const bool is_done = traverse(tree, kd, begin, end, pairs, counters, limit,
                                  [&](std::uint32_t node, vmask alive, vfloat near, vfloat far, int finest, int coarsest) {
                                      return meet_leaf(node, alive, near, far, pairs, finest, coarsest, limit_bytes, as_one, limit, enter, meet);
                                  });
    return is_done ? PacketResult::Done : PacketResult::Abandoned;
}

template <class Found>
bool Tracer::State::run_single(const Ray& ray, const RayAxes& ax, std::size_t limit_bytes, Query<Found, true>& query)
{
    const PlacedOrigin start = place(ray, frame.anchor, frame.radius);
    KdRay<float> kd;
    RayLanes lanes;
    vfloat direction[3];
    lanes.kx = ax.kx;
    lanes.ky = ax.ky;
    lanes.kz = ax.kz;
    lanes.sx = ax.shear[0];
    lanes.sy = ax.shear[1];
    lanes.sz = ax.shear[2];
    kd.shift = start.shift;
    for (int a = 0; a < 3; ++a) {
        kd.origin[a] = start.origin[a];
        kd.inverse[a] = ax.inverse[a];
        kd.negative[a] = ax.negative[a];
        lanes.inverse[a] = ax.inverse[a];
        kd.direction[a] = ray.direction[a];
        direction[a] = ray.direction[a];
    }
    const int lane = query.only;
    float begin = ray.t_near - kd.shift, end = query.t[lane] - kd.shift;
    begin = begin - (std::fabs(ray.t_near) + std::fabs(kd.shift)) * (4 * FLT_EPSILON);
    const auto limit = [&] { return query.t[lane] - kd.shift + (std::fabs(query.t[lane]) + std::fabs(kd.shift)) * (4 * FLT_EPSILON); };
    clip(kd, frame.bounds, begin, end);

    if (!(begin <= end)) return true;
    PairSpans<float> pairs{nullptr, kd.shift, 0, 0};
    if (is_per_ray()) {
        // One ray never has too many pairs.
        const Reach reach = reach_of(ray);
        single_levels.set(reach.wanted.a, reach.wanted.b, kd.shift + begin, kd.shift + end, reach.coordinate, frame.levels);
        pairs = {&single_levels, kd.shift, single_levels.finest, single_levels.coarsest};
    }

    const lod::PosedCage* here = nullptr;
    int blended = lod::kNoPair;
    ++visit;
    const RaysAsOne<float> as_one(kd, begin);
    const auto enter = [&](const GridBounds& bounds, float far) {
        float in = begin, out = far;
        clip(kd, bounds.box, in, out);
        return in <= out && crosses(kd, bounds.slab, in, out);
    };
    const auto meet = [&](const KdLeaf& leaf, std::size_t number, int pair, bool) {
        IGrid* known = read_published(leaf.entries[number].grid);
        if (!known) {
            known = &lazy.grid(leaf, number, pair, counters.diced);
            if (arena.bytes() > limit_bytes) return false;
        }
        IGrid& grid = *known;
        GridVisit& visited = mailboxes.of(grid);
        if (visited.packet == visit || (ray.kinds & grid.seen_by) == 0) return true;
        visited.packet = visit;
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
        IGridTracer(grid, lanes, kd.negative, from, to, query).single(lane);
        return true;
    };
    return traverse(tree, kd, begin, end, pairs, counters, limit, [&](std::uint32_t node, bool alive, float near, float far, int finest, int coarsest) {
        return meet_leaf(node, alive, near, far, pairs, finest, coarsest, limit_bytes, as_one, limit, enter, meet);
    });
}

Tracer::Tracer(const Frame& frame, std::size_t budget_bytes, BuildTechniques techniques)
    : state_(std::make_unique<State>(std::make_unique<LazyTree>(frame.state(), budget_bytes, techniques, false)))
{
}
Tracer::Tracer(SharedTree& tree) : state_(std::make_unique<State>(*tree.tree_)) {}
Tracer::~Tracer() = default;
TraceCounters Tracer::counters() const
{
    TraceCounters all = state_->counters;
    all.diced = 0;  // counted with building
    if (state_->own) all += state_->own->totals();
    return all;
}

bool Tracer::State::fits_packet(std::span<const Ray> rays, vmask enters, vfloat t_in, vfloat t_out) noexcept
{
    const std::size_t n = rays.size();
    // A ray that misses the scene has the table of one that does not, so as to ask for no more pairs.
    const int one = std::countr_zero(bits(enters));
    Reach reach[kPacket];
    for (std::size_t i = 0; i < n; ++i) reach[i] = reach_of(rays[bits(enters) >> i & 1 ? i : static_cast<std::size_t>(one)]);
    vfloat of[4];
    gather_four(reach, n, 0, of);
    return packet_levels.set(of[0], of[1], select(enters, t_in, spread(t_in, one)), select(enters, t_out, spread(t_out, one)), of[2], frame.levels);
}

template <class Found, class Take>
bool Tracer::State::run(std::size_t first, std::size_t count, std::size_t limit_bytes, Take&& take)
{
    const std::span<const Ray> group{&sorted[first], count};
    if (count >= kWorthAPacket) {
        Query<Found, false> query;
        start(query, group);
        const PacketResult result = run_packet(group, &sorted_axes[first], limit_bytes, query);
        if (result == PacketResult::Abandoned) return false;
        if (result == PacketResult::Done) {
            for (std::size_t i = 0; i < count; ++i) take(i, query, false);
            return true;
        }
    }
    for (std::size_t i = 0; i < count; ++i) {
        Query<Found, true> query;
        start(query, group);
        query.only = static_cast<int>(i % kLanes);
        query.t[query.only] = group[i].t_far;
        if (!run_single(group[i], sorted_axes[first + i], limit_bytes, query)) return false;
        take(i, query, true);
    }
    return true;
}

template <bool kWithBlend, class Fill>
void Tracer::State::find_nearest(std::span<const Ray> rays, Fill&& fill)
{
    const std::uint64_t diced = counters.diced;
    for_groups(rays, [&](std::size_t first, std::size_t count, std::size_t limit) {
        Met met[kPacket];
        int pair = lod::kNoPair;
        float start[kLanes]{}, scale[kLanes]{};  // of the packet's blends in that pair
        const auto take = [&](std::size_t i, const auto& found, bool is_single) {
            const std::size_t lane = i % kLanes;
            Met& m = met[i] = {found.t[lane], found.grid[lane], found.id[lane], {}};
            if (!kWithBlend || !m.grid || !m.grid->blends()) return;
            if (is_single) {
                m.blend = single_levels.blend(m.grid->pairs.finest);
                return;
            }
            if (pair != m.grid->pairs.finest) {
                pair = m.grid->pairs.finest;
                const lod::Blend<vfloat> lanes = packet_levels.blend(pair);
                lanes.start.store(start);
                lanes.scale.store(scale);
            }
            m.blend = {start[lane], scale[lane]};
        };
        if (!run<Nearest>(first, count, limit, take)) return false;
        fill(first, std::span<const Met>(met, count));
        return arena.bytes() <= limit;
    });
    if (!rays.empty() && rays.front().kinds & RayKind::Camera) counters.diced_for_camera += counters.diced - diced;
}

void Tracer::closest(std::span<const Ray> rays, std::span<SurfaceHit> hits)
{
    State& s = *state_;
    s.find_nearest<true>(rays, [&](std::size_t first, std::span<const Met> met) {
        SurfaceHit* to[kPacket];
        bool any_met = false;
        for (std::size_t i = 0; i < met.size(); ++i) {
            to[i] = &hits[s.place_of[first + i]];
            if (met[i].grid) any_met = true;
            else to[i]->t = std::numeric_limits<float>::infinity();
        }
        if (!any_met) return;
        const std::span<const Ray> group(&s.sorted[first], met.size());
        for (std::size_t i = 0; i < met.size(); i += kLanes) {
            const std::size_t n = std::min<std::size_t>(kLanes, met.size() - i);
            resolve(group.subspan(i, n), &s.sorted_axes[first + i], met.subspan(i, n), s.lazy.phase_one(), to + i);
        }
    });
}

void Tracer::first_hits(std::span<const Ray> rays, std::span<FirstHit> hits)
{
    State& s = *state_;
    s.find_nearest<false>(rays, [&](std::size_t first, std::span<const Met> met) {
        for (std::size_t i = 0; i < met.size(); ++i) {
            FirstHit& hit = hits[s.place_of[first + i]] = {};
            if (met[i].grid) hit = {met[i].t, met[i].grid->cage->node_id, face_of(met[i])};
        }
    });
}

void Tracer::occluded(std::span<const Ray> rays, std::span<std::uint8_t> occluded)
{
    State& s = *state_;
    const std::uint64_t diced = s.counters.diced;
    s.for_groups(rays, [&](std::size_t first, std::size_t count, std::size_t limit) {
        const auto take = [&](std::size_t i, const auto& found, bool) { occluded[s.place_of[first + i]] = found.t[i % kLanes] == kDead; };
        return s.run<AnyHit>(first, count, limit, take);
    });
    s.counters.diced_for_occlusion += s.counters.diced - diced;
}

}  // namespace occam::accel
