#include "render/sampler.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "render/aperture.h"
#include "render/filter.h"
#include "tests/support/statistics.h"

namespace occam::render {
namespace {

constexpr Dimension kLight = {77};

// Every elementary interval of area 2^-m (of each shape, in 2^a x 2^(m - a) cells) holds one of each aligned 2^m points.
TEST(Sampler, EveryElementaryIntervalHoldsOnePointOfEachAlignedBlock)
{
    const Sampler sampler(7, 1, true);
    for (int pixel = 0; pixel < 5; ++pixel)
        for (const int m : {2, 4, 5, 8})
            for (const std::uint32_t block : {0u, 1u, 6u})
                for (int a = 0; a <= m; ++a) {
                    std::set<int> cells;
                    for (std::uint32_t i = block << m; i < (block + 1) << m; ++i) {
                        const Vec2f p = sampler.square(pixel, 3, i, kLight);
                        ASSERT_TRUE(p.x >= 0 && p.x < 1 && p.y >= 0 && p.y < 1);
                        cells.insert(int(p.x * float(1 << a)) + (int(p.y * float(1 << (m - a))) << a));
                    }
                    EXPECT_EQ(cells.size(), std::size_t(1) << m) << "2^" << m << " points in columns 2^" << a;
                }
}

// The direction numbers of the second dimension are the polynomials (1 + x)^i modulo 2.
TEST(Sampler, TheSecondDimensionIsThatOfSobolsDirectionNumbers)
{
    for (std::uint32_t n = 0; n < 5000; ++n) {
        const std::uint32_t index = n * 0x9e3779b9u;
        std::uint32_t y = 0, direction = 1u << 31;
        for (std::uint32_t i = index; i != 0; i >>= 1, direction ^= direction >> 1)
            if ((i & 1u) != 0) y ^= direction;
        ASSERT_EQ(sobol_pair(index).y, y) << "of number " << index;
    }
}

TEST(Sampler, AnIntervalIsTheFirstCoordinateOfItsSquare)
{
    const Sampler sampler(7, 1, true);
    for (std::uint32_t i = 0; i < 100; ++i) EXPECT_EQ(sampler.interval(4, 5, i, kLight), sampler.square(4, 5, i, kLight).x);
}

TEST(Sampler, NumbersOfSeveralSurfacesAreThoseOfTheirSequences)
{
    using Use = Dimension::Use;
    const Sampler sampler(7, 16, true);
    SurfacesToDraw of;
    for (int i = 0; i < SurfacesToDraw::kMost; ++i) {
        of.x[i] = 5 * i;
        of.y[i] = 100 - i;
        of.index[i] = static_cast<std::uint32_t>(i * i);
        of.key[i] = 0x9e3779b9u * static_cast<std::uint32_t>(i);
    }
    of.light_slots = (1u << SurfacesToDraw::kLightSlots) - 1;
    SurfaceNumbers drawn;
    sampler.draw(of, drawn);
    of.light_slots = 4;
    SurfaceNumbers some{};
    sampler.draw(of, some);
    Vec2f in_pixels[SurfacesToDraw::kMost];
    sampler.draw_in_pixels(of, in_pixels);
    for (int i = 0; i < SurfacesToDraw::kMost; ++i) {
        const auto sequence = [&](Use use) { return sampler.sequence(of.x[i], of.y[i], Dimension::at(of.key[i], use)); };
        const auto at = [&](const SurfaceNumbers::Squares& squares) { return Vec2f(squares.x[i], squares.y[i]); };
        for (int slot = 0; slot < SurfacesToDraw::kLightSlots; ++slot) {
            const Dimension light = Dimension::at(of.key[i], Use::Light, static_cast<std::uint32_t>(slot));
            EXPECT_EQ(at(drawn.light[slot]), sampler.square(of.x[i], of.y[i], of.index[i], light));
        }
        EXPECT_EQ(at(some.light[2]), at(drawn.light[2]));
        EXPECT_EQ(at(some.light[1]), Vec2f(0)) << "a slot that is not drawn";
        EXPECT_EQ(in_pixels[i], sampler.in_pixel(of.x[i], of.y[i], static_cast<int>(of.index[i])));
        EXPECT_EQ(at(drawn.scatter), sequence(Use::Scatter).square(of.index[i]));
        EXPECT_EQ(drawn.lobe[i], sequence(Use::Lobe).interval(of.index[i]));
    }
}

TEST(Sampler, ABlockIsItsPoints)
{
    const Sequence sequence = Sampler(7, 1, true).sequence(4, 5, kLight);
    for (const std::uint32_t first : {0u, 5u, 1000u, 0xfffffffcu}) {
        float x[Sequence::kBlock], y[Sequence::kBlock];
        sequence.squares(first, x, y);
        for (std::uint32_t i = 0; i < Sequence::kBlock; ++i) EXPECT_EQ(Vec2f(x[i], y[i]), sequence.square(first + i));
    }
}

TEST(Sampler, ScramblingKeepsTheOrderOfBitsAndIsABijection)
{
    std::set<std::uint32_t> seen;
    for (std::uint32_t i = 0; i < 4096; ++i) seen.insert(owen_scramble(i << 20, 0x1234567u) >> 20);
    EXPECT_EQ(seen.size(), 4096u) << "of the first twelve bits";
}

TEST(Sampler, WithoutJitterEverySampleIsTheMiddle)
{
    const Sampler sampler(7, 16, false);
    for (int s = 0; s < 16; ++s) EXPECT_EQ(sampler.in_pixel(3, 4, s), Vec2f(0.5f));
}

TEST(Sampler, NumbersDependOnSeedPixelDimensionAndIndex)
{
    const auto u = [](std::uint64_t seed, int x, int y, std::uint32_t index, std::uint32_t slot) {
        return Sampler(seed, 1, true).interval(x, y, index, Dimension::at(5, Dimension::Use::Light, slot));
    };
    EXPECT_EQ(u(1, 2, 3, 0, 4), u(1, 2, 3, 0, 4));
    EXPECT_NE(u(1, 2, 3, 0, 4), u(2, 2, 3, 0, 4));
    EXPECT_NE(u(1, 2, 3, 0, 4), u(1, 3, 2, 0, 4));
    EXPECT_NE(u(1, 2, 3, 0, 4), u(1, 2, 3, 1, 4));
    EXPECT_NE(u(1, 2, 3, 0, 4), u(1, 2, 3, 0, 5));
}

// Pairs of numbers from two dimensions are counted in 8 x 8 cells, for one sample in many pixels and for many samples in one
// pixel.
TEST(Sampler, TwoDimensionsAreNotCorrelated)
{
    const Sampler sampler(1, 16, true);
    const std::vector<double> wanted(64, 64.0);
    for (const bool along_samples : {false, true}) {
        std::vector<double> cells(64);
        for (int i = 0; i < 4096; ++i) {
            const int x = along_samples ? 9 : i % 64, y = along_samples ? 9 : i / 64;
            const auto index = static_cast<std::uint32_t>(along_samples ? i : 5);
            const float a = sampler.square(x, y, index, Dimension::pixel()).x, b = sampler.square(x, y, index, kLight).y;
            ++cells[std::size_t(int(a * 8) + 8 * int(b * 8))];
        }
        EXPECT_LT(test::chi_square_excess(cells, wanted), 4.5) << along_samples;
    }
}

// Weighted samples have the distribution of the filter: their moments are compared with the filter's own, from sums over a
// fine grid.
TEST(Filter, SamplesFollowTheFilter)
{
    for (const auto& [kind, name, usual] : kFilters) {
        const PixelFilter filter(kind);
        const float r = filter.radius();
        double sum = 0, absolute = 0, square = 0;
        for (int i = 0; i < 20000; ++i) {
            const float x = (2 * (float(i) + 0.5f) / 20000 - 1) * r;
            sum += double(filter.value(x));
            absolute += double(std::fabs(filter.value(x)));
            square += double(x * x * filter.value(x));
        }
        const Sampler sampler(3, 1, true);
        double weights = 0, drawn = 0;
        constexpr int kCount = 1 << 14;
        for (std::uint32_t i = 0; i < kCount; ++i) {
            const PixelFilter::Place p = filter.place(sampler.square(0, 0, i, kLight));
            EXPECT_LE(std::fabs(p.offset.x), r);
            weights += double(p.weight);
            drawn += double(p.weight * p.offset.x * p.offset.x);
        }
        // The filter is a product of two equal ones, so the mean of the weights is the square of that along one axis.
        EXPECT_NEAR(weights / kCount, (sum / absolute) * (sum / absolute), 5e-3) << name;
        EXPECT_NEAR(drawn / weights, square / sum, 5e-3 * std::max(1.0, square / sum)) << name;
    }
}

TEST(Filter, TheMiddleOfTheSquareIsTheMiddleOfThePixel)
{
    for (const auto& [kind, name, usual] : kFilters) {
        const PixelFilter::Place p = PixelFilter(kind).place(Vec2f(0.5f));
        EXPECT_NEAR(p.offset.x, 0, 1e-5f) << name;
        EXPECT_EQ(p.weight, 1) << name;
    }
}

// For a regular polygon and a disc, expectations are the shares of a grid's cells that lie in it, from the points of a finer
// grid.
TEST(Aperture, PointsAreUniformInTheOpening)
{
    constexpr int kCells = 10, kFine = 40;
    constexpr double kTau = 6.283185307179586;
    for (const int blades : {0, 3, 5, 6, 8}) {
        const auto is_inside = [&](double x, double y) {
            if (blades < 3) return x * x + y * y <= 1;
            for (int b = 0; b < blades; ++b) {
                const double middle = (b + 0.5) * kTau / blades;
                if (x * std::cos(middle) + y * std::sin(middle) > std::cos(kTau / blades / 2)) return false;
            }
            return true;
        };
        std::vector<double> found(kCells * kCells), wanted(kCells * kCells);
        test::Numbers numbers(4);
        constexpr int kCount = 40'000;
        double inside = 0;
        for (int j = 0; j < kCells * kFine; ++j)
            for (int i = 0; i < kCells * kFine; ++i) {
                const double x = (i + 0.5) / (kCells * kFine) * 2 - 1, y = (j + 0.5) / (kCells * kFine) * 2 - 1;
                if (!is_inside(x, y)) continue;
                wanted[std::size_t(j / kFine * kCells + i / kFine)] += 1;
                inside += 1;
            }
        for (double& w : wanted) w *= kCount / inside;
        for (int i = 0; i < kCount; ++i) {
            const Vec2f p = aperture_point(numbers.square(), blades);
            ++found[std::size_t(std::min(kCells - 1, int((p.y + 1) / 2 * kCells)) * kCells +
                                std::min(kCells - 1, int((p.x + 1) / 2 * kCells)))];
        }
        EXPECT_LT(test::chi_square_excess(found, wanted), 4.5) << blades;
    }
}

}  // namespace
}  // namespace occam::render
