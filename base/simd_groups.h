// Several vfloats as one, for packets of more rays than there are lanes.
//
// Each operation runs on its parts, one after the other. Lanes are independent, so a ray has the same bits in a packet of
// any size. The parts do not wait for each other, which hides the latency of the few operations of a traversal step.
#pragma once

#include <cstring>
#include <type_traits>

#include "base/simd.h"

namespace occam {

template <int kParts>
struct vmasks {
    vmask part[kParts];

    vmasks() = default;
    explicit vmasks(bool all) noexcept
    {
        for (vmask& p : part) p = vmask(all);
    }
    OCCAM_ALWAYS_INLINE friend vmasks operator&(vmasks a, const vmasks& b) noexcept
    {
        for (int i = 0; i < kParts; ++i) a.part[i] = a.part[i] & b.part[i];
        return a;
    }
    OCCAM_ALWAYS_INLINE friend vmasks operator|(vmasks a, const vmasks& b) noexcept
    {
        for (int i = 0; i < kParts; ++i) a.part[i] = a.part[i] | b.part[i];
        return a;
    }
    OCCAM_ALWAYS_INLINE friend vmasks andnot(vmasks a, const vmasks& b) noexcept
    {
        for (int i = 0; i < kParts; ++i) a.part[i] = andnot(a.part[i], b.part[i]);
        return a;
    }
    OCCAM_ALWAYS_INLINE friend bool any(const vmasks& a) noexcept
    {
        vmask all = a.part[0];
        for (int i = 1; i < kParts; ++i) all = all | a.part[i];
        return any(all);
    }
    OCCAM_ALWAYS_INLINE friend bool none(const vmasks& a) noexcept { return !any(a); }
    /// Returns the lanes as bits, where bit i is lane i.
    OCCAM_ALWAYS_INLINE friend unsigned bits(const vmasks& a) noexcept
    {
        unsigned all = 0;
        for (int i = 0; i < kParts; ++i) all |= bits(a.part[i]) << (i * kLanes);
        return all;
    }
};

template <int kParts>
struct vfloats {
    using Mask = vmasks<kParts>;
    vfloat part[kParts];

    vfloats() = default;
    vfloats(float x) noexcept
    {
        for (vfloat& p : part) p = vfloat(x);
    }
    OCCAM_ALWAYS_INLINE static vfloats load(const float* p) noexcept
    {
        vfloats v;
        for (int i = 0; i < kParts; ++i) v.part[i] = vfloat::load(p + i * kLanes);
        return v;
    }
    OCCAM_ALWAYS_INLINE void store(float* p) const noexcept
    {
        for (int i = 0; i < kParts; ++i) part[i].store(p + i * kLanes);
    }

    OCCAM_ALWAYS_INLINE friend vfloats operator+(vfloats a, const vfloats& b) noexcept
    {
        for (int i = 0; i < kParts; ++i) a.part[i] = a.part[i] + b.part[i];
        return a;
    }
    OCCAM_ALWAYS_INLINE friend vfloats operator-(vfloats a, const vfloats& b) noexcept
    {
        for (int i = 0; i < kParts; ++i) a.part[i] = a.part[i] - b.part[i];
        return a;
    }
    OCCAM_ALWAYS_INLINE friend vfloats operator*(vfloats a, const vfloats& b) noexcept
    {
        for (int i = 0; i < kParts; ++i) a.part[i] = a.part[i] * b.part[i];
        return a;
    }
    OCCAM_ALWAYS_INLINE friend vfloats operator/(vfloats a, const vfloats& b) noexcept
    {
        for (int i = 0; i < kParts; ++i) a.part[i] = a.part[i] / b.part[i];
        return a;
    }
    OCCAM_ALWAYS_INLINE friend Mask operator<(const vfloats& a, const vfloats& b) noexcept
    {
        Mask m;
        for (int i = 0; i < kParts; ++i) m.part[i] = a.part[i] < b.part[i];
        return m;
    }
    OCCAM_ALWAYS_INLINE friend Mask operator<=(const vfloats& a, const vfloats& b) noexcept
    {
        Mask m;
        for (int i = 0; i < kParts; ++i) m.part[i] = a.part[i] <= b.part[i];
        return m;
    }
    OCCAM_ALWAYS_INLINE friend Mask operator>(const vfloats& a, const vfloats& b) noexcept { return b < a; }
    OCCAM_ALWAYS_INLINE friend Mask operator>=(const vfloats& a, const vfloats& b) noexcept { return b <= a; }
    OCCAM_ALWAYS_INLINE friend vfloats min(vfloats a, const vfloats& b) noexcept
    {
        for (int i = 0; i < kParts; ++i) a.part[i] = min(a.part[i], b.part[i]);
        return a;
    }
    OCCAM_ALWAYS_INLINE friend vfloats max(vfloats a, const vfloats& b) noexcept
    {
        for (int i = 0; i < kParts; ++i) a.part[i] = max(a.part[i], b.part[i]);
        return a;
    }
    OCCAM_ALWAYS_INLINE friend vfloats abs(vfloats a) noexcept
    {
        for (int i = 0; i < kParts; ++i) a.part[i] = abs(a.part[i]);
        return a;
    }
    OCCAM_ALWAYS_INLINE friend vfloats power_of_two_at_most(vfloats a) noexcept
    {
        for (int i = 0; i < kParts; ++i) a.part[i] = power_of_two_at_most(a.part[i]);
        return a;
    }
    OCCAM_ALWAYS_INLINE friend vfloats fma(const vfloats& a, const vfloats& b, vfloats c) noexcept
    {
        for (int i = 0; i < kParts; ++i) c.part[i] = fma(a.part[i], b.part[i], c.part[i]);
        return c;
    }
    OCCAM_ALWAYS_INLINE friend vfloats select(const Mask& m, vfloats yes, const vfloats& no) noexcept
    {
        for (int i = 0; i < kParts; ++i) yes.part[i] = select(m.part[i], yes.part[i], no.part[i]);
        return yes;
    }
    /// Returns the minimum of all lanes.
    OCCAM_ALWAYS_INLINE friend float lowest(const vfloats& a) noexcept
    {
        vfloat least = a.part[0];
        for (int i = 1; i < kParts; ++i) least = min(least, a.part[i]);
        return lowest(least);
    }
    OCCAM_ALWAYS_INLINE friend float highest(const vfloats& a) noexcept
    {
        vfloat most = a.part[0];
        for (int i = 1; i < kParts; ++i) most = max(most, a.part[i]);
        return highest(most);
    }
};

/// Returns one lane.
OCCAM_ALWAYS_INLINE float lane_of(const vfloat& x, int lane) noexcept
{
    static_assert(std::is_trivially_copyable_v<vfloat>);
    float one;
    std::memcpy(&one, reinterpret_cast<const unsigned char*>(&x) + static_cast<std::size_t>(lane) * sizeof(float),
                sizeof one);
    return one;
}
template <int kParts>
OCCAM_ALWAYS_INLINE float lane_of(const vfloats<kParts>& x, int lane) noexcept
{
    return lane_of(x.part[lane / kLanes], lane % kLanes);
}

}  // namespace occam
