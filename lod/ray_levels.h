// A ray's table of transitions: in which range of distances it sees which pair of levels, and how far each vertex has moved
// from its fine to its coarse position.
//
// Djeu et al. 2011, sec. 5.1.2 and 5.2.6; the constants are those of docs/watertightness.md, rules 11 to 14. A ray sees pair
// l where d_l <= target edge length < d_(l+1). F is vfloat (lanes are rays) or float (one ray): both use the same operations
// and so give the same bits.
//
// Transition b lies between pair b - 1 and pair b. Where the footprint grows, transitions are pushed away from the ray's
// start until each segment between two of them is at least two margins long; where it shrinks, they are pulled towards the
// start from the ray's end. So nothing is coarser than the target. Constant, zero and infinite widths need no special case:
// a constant width is treated as growing by next to nothing, and its transitions are far away.
#pragma once

#include <algorithm>
#include <bit>
#include <cfloat>
#include <cstdint>

#include "base/simd.h"
#include "lod/footprint.h"
#include "lod/rates.h"

namespace occam::lod {

/// Returns the weight of the coarse position where the fraction `ramp` of the way from fine to coarse is done (0 at the fine
/// end, 1 at the coarse end, and values beyond). It is a smoothstep, exactly 0 and 1 from the ends on. All blending of
/// levels takes its weight from here.
template <class F>
OCCAM_ALWAYS_INLINE F coarse_weight(F ramp) noexcept
{
    const F x = min(max(ramp, F(0.0f)), F(1.0f));
    return x * x * (F(3.0f) - (x + x));
}

/// Says how a vertex at distance t of the ray moves from fine to coarse: w = coarse_weight((t - start) * scale).
template <class F>
struct Blend {
    F start, scale;

    F weight(F t) const noexcept { return coarse_weight((t - start) * scale); }
};

/// The width by which the transitions of a ray are chosen: it asks for edges of the length a + b t.
/// start   the edge length of the level on whose mesh the ray starts; 0 if it may start anywhere
/// focus   if above 0, `start` is the level not of the ray's origin but of the place at this distance, where the ray begins
///         or ends. The ray is thinnest there, and a may be below 0
template <class F>
struct RayWidth {
    F a, b;
    F start = 0.0f, focus = 0.0f;
};

template <class F>
class RayLevels {
public:
    using Mask = decltype(F() < F());
    static constexpr int kMostOfRay = 16;  ///< most pairs of one ray; the finest of them serves everything nearer
    static constexpr int kMost = 32;       ///< most pairs of all lanes together
    static constexpr float kFinerThanEven = 0x1p-5f, kLeastOfDisplaced = 0x1p-6f;  ///< see find_ends()
    static constexpr float kFar = 1e30f;

    /// t_in, t_end   where the ray enters the scene, and where it leaves the scene or ends; both finite
    /// coordinate    the largest coordinate of the ray's origin
    /// Returns false if the lanes have more than kMost pairs, because they cannot travel together then.
    ///
    /// A ray with a start sees only the mesh of its start around its origin. If its width grows, the start counts as a
    /// transition at t = 0, which keeps its margin. If the width shrinks, the pair of the start stays fine until the
    /// transition to the next finer pair, and all further transitions are pushed away from the start.
    /// A ray with a focus sees only the mesh of its start around the focus, which counts as a transition and keeps its
    /// margin: all others are pushed away from there, behind it if the width grows and before it if the width shrinks.
    bool set(RayWidth<F> width, F t_in, F t_end, F coordinate, const LevelSettings& settings) noexcept
    {
        settings_ = &settings;
        const F zero = 0.0f;
        a_ = select(width.focus > zero, width.a, max(width.a, zero));
        b_ = width.b;
        start_ = width.start;
        focus_ = width.focus;
        t_end_ = t_end;
        const F of_one(settings.overlap_ulps * 0x1p-24f);
        least_ulps_ = max(coordinate, F(settings.least_coordinate)) * of_one;
        most_ulps_ = max(least_ulps_, t_end_ * of_one);
        const F at_origin = max(a_, zero), at_end = max(a_ + b_ * t_end_, zero);
        // There is no surface before the ray enters the scene, so the width there decides the finest pair.
        const F at_start = min(max(a_ + b_ * t_in, zero), at_end);
        find_ends({max(at_origin, at_end), min(at_origin, at_end), at_start, abs(b_) * F(8 * settings.displaced),
                   abs(b_) * (F(4.0f) * least_ulps_)});
        is_made_ = false;
        return coarsest - finest < kMost;
    }

