// Random numbers and directions for rays of tests: the same ones for a seed on every platform.
#pragma once

#include <cstdint>
#include <random>

#include "base/vec.h"

namespace occam::test {

class Random {
public:
    explicit Random(std::uint64_t seed) : bits_(seed) {}
    /// Returns a number that is uniform in [0, 1).
    double operator()() { return double(bits_() >> 11) * 0x1p-53; }
    Vec3d direction()
    {
        while (true) {
            const double x = (*this)(), y = (*this)(), z = (*this)();
            const Vec3d d = 2.0 * Vec3d(x, y, z) - 1.0;
            if (const double l = glm::length(d); l > 0.1 && l <= 1) return d / l;
        }
    }

private:
    std::mt19937_64 bits_;
};

}  // namespace occam::test
