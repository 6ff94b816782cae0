// Dicing rates: the number of pieces of an edge and of a face at a level. Rates are powers of two that halve exactly from
// level to level.
//
// Djeu et al. 2011, sec. 5.1.3. A curve of largest speed s (world length per unit of its parameter) has 2^max(m, k - l)
// pieces at level l. Here k = ceil(log2 s) is computed once, as an integer: a logarithm for each level would not halve
// exactly for round lengths. The rate follows from speed and not from length, because length bounds no piece. So no piece is
// longer than d_l = 2^l.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace occam::lod {

inline constexpr int kMaxExponent = 20;  ///< largest exponent of a rate; every patch keeps to it at its cage's finest level
inline constexpr int kMinLength = -200;  ///< exponent of a speed of 0
inline constexpr int kMaxAspect = 4;     ///< a patch thinner than 1 : 16 is diced as if it were as wide

/// The levels, and pairs of levels, that are considered. No scene has scales beyond them.
inline constexpr int kFinestLevel = -60, kCoarsestLevel = 60;
/// A pair coarser than all others.
inline constexpr int kNoPair = kCoarsestLevel + 1;

/// Returns ceil(log2(s)) by frexp; kMinLength for s <= 0 and NaN.
inline int ceil_log2(float s) noexcept
{
    if (!(s > 0) || std::isinf(s)) return s > 0 ? kMaxExponent + 128 : kMinLength;
    int e;
    return std::frexp(s, &e) == 0.5f ? e - 1 : e;
}

/// Returns the exponent of a curve's rate at a level.
inline int curve_exponent(int k, int least, int level) noexcept { return std::clamp(k - level, least, kMaxExponent); }

/// The exponents of a patch's rates at a level.
struct PatchRates {
    int u = 0, v = 0;           ///< exponents of the inside
    std::array<int, 4> side{};  ///< exponents of each side's own vertices; at most u (sides 0, 2) or v (1, 3)
    /// For displaced cages, the level whose edge length is the filter width of the texture; else a constant.
    int filter = kFinestLevel - 1;
    friend bool operator==(const PatchRates&, const PatchRates&) = default;
};

/// The size of a patch, from which its rates at all levels follow.
struct PatchScale {
    /// The ceil(log2) of the largest speed along u and along v, inside and on the sides.
    std::array<int, 2> k{kMinLength, kMinLength};
    std::array<int, 2> least{};                 ///< least exponents along u and v, because of the sides
    std::array<int, 4> side_k{}, side_least{};  ///< for each side, per unit of the patch's parameter
    int filter_stops = kFinestLevel - 1;        ///< displacement is the same from this level on

    /// Completes k, so that no patch counts as thinner than kMaxAspect.
    void limit_aspect() noexcept
    {
        for (int a : {0, 1}) k[a] = std::max({k[a], k[1 - a] - kMaxAspect, kMinLength});
    }
    /// Returns the level from which on the inside is the same. Both axes halve together and stop together; otherwise a
    /// coarse diagonal would cross a row that the finer level has.
    int inside_stops() const noexcept { return std::min(k[0] - least[0], k[1] - least[1]); }
    int inside(int axis, int level) const noexcept
    {
        return std::clamp(k[axis] - std::min(level, inside_stops()), least[axis], kMaxExponent);
    }
    PatchRates rates(int level) const noexcept
    {
        PatchRates r{inside(0, level), inside(1, level), {}, std::min(level, filter_stops)};
        for (int s = 0; s < 4; ++s) r.side[s] = curve_exponent(side_k[s], side_least[s], level);
        return r;
    }
    /// Returns the level from which on nothing changes any more.
    int coarsest() const noexcept
    {
        int level = std::max(inside_stops(), filter_stops);
        for (int s = 0; s < 4; ++s) level = std::max(level, side_k[s] - side_least[s]);
        return level;
    }
};

}  // namespace occam::lod
