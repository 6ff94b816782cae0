// A ray's table of transitions: from where to where it sees which pair of levels, and how far each vertex has gone from the
// finer to the coarser.
//
// Djeu et al. 2011, sec. 5.1.2 and 5.2.6; the constants are those of docs/watertightness.md, rules 11 to 14. Pair l serves
// a ray where d_l <= target edge length < d_(l+1). F is vfloat (lanes are rays) or float (one ray): the same operations, so
// the same bits.
//
// Transition b lies between pair b - 1 and pair b. Where the footprint grows, transitions are pushed away from the ray's
// start until each segment between two of them is at least two margins long; where it shrinks, they are pulled towards it
// from the ray's end. So nothing is coarser than asked. Constant, zero and infinite widths are ordinary: a width that does
// not change grows by next to nothing, and its transitions are far away.
#pragma once

#include <bit>
#include <cfloat>
#include <cstdint>
#include <type_traits>

#include "base/simd.h"
#include "lod/footprint.h"
#include "lod/rates.h"

namespace occam::lod {

/// The weight of the coarse position where the way from fine to coarse is done up to `ramp` (0 at the fine end, 1 at the
/// coarse end, also beyond): a smoothstep, exactly 0 and 1 from the ends on. Everything that blends levels takes its weight
/// from here.
template <class F>
OCCAM_ALWAYS_INLINE F coarse_weight(F ramp) noexcept
{
    const F x = min(max(ramp, F(0.0f)), F(1.0f));
    return x * x * (F(3.0f) - (x + x));
}

/// How a vertex at distance t of the ray goes from fine to coarse: w = coarse_weight((t - start) * scale).
template <class F>
struct Blend {
    F start, scale;

    F weight(F t) const noexcept { return coarse_weight((t - start) * scale); }
};

template <class F>
class RayLevels {
public:
    using Mask = decltype(F() < F());
    static constexpr int kMostOfRay = 16;  ///< pairs of one ray: the finest serves all that is nearer
    static constexpr int kMost = 32;       ///< of all lanes together
    static constexpr float kFinerThanEven = 0x1p-5f, kLeastOfDisplaced = 0x1p-6f;  ///< see floor_exponents
    static constexpr float kFar = 1e30f;

    /// width    a + b t: the wanted edge; t_in, t_end: where the ray enters the scene, and leaves it or ends, finite;
    /// coordinate: the largest of
    ///          ray and scene.
    /// Returns false if the lanes have more than kMost pairs: then they cannot travel together.
    bool set(F a, F b, F t_in, F t_end, F coordinate, const LevelSettings& settings) noexcept
    {
        settings_ = &settings;
        a_ = max(a, F(0.0f));
        b_ = b;
        t_end_ = t_end;
        ulps_ = coordinate * F(settings.overlap_ulps * 0x1p-24f);
        const F at_end = max(a_ + b_ * t_end_, F(0.0f));
        // What is finer than the width where the ray enters the scene meets nothing.
        const F at_start = min(max(a_ + b_ * t_in, F(0.0f)), at_end);
        cap_ = floor_exponents(max(a_, at_end), min(a_, at_end), at_start, abs(b_) * F(8 * settings.displaced));
        is_made_ = false;
        return coarsest - finest < kMost;
    }

    /// Makes the table, which nothing but the following asks for: rays that see one mesh all along do without.
    void make() noexcept
    {
        if (is_made_) return;
        is_made_ = true;
        grows_ = b_ >= F(0.0f);
        // Never divide by 0: what hardly changes changes by 10^-24 of itself.
        const F least = a_ * F(1e-24f) + F(1e-37f);
        const F per_slope = F(1.0f) / select(grows_, max(b_, least), min(b_, F(0.0f) - least));
        const F low = -kFar, high = kFar;
        F previous = select(grows_, low, high);
        for (int at = finest; at <= coarsest + 1; ++at) {
            const F d = edge_length(at);
            const F ideal = min(max((d - a_) * per_slope, low), high);
            const F length = margin(at - 1) + margin(at - 1);
            const F pushed = select(grows_, max(ideal, previous + length), min(ideal, previous - length));
            // Before the ray's start, past its end, and below the finest pair of a lane, there is none.
            const Mask none_before = (pushed <= F(0.0f)) | (grows_ & (d <= cap_));
            const Mask none_after = andnot((pushed >= t_end_) | (d <= cap_), grows_);
            raw_[at - finest] = pushed;
            F edge = select(none_after, high, select(none_before, low, pushed));
            if (at == finest) edge = select(grows_, low, high);
            if (at == coarsest + 1) edge = select(grows_, high, low);
            edge_[at - finest] = edge;
            previous = select(grows_, select(none_before, low, pushed), select(none_after, high, pushed));
        }
        for (int pair = finest; pair <= coarsest; ++pair) {
            first_[pair - finest] = lowest(begin(pair));
            last_[pair - finest] = highest(end(pair));
        }
    }

    /// Leaves out pairs that no ray sees in [near, far], from both ends of [low, high], which are pairs that some lane has.
    void narrow(float near, float far, int& low, int& high) const noexcept
    {
        const auto is_away = [&](int pair) { return last_[pair - finest] < near || first_[pair - finest] > far; };
        while (low < high && is_away(low)) ++low;
        while (low < high && is_away(high)) --high;
    }

