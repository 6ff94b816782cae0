#include "render/sampler.h"

namespace occam::render {

// Each loop computes one coordinate and is not inlined into code that uses the points one by one, so that compilers
// vectorize it.
void Sequence::squares(std::uint32_t first, float (&x)[kBlock], float (&y)[kBlock]) const noexcept
{
    using namespace sobol;
    std::uint32_t shuffled[kBlock];
    for (std::uint32_t i = 0; i < kBlock; ++i) shuffled[i] = owen_scramble(first + i, order_);
    for (int i = 0; i < kBlock; ++i) x[i] = unit_float(reversed(scramble_reversed(shuffled[i], flips_x_)));
    for (int i = 0; i < kBlock; ++i) y[i] = unit_float(reversed(scramble_reversed(pascal(shuffled[i]), flips_y_)));
}

namespace {

constexpr int kMost = SurfacesToDraw::kMost;

// Holds what one dimension of each surface needs: Sequence's members, and the index shuffled by them.
struct Scrambles {
    std::uint32_t shuffled[kMost], flips_x[kMost], flips_y[kMost];
};

// Compilers vectorize these loops, one after the other.
void set_x(const Scrambles& of, float (&x)[kMost]) noexcept
{
    using namespace sobol;
    for (int i = 0; i < kMost; ++i) x[i] = unit_float(reversed(scramble_reversed(of.shuffled[i], of.flips_x[i])));
}
void set_y(const Scrambles& of, float (&y)[kMost]) noexcept
{
    using namespace sobol;
    for (int i = 0; i < kMost; ++i) y[i] = unit_float(reversed(scramble_reversed(pascal(of.shuffled[i]), of.flips_y[i])));
}

// Pixels and indices of surfaces, as the keys of their sequences need them.
struct Prepared {
    std::uint64_t pixels[kMost];
    std::uint32_t reversed_index[kMost];
};

template <class KeyOf>
Scrambles scrambles(const Prepared& of, KeyOf&& key_of)
{
    Scrambles all;
    std::uint32_t order[kMost];
    for (int i = 0; i < kMost; ++i) {
        const std::uint64_t key = key_of(of.pixels[i], i);
        order[i] = static_cast<std::uint32_t>(key);
        all.flips_x[i] = static_cast<std::uint32_t>(key >> 32);
        all.flips_y[i] = static_cast<std::uint32_t>(mix_bits(key));
    }
    for (int i = 0; i < kMost; ++i)
        all.shuffled[i] = sobol::reversed(sobol::scramble_reversed(of.reversed_index[i], order[i]));
    return all;
}

// Calls set(i, square) for each surface.
template <class Set>
void set_squares(const Scrambles& of, Set&& set) noexcept
{
    float x[kMost], y[kMost];
    set_x(of, x);
    set_y(of, y);
    for (int i = 0; i < kMost; ++i) set(i, Vec2f(x[i], y[i]));
}

}  // namespace

void Sampler::draw_in_pixels(const SurfacesToDraw& of, Vec2f (&to)[kMost]) const noexcept
{
    Prepared prepared;
    for (int i = 0; i < kMost; ++i) prepared.pixels[i] = mixed_pixel(of.x[i], of.y[i]);
    for (int i = 0; i < kMost; ++i) prepared.reversed_index[i] = sobol::reversed(of.index[i]);
    const auto key = [](std::uint64_t pixel, int) { return key_of(pixel, Dimension::pixel()); };
    set_squares(scrambles(prepared, key), [&](int i, Vec2f square) { to[i] = jitter_ ? square : Vec2f(0.5f); });
}

void Sampler::draw(const SurfacesToDraw& of, SurfaceNumbers (&to)[kMost]) const noexcept
{
    using Use = Dimension::Use;
    Prepared prepared;
    for (int i = 0; i < kMost; ++i) prepared.pixels[i] = mixed_pixel(of.x[i], of.y[i]);
    for (int i = 0; i < kMost; ++i) prepared.reversed_index[i] = sobol::reversed(of.index[i]);
    const auto numbers = [&](Use use, int slot = 0) {
        return scrambles(prepared, [&](std::uint64_t pixel, int i) {
            return key_of(pixel, Dimension::at(of.key[i], use, static_cast<std::uint32_t>(slot)));
        });
    };
    for (int slot = 0; slot < SurfaceNumbers::kLightSlots; ++slot)
        if ((of.light_slots >> slot & 1) != 0)
            set_squares(numbers(Use::Light, slot), [&](int i, Vec2f square) { to[i].light[slot] = square; });
    set_squares(numbers(Use::Scatter), [&](int i, Vec2f square) { to[i].scatter = square; });
    float x[kMost];
    set_x(numbers(Use::Lobe), x);
    for (int i = 0; i < kMost; ++i) to[i].lobe = x[i];
}

}  // namespace occam::render
