#include "accel/tracer.h"

#include <algorithm>
#include <array>
#include <bit>

#include "accel/frame_state.h"
#include "accel/hit.h"
#include "accel/igrid_intersect.h"
#include "accel/kd_tree.h"
#include "accel/traverse.h"

namespace occam::accel {
namespace {

constexpr int kPacket = 8;       // rays a packet; as many as lanes, but for the one-lane build, which has no packets
constexpr int kWorthAPacket = 3; // live rays below which single rays are faster (docs/performance.md)
constexpr std::size_t kNoLimit = ~std::size_t(0);

// limit() of a single ray is the same in all lanes.
template <class Found, bool kSingle>
struct Query : Found {
    int only = 0;
    vfloat limit() const noexcept
    {
        if constexpr (kSingle) return vfloat(this->t[only]);
        else return vfloat::load(this->t);
    }
};

// One ray of a packet, as a query of its own.
template <class Found>
struct LaneOf {
    Found& all;
    int lane;
    vfloat limit() const noexcept { return vfloat(all.t[lane]); }
    void offer(int at, float t, IGrid& grid, std::uint32_t id) noexcept { all.offer(at, t, grid, id); }
};

}  // namespace

struct Tracer::State {
    State(const FrameState& f, std::size_t budget_bytes)
        : frame(f), budget(budget_bytes), items(f, arena, dicer, counters), tree(items, arena, counters)
    {
        flush();
        counters.flushes = 0;
    }

    void flush()
    {
        counters.peak_bytes = std::max(counters.peak_bytes, arena.bytes());
        ++counters.flushes;
        arena.reset(budget);
        dicer.forget();
        const ItemIndex root = items.restart();
        tree.restart(frame.bounds, root);
    }

    /// One group of rays with equal axes and octant; false if the budget was passed on the way.
    template <class Found>
    bool run_packet(std::span<const Ray> rays, const RayAxes* axes, std::size_t limit_bytes, Query<Found, false>& query);
    template <class Found>
    bool run_single(const Ray& ray, const RayAxes& axes, std::size_t limit_bytes, Query<Found, true>& query);

    /// Traces rays[first, first + count) by `run(first, count, limit)`, flushing and halving as the budget asks.
    template <class Run>
    void within_budget(std::size_t first, std::size_t count, Run&& run)
    {
        if (run(first, count, budget)) return;
        // Abandoned: what was built is dropped, and the same rays start again in an empty arena, at last one by one.
        flush();
        if (run(first, count, budget)) return;
        flush();
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
        sorted.resize(rays.size());
        place_of.resize(rays.size());
        sorted_axes.resize(rays.size(), RayAxes(Vec3f(0, 0, 1)));
        for (std::uint32_t i = 0; i < rays.size(); ++i) {
            const std::uint32_t to = begin[axes[i].bin()]++;
            sorted[to] = rays[i];
            sorted_axes[to] = axes[i];
            place_of[to] = i;
        }
        for (std::size_t first = 0; first < rays.size();) {
            std::size_t end = first + 1;
            while (kLanes > 1 && end < rays.size() && end < first + kPacket && sorted_axes[end].group() == sorted_axes[first].group()) ++end;
            within_budget(first, end - first, run);
            first = end;
        }
        counters.rays += rays.size();
        counters.peak_bytes = std::max(counters.peak_bytes, arena.bytes());
        counters.vertices_diced = dicer.vertices_diced;
        counters.vertices_shaded = dicer.vertices_shaded;
    }

