// Lets allocations fail on purpose.
//
// A program that links failing_allocations.cpp has its own operator new, which serves all libraries of the process, too.
// Memory that C libraries take by malloc() does not fail.
//
// Threads  The counters are those of all threads together. One FailingAllocations may live at a time.
#pragma once

#include <cstdint>

namespace occam::test {

/// Returns the number of blocks that operator new has given out and that are not freed yet.
std::int64_t blocks_alive() noexcept;

inline constexpr std::uint64_t kAllFurther = ~std::uint64_t(0);

/// Lets `count` allocations fail, from number `first` on; the first allocation of its lifetime has the number 0.
class FailingAllocations {
public:
    FailingAllocations(std::uint64_t first, std::uint64_t count) noexcept;
    ~FailingAllocations();
    FailingAllocations(const FailingAllocations&) = delete;
    FailingAllocations& operator=(const FailingAllocations&) = delete;

    /// Returns how many allocations were asked for, and how many of them failed.
    std::uint64_t made() const noexcept;
    std::uint64_t failed() const noexcept;
};

}  // namespace occam::test
