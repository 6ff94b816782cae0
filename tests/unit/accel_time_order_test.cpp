// Tests of the choice of bins of time (accel/time_order.h).
#include "accel/time_order.h"

#include <gtest/gtest.h>

#include <bit>
#include <random>

namespace occam::test {
namespace {

constexpr std::size_t kRays = 4096;

// Lets batches cost costs[k] a ray with 2^k bins, and costs[5] if rays travel alone, with noise from tile to tile. Returns
// the mean cost of the last ones.
double cost_after_a_while(const double (&costs)[6], int batches, std::uint64_t seed)
{
    accel::TimeOrder order;
    std::mt19937_64 bits(seed);
    double sum = 0;
    for (int b = 0; b < 2 * batches; ++b) {
        const accel::BatchOrder next = order.next(kRays);
        EXPECT_TRUE(std::has_single_bit(next.bins) && next.bins <= accel::TimeOrder::kMostBins);
        const double cost = costs[next.is_alone ? 5 : std::countr_zero(next.bins)],
                     noise = 0.8 + 0.4 * double(bits() >> 11) * 0x1p-53;
        accel::BatchVisits visits;
        visits.rays_inside = kRays;
        visits.nodes = static_cast<std::uint64_t>(double(kRays) * 100 * cost * noise);
        order.note(kRays, visits);
        if (b >= batches) sum += cost;
    }
    return sum / batches;
}

TEST(TimeOrder, FindsTheCheapestNumberOfBins)
{
    for (const std::uint64_t seed : {1, 2, 3, 4}) {
        EXPECT_LT(cost_after_a_while({1, 1.3, 1.7, 2, 2.2, 2.2}, 200, seed), 1.1);
        EXPECT_LT(cost_after_a_while({5, 4, 3, 2, 1, 2}, 200, seed), 1.15);
        EXPECT_LT(cost_after_a_while({2, 1.5, 1, 1.3, 1.8, 2}, 200, seed), 1.1);
    }
}

TEST(TimeOrder, LetsRaysTravelAloneWhereThatIsCheapest)
{
    for (const std::uint64_t seed : {1, 2, 3, 4}) EXPECT_LT(cost_after_a_while({5, 4, 3, 2, 1.5, 1}, 200, seed), 1.1);
}

// Of some tiles few rays enter the scene; these cost little in any way.
TEST(TimeOrder, ComparesTheCostsOfRaysInTheScene)
{
    accel::TimeOrder order;
    std::size_t last = 0;
    for (int b = 0; b < 25; ++b) {
        const accel::BatchOrder next = order.next(kRays);
        last = next.bins;
        accel::BatchVisits visits;
        visits.rays_inside = next.bins == 16 ? kRays / 16 : kRays;
        visits.nodes = visits.rays_inside * (next.bins == 2 ? 5 : 10);
        order.note(kRays, visits);
    }
    EXPECT_EQ(last, 2U);
}

// What sixteen rays have met of tori that moved by 190 and by 19 pixels. In the first scene packets took 1.4 times as long
// as rays alone, although they visited a fifth of the nodes; in the second 0.8 times as long.
TEST(TimeOrder, HasTheOrderOfMeasuredTimes)
{
    const auto packets = [](std::uint64_t nodes, std::uint64_t leaves, std::uint64_t igrids, std::uint64_t rays) {
        return accel::BatchVisits{.nodes = nodes, .leaves = leaves, .igrids = igrids, .rays = rays}.cost();
    };
    const auto alone = [](std::uint64_t rays, std::uint64_t nodes, std::uint64_t igrids) {
        accel::BatchVisits visits;
        visits.lone_rays = rays;
        visits.nodes_of_lone_rays = nodes;
        visits.igrids_of_lone_rays = igrids;
        return visits.cost();
    };
    EXPECT_GT(packets(17, 30, 11, 14), 1.2 * alone(13, 84, 14));
    EXPECT_LT(packets(11, 7, 8, 17), 0.9 * alone(11, 95, 16));
}

TEST(TimeOrder, SortsSmallBatchesByTime)
{
    accel::TimeOrder order;
    EXPECT_EQ(order.next(16).bins, accel::TimeOrder::kMostBins);
    EXPECT_FALSE(order.next(16).is_alone);
}

}  // namespace
}  // namespace occam::test
