// Chooses into how many bins of time the rays of a batch are sorted before they are sorted by direction.
//
// Rays of one time see what moves in one place, but the samples of one pixel have all times: bins of time take them apart.
// Which packets meet fewest boxes depends on how far things move while the shutter is open: where they move by less than a
// pixel, one bin is best, and where they fly, sixteen are. So the first batches try all numbers, and later ones try the next
// smaller and the next larger one now and then. Hits do not depend on it.
//
// Threads  Each worker has its own.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace occam::accel {

/// Counts what rays of a batch have met.
struct BatchVisits {
    std::uint64_t of_packets = 0;    ///< nodes and igrids; an igrid counts once for each segment of its motion
    std::uint64_t rays = 0;          ///< the rays of packets at igrids
    std::uint64_t of_lone_rays = 0;  ///< nodes, and igrids twice

    /// Returns the cost, roughly, in visits of packets (docs/performance.md).
    double cost() const noexcept { return double(of_packets) + 0.5 * double(rays) + 0.25 * double(of_lone_rays); }
};

class TimeOrder {
public:
    static constexpr std::size_t kMostBins = 16;

    /// Returns the largest number of bins for the next batch.
    std::size_t bins(std::size_t rays) noexcept
    {
        if (rays < kLeastRays) return kMostBins;
        ++batches_;
        tried_ = exponent_;
        if (batches_ <= kFirstBatches) tried_ = static_cast<int>(batches_ % kExponents);
        else if (batches_ % kPeriod == 0) tried_ = (batches_ / kPeriod) % 2 == 0 ? exponent_ - 1 : exponent_ + 1;
        if (tried_ < 0 || tried_ >= kExponents) tried_ = exponent_;
        return std::size_t(1) << tried_;
    }
    /// Notes what that batch has cost.
    void note(std::size_t rays, const BatchVisits& visits) noexcept
    {
        if (rays < kLeastRays) return;
        const double cost = visits.cost() / double(rays);
        if (batches_ <= kFirstBatches) {
            first_[tried_] += cost;
            if (batches_ == kFirstBatches)
                exponent_ = static_cast<int>(std::min_element(first_, first_ + kExponents) - first_);
        } else if (tried_ != exponent_) {
            compare(known_[tried_ > exponent_], cost);
        }
        last_cost_ = cost;
    }

private:
    /// The costs of batches with the number of bins that is in use, and of those after them with another number. The latest
    /// count most.
    struct Trials {
        double here = 0, there = 0;
        int count = 0;
    };
    static constexpr std::size_t kLeastRays = 512;  ///< smaller batches teach nothing
    static constexpr int kExponents = 5, kFirstBatches = 4 * kExponents;
    static constexpr int kPeriod = 12;  ///< of so many batches one is a trial
    static constexpr int kLeastTrials = 4;
    static constexpr double kShareOfOld = 0.85, kMuchLess = 0.95;

    void compare(Trials& known, double cost) noexcept
    {
        known.here = kShareOfOld * known.here + last_cost_;
        known.there = kShareOfOld * known.there + cost;
        if (++known.count < kLeastTrials || !(known.there < kMuchLess * known.here)) return;
        exponent_ = tried_;
        known_[0] = known_[1] = {};
    }

    double first_[kExponents]{};  ///< sums of the first batches' costs, by the logarithm of their number of bins
    Trials known_[2];             ///< beside half as many bins, and twice as many
    double last_cost_ = 0;
    int exponent_ = 0, tried_ = 0;  ///< logarithms
    std::int64_t batches_ = 0;
};

}  // namespace occam::accel
