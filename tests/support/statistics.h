// Unstratified random numbers, and the statistical tests of sampling routines.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>

#include "base/hash.h"
#include "base/vec.h"

namespace occam::test {

/// Generates independent uniform numbers, the same in every run. (With stratified numbers the statistics would be too
/// small.)
class Numbers {
public:
    explicit Numbers(std::uint64_t seed) : state_(mix_bits(seed)) {}
    float one()
    {
        state_ += 0x9e3779b97f4a7c15ull;
        return static_cast<float>(mix_bits(state_) >> 40) * 0x1p-24f;
    }
    Vec2f square()
    {
        const float x = one();
        return {x, one()};
    }

private:
    std::uint64_t state_;
};

/// Holds the mean of independent samples and its standard error.
class Mean {
public:
    void add(double value)
    {
        sum_ += value;
        squares_ += value * value;
        ++count_;
    }
    double value() const { return sum_ / count_; }
    double error() const { return std::sqrt(std::max(0.0, squares_ / count_ - value() * value()) / count_); }

private:
    double sum_ = 0, squares_ = 0;
    int count_ = 0;
};

/// Returns how many standard deviations Pearson's statistic lies above its mean. `found` holds the counts in cells, and
/// `wanted` their expectations; cells whose expectation is below 5 are pooled. If both agree, the result exceeds 4.5 once in
/// 300,000 runs.
inline double chi_square_excess(std::span<const double> found, std::span<const double> wanted)
{
    double chi2 = 0, pooled_found = 0, pooled_wanted = 0;
    int freedom = -1;
    const auto add = [&](double f, double w) {
        chi2 += (f - w) * (f - w) / w;
        ++freedom;
    };
    for (std::size_t i = 0; i < found.size(); ++i) {
        if (wanted[i] < 5) {
            pooled_found += found[i];
            pooled_wanted += wanted[i];
        } else {
            add(found[i], wanted[i]);
        }
    }
    if (pooled_wanted >= 1) add(pooled_found, pooled_wanted);
    return (chi2 - freedom) / std::sqrt(2.0 * freedom);
}

/// Does the same for directions on the sphere: `draw(numbers)` returns one (or the zero vector for a lost sample),
/// `density(d)` its density per solid angle. There are 16 x 32 cells of equal area; the density is summed over `fine` x
/// `fine` points of each cell.
template <class Draw, class Density>
double direction_excess(int samples, int fine, Draw&& draw, Density&& density, std::uint64_t seed = 11)
{
    constexpr int kRows = 16, kColumns = 32;
    constexpr double kTau = 6.283185307179586;
    double found[kRows * kColumns] = {}, wanted[kRows * kColumns] = {};
    Numbers numbers(seed);
    for (int i = 0; i < samples; ++i) {
        const Vec3f d = draw(numbers);
        if (d == Vec3f(0)) continue;
        const int row = std::min(kRows - 1, int((double(d.z) + 1) / 2 * kRows));
        const int column = std::min(kColumns - 1, int((std::atan2(double(d.y), double(d.x)) / kTau + 0.5) * kColumns));
        ++found[row * kColumns + column];
    }
    for (int row = 0; row < kRows * fine; ++row)
        for (int column = 0; column < kColumns * fine; ++column) {
            const double z = (row + 0.5) / (kRows * fine) * 2 - 1, angle = ((column + 0.5) / (kColumns * fine) - 0.5) * kTau;
            const double r = std::sqrt(1 - z * z);
            const Vec3f d(float(r * std::cos(angle)), float(r * std::sin(angle)), float(z));
            wanted[row / fine * kColumns + column / fine] += double(density(d)) * 2 * kTau /
                                                             (double(kRows) * fine * kColumns * fine) * samples;
        }
    return chi_square_excess(found, wanted);
}

}  // namespace occam::test
