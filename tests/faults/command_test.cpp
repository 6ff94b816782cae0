// The executable without enough memory: it ends with exit code 3 and one line, or does its work.
#include <unistd.h>

#include <csignal>
#include <cstdlib>

#include "tests/faults/fail_everywhere.h"
#include "tests/support/command_test.h"

namespace occam::test {
namespace {

constexpr unsigned kMostSeconds = 60;  // a command that takes longer is ended by a signal

class FailingCommand : public CommandTest {
protected:
    void SetUp() override
    {
        if (kIsSanitized) GTEST_SKIP() << "sanitizers have an operator new of their own";
        CommandTest::SetUp();
        executable = failing_executable();
    }
    /// Runs the command with failing allocations. Returns whether it has done its work.
    bool run_with(const std::string& failing, const std::vector<std::string>& arguments, const fs::path& output)
    {
        SCOPED_TRACE("OCCAM_FAILING=" + failing);
        before_exec = [&] {
            setenv("OCCAM_FAILING", failing.c_str(), 1);
            alarm(kMostSeconds);
        };
        const Outcome o = run(arguments);
        const bool is_done = o.exit_code == kDone;
        EXPECT_EQ(fs::exists(output), is_done) << o.err;
        if (!is_done) {
            EXPECT_EQ(o.exit_code, kOutput) << o.err;
            EXPECT_TRUE(o.err.starts_with("occam: ") && o.err.find('\n') == o.err.size() - 1) << o.err;
        }
        fs::remove(output);
        return is_done;
    }
    /// Runs the command without memory from each `step`-th of its last allocations on. `last` is the number of these.
    void run_at_end(const std::vector<std::string>& arguments, const fs::path& output, std::uint64_t last, unsigned step)
    {
        const fs::path count = folder / "allocations.txt";
        setenv("OCCAM_ALLOCATIONS", count.c_str(), 1);
        EXPECT_TRUE(run_with("1000000000 1", arguments, output));
        unsetenv("OCCAM_ALLOCATIONS");
        // Its end needs no memory, so that some are left when it has done its work.
        std::uint64_t enough = std::stoull("0" + text_of(count)), too_few = enough;
        for (std::uint64_t back = 1; too_few == enough && back < enough && !HasFailure(); back *= 2)
            (run_with(std::to_string(enough - back) + " 0", arguments, output) ? enough : too_few) = enough - back;
        while (enough - too_few > 1 && !HasFailure()) {
            const std::uint64_t middle = too_few + (enough - too_few) / 2;
            (run_with(std::to_string(middle) + " 0", arguments, output) ? enough : too_few) = middle;
        }
        ASSERT_GT(too_few, last);
        for (std::uint64_t n = too_few - last; n < too_few && !HasFailure(); n += step)
            run_with(std::to_string(n) + " 0", arguments, output);
    }
    /// Runs the command while one allocation fails, or that and all further ones, for ever later allocations.
    void run_everywhere(const std::vector<std::string>& arguments, const fs::path& output, const Density& density)
    {
        std::uint64_t all = 0;
        while (!run_with(std::to_string(all) + " 0", arguments, output) && !HasFailure()) all = density.after(all);
        EXPECT_GT(all, 1000u) << "it allocates more than that";
        for (std::uint64_t n = 0; n < all && !HasFailure(); n = density.after(n))
            run_with(std::to_string(n) + " 1", arguments, output);
        // What is left is the input, and what the command has printed: the last run has removed what others left behind that
        // were ended within a library.
        EXPECT_TRUE(run_with(std::to_string(all) + " 1", arguments, output));
        EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 3);
    }
};

TEST_F(FailingCommand, RendersOrEndsInOneLine)
{
    run_everywhere({"render", "triangle.obj", "-o", "a.exr", "--size", "8x6", "--spp", "1", "--threads", "1", "-q"},
                   folder / "a.exr", {.dense = 4, .growth = 1.6});
}

// The last allocations of a command are those of the library that writes its file. Some 230 before the end of an EXR file
// its attributes are copied. By default every fourth or fifth of the last ones is tried, and no format whose library takes
// long to load: FailingFiles writes these within the process.
TEST_F(FailingCommand, EndsInOneLineWhereverMemoryEndsWhileAFileIsWritten)
{
    // The library of the last three formats takes a quarter of a second to load.
    for (const auto& [name, last, is_quick] : {std::tuple("a.exr", 250u, true),
                                               {"a.png", 100u, true},
                                               {"a.jpg", 100u, false},
                                               {"a.hdr", 100u, false},
                                               {"a.tif", 100u, false}}) {
        const unsigned step = is_long() ? 1 : last == 100 ? 4 : 5;
        if (!is_quick && !is_long()) continue;
        run_at_end({"render", "triangle.obj", "-o", name, "--size", "8x6", "--spp", "1", "--threads", "1", "-q"},
                   folder / name, last, step);
    }
}

TEST_F(FailingCommand, WritesPNGOrEndsInOneLine)
{
    run_everywhere({"render", "triangle.obj", "-o", "a.png", "--size", "8x6", "--spp", "1", "--threads", "1", "-q"},
                   folder / "a.png", {.dense = 1, .growth = 8});
}

}  // namespace
}  // namespace occam::test
