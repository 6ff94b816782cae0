// Chooses into how many bins of time the rays of a batch are sorted before they are sorted by direction, or that each of
// them travels alone.
//
// Rays of one time see what moves in one place, but the samples of one pixel have all times: bins of time take them apart.
// Which packets meet fewest boxes depends on how far things move while the shutter is open: where they move by less than a
// pixel, one bin is best, and where they move by several, four or eight are. Where things fly, the rays of any packet meet
// different igrids, and each had better travel alone. So the first batches try all of these, and later ones try the
// neighbours of what is in use now and then. Hits do not depend on it.
//
// Threads  Each worker has its own.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace occam::accel {

/// Counts what rays of a batch have met.
struct BatchVisits {
    std::uint64_t rays_inside = 0;                    ///< rays that enter the scene
    std::uint64_t nodes = 0, leaves = 0, igrids = 0;  ///< of packets
    std::uint64_t rays = 0;                           ///< of packets at these igrids
    std::uint64_t lone_rays = 0;                      ///< that enter the scene
    std::uint64_t nodes_of_lone_rays = 0, igrids_of_lone_rays = 0;

    /// Returns the cost, roughly, in visits of nodes by packets (docs/what-was-tried.md).
    double cost() const noexcept
    {
        return double(nodes) + 0.5 * double(leaves + igrids) + 0.4 * double(rays) +
               0.25 * double(lone_rays + nodes_of_lone_rays) + 0.5 * double(igrids_of_lone_rays);
    }
};

/// Says how the rays of a batch travel where things move.
struct BatchOrder {
    std::size_t bins;  ///< the largest number of bins of time
    bool is_alone = false;
};

class TimeOrder {
public:
    static constexpr std::size_t kMostBins = 16;

    /// Returns how the rays of the next batch travel.
    BatchOrder next(std::size_t rays) noexcept
    {
        if (rays < kLeastRays) return {kMostBins};
        ++batches_;
        tried_ = used_;
        if (batches_ <= kFirstBatches) tried_ = static_cast<int>(batches_ % kWays);
        else {
            const int period = batches_ <= kEarlyBatches ? kEarlyPeriod : kPeriod;
            if (batches_ % period == 0) tried_ = (batches_ / period) % 2 == 0 ? used_ - 1 : used_ + 1;
        }
        if (tried_ < 0 || tried_ >= kWays) tried_ = used_;
        // Rays alone need no bins.
        if (tried_ == kAlone) return {1, true};
        return {std::size_t(1) << tried_};
    }
    /// Notes what that batch has cost.
    void note(std::size_t rays, const BatchVisits& visits) noexcept
    {
        if (rays < kLeastRays) return;
        // Tiles differ most by how many of their rays miss the scene.
        const double inside = double(std::max<std::uint64_t>(1, visits.rays_inside)), cost = visits.cost() / inside;
        if (batches_ <= kFirstBatches) {
            first_[tried_].cost += visits.cost();
            first_[tried_].rays += inside;
            if (batches_ == kFirstBatches) used_ = static_cast<int>(std::min_element(first_, first_ + kWays) - first_);
        } else if (tried_ != used_) {
            compare(known_[tried_ > used_], cost);
        }
        last_cost_ = cost;
    }

private:
    /// The sums of the first batches, which are compared by the cost of a ray.
    struct First {
        double cost = 0, rays = 1;
        friend bool operator<(const First& a, const First& b) noexcept { return a.cost * b.rays < b.cost * a.rays; }
    };
    /// The costs of batches that travel in the way that is in use, and of those after them in another way. The latest count
    /// most.
    struct Trials {
        double here = 0, there = 0;
        int count = 0;
    };
    static constexpr std::size_t kLeastRays = 512;  ///< smaller batches teach nothing
    /// A way is the logarithm of a number of bins, or kAlone.
    static constexpr int kAlone = std::countr_zero(kMostBins) + 1, kWays = kAlone + 1, kFirstBatches = 4 * kWays;
    static constexpr int kPeriod = 12, kEarlyPeriod = 4;  ///< of so many batches one is a trial
    static constexpr int kEarlyBatches = 5 * kFirstBatches;
    static constexpr int kLeastTrials = 4;
    static constexpr double kShareOfOld = 0.85, kMuchLess = 0.95;

    void compare(Trials& known, double cost) noexcept
    {
        known.here = kShareOfOld * known.here + last_cost_;
        known.there = kShareOfOld * known.there + cost;
        if (++known.count < kLeastTrials || !(known.there < kMuchLess * known.here)) return;
        used_ = tried_;
        known_[0] = known_[1] = {};
    }

    First first_[kWays];  ///< by way
    Trials known_[2];     ///< beside the way before the one in use, and the one after it
    double last_cost_ = 0;
    int used_ = 0, tried_ = 0;  ///< ways
    std::int64_t batches_ = 0;
};

}  // namespace occam::accel
