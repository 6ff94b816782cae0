// Holds a normal in half the memory of three floats, since a cage that moves has one at each vertex and key.
#pragma once

#include <cstdint>

#include "base/maths.h"

namespace occam::lod {

/// Each coordinate is a multiple of 1 / 32,767, which turns a unit vector by less than 0.0016 degrees.
class ShortNormal {
public:
    ShortNormal() = default;
    /// Coordinates beyond [-1, 1] are cut off.
    explicit ShortNormal(Vec3f n) noexcept
    {
        for (int a = 0; a < 3; ++a) {
            const float x = !(n[a] > -1) ? -kSteps : n[a] < 1 ? n[a] * kSteps : kSteps;
            steps_[a] = static_cast<std::int16_t>(x < 0 ? x - 0.5f : x + 0.5f);
        }
    }
    Vec3f get() const noexcept { return Vec3f(steps_[0], steps_[1], steps_[2]) * (1 / kSteps); }

private:
    static constexpr float kSteps = 32767;
    std::int16_t steps_[3];
};
static_assert(sizeof(ShortNormal) == 6);

}  // namespace occam::lod
