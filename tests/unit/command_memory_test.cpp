// Tests that a process whose memory is limited ends with one line and an exit code, wherever the limit is met.
#include <sys/resource.h>

#include "tests/support/campaign.h"
#include "tests/support/command_test.h"

namespace occam {
namespace {

using namespace test;

class LimitedMemory : public CommandTest {};

// The limits range from what the program itself needs, over the loading of the libraries for pictures, to plenty.
TEST_F(LimitedMemory, EndsInOneLineOrAPicture)
{
    if (kIsSanitized) GTEST_SKIP() << "sanitizers reserve more addresses than these limits allow";
    int done = 0;
    for (const rlim_t megabytes : {96, 256, 400, 450, 470, 490, 520, 2048}) {
        before_exec = [megabytes] {
            const rlimit limit{megabytes << 20, megabytes << 20};
            setrlimit(RLIMIT_AS, &limit);
        };
        const Outcome o = run(
            {"render", "triangle.obj", "-o", "a.png", "--size", "16x12", "--spp", "1", "--threads", "2", "-q"});
        EXPECT_TRUE(o.exit_code == kDone || o.exit_code == kBadInput || o.exit_code == kOutput)
            << megabytes << ": " << o.err;
        EXPECT_EQ(fs::exists(folder / "a.png"), o.exit_code == kDone) << megabytes;
        EXPECT_EQ(o.err.find("occam: ") == std::string::npos, o.exit_code == kDone) << megabytes << ": " << o.err;
        done += o.exit_code == kDone;
        fs::remove(folder / "a.png");
    }
    EXPECT_GT(done, 0);
}

}  // namespace
}  // namespace occam
