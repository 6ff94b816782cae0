#include "accel/tracer.h"

#include <limits>

#include "accel/holes.h"
#include "accel/tracer_state.h"
#include "base/prefetch.h"

namespace occam::accel {
namespace {

/// Returns how the rays of a packet, or a single ray, blend in a pair. For a packet the blend of a pair is computed once for
/// all rays.
template <class F>
class Blends {
public:
    explicit Blends(lod::RayLevels<F>& levels) : levels_(levels) {}

    lod::Blend<float> operator()(int pair, std::size_t lane)
    {
        if constexpr (std::is_same_v<F, float>) return levels_.blend(pair);
        else {
            if (pair != pair_) {
                pair_ = pair;
                const lod::Blend<F> all = levels_.blend(pair);
                all.start.store(start_);
                all.scale.store(scale_);
            }
            return {start_[lane], scale_[lane]};
        }
    }

    /// Returns the level whose mesh the ray in a lane sees at its hit, or the nearer one of two that it sees blended there:
    /// kAnyLevel if the ray sees no level there, as on a mesh that is beside everything that is diced.
    int level_at(const Nearest& found, const IGrid& grid, std::size_t lane)
    {
        if constexpr (std::is_same_v<F, float>) return level_at(found.t[lane], grid, lane);
        else {
            // The levels of all lanes are found at once.
            if (!grid.is_lattice && !is_reach_set_) levels_.reaches(F::load(found.t)).store(reach_);
            is_reach_set_ = is_reach_set_ || !grid.is_lattice;
            if (!grid.is_lattice && reach_[lane] == 0) return kAnyLevel;
            if (!are_levels_set_) levels_.nearest_level(F::load(found.t)).store(level_);
            are_levels_set_ = true;
            return static_cast<int>(level_[lane]);
        }
    }
    /// Returns the same for any t.
    int level_at(float t, const IGrid& grid, std::size_t lane)
    {
        const auto of_lane = [&](const F& x) {
            if constexpr (std::is_same_v<F, float>) return x;
            else return lane_of(x, static_cast<int>(lane));
        };
        if (!grid.is_lattice && of_lane(levels_.reaches(F(t))) == 0) return kAnyLevel;
        return static_cast<int>(of_lane(levels_.nearest_level(F(t))));
    }

private:
    lod::RayLevels<F>& levels_;
    int pair_ = lod::kNoPair;
    bool are_levels_set_ = false, is_reach_set_ = false;
    float start_[sizeof(F) / sizeof(float)]{}, scale_[sizeof(F) / sizeof(float)]{};
    float level_[sizeof(F) / sizeof(float)]{}, reach_[sizeof(F) / sizeof(float)]{};
};

}  // namespace

Tracer::Tracer(const Frame& frame, std::size_t memory_bytes, BuildTechniques techniques)
    : state_(std::make_unique<State>(std::make_unique<LazyTree>(frame.state(), memory_bytes, techniques, false)))
{
}
Tracer::Tracer(SharedTree& tree) : state_(std::make_unique<State>(*tree.tree_)) {}
Tracer::~Tracer() = default;
TraceCounters Tracer::counters() const
{
    TraceCounters all = state_->counters;
    all.diced = all.grids = 0;  // the tree's own counters have them
    if (state_->own) all += state_->own->totals();
    return all;
}

bool Tracer::State::travel_alone(std::span<const Ray> rays, bool is_nearest) const noexcept
{
    constexpr float kWide = 0.97f, kNarrow = 0.999f;  // cosines of 14 and of 2.5 degrees
    if (are_all_alone) return true;
    if (frame.tree != TreeKind::Bvh) return false;
    // An igrid of a mesh holds up to 2,048 triangles, in whose tree packets pay for any rays.
    if (!frame.has_levels && frame.segments == 0) return false;
    // Where boxes move, a packet has those of all its rays' times. Rays that look for nearest hits lose by that sooner than
    // shadow rays do (docs/what-was-tried.md).
    const float least_cosine = frame.segments > 0 && is_nearest ? kNarrow : kWide;
    const Vec3f way = rays.front().direction;
    return std::any_of(rays.begin(), rays.end(),
                       [&](const Ray& ray) { return glm::dot(ray.direction, way) < least_cosine; });
}

template <int kParts, class Found, class Take>
Tracer::State::PacketResult Tracer::State::run_packet_of(std::span<const Ray> rays, const RayAxes& axes, std::size_t first,
                                                         std::size_t memory_bytes, Take&& take)
{
    PacketQuery<Found, kParts> query;
    const Holes holes(frame, rays, axes, packet_levels<kParts>());
    prepare(query, rays, holes);
    const PacketResult result = in_tree(
        [&](auto way) { return run_packet<decltype(way), kParts>(rays, axes, memory_bytes, query); });
    if (result != PacketResult::Done) return result;
    Blends blends(packet_levels<kParts>());
    for (std::size_t i = 0; i < rays.size(); ++i) take(first + i, i, query, blends);
    return result;
}

template <class Found, class Take>
bool Tracer::State::run(const RayAxes& axes, std::size_t first, std::size_t count, std::size_t memory_bytes, Take&& take)
{
    const bool is_alone = travel_alone({&groups.sorted[first], count}, !std::is_same_v<Found, AnyHit>);
    if (!is_alone && count > kLanes) {
        const PacketResult result = run_packet_of<2, Found>({&groups.sorted[first], count}, axes, 0, memory_bytes, take);
        if (result == PacketResult::Abandoned) return false;
        if (result == PacketResult::Done) return true;
    }
    for (std::size_t at = 0; at < count; at += kLanes) {
        const std::span<const Ray> rays{&groups.sorted[first + at], std::min<std::size_t>(kLanes, count - at)};
        if (!is_alone && rays.size() >= kWorthAPacket) {
            const PacketResult result = run_packet_of<1, Found>(rays, axes, at, memory_bytes, take);
            if (result == PacketResult::Abandoned) return false;
            if (result == PacketResult::Done) continue;
        }
        const Holes holes(frame, rays, axes, single_levels);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            SingleQuery<Found> query;
            query.only = static_cast<int>(i);
            start(query, query.only, rays[i].t_far);
            set_wishes(query, holes);
            if (!in_tree([&](auto way) { return run_single<decltype(way)>(rays[i], axes, memory_bytes, query); }))
                return false;
            Blends blends(single_levels);
            take(at + i, i, query, blends);
        }
    }
    return true;
}