    /// Makes the table, which only the following functions need: rays that see one mesh all along do without it.
    void make() noexcept
    {
        if (is_made_) return;
        is_made_ = true;
        grows_ = b_ >= F(0.0f);
        // A width that hardly changes is treated as changing by 10^-24 of itself, so that nothing is divided by 0.
        const F least = abs(a_) * F(1e-24f) + F(1e-37f);
        const F per_slope = F(1.0f) / select(grows_, max(b_, least), min(b_, F(0.0f) - least));
        // A transition is no farther away than where the ray's width says, except for what margins push it. Behind a focus
        // the width says no more than how much farther than the focus it is.
        const F of_one(settings_->overlap_ulps * 0x1p-24f), pushed_by = F(256 * settings_->displaced) + focus_;
        ulps_of_edge_ = select(grows_, per_slope * of_one, F(0.0f));
        ulps_of_all_ = (select(grows_, F(0.0f), F(0.0f) - a_ * per_slope) + pushed_by) * of_one;
        const Mask has_start = start_ > F(0.0f);
        const bool some_have_none = any(andnot(Mask(true), has_start));
        if (some_have_none) make_from_origin(per_slope);
        if (any(has_start)) make_from_start(per_slope, some_have_none);
        F before = overlap(finest);
        for (int pair = finest; pair <= coarsest; ++pair) {
            const int i = pair - finest;
            const F after = overlap(pair + 1);
            begin_[i] = select(grows_, edge_[i] - before, edge_[i + 1] - after);
            end_[i] = select(grows_, edge_[i + 1] + after, edge_[i] + before);
            first_[i] = lowest(begin_[i]);
            last_[i] = highest(end_[i]);
            before = after;
        }
    }

    /// Removes pairs that no ray sees in [near, far] from both ends of [low, high], whose pairs some lane has.
    void narrow(float near, float far, int& low, int& high) const noexcept
    {
        const auto is_away = [&](int pair) { return last_[pair - finest] < near || first_[pair - finest] > far; };
        while (low < high && is_away(low)) ++low;
        while (low < high && is_away(high)) --high;
    }

    int finest = 0, coarsest = 0;  ///< the range of pairs that some lane has

    /// Returns where pair p's part of each ray begins, overlaps included. Lanes without the pair get an empty range (begin >
    /// end).
    F begin(int pair) const noexcept { return begin_[pair - finest]; }
    F end(int pair) const noexcept { return end_[pair - finest]; }
    /// Returns the same for the pairs [low, high] together, as far as they exist.
    F begin(int low, int high) const noexcept
    {
        return select(grows_, begin(std::clamp(low, finest, coarsest)), begin(std::clamp(high, finest, coarsest)));
    }
    F end(int low, int high) const noexcept
    {
        return select(grows_, end(std::clamp(high, finest, coarsest)), end(std::clamp(low, finest, coarsest)));
    }

    /// Notes between which t the rays see what is diced: the tables of other rays, and of other places, say nothing. Rays
    /// that are not among `those` see it nowhere.
    void note_reach(Mask those, F from, F to) noexcept
    {
        const F nowhere = kFar;
        sees_from_ = select(those, from, nowhere);
        sees_to_ = to;
    }
    /// Returns 1 for rays that see what is diced around t, and 0 for others.
    F reaches(F t) const noexcept
    {
        const F zero = 0.0f, one = 1.0f;
        return select((sees_from_ <= t) & (t <= sees_to_), one, zero);
    }

    /// Returns the level whose mesh each ray sees at t, or the nearer one of the two that it sees blended there. It makes
    /// the table.
    F nearest_level(F t) noexcept
    {
        make();
        int low = finest, high = coarsest;
        narrow(lowest(t), highest(t), low, high);
        const F zero = 0.0f, one = 1.0f;
        F level = static_cast<float>(low), reaches_pair = one;
        for (int pair = low; pair <= high; ++pair) {
            const F edge = edge_[pair + 1 - finest];
            const F reaches_next = pair == high ? zero
                                                : select(grows_, select(edge <= t, one, zero), select(t < edge, one, zero));
            level = level + reaches_next;
            const Mask sees_pair = reaches_pair > reaches_next;
            if (any(sees_pair)) level = level + select(sees_pair & (blend(pair).weight(t) >= F(0.5f)), one, zero);
            reaches_pair = reaches_next;
        }
        return level;
    }

