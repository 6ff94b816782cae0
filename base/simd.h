// Eight floats at a time, behind operators. This is the only file that knows the SIMD library and the lane count.
//
// It is built on Highway, statically for the target of the build. OCCAM_ONE_LANE gives the same interface with one lane, and
// the same bits. Highway's own one-lane target fuses nothing and orders NaN differently, so these operations are written
// out.
//
// NaN      min(a, b) = a < b ? a : b and max(a, b) = a > b ? a : b: the second operand if either is NaN (x86's minps).
//          Comparisons with NaN are false.
// Fusing   Nothing is contracted (a compiler flag forbids it); fma() rounds once, in every build.
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "base/half.h"

#ifdef OCCAM_ONE_LANE
#define HWY_COMPILE_ONLY_SCALAR
#endif
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wshadow"
#include <hwy/highway.h>
#pragma GCC diagnostic pop

namespace occam {

namespace hn = hwy::HWY_NAMESPACE;

/// Forces the inlining of kernels that the compiler considers too long, but that are called where every cycle counts.
#define OCCAM_ALWAYS_INLINE [[gnu::always_inline]] inline
/// Keeps rare code out of line, where it would otherwise take registers from the common path.
#define OCCAM_NEVER_INLINE [[gnu::noinline]]

#ifdef OCCAM_ONE_LANE
inline constexpr int kLanes = 1;
using FloatTag = hn::CappedTag<float, 1>;
#else
inline constexpr int kLanes = 8;
using FloatTag = hn::CappedTag<float, 8>;
static_assert(hn::MaxLanes(FloatTag()) == 8, "eight lanes need AVX2 with AES and PCLMUL, or OCCAM_ONE_LANE");
#endif

class vmask {
public:
    using Raw = hn::Mask<FloatTag>;
    vmask() = default;
    vmask(Raw raw) noexcept : raw_(raw) {}
    explicit vmask(bool all) noexcept : raw_(hn::MaskFromVec(hn::Set(FloatTag(), all ? -1.0f : 0.0f))) {}
    Raw raw() const noexcept { return raw_; }

    friend vmask operator&(vmask a, vmask b) noexcept { return hn::And(a.raw_, b.raw_); }
    friend vmask operator|(vmask a, vmask b) noexcept { return hn::Or(a.raw_, b.raw_); }
    friend vmask operator!(vmask a) noexcept { return hn::Not(a.raw_); }
    /// Returns a and not b.
    friend vmask andnot(vmask a, vmask b) noexcept { return hn::AndNot(b.raw_, a.raw_); }
    friend bool any(vmask a) noexcept { return bits(a) != 0; }
    friend bool none(vmask a) noexcept { return bits(a) == 0; }
    /// Returns the lanes as bits, where bit i is lane i.
    friend unsigned bits(vmask a) noexcept
    {
#ifdef OCCAM_ONE_LANE
        return hn::CountTrue(FloatTag(), a.raw_) != 0 ? 1u : 0u;
#else
        std::uint8_t b[8] = {};
        hn::StoreMaskBits(FloatTag(), a.raw_, b);
        return b[0];
#endif
    }

private:
    Raw raw_;
};

class vfloat {
public:
    using Raw = hn::Vec<FloatTag>;
    vfloat() = default;
    vfloat(Raw raw) noexcept : raw_(raw) {}
    vfloat(float x) noexcept : raw_(hn::Set(FloatTag(), x)) {}
    Raw raw() const noexcept { return raw_; }

    static vfloat load(const float* p) noexcept { return hn::LoadU(FloatTag(), p); }
    void store(float* p) const noexcept { hn::StoreU(raw_, FloatTag(), p); }
    /// Loads lanes 0 to 3 from a and 4 to 7 from b. With one lane, it loads lane `first` of those eight.
    static vfloat load_halves(const float* a, const float* b, [[maybe_unused]] int first) noexcept
    {
#ifdef OCCAM_ONE_LANE
        return vfloat(first < 4 ? a[first] : b[first - 4]);
#else
        const hn::Half<FloatTag> half;
        return hn::Combine(FloatTag(), hn::LoadU(half, b), hn::LoadU(half, a));
#endif
    }

