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

}  // namespace

void Sampler::draw(const SurfacesToDraw& of, SurfaceNumbers (&to)[kMost]) const noexcept
{
    using Use = Dimension::Use;
    std::uint64_t pixels[kMost];
    std::uint32_t reversed_index[kMost];
    for (int i = 0; i < kMost; ++i) pixels[i] = mixed_pixel(of.x[i], of.y[i]);
    for (int i = 0; i < kMost; ++i) reversed_index[i] = sobol::reversed(of.index[i]);
    const auto scrambles = [&](Use use) {
        Scrambles all;
        std::uint32_t order[kMost];
        for (int i = 0; i < kMost; ++i) {
            const std::uint64_t key = key_of(pixels[i], Dimension::at(of.key[i], use));
            order[i] = static_cast<std::uint32_t>(key);
            all.flips_x[i] = static_cast<std::uint32_t>(key >> 32);
            all.flips_y[i] = static_cast<std::uint32_t>(mix_bits(key));
        }
        for (int i = 0; i < kMost; ++i)
            all.shuffled[i] = sobol::reversed(sobol::scramble_reversed(reversed_index[i], order[i]));
        return all;
    };
    float x[kMost], y[kMost];
    const Scrambles light = scrambles(Use::Light);
    set_x(light, x);
    set_y(light, y);
    for (int i = 0; i < kMost; ++i) to[i].light = {x[i], y[i]};
    const Scrambles scatter = scrambles(Use::Scatter);
    set_x(scatter, x);
    set_y(scatter, y);
    for (int i = 0; i < kMost; ++i) to[i].scatter = {x[i], y[i]};
    set_x(scrambles(Use::Lobe), x);
    for (int i = 0; i < kMost; ++i) to[i].lobe = x[i];
    set_x(scrambles(Use::Survival), x);
    for (int i = 0; i < kMost; ++i) to[i].survival = x[i];
}

}  // namespace occam::render