    Blend<F> blend(int pair) const noexcept
    {
        const F m = margin(pair), zero = 0.0f, far_away = kFar;
        const F lower = raw_[pair - finest], upper = raw_[pair + 1 - finest];
        // Margins are kept at transitions, but not at the ray's own ends, where the finest or the coarsest segment may be
        // too short for them. The start of a ray that begins on a mesh is a transition, and so is a focus.
        const Mask is_start = are_same(start_, F(edge_length(pair)));
        const Mask starts_at_end = is_start & (grows_ | (focus_ > zero));
        const Mask lower_is_real = (abs(edge_[pair - finest]) < far_away) | starts_at_end;
        const Mask upper_is_real = abs(edge_[pair + 1 - finest]) < far_away;
        const F fine = select(grows_, lower + select(lower_is_real, m, zero), lower - select(lower_is_real, m, zero));
        const F coarse = select(grows_, upper - m, upper + select(upper_is_real, m, zero));
        // The ramp is a little steeper than from one end to the other, so that rounding never keeps a weight off its end.
        const F steep = F(1.0f + 0x1p-20f) / max(abs(coarse - fine), F(1e-30f));
        const F grown = select(lower_is_real, fine, min(fine, coarse)),
                shrunk = select(lower_is_real, fine, max(fine, coarse));
        // If the width shrinks from the start on, the pair of the start stays fine all along.
        const Mask stays_fine = andnot(is_start, starts_at_end);
        return {select(grows_, grown, select(stays_fine, F(-kFar), shrunk)), select(grows_, steep, zero - steep)};
    }

    /// Returns the length of the margin at each end of a segment.
    F margin(int pair) const noexcept
    {
        const F rounding = ulps(pair + 1);
        return F(2 * settings_->edges.at(pair) + 4 * settings_->displaced) +
               max(F(settings_->overlap_edges * edge_length(pair)), rounding) + rounding;
    }
    /// Returns the length by which the segments at transition b overlap, on either side.
    F overlap(int b) const noexcept { return max(F(settings_->overlap_edges * edge_length(b - 1)), ulps(b)); }

private:
    /// Returns LevelSettings::overlap_ulps of the largest coordinate at transition b: that of the ray's origin, or the
    /// distance of the transition.
    F ulps(int b) const noexcept
    {
        return max(least_ulps_, min(most_ulps_, F(edge_length(b)) * ulps_of_edge_ + ulps_of_all_));
    }
    /// Returns the level of an edge length.
    static int level_of(float edge) noexcept { return static_cast<int>(std::bit_cast<std::uint32_t>(edge) >> 23) - 127; }
    static Mask are_same(F x, F y) noexcept { return (x <= y) & (x >= y); }

    /// Sets the transitions of all lanes, as is right for those that have no start.
    void make_from_origin(F per_slope) noexcept
    {
        const F low = -kFar, high = kFar;
        F previous = select(grows_, low, high);
        for (int at = finest; at <= coarsest + 1; ++at) {
            const F d = edge_length(at);
            const F ideal = min(max((d - a_) * per_slope, low), high);
            const F length = margin(at - 1) + margin(at - 1);
            const F pushed = select(grows_, max(ideal, previous + length), min(ideal, previous - length));
            // There is no transition before the ray's start, past its end, below the finest pair of a lane, or above its
            // coarsest one: a lane has the same table whatever pairs the others have.
            const Mask is_finest = d <= finest_edge_, is_beyond = d > coarsest_edge_;
            const Mask none_before = (pushed <= F(0.0f)) | (grows_ & is_finest);
            const Mask none_after = andnot((pushed >= t_end_) | is_finest, grows_);
            raw_[at - finest] = pushed;
            const F edge = select(none_after, high, select(none_before, low, pushed));
            edge_[at - finest] = select(is_beyond, select(grows_, high, low), edge);
            previous = select(grows_, select(none_before, low, pushed), select(none_after, high, pushed));
        }
    }
    /// Sets the transitions of the lanes that have a start: each is at least a segment away from the one before it, as
    /// seen from the start or from the focus.
    /// is_set   whether those of all lanes are set already, and those of the other lanes stay
    void make_from_start(F per_slope, bool is_set) noexcept
    {
        const F low = -kFar, high = kFar, zero = 0.0f;
        const Mask has_start = start_ > zero, has_focus = focus_ > zero;
        const auto put = [&](int at, Mask lanes, F pushed, F edge) {
            raw_[at - finest] = is_set ? select(lanes, pushed, raw_[at - finest]) : pushed;
            edge_[at - finest] = is_set ? select(lanes, edge, edge_[at - finest]) : edge;
        };
        const auto ideal = [&](F d) { return min(max((d - a_) * per_slope, low), high); };
        const Mask widens = grows_ | has_focus;  // away from the start
        const Mask coarsens = has_start & widens, refines = andnot(has_start, widens);
        const F inner = select(grows_, low, high), outer = select(grows_, high, low);
        F previous = focus_;
        for (int at = finest; at <= coarsest + 1 && any(coarsens); ++at) {
            const F d = edge_length(at), length = margin(at - 1) + margin(at - 1);
            const Mask is_before = d <= start_;
            const F away = select(grows_, max(ideal(d), previous + length), min(ideal(d), previous - length));
            const F pushed = select(is_before, focus_, away);
            const Mask is_last = (grows_ & (pushed >= t_end_)) | andnot(pushed <= zero, grows_) | (d > coarsest_edge_);
            put(at, coarsens, pushed, select(is_before, inner, select(is_last, outer, pushed)));
            previous = pushed;
        }
        is_set = is_set || any(coarsens);
        previous = zero;
        for (int at = coarsest + 1; at >= finest && any(refines); --at) {
            const F d = edge_length(at), length = margin(at) + margin(at);
            const Mask is_before = d > start_;
            const F pushed = select(is_before, zero, max(ideal(d), select(are_same(d, start_), zero, previous + length)));
            const Mask is_last = (pushed >= t_end_) | (d <= finest_edge_);
            put(at, refines, pushed, select(is_before, low, select(is_last, high, pushed)));
            previous = pushed;
        }
    }

