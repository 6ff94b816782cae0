#include "command/sequence.h"

#include <gtest/gtest.h>

#include <map>
#include <stdexcept>

namespace occam::command {
namespace {

TEST(FramePattern, PutsTheNumberWhereThePatternHasIt)
{
    EXPECT_EQ(FramePattern("out.####.exr").file(7), "out.0007.exr");
    EXPECT_EQ(FramePattern("out.####.exr").file(123456), "out.123456.exr");
    EXPECT_EQ(FramePattern("shots/a%04d.png").file(12), "shots/a0012.png");
    EXPECT_EQ(FramePattern("%d.png").file(12), "12.png");
    EXPECT_EQ(FramePattern("#.png").file(12), "12.png");
    EXPECT_EQ(FramePattern("shot #2/50%/a.##.png").file(3), "shot #2/50%/a.03.png");
    for (const char* bad :
         {"out.exr", "out.##.##.exr", "a%04d.#.exr", "a%s.exr", "a%4d.exr", "a%0d.exr", "a%.exr", "#/a.exr", "%0999d.exr"})
        EXPECT_THROW(FramePattern{bad}, std::invalid_argument) << bad;
}

TEST(Frames, AreRangesAndListsInOrderEachOnce)
{
    EXPECT_EQ(frames_of("5"), (std::vector<int>{5}));
    EXPECT_EQ(frames_of("1-4"), (std::vector<int>{1, 2, 3, 4}));
    EXPECT_EQ(frames_of("0-10x4"), (std::vector<int>{0, 4, 8}));
    EXPECT_EQ(frames_of("0-1000000").size(), 1'000'001u);
    EXPECT_EQ(frames_of("7,1-3,2-8x3"), (std::vector<int>{7, 1, 2, 3, 5, 8}));
    for (const char* bad : {"", "a", "1-", "-3", "4-1", "1-3x0", "1-3x", "5x2", "1,,2", "1-3-5", "1e3", "0-9999999", "1 2"})
        EXPECT_THROW(frames_of(bad), std::invalid_argument) << bad;
}

TEST(Shards, DivideASequenceWithoutOverlapOrGap)
{
    const std::vector<int> frames = frames_of("1-10,50-53");
    for (int count : {1, 2, 3, 14, 20}) {
        std::multiset<int> all;
        for (int index = 1; index <= count; ++index)
            for (int frame : Shard{index, count}.of(frames)) all.insert(frame);
        EXPECT_EQ(all, std::multiset<int>(frames.begin(), frames.end())) << count;
    }
    EXPECT_EQ(shard_of("2/8").index, 2);
    EXPECT_EQ(shard_of("2/8").count, 8);
    for (const char* bad : {"", "2", "0/4", "5/4", "1/0", "a/b", "1/2/3"})
        EXPECT_THROW(shard_of(bad), std::invalid_argument) << bad;
}

std::map<std::string, std::string> environment;
const char* variable(const char* name)
{
    const auto found = environment.find(name);
    return found == environment.end() ? nullptr : found->second.c_str();
}

TEST(Shards, FollowSlurmsArrayVariables)
{
    environment.clear();
    EXPECT_FALSE(slurm_shard(variable));
    // sbatch --array=4-10:2 starts tasks 4, 6, 8 and 10.
    environment = {{"SLURM_ARRAY_TASK_COUNT", "4"}, {"SLURM_ARRAY_TASK_MIN", "4"}, {"SLURM_ARRAY_TASK_STEP", "2"}};
    for (int i = 1; i <= 4; ++i) {
        environment["SLURM_ARRAY_TASK_ID"] = std::to_string(2 + 2 * i);
        const auto shard = slurm_shard(variable);
        ASSERT_TRUE(shard);
        EXPECT_EQ(shard->index, i);
        EXPECT_EQ(shard->count, 4);
    }
    environment["SLURM_ARRAY_TASK_ID"] = "12";
    EXPECT_FALSE(slurm_shard(variable)) << "not a task of that array";
    environment["SLURM_ARRAY_TASK_ID"] = "x";
    EXPECT_FALSE(slurm_shard(variable));
}

}  // namespace
}  // namespace occam::command
