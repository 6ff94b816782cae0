// How many surfaces the rays of a frame may pass straight on, all together.
//
// Surfaces that stand in a row along the view are few by their areas (kMostPassed in scenegraph/contents.h), and yet each
// ray may pass them all. So what rays really pass is limited, too. Whether a frame is refused depends on the sum over all of
// its samples, which is the same for any number of threads.
//
// Threads  any thread may call spend().
#pragma once

#include <atomic>
#include <cstdint>

namespace occam::render {

struct Settings;

class PassBudget {
public:
    /// The most surfaces that the rays of a sample may pass on average, for each light sample of a hit.
    static constexpr double kMostOfASample = 1 << 11;
    /// A frame may always pass this many, which takes about a second.
    static constexpr std::uint64_t kLeast = 1 << 22;

    explicit PassBudget(const Settings& settings) noexcept;

    /// Counts surfaces that rays have passed. Throws Error if the rays of the frame have passed too many.
    void spend(std::uint64_t passed)
    {
        if (passed > 0 && passed_.fetch_add(passed, std::memory_order_relaxed) + passed > most_) refuse();
    }

private:
    [[noreturn]] void refuse() const;

    std::uint64_t most_;
    std::atomic<std::uint64_t> passed_ = 0;
};

}  // namespace occam::render
