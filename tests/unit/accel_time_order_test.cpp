// Tests of the choice of bins of time (accel/time_order.h).
#include "accel/time_order.h"

#include <gtest/gtest.h>

#include <bit>
#include <random>

namespace occam::test {
namespace {

constexpr std::size_t kRays = 4096;

// Lets batches cost costs[k] a ray with 2^k bins, with noise from tile to tile, and returns the mean cost of the last ones.
double cost_after_a_while(const double (&costs)[5], int batches, std::uint64_t seed)
{
    accel::TimeOrder order;
    std::mt19937_64 bits(seed);
    double sum = 0;
    for (int b = 0; b < 2 * batches; ++b) {
        const std::size_t bins = order.bins(kRays);
        EXPECT_TRUE(std::has_single_bit(bins) && bins <= accel::TimeOrder::kMostBins);
        const double cost = costs[std::countr_zero(bins)], noise = 0.8 + 0.4 * double(bits() >> 11) * 0x1p-53;
        accel::BatchVisits visits;
        visits.of_packets = static_cast<std::uint64_t>(double(kRays) * 100 * cost * noise);
        order.note(kRays, visits);
        if (b >= batches) sum += cost;
    }
    return sum / batches;
}

TEST(TimeOrder, FindsTheCheapestNumberOfBins)
{
    for (const std::uint64_t seed : {1, 2, 3, 4}) {
        EXPECT_LT(cost_after_a_while({1, 1.3, 1.7, 2, 2.2}, 200, seed), 1.1);
        EXPECT_LT(cost_after_a_while({5, 4, 3, 2, 1}, 200, seed), 1.15);
        EXPECT_LT(cost_after_a_while({2, 1.5, 1, 1.3, 1.8}, 200, seed), 1.1);
    }
}

TEST(TimeOrder, SortsSmallBatchesByTime)
{
    accel::TimeOrder order;
    EXPECT_EQ(order.bins(16), accel::TimeOrder::kMostBins);
}

}  // namespace
}  // namespace occam::test
