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

}  // namespace occam::render