template <bool kWithBlend, class Expect, class Fill>
void Tracer::State::find_nearest(std::span<const Ray> rays, Expect&& expect, Fill&& fill)
{
    for_groups(rays, [&](const RayAxes& axes, std::size_t first, std::size_t count, std::size_t memory_bytes) {
        GridHit met[kPacket];
        const auto take = [&](std::size_t i, std::size_t lane, const Nearest& found, auto& blends) {
            // Members are set one by one: a temporary would be stored in small pieces and loaded in large ones at once.
            GridHit& m = met[i];
            m.t = found.t[lane];
            m.grid = found.grid[lane];
            m.id = found.id[lane];
            m.blend = {};
            m.time = {};
            if (!kWithBlend || !m.grid) return;
            if (m.grid->blends()) m.blend = blends(m.grid->pairs.finest, lane);
            else if (frame.has_levels) m.level = blends.level_at(found, *m.grid, lane);
            if (m.grid->segments > 0) m.time = lod::key_time(groups.sorted[first + i].time, m.grid->segments);
        };
        for (std::size_t i = 0; i < count; ++i) expect(groups.place_of[first + i]);
        if (!run<Nearest>(axes, first, count, memory_bytes, take)) return false;
        fill(axes, first, std::span<const GridHit>(met, count));
        return is_within(memory_bytes);
    });
}

void Tracer::closest(std::span<const Ray> rays, std::span<SurfaceHit> hits)
{
    State& s = *state_;
    // Rays are sorted, so their hits lie far apart. They are loaded while the rays are traced, except for values at
    // vertices, which are rare.
    const auto expect = [&](std::size_t i) { prefetch_to_write(&hits[i], offsetof(SurfaceHit, phase_one)); };
    s.find_nearest<true>(rays, expect, [&](const RayAxes& axes, std::size_t first, std::span<const GridHit> met) {
        for (std::size_t at = 0; at < met.size(); at += kLanes) {
            const std::size_t n = std::min<std::size_t>(kLanes, met.size() - at);
            SurfaceHit* to[kLanes];
            for (std::size_t i = 0; i < n; ++i) {
                to[i] = &hits[s.groups.place_of[first + at + i]];
                if (!met[at + i].grid) to[i]->t = std::numeric_limits<float>::infinity();
            }
            resolve({&s.groups.sorted[first + at], n}, axes, met.subspan(at, n), s.lazy.phase_one(), to);
        }
    });
}

