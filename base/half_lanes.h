// Converts many floats to half floats at once.
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/half.h"
#include "base/simd.h"

namespace occam {

/// Converts `count` floats as finite_half_from_float() does, with the same bits in every build.
inline void finite_halves_from_floats(const float* from, std::size_t count, std::uint16_t* to) noexcept
{
    std::size_t i = 0;
#ifndef OCCAM_ONE_LANE
    const hn::CappedTag<float, 8> floats;
    const hn::Rebind<hwy::float16_t, decltype(floats)> halves;
    const auto most = hn::Set(floats, 65504.0f);
    for (; i + hn::Lanes(floats) <= count; i += hn::Lanes(floats)) {
        const auto x = hn::LoadU(floats, from + i);
        const auto number = hn::IfThenElseZero(hn::Eq(x, x), x);
        const auto finite = hn::Max(hn::Min(number, most), hn::Neg(most));
        hn::StoreU(hn::DemoteTo(halves, finite), halves, reinterpret_cast<hwy::float16_t*>(to + i));
    }
#endif
    for (; i < count; ++i) to[i] = finite_half_from_float(from[i]);
}

}  // namespace occam
