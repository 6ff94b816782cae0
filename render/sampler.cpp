#include "render/sampler.h"

#include <bit>

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

}  // namespace

void Sampler::draw_in_pixels(const SurfacesToDraw& of, Vec2f (&to)[kMost]) const noexcept
{
    Prepared prepared;
    for (int i = 0; i < kMost; ++i) prepared.pixels[i] = mixed_pixel(of.x[i], of.y[i]);
    for (int i = 0; i < kMost; ++i) prepared.reversed_index[i] = sobol::reversed(of.index[i]);
    const auto key = [](std::uint64_t pixel, int) { return key_of(pixel, Dimension::pixel()); };
    const Scrambles all = scrambles(prepared, key);
    float x[kMost], y[kMost];
    set_x(all, x);
    set_y(all, y);
    for (int i = 0; i < kMost; ++i) to[i] = jitter_ ? Vec2f(x[i], y[i]) : Vec2f(0.5f);
}

void Sampler::draw(const SurfacesToDraw& of, SurfaceNumbers& to) const noexcept
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
    const auto set = [](const Scrambles& all, SurfaceNumbers::Squares& squares) {
        set_x(all, squares.x);
        set_y(all, squares.y);
    };
    for (std::uint32_t left = of.light_slots; left != 0; left &= left - 1) {
        const int slot = std::countr_zero(left);
        set(numbers(Use::Light, slot), to.light[slot]);
    }
    set(numbers(Use::Scatter), to.scatter);
    set_x(numbers(Use::Lobe), to.lobe);
}

}  // namespace occam::render
