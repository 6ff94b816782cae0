// Tests of what is made once, by whoever asks first, also where the maker fails and where there is no memory at all.
#include "base/made_once.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <memory>
#include <new>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "lod/patch_class.h"
#include "lod/patch_hull.h"
#include "tests/support/campaign.h"

namespace occam {
namespace {

TEST(MadeOnce, IsMadeByTheFirstOneWhoAsks)
{
    MadeOnce<int> value;
    EXPECT_EQ(value.get(), nullptr);
    const int& made = value.get_or_make([] { return std::make_unique<int>(1); });
    EXPECT_EQ(made, 1);
    EXPECT_EQ(&value.get_or_make([] { return std::make_unique<int>(2); }), &made);
    EXPECT_EQ(value.get(), &made);
}

TEST(MadeOnce, IsMadeAnewWhereTheMakerHasFailed)
{
    MadeOnce<int> value;
    for (int i = 0; i < 2; ++i) {
        EXPECT_THROW(value.get_or_make([]() -> std::unique_ptr<int> { throw std::runtime_error("no"); }),
                     std::runtime_error);
        EXPECT_EQ(value.get(), nullptr);
    }
    EXPECT_EQ(value.get_or_make([] { return std::make_unique<int>(3); }), 3);
}

TEST(MadeOnce, IsMadeOnceForManyThreadsOfWhichTheFirstFail)
{
    constexpr int kRounds = 50, kThreads = 4, kFailures = 3;
    for (int round = 0; round < kRounds; ++round) {
        MadeOnce<std::vector<int>> value;
        std::atomic<int> calls = 0, wrong = 0;
        const auto ask = [&] {
            for (;;) try {
                    const std::vector<int>& made = value.get_or_make([&] {
                        if (++calls <= kFailures) throw std::bad_alloc();
                        return std::make_unique<std::vector<int>>(100, calls);
                    });
                    wrong += made != std::vector<int>(100, kFailures + 1);
                    return;
                } catch (const std::bad_alloc&) {
                }
        };
        std::vector<std::thread> threads;
        for (int i = 0; i < kThreads; ++i) threads.emplace_back(ask);
        for (std::thread& thread : threads) thread.join();
        EXPECT_EQ(calls, kFailures + 1);
        EXPECT_EQ(wrong, 0);
    }
}

/// The source of a patch whose limit surface is its one control point.
struct OnePoint final : lod::LimitSource {
    void evaluate(double, double, Of, lod::LimitStencil& out) const override
    {
        out.p.assign(1, 1.0);
        out.du.assign(1, 0.0);
        out.dv.assign(1, 0.0);
    }
    std::size_t bytes() const noexcept override { return 0; }
};

/// Takes all memory that the process can get, and gives it back at the end.
class NoMemory {
public:
    NoMemory()
    {
        rlimit limit{};
        getrlimit(RLIMIT_AS, &limit);
        limit.rlim_cur = 1;  // what is there stays, and nothing can be added
        setrlimit(RLIMIT_AS, &limit);
        // Small blocks that were freed before are kept for requests of just their size.
        constexpr std::size_t kLargestSmall = 2048, kStep = 16;
        for (std::size_t bytes = std::size_t(1) << 20; bytes > kLargestSmall; bytes /= 2) take_all(bytes);
        for (std::size_t bytes = kLargestSmall; bytes > 0; bytes -= kStep) take_all(bytes);
    }
    ~NoMemory()
    {
        while (first_) std::free(std::exchange(first_, first_->next));
    }
    NoMemory(const NoMemory&) = delete;
    NoMemory& operator=(const NoMemory&) = delete;

private:
    struct Block {
        Block* next;
    };
    void take_all(std::size_t bytes)
    {
        while (void* memory = std::malloc(bytes)) first_ = new (memory) Block{first_};
    }
    Block* first_ = nullptr;
};

/// Returns 0 if ask() throws std::bad_alloc without memory, and returns true with it. Every other number names a step.
template <class Ask>
int outcome_without_memory(Ask&& ask)
{
    try {
        const NoMemory none;
        ask();
        return 1;
    } catch (const std::bad_alloc&) {
    }
    return ask() ? 0 : 2;
}

/// Returns what the process has ended with that calls ask(), -1 if a signal has ended it.
template <class Ask>
int outcome_in_child(Ask&& ask)
{
    const pid_t child = fork();
    if (child == 0) {
        const rlimit no_core{};
        setrlimit(RLIMIT_CORE, &no_core);
        _exit(outcome_without_memory(ask));
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

// Where these tables were made in a std::call_once, the process was ended by glibc, which had no memory to look for a
// library.
TEST(MadeOnce, TablesOfAPatchThatHaveNoMemoryDoNotEndTheProcess)
{
    if (test::kIsSanitized) GTEST_SKIP() << "sanitizers have a malloc of their own";
    const lod::PatchClass kind(1, std::make_unique<const OnePoint>());
    EXPECT_EQ(outcome_in_child([&] { return kind.hull().squares > 0; }), 0);
    EXPECT_EQ(outcome_in_child([&] { return kind.corner(3).weights.size() == 1; }), 0);
}

}  // namespace
}  // namespace occam
