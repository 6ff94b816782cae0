// The random numbers of a random case (random_case.h).
#pragma once

#include <algorithm>
#include <cstdint>

#include "base/hash.h"
#include "tests/support/random_case.h"

namespace occam::test {

/// Generates the random numbers of one feature of one part, which are the same whatever else the case has.
class CaseRandom {
public:
    CaseRandom(std::uint64_t seed, std::uint64_t key, std::uint64_t feature)
        : state_(mix_bits(seed * 0x9e3779b97f4a7c15ull + key * 1009 + feature * 31 + 7))
    {
    }
    CaseRandom(const RandomCase& c, const RandomPart& part, PartFeature f)
        : CaseRandom(c.seed, part.key, static_cast<std::uint64_t>(f) + 100)
    {
    }
    CaseRandom(const RandomCase& c, SettingFeature f) : CaseRandom(c.seed, 0, static_cast<std::uint64_t>(f) + 200) {}

    /// Returns a number that is uniform in [0, 1).
    double number() { return double(mix_bits(state_ += 0x9e3779b97f4a7c15ull) >> 11) * 0x1p-53; }
    double between(double lo, double hi) { return lo + (hi - lo) * number(); }
    std::size_t index(std::size_t count) { return std::min(count - 1, static_cast<std::size_t>(number() * double(count))); }
    Vec3d inside_cube()
    {
        const double x = between(-1, 1), y = between(-1, 1);
        return {x, y, between(-1, 1)};
    }
    /// Returns a colour of channels from 0 to 1.
    Vec3f color() { return Vec3f(0.5 + 0.5 * inside_cube()); }

private:
    std::uint64_t state_;
};

}  // namespace occam::test
