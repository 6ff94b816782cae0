// Dicing rates: how many pieces an edge and a face have at a level. Always powers of two, halving exactly from level to level.
//
// Djeu et al. 2011, sec. 5.1.3. A curve of largest speed s (world length per unit of its parameter) has 2^max(m, k - l) pieces
// at level l, k = ceil(log2 s) taken once as an integer: a logarithm per level would fail to halve for round lengths. Speed,
// not length: length bounds no piece. So no piece is longer than d_l = 2^l.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace occam::lod {

inline constexpr int kMaxExponent = 12;  ///< 4096 pieces: what one face may have along a side
inline constexpr int kMinLength = -200;  ///< exponent of a speed of 0

/// ceil(log2(s)) by frexp; kMinLength for s <= 0 and NaN.
inline int ceil_log2(float s) noexcept
{
    if (!(s > 0) || std::isinf(s)) return s > 0 ? kMaxExponent + 128 : kMinLength;
    int e;
    return std::frexp(s, &e) == 0.5f ? e - 1 : e;
}

/// Exponent of a curve's rate at a level.
inline int curve_exponent(int k, int least, int level) noexcept { return std::clamp(k - level, least, kMaxExponent); }

/// Exponents of a patch's rates at a level.
struct PatchRates {
    int u = 0, v = 0;              ///< of the inside
    std::array<int, 4> side{};     ///< of each side's own vertices; at most u (sides 0, 2) or v (1, 3)
};

/// The inside of a patch at a level. ku, kv: of the inside and of its sides, whichever is largest; mu, mv: least exponents of
/// the sides. Both axes halve together and stop together: else a coarse diagonal would cross a row that the finer level has.
inline void inside_exponents(int ku, int kv, int mu, int mv, int level, int& u, int& v) noexcept
{
    const int steps = std::min({level, ku - mu, kv - mv});
    u = std::clamp(ku - steps, mu, kMaxExponent);
    v = std::clamp(kv - steps, mv, kMaxExponent);
}

}  // namespace occam::lod