    friend vfloat operator+(vfloat a, vfloat b) noexcept { return hn::Add(a.raw_, b.raw_); }
    friend vfloat operator-(vfloat a, vfloat b) noexcept { return hn::Sub(a.raw_, b.raw_); }
    friend vfloat operator*(vfloat a, vfloat b) noexcept { return hn::Mul(a.raw_, b.raw_); }
    friend vfloat operator/(vfloat a, vfloat b) noexcept { return hn::Div(a.raw_, b.raw_); }
    friend vfloat operator-(vfloat a) noexcept { return hn::Neg(a.raw_); }
    friend vmask operator<(vfloat a, vfloat b) noexcept { return hn::Lt(a.raw_, b.raw_); }
    friend vmask operator<=(vfloat a, vfloat b) noexcept { return hn::Le(a.raw_, b.raw_); }
    friend vmask operator>(vfloat a, vfloat b) noexcept { return hn::Gt(a.raw_, b.raw_); }
    friend vmask operator>=(vfloat a, vfloat b) noexcept { return hn::Ge(a.raw_, b.raw_); }
    friend vmask operator==(vfloat a, vfloat b) noexcept { return hn::Eq(a.raw_, b.raw_); }

private:
    Raw raw_;
};

/// Four floats of one colour, normal or the like, in every build.
class vfloat4 {
public:
#ifdef OCCAM_ONE_LANE
    explicit vfloat4(float x) noexcept : raw_{x, x, x, x} {}
    static vfloat4 from_halves(const std::uint16_t* p) noexcept
    {
        vfloat4 v(0);
        for (int i = 0; i < 4; ++i) v.raw_[i] = float_from_half(p[i]);
        return v;
    }
    static vfloat4 load(const float* p) noexcept
    {
        vfloat4 v(0);
        for (int i = 0; i < 4; ++i) v.raw_[i] = p[i];
        return v;
    }
    void store(float* p) const noexcept
    {
        for (int i = 0; i < 4; ++i) p[i] = raw_[i];
    }
    friend vfloat4 operator+(vfloat4 a, vfloat4 b) noexcept
    {
        for (int i = 0; i < 4; ++i) a.raw_[i] = a.raw_[i] + b.raw_[i];
        return a;
    }
    friend vfloat4 operator*(vfloat4 a, float b) noexcept
    {
        for (int i = 0; i < 4; ++i) a.raw_[i] = a.raw_[i] * b;
        return a;
    }

private:
    float raw_[4];
#else
    using Tag = hn::CappedTag<float, 4>;
    using Raw = hn::Vec<Tag>;
    vfloat4(Raw raw) noexcept : raw_(raw) {}
    explicit vfloat4(float x) noexcept : raw_(hn::Set(Tag(), x)) {}
    /// Converts four finite half floats exactly.
    static vfloat4 from_halves(const std::uint16_t* p) noexcept
    {
        return hn::PromoteTo(Tag(),
                             hn::LoadU(hn::Rebind<hwy::float16_t, Tag>(), reinterpret_cast<const hwy::float16_t*>(p)));
    }
    static vfloat4 load(const float* p) noexcept { return hn::LoadU(Tag(), p); }
    void store(float* p) const noexcept { hn::StoreU(raw_, Tag(), p); }
    friend vfloat4 operator+(vfloat4 a, vfloat4 b) noexcept { return hn::Add(a.raw_, b.raw_); }
    friend vfloat4 operator*(vfloat4 a, float b) noexcept { return hn::Mul(a.raw_, hn::Set(Tag(), b)); }

private:
    Raw raw_;
#endif
};

/// Sixteen floats as four rows of four, in every build.
class vfloat4x4 {
public:
    static constexpr int kParts = 16 / kLanes;