    /// Holds the extreme widths of a ray.
    struct Extremes {
        F widest, thinnest;
        /// The width where a growing ray enters the scene; at most the width at its end.
        F start;
        /// Where displacement makes margins long, pairs of edges shorter than this have segments whose length follows from
        /// the margins and not from the edges. A beam that begins as a point would see many such pairs, each much finer than
        /// its target, so it begins with this pair. Any other beam may start on the surface that scattered it and goes down
        /// further: to edges of kFinerThanEven of this length, or of kLeastOfDisplaced of the displacement if that is
        /// longer.
        F even;
        /// The same where the overlap of segments makes margins long, because the ray begins where coordinates are large:
        /// pairs of shorter edges have segments whose length follows from rounding. No beam sees finer ones.
        F rounded;
    };
    /// Returns the edge length of the pair that a target edge length asks for.
    static F edge_at(F target) noexcept
    {
        return min(max(power_of_two_at_most(target), F(edge_length(kFinestLevel))), F(edge_length(kCoarsestLevel)));
    }
    /// Sets the finest and the coarsest pair, of each lane and of all lanes.
    void find_ends(const Extremes& widths) noexcept
    {
        const F most_finer(edge_length(1 - kMostOfRay)), most_coarser(edge_length(kMostOfRay - 1)), zero = 0.0f;
        const F widest = edge_at(widths.widest), thinnest = edge_at(widths.thinnest);
        F cap = max(widest * most_finer, min(widest, edge_at(widths.rounded)));
        if (settings_->displaced > 0) {
            const F down = max(widths.even * F(kFinerThanEven), F(settings_->displaced * kLeastOfDisplaced));
            const F least = select(widths.thinnest > zero, min(widths.even, down), widths.even);
            cap = max(cap, min(widest, edge_at(least)));
        }
        finest_edge_ = max(thinnest, max(cap, edge_at(widths.start)));
        coarsest_edge_ = widest;
        if (const Mask has_start = start_ > zero; any(has_start)) {
            const F start = edge_at(start_);
            const Mask widens = (b_ >= zero) | (focus_ > zero);  // away from the start
            const F low = select(widens, start, min(max(thinnest, start * most_finer), start));
            const F high = select(widens, min(max(widest, start), start * most_coarser), start);
            finest_edge_ = select(has_start, low, finest_edge_);
            coarsest_edge_ = select(has_start, high, coarsest_edge_);
        }
        finest = level_of(lowest(finest_edge_));
        coarsest = level_of(highest(coarsest_edge_));
    }

    const LevelSettings* settings_ = nullptr;
    F a_, b_, start_, focus_, t_end_;
    F sees_from_, sees_to_;
    F least_ulps_, most_ulps_;       ///< bounds of ulps()
    F ulps_of_edge_, ulps_of_all_;   ///< what a transition has of them, by its edge length and by itself
    F finest_edge_, coarsest_edge_;  ///< edge lengths of the first and the last pair of each lane
    Mask grows_;
    bool is_made_ = false;
    F raw_[kMost + 1], edge_[kMost + 1];
    F begin_[kMost], end_[kMost];  ///< of each pair, with overlaps
    /// For each pair: the first distance at which it begins for any ray, and the last at which it ends.
    float first_[kMost], last_[kMost];
};

}  // namespace occam::lod