void Tracer::nearest(std::span<const Ray> rays, int most, std::span<SurfaceHit> hits, std::span<HitCount> counts)
{
    State& s = *state_;
    s.wanted_hits = most;
    std::vector<GridHit> met(
        static_cast<std::size_t>(kPacket * most));  // first all rays' nearest hits, then their second ones
    const auto at = [](std::size_t ray, int k) { return static_cast<std::size_t>(k) * kPacket + ray; };
    s.for_groups(rays, [&](const RayAxes& axes, std::size_t first, std::size_t count, std::size_t memory_bytes) {
        int deepest = 0;
        const auto take = [&](std::size_t i, std::size_t lane, const NearestSome& found, auto& blends) {
            HitCount& known = counts[s.groups.place_of[first + i]] = {0, found.count[lane] < most};
            float begin = s.groups.sorted[first + i].t_near;
            for (int k = 0; k < found.count[lane]; ++k) {
                const NearestSome::Hit& hit = found.hits[lane][k];
                if (!(hit.t > begin)) continue;
                GridHit& m = met[at(i, known.count++)] = {hit.t, hit.grid, hit.id, {}, {}, 0};
                if (m.grid->blends()) m.blend = blends(m.grid->pairs.finest, lane);
                else if (s.frame.has_levels) m.level = blends.level_at(m.t, *m.grid, lane);
                if (m.grid->segments > 0) m.time = lod::key_time(s.groups.sorted[first + i].time, m.grid->segments);
                begin = behind(hit.t);
            }
            for (int k = known.count; k < most; ++k) met[at(i, k)].grid = nullptr;
            deepest = std::max<int>(deepest, known.count);
        };
        if (!s.run<NearestSome>(axes, first, count, memory_bytes, take)) return false;
        for (int k = 0; k < deepest; ++k)
            for (std::size_t from = 0; from < count; from += kLanes) {
                const std::size_t n = std::min<std::size_t>(kLanes, count - from);
                SurfaceHit* to[kLanes];
                for (std::size_t i = 0; i < n; ++i)
                    to[i] = &hits[s.groups.place_of[first + from + i] * std::size_t(most) + std::size_t(k)];
                resolve({&s.groups.sorted[first + from], n}, axes, {&met[at(from, k)], n}, s.lazy.phase_one(), to, k == 0);
            }
        return s.is_within(memory_bytes);
    });
}

void Tracer::first_hits(std::span<const Ray> rays, std::span<FirstHit> hits)
{
    State& s = *state_;
    s.find_nearest<false>(
        rays, [](std::size_t) {},
        [&](const RayAxes&, std::size_t first, std::span<const GridHit> met) {
            for (std::size_t i = 0; i < met.size(); ++i) {
                FirstHit& hit = hits[s.groups.place_of[first + i]] = {};
                if (!met[i].grid) continue;
                MicropolygonPlace spot;
                spot.set(met[i]);
                const lod::PosedCage& cage = *met[i].grid->cage;
                hit = {met[i].t, cage.node_id, cage.cage_id, spot.face, cage.instance};
            }
        });
}

void Tracer::occluded(std::span<const Ray> rays, std::span<std::uint8_t> occluded)
{
    State& s = *state_;
    const std::uint64_t diced = s.counters.diced, for_camera = s.counters.diced_for_camera;
    s.for_groups(rays, [&](const RayAxes& axes, std::size_t first, std::size_t count, std::size_t memory_bytes) {
        const auto take = [&](std::size_t i, std::size_t lane, const AnyHit& found, auto&) {
            occluded[s.groups.place_of[first + i]] = found.t[lane] == kDead;
        };
        return s.run<AnyHit>(axes, first, count, memory_bytes, take);
    });
    // Rays that only ask for occlusion are not the camera's, whatever their kinds are.
    s.counters.diced_for_camera = for_camera;
    s.counters.diced_for_occlusion += s.counters.diced - diced;
}

SharedTree::SharedTree(const Frame& frame, std::size_t memory_bytes)
    : tree_(std::make_unique<LazyTree>(frame.state(), memory_bytes, BuildTechniques(), true))
{
}
SharedTree::~SharedTree() = default;
TraceCounters SharedTree::counters() const { return tree_->totals(); }

}  // namespace occam::accel