    const FrameState& frame;
    std::size_t budget;
    Arena arena;
    lod::Dicer dicer;
    TraceCounters counters;
    Items items;
    KdTree tree;
    std::vector<Ray> sorted;            ///< the batch, by direction
    std::vector<RayAxes> axes, sorted_axes;
    std::vector<std::uint32_t> place_of;  ///< in the caller's order
    std::uint64_t visit = 0;
};

namespace {

/// Lanes of a group: rays past its end repeat the last one and are never alive.
template <class Get>
vfloat gather(std::size_t count, Get&& get) noexcept
{
    alignas(32) float lanes[kLanes];
    for (int i = 0; i < kLanes; ++i) lanes[i] = get(std::min<std::size_t>(i, count - 1));
    return vfloat::load(lanes);
}

}  // namespace

template <class Found>
bool Tracer::State::run_packet(std::span<const Ray> rays, const RayAxes* ax, std::size_t limit_bytes, Query<Found, false>& query)
{
    const std::size_t n = rays.size();
    PlacedOrigin placed[kPacket];
    const auto place_all = [&](Vec3d anchor, float radius, vfloat (&origin)[3], vfloat& shift) {
        for (std::size_t i = 0; i < n; ++i) placed[i] = place(rays[i], anchor, radius);
        for (int a = 0; a < 3; ++a) origin[a] = gather(n, [&](std::size_t i) { return placed[i].origin[a]; });
        shift = gather(n, [&](std::size_t i) { return placed[i].shift; });
    };
    KdRay<vfloat> kd;
    place_all(frame.anchor, frame.radius, kd.origin, kd.shift);
    RayLanes lanes;
    lanes.kx = ax->kx;
    lanes.ky = ax->ky;
    lanes.kz = ax->kz;
    lanes.sx = gather(n, [&](std::size_t i) { return ax[i].sx; });
    lanes.sy = gather(n, [&](std::size_t i) { return ax[i].sy; });
    lanes.sz = gather(n, [&](std::size_t i) { return ax[i].sz; });
    for (int a = 0; a < 3; ++a) {
        kd.inverse[a] = lanes.inverse[a] = gather(n, [&](std::size_t i) { return ax[i].inverse[a]; });
        kd.negative[a] = ax->negative[a];
    }
    const vfloat t_near = gather(n, [&](std::size_t i) { return rays[i].t_near; });
    vfloat begin = t_near - kd.shift, end = query.limit() - kd.shift;
    begin = begin - (abs(t_near) + abs(kd.shift)) * vfloat(4 * FLT_EPSILON);
    const auto limit = [&] { return query.limit() - kd.shift + (abs(query.limit()) + abs(kd.shift)) * vfloat(4 * FLT_EPSILON); };
    clip(kd, frame.bounds, begin, end);

    const lod::PosedCage* here = nullptr;
    ++visit;
    ++counters.packets;
    return traverse(tree, kd, begin, end, counters, limit, [&](const KdNode& leaf, vmask alive, vfloat, vfloat) {
        for (const ItemIndex i : tree.leaf(leaf)) {
            vfloat in = begin, out = limit();
            clip(kd, items[i].box, in, out);
            const vmask entering = alive & (in <= out);
            if (none(entering)) continue;
            IGrid& grid = items.grid(i);
            if (arena.bytes() > limit_bytes) return false;
            if (grid.visit != visit) {
                grid.visit = visit;
                grid.visited_lanes = 0;
            }
            // A box that a ray enters in several cells is met once.
            const unsigned fresh = bits(entering) & ~grid.visited_lanes;
            if (fresh == 0) continue;
            grid.visited_lanes |= fresh;
            if (grid.cage != here) {
                here = grid.cage;
                place_all(here->anchor, here->radius, lanes.origin, lanes.shift);
            }
            if (std::popcount(fresh) >= kWorthAPacket) {
                IGridTracer(grid, lanes, kd.negative, t_near, query).packet(entering);
                continue;
            }
            // Few are left: each alone, across micropolygons.
            for (unsigned left = fresh; left != 0; left &= left - 1) {
                const int lane = std::countr_zero(left);
                LaneOf<Found> one{query, lane};
                const RayLanes ray = spread(lanes, lane);
                IGridTracer(grid, ray, kd.negative, vfloat(rays[lane].t_near), one).single(lane);
            }
        }
        return arena.bytes() <= limit_bytes;
    });
}

template <class Found>
bool Tracer::State::run_single(const Ray& ray, const RayAxes& ax, std::size_t limit_bytes, Query<Found, true>& query)
{
    const PlacedOrigin start = place(ray, frame.anchor, frame.radius);
    KdRay<float> kd;
    RayLanes lanes;
    lanes.kx = ax.kx;
    lanes.ky = ax.ky;
    lanes.kz = ax.kz;
    lanes.sx = ax.sx;
    lanes.sy = ax.sy;
    lanes.sz = ax.sz;
    kd.shift = start.shift;
    for (int a = 0; a < 3; ++a) {
        kd.origin[a] = start.origin[a];
        kd.inverse[a] = ax.inverse[a];
        kd.negative[a] = ax.negative[a];
        lanes.inverse[a] = ax.inverse[a];
    }
    const int lane = query.only;
    float begin = ray.t_near - kd.shift, end = query.t[lane] - kd.shift;
    begin = begin - (std::fabs(ray.t_near) + std::fabs(kd.shift)) * (4 * FLT_EPSILON);
    const auto limit = [&] { return query.t[lane] - kd.shift + (std::fabs(query.t[lane]) + std::fabs(kd.shift)) * (4 * FLT_EPSILON); };
    clip(kd, frame.bounds, begin, end);

    const lod::PosedCage* here = nullptr;
    ++visit;
    return traverse(tree, kd, begin, end, counters, limit, [&](const KdNode& leaf, bool, float, float) {
        for (const ItemIndex i : tree.leaf(leaf)) {
            float in = begin, out = limit();
            clip(kd, items[i].box, in, out);
            if (!(in <= out)) continue;
            IGrid& grid = items.grid(i);
            if (arena.bytes() > limit_bytes) return false;
            if (grid.visit == visit) continue;
            grid.visit = visit;
            if (grid.cage != here) {
                here = grid.cage;
                const PlacedOrigin at = place(ray, here->anchor, here->radius);
                for (int a = 0; a < 3; ++a) lanes.origin[a] = at.origin[a];
                lanes.shift = at.shift;
            }
            IGridTracer tracer(grid, lanes, kd.negative, vfloat(ray.t_near), query);
            tracer.single(lane);
        }
        return arena.bytes() <= limit_bytes;
    });
}

Tracer::Tracer(const Frame& frame, std::size_t budget_bytes) : state_(std::make_unique<State>(frame.state(), budget_bytes)) {}
Tracer::~Tracer() = default;
const TraceCounters& Tracer::counters() const noexcept { return state_->counters; }

void Tracer::closest(std::span<const Ray> rays, std::span<SurfaceHit> hits)
{
    State& s = *state_;
    s.for_groups(rays, [&](std::size_t first, std::size_t count, std::size_t limit) {
        const std::span<const Ray> group{&s.sorted[first], count};
        Nearest found;
        const auto start = [&](Nearest& n) {
            for (int i = 0; i < kLanes; ++i) {
                n.t[i] = std::size_t(i) < count ? group[i].t_far : kDead;
                n.grid[i] = nullptr;
            }
        };
        if (count >= kWorthAPacket) {
            Query<Nearest, false> query;
            start(query);
            if (!s.run_packet(group, &s.sorted_axes[first], limit, query)) return false;
            found = query;
        } else {
            Query<Nearest, true> query;
            start(query);
            for (std::size_t i = 0; i < count; ++i) {
                query.only = static_cast<int>(i);
                if (!s.run_single(group[i], s.sorted_axes[first + i], limit, query)) return false;
            }
            found = query;
        }
        for (std::size_t i = 0; i < count; ++i) {
            SurfaceHit& hit = hits[s.place_of[first + i]] = {};
            if (found.grid[i])
                resolve(group[i], found.t[i], *found.grid[i], found.id[i], *s.frame.scene, s.dicer, s.arena, hit);
        }
        return s.arena.bytes() <= limit;
    });
}

void Tracer::occluded(std::span<const Ray> rays, std::span<std::uint8_t> occluded)
{
    State& s = *state_;
    s.for_groups(rays, [&](std::size_t first, std::size_t count, std::size_t limit) {
        const std::span<const Ray> group{&s.sorted[first], count};
        const auto start = [&](AnyHit& n) {
            for (int i = 0; i < kLanes; ++i)
                n.t[i] = std::size_t(i) < count ? group[i].t_far : kDead;
        };
        const auto finish = [&](const AnyHit& n) {
            for (std::size_t i = 0; i < count; ++i) occluded[s.place_of[first + i]] = n.t[i] == kDead;
        };
        if (count >= kWorthAPacket) {
            Query<AnyHit, false> query;
            start(query);
            if (!s.run_packet(group, &s.sorted_axes[first], limit, query)) return false;
            finish(query);
        } else {
            Query<AnyHit, true> query;
            start(query);
            for (std::size_t i = 0; i < count; ++i) {
                query.only = static_cast<int>(i);
                if (!s.run_single(group[i], s.sorted_axes[first + i], limit, query)) return false;
            }
            finish(query);
        }
        return true;
    });
}

TraceCounters& TraceCounters::operator+=(const TraceCounters& o) noexcept
{
    rays += o.rays;
    packets += o.packets;
    kd_nodes += o.kd_nodes;
    kd_visited += o.kd_visited;
    kd_expanded += o.kd_expanded;
    grids += o.grids;
    micropolygons += o.micropolygons;
    faces_touched += o.faces_touched;
    flushes += o.flushes;
    vertices_diced += o.vertices_diced;
    vertices_shaded += o.vertices_shaded;
    peak_bytes += o.peak_bytes;
    build_seconds += o.build_seconds;
    dice_seconds += o.dice_seconds;
    for (int l = 0; l < kLevels; ++l) micropolygons_of_level[l] += o.micropolygons_of_level[l];
    return *this;
}

}  // namespace occam::accel