    int finest = 0, coarsest = 0;  ///< pairs that some lane has

    /// Pair p's part of each ray, overlaps included; empty (begin > end of anything) for lanes without it.
    F begin(int pair) const noexcept
    {
        const F near = select(grows_, edge_[pair - finest], edge_[pair + 1 - finest]);
        return near - select(grows_, overlap(pair), overlap(pair + 1));
    }
    F end(int pair) const noexcept
    {
        const F far = select(grows_, edge_[pair + 1 - finest], edge_[pair - finest]);
        return far + select(grows_, overlap(pair + 1), overlap(pair));
    }
    /// Of the pairs [low, high] together, as far as there are such.
    F begin(int low, int high) const noexcept
    {
        return select(grows_, begin(std::clamp(low, finest, coarsest)), begin(std::clamp(high, finest, coarsest)));
    }
    F end(int low, int high) const noexcept
    {
        return select(grows_, end(std::clamp(high, finest, coarsest)), end(std::clamp(low, finest, coarsest)));
    }

    Blend<F> blend(int pair) const noexcept
    {
        const F m = margin(pair), zero = 0.0f, far_away = kFar;
        const F lower = raw_[pair - finest], upper = raw_[pair + 1 - finest];
        // Margins are kept at transitions: not at the ray's own ends, where the finest or the coarsest segment may be too
        // short for them.
        const Mask lower_is_real = abs(edge_[pair - finest]) < far_away;
        const Mask upper_is_real = abs(edge_[pair + 1 - finest]) < far_away;
        const F fine = select(grows_, lower + select(lower_is_real, m, zero), lower - select(lower_is_real, m, zero));
        const F coarse = select(grows_, upper - m, upper + select(upper_is_real, m, zero));
        // A little steeper than from one to the other, so that rounding never keeps a weight off its end.
        const F steep = F(1.0f + 0x1p-20f) / max(abs(coarse - fine), F(1e-30f));
        const F grown = select(lower_is_real, fine, min(fine, coarse)),
                shrunk = select(lower_is_real, fine, max(fine, coarse));
        return {select(grows_, grown, shrunk), select(grows_, steep, zero - steep)};
    }

    /// What each end of a segment keeps flat.
    F margin(int pair) const noexcept
    {
        const float d = edge_length(pair);
        return F(2 * d + 4 * settings_->displaced) + max(F(settings_->overlap_edges * d), ulps_) + ulps_;
    }
    /// By which the segments at transition b overlap, on either side.
    F overlap(int b) const noexcept { return max(F(settings_->overlap_edges * edge_length(b - 1)), ulps_); }

private:
    static int exponent_of(float x) noexcept
    {
        const auto e = static_cast<int>(std::bit_cast<std::uint32_t>(x) >> 23 & 0xff) - 127;
        return std::clamp(e, kFinestLevel, kCoarsestLevel);
    }
    /// Sets finest and coarsest; returns the finest level of each lane.
    /// even   where displacement makes margins long, pairs of shorter edges than this have segments as long as margins ask,
    /// and not
    ///        as edges do. A beam that begins as a point would see many such pairs, each much finer than it asks for, so it
    ///        begins with this one. Any other may start on what it was scattered by, and goes on down: to edges of
    ///        kFinerThanEven of it, or of kLeastOfDisplaced of what displacement does if that is longer.
    /// start  the width where a growing ray enters the scene; at most that at its end.
    F floor_exponents(F widest, F thinnest, F start, F even) noexcept
    {
        constexpr int kCount = sizeof(F) / sizeof(float);
        float wide[kCount], thin[kCount], first[kCount], least[kCount];
        if constexpr (std::is_same_v<F, float>) {
            wide[0] = widest;
            thin[0] = thinnest;
            first[0] = start;
            least[0] = even;
        } else {
            widest.store(wide);
            thinnest.store(thin);
            start.store(first);
            even.store(least);
        }
        finest = kCoarsestLevel;
        coarsest = kFinestLevel;
        for (int i = 0; i < kCount; ++i) {
            const int high = exponent_of(wide[i]);
            int cap = high - kMostOfRay + 1;
            if (settings_->displaced > 0) {
                const float down = std::max(least[i] * kFinerThanEven, settings_->displaced * kLeastOfDisplaced);
                cap = std::max(cap, std::min(high, exponent_of(thin[i] > 0 ? std::min(least[i], down) : least[i])));
            }
            cap = std::max(cap, exponent_of(first[i]));
            const int low = std::max(exponent_of(thin[i]), cap);
            finest = std::min(finest, low);
            coarsest = std::max(coarsest, high);
            wide[i] = edge_length(cap);
        }
        if constexpr (std::is_same_v<F, float>) return wide[0];
        else return F::load(wide);
    }

    const LevelSettings* settings_ = nullptr;
    F a_, b_, t_end_, ulps_, cap_;
    Mask grows_;
    bool is_made_ = false;
    F raw_[kMost + 1], edge_[kMost + 1];
    float first_[kMost], last_[kMost];  ///< of each pair: where it begins for the first of the rays, and ends for the last
};

}  // namespace occam::lod