    vfloat4x4() = default;
    vfloat4x4(vfloat x) noexcept
    {
        for (vfloat& part : parts_) part = x;
    }
    vfloat4x4(float x) noexcept : vfloat4x4(vfloat(x)) {}
    static vfloat4x4 load(const float* p) noexcept
    {
        vfloat4x4 m;
        for (int i = 0; i < kParts; ++i) m.parts_[i] = vfloat::load(p + i * kLanes);
        return m;
    }
    void store(float* p) const noexcept
    {
        for (int i = 0; i < kParts; ++i) parts_[i].store(p + i * kLanes);
    }
    /// Rotates each row by one: column c takes the values of column c + 1, and the last column those of the first.
    vfloat4x4 next_column() const noexcept
    {
        vfloat4x4 m;
#ifdef OCCAM_ONE_LANE
        for (int i = 0; i < 16; ++i) m.parts_[i] = parts_[i / 4 * 4 + (i + 1) % 4];
#else
        for (int i = 0; i < kParts; ++i) m.parts_[i] = hn::Shuffle0321(parts_[i].raw());
#endif
        return m;
    }
    /// Rotates each column by one in the same way.
    vfloat4x4 next_row() const noexcept
    {
        vfloat4x4 m;
#ifdef OCCAM_ONE_LANE
        for (int i = 0; i < 16; ++i) m.parts_[i] = parts_[(i + 4) % 16];
#else
        for (int i = 0; i < kParts; ++i)
            m.parts_[i] = hn::ConcatLowerUpper(FloatTag(), parts_[(i + 1) % kParts].raw(), parts_[i].raw());
#endif
        return m;
    }
    friend vfloat4x4 operator-(vfloat4x4 a, vfloat4x4 b) noexcept
    {
        for (int i = 0; i < kParts; ++i) a.parts_[i] = a.parts_[i] - b.parts_[i];
        return a;
    }
    friend vfloat4x4 operator*(vfloat4x4 a, vfloat4x4 b) noexcept
    {
        for (int i = 0; i < kParts; ++i) a.parts_[i] = a.parts_[i] * b.parts_[i];
        return a;
    }
    friend vfloat4x4 min(vfloat4x4 a, vfloat4x4 b) noexcept;
    friend vfloat4x4 max(vfloat4x4 a, vfloat4x4 b) noexcept;
    friend vfloat4x4 fma(vfloat4x4 a, vfloat4x4 b, vfloat4x4 c) noexcept;
    friend float smallest(vfloat4x4 a) noexcept;
    friend float largest(vfloat4x4 a) noexcept;

private:
    vfloat parts_[kParts];
};

/// Broadcasts one lane to all lanes.
inline vfloat spread(vfloat x, [[maybe_unused]] int lane) noexcept
{
#ifdef OCCAM_ONE_LANE
    return x;
#else
    return hn::TableLookupLanes(x.raw(), hn::IndicesFromVec(FloatTag(), hn::Set(hn::RebindToSigned<FloatTag>(), lane)));
#endif
}

/// Returns a * b + c with one rounding.
inline vfloat fma(vfloat a, vfloat b, vfloat c) noexcept
{
#ifdef OCCAM_ONE_LANE
    return vfloat(__builtin_fmaf(hn::GetLane(a.raw()), hn::GetLane(b.raw()), hn::GetLane(c.raw())));
#else
    return hn::MulAdd(a.raw(), b.raw(), c.raw());
#endif
}
/// Returns c - a * b with one rounding.
inline vfloat fnma(vfloat a, vfloat b, vfloat c) noexcept
{
#ifdef OCCAM_ONE_LANE
    return vfloat(__builtin_fmaf(-hn::GetLane(a.raw()), hn::GetLane(b.raw()), hn::GetLane(c.raw())));
#else
    return hn::NegMulAdd(a.raw(), b.raw(), c.raw());
#endif
}
inline vfloat select(vmask m, vfloat yes, vfloat no) noexcept { return hn::IfThenElse(m.raw(), yes.raw(), no.raw()); }
inline vfloat min(vfloat a, vfloat b) noexcept
{
#if defined(OCCAM_ONE_LANE) || !HWY_ARCH_X86
    return select(a < b, a, b);
#else
    return hn::Min(a.raw(), b.raw());
#endif
}
inline vfloat max(vfloat a, vfloat b) noexcept
{
#if defined(OCCAM_ONE_LANE) || !HWY_ARCH_X86
    return select(a > b, a, b);
#else
    return hn::Max(a.raw(), b.raw());
#endif
}
inline vfloat abs(vfloat a) noexcept { return hn::Abs(a.raw()); }
/// Returns the size of a number with the sign of another number, which may be a zero.
inline vfloat copysign(vfloat magnitude, vfloat sign) noexcept { return hn::CopySign(magnitude.raw(), sign.raw()); }
inline vfloat sqrt(vfloat a) noexcept { return hn::Sqrt(a.raw()); }
/// Returns the largest power of two that is at most a, for a >= 0: 0 below the normal numbers, infinity for what is not
/// finite.
inline vfloat power_of_two_at_most(vfloat a) noexcept
{
    const hn::RebindToUnsigned<FloatTag> integers;
    return hn::And(a.raw(), hn::BitCast(FloatTag(), hn::Set(integers, 0x7f800000u)));
}
/// Returns the minimum of all lanes.
inline float lowest(vfloat a) noexcept { return hn::GetLane(hn::MinOfLanes(FloatTag(), a.raw())); }
inline float highest(vfloat a) noexcept { return hn::GetLane(hn::MaxOfLanes(FloatTag(), a.raw())); }

/// Loads four floats of each of as many objects as there are lanes and transposes them: lane i of to[f] is from[i][f].
inline void load_turned(const float* const* from, vfloat (&to)[4]) noexcept
{
#ifdef OCCAM_ONE_LANE
    for (int f = 0; f < 4; ++f) to[f] = vfloat(from[0][f]);
#else
    const FloatTag tag;
    const hn::RepartitionToWide<FloatTag> pairs;
    const auto both = [&](int i) { return vfloat::load_halves(from[i], from[i + 4], 0).raw(); };
    const auto a = both(0), b = both(1), c = both(2), d = both(3);
    const auto ab_low = hn::BitCast(pairs, hn::InterleaveLower(tag, a, b)),
               ab_high = hn::BitCast(pairs, hn::InterleaveUpper(tag, a, b));
    const auto cd_low = hn::BitCast(pairs, hn::InterleaveLower(tag, c, d)),
               cd_high = hn::BitCast(pairs, hn::InterleaveUpper(tag, c, d));
    to[0] = hn::BitCast(tag, hn::InterleaveLower(pairs, ab_low, cd_low));
    to[1] = hn::BitCast(tag, hn::InterleaveUpper(pairs, ab_low, cd_low));
    to[2] = hn::BitCast(tag, hn::InterleaveLower(pairs, ab_high, cd_high));
    to[3] = hn::BitCast(tag, hn::InterleaveUpper(pairs, ab_high, cd_high));
#endif
}

/// Transposes and stores, the inverse of load_turned(): lane i of from[f] goes to to[i][offset + f].
inline void store_turned(const vfloat (&from)[4], float* const* to, std::size_t offset) noexcept
{
#ifdef OCCAM_ONE_LANE
    for (std::size_t f = 0; f < 4; ++f) from[f].store(to[0] + offset + f);
#else
    const FloatTag tag;
    const hn::RepartitionToWide<FloatTag> pairs;
    const hn::Half<FloatTag> half;
    const auto a = from[0].raw(), b = from[1].raw(), c = from[2].raw(), d = from[3].raw();
    const auto ab_low = hn::BitCast(pairs, hn::InterleaveLower(tag, a, b)),
               ab_high = hn::BitCast(pairs, hn::InterleaveUpper(tag, a, b));
    const auto cd_low = hn::BitCast(pairs, hn::InterleaveLower(tag, c, d)),
               cd_high = hn::BitCast(pairs, hn::InterleaveUpper(tag, c, d));
    const auto both = [&](auto turned, int i) {
        const auto floats = hn::BitCast(tag, turned);
        hn::StoreU(hn::LowerHalf(half, floats), half, to[i] + offset);
        hn::StoreU(hn::UpperHalf(half, floats), half, to[i + 4] + offset);
    };
    both(hn::InterleaveLower(pairs, ab_low, cd_low), 0);
    both(hn::InterleaveUpper(pairs, ab_low, cd_low), 1);
    both(hn::InterleaveLower(pairs, ab_high, cd_high), 2);
    both(hn::InterleaveUpper(pairs, ab_high, cd_high), 3);
#endif
}

inline vfloat4x4 min(vfloat4x4 a, vfloat4x4 b) noexcept
{
    for (int i = 0; i < vfloat4x4::kParts; ++i) a.parts_[i] = min(a.parts_[i], b.parts_[i]);
    return a;
}
inline vfloat4x4 max(vfloat4x4 a, vfloat4x4 b) noexcept
{
    for (int i = 0; i < vfloat4x4::kParts; ++i) a.parts_[i] = max(a.parts_[i], b.parts_[i]);
    return a;
}
inline vfloat4x4 fma(vfloat4x4 a, vfloat4x4 b, vfloat4x4 c) noexcept
{
    for (int i = 0; i < vfloat4x4::kParts; ++i) c.parts_[i] = fma(a.parts_[i], b.parts_[i], c.parts_[i]);
    return c;
}
/// Returns the minimum of all sixteen values, none of which may be NaN.
inline float smallest(vfloat4x4 a) noexcept
{
    vfloat least = a.parts_[0];
    for (int i = 1; i < vfloat4x4::kParts; ++i) least = min(least, a.parts_[i]);
    return hn::GetLane(hn::MinOfLanes(FloatTag(), least.raw()));
}
inline float largest(vfloat4x4 a) noexcept
{
    vfloat most = a.parts_[0];
    for (int i = 1; i < vfloat4x4::kParts; ++i) most = max(most, a.parts_[i]);
    return hn::GetLane(hn::MaxOfLanes(FloatTag(), most.raw()));
}

// These overloads for one float let what is written once serve lanes and a single ray or surface.
inline float abs(float a) noexcept { return std::fabs(a); }
inline float sqrt(float a) noexcept { return std::sqrt(a); }
inline float power_of_two_at_most(float a) noexcept
{
    return std::bit_cast<float>(std::bit_cast<std::uint32_t>(a) & 0x7f800000u);
}
inline float fma(float a, float b, float c) noexcept { return __builtin_fmaf(a, b, c); }
inline float fnma(float a, float b, float c) noexcept { return __builtin_fmaf(-a, b, c); }
inline float select(bool m, float yes, float no) noexcept { return m ? yes : no; }
inline float min(float a, float b) noexcept { return a < b ? a : b; }
inline float max(float a, float b) noexcept { return a > b ? a : b; }
/// Returns x within [low, high]; NaN stays NaN.
template <class F>
F clamp(F x, F low, F high) noexcept
{
    return select(x < low, low, select(high < x, high, x));
}
inline float lowest(float a) noexcept { return a; }
inline float highest(float a) noexcept { return a; }
inline bool any(bool m) noexcept { return m; }
inline bool none(bool m) noexcept { return !m; }
inline bool andnot(bool a, bool b) noexcept { return a && !b; }

}  // namespace occam
