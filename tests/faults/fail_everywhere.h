// Tries something again and again while another allocation fails each time.
#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <new>

#include "base/error.h"
#include "tests/faults/failing_allocations.h"
#include "tests/support/campaign.h"

namespace occam::test {

/// Says which allocations fail one after the other: all of the first `dense` ones, then fewer and fewer.
struct Density {
    std::uint64_t dense = 16;
    double growth = 1.25;
    bool may_lose_blocks = false;  ///< libraries lose blocks where allocations fail in them

    std::uint64_t after(std::uint64_t n) const
    {
        if (n < dense) return n + 1;
        return std::max(n + 1, static_cast<std::uint64_t>(double(n) * (is_long() ? 1.01 : growth)));
    }
};

/// Calls attempt() while one allocation fails, or that and all further ones, for ever later allocations, until it needs so
/// few that none fails. It may throw std::bad_alloc, or an Error that says so. Each time check(has_thrown) is called
/// afterwards. Together they may not leave more blocks behind than there were before, except for what libraries make once.
template <class Attempt, class Check>
void fail_everywhere(Density density, Attempt&& attempt, Check&& check)
{
    for (const std::uint64_t count : {std::uint64_t(1), kAllFurther}) {
        std::uint64_t failed = 1;
        for (std::uint64_t n = 0; failed > 0 && !testing::Test::HasFailure(); n = density.after(n)) {
            SCOPED_TRACE(testing::Message() << "allocation " << n << (count == 1 ? "" : " and all further ones"));
            std::int64_t lost = 1;
            for (int again = 0; lost > 0 && again < 3; ++again) {
                const std::int64_t before = blocks_alive();
                bool has_thrown = false;
                char wrong[200] = "";  // a string would be allocated while allocations fail
                {
                    const FailingAllocations failing(n, count);
                    try {
                        attempt();
                    } catch (const std::bad_alloc&) {
                        has_thrown = true;
                    } catch (const Error& error) {
                        has_thrown = true;
                        if (error.kind() != Error::Kind::Output) std::snprintf(wrong, sizeof wrong, "%s", error.what());
                    }
                    failed = failing.failed();
                }
                EXPECT_STREQ(wrong, "") << "it is no lack of memory by its kind";
                check(has_thrown);
                lost = blocks_alive() - before;
            }
            EXPECT_TRUE(lost <= 0 || density.may_lose_blocks) << lost << " blocks are lost each time";
        }
    }
}

}  // namespace occam::test
