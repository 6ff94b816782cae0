// Tests of the limits that a container sets, on trees of files as Linux shows them.
#include <gtest/gtest.h>

#include <string>

#include "base/container_limits.h"
#include "base/machine_memory.h"
#include "base/processors.h"
#include "tests/support/temp_folder.h"

namespace occam::test {
namespace {

/// A file system with nothing but what says how the process is limited.
class FakeSystem {
public:
    FakeSystem& with(const std::string& path, const std::string& text)
    {
        folder_.write(path.substr(1), text);
        return *this;
    }
    ContainerLimits limits() const { return container_limits(folder_.path().string()); }

private:
    TempFolder folder_;
};

constexpr const char* kMountOfTwo = "25 1 0:22 / /sys/fs/cgroup rw,nosuid - cgroup2 cgroup rw\n";
// A container of version 1 sees the groups from its own on, and its own by its name outside.
constexpr const char* kMountsOfOne =
    "20 1 0:19 / / rw - overlay overlay rw\n"
    "30 20 0:26 /docker/abc /sys/fs/cgroup/memory ro,nosuid master:11 - cgroup cgroup rw,memory\n"
    "31 20 0:27 /docker/abc /sys/fs/cgroup/cpu,cpuacct ro,nosuid master:12 - cgroup cgroup rw,cpu,cpuacct\n";
constexpr const char* kGroupsOfOne = "12:memory:/docker/abc\n9:cpu,cpuacct:/docker/abc\n3:cpuset:/docker/abc\n";

TEST(ContainerLimits, AreThoseOfTheOwnGroupAndOfAllAroundItInVersionTwo)
{
    FakeSystem system;
    system.with("/proc/self/cgroup", "0::/jobs/night/one\n").with("/proc/self/mountinfo", kMountOfTwo);
    EXPECT_EQ(system.limits().memory_bytes, 0u);
    EXPECT_EQ(system.limits().processors, 0);
    const std::string top = "/sys/fs/cgroup";
    system.with(top + "/jobs/night/one/memory.max", "max\n").with(top + "/jobs/night/one/cpu.max", "max 100000\n");
    EXPECT_EQ(system.limits().memory_bytes, 0u);
    EXPECT_EQ(system.limits().processors, 0);
    system.with(top + "/jobs/night/memory.max", "2147483648\n").with(top + "/jobs/night/cpu.max", "150000 100000\n");
    EXPECT_EQ(system.limits().memory_bytes, std::size_t(2) << 30);
    EXPECT_EQ(system.limits().processors, 1.5);
    system.with(top + "/jobs/night/one/memory.max", "1073741824\n").with(top + "/jobs/memory.max", "4294967296\n");
    EXPECT_EQ(system.limits().memory_bytes, std::size_t(1) << 30);
    system.with(top + "/jobs/cpu.max", "50000 100000\n");
    EXPECT_EQ(system.limits().processors, 0.5);
    system.with(top + "/jobs/nightly/memory.max", "4096\n").with(top + "/jobs/night/one/two/memory.max", "4096\n");
    EXPECT_EQ(system.limits().memory_bytes, std::size_t(1) << 30) << "other groups do not count";
}

TEST(ContainerLimits, AreThoseOfTheGroupThatAContainerSees)
{
    FakeSystem one;
    one.with("/proc/self/cgroup", kGroupsOfOne).with("/proc/self/mountinfo", kMountsOfOne);
    one.with("/sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");
    one.with("/sys/fs/cgroup/cpu,cpuacct/cpu.cfs_quota_us", "-1\n");
    one.with("/sys/fs/cgroup/cpu,cpuacct/cpu.cfs_period_us", "100000\n");
    EXPECT_EQ(one.limits().memory_bytes, 0u);
    EXPECT_EQ(one.limits().processors, 0);
    one.with("/sys/fs/cgroup/memory/memory.limit_in_bytes", "536870912\n");
    one.with("/sys/fs/cgroup/cpu,cpuacct/cpu.cfs_quota_us", "250000\n");
    EXPECT_EQ(one.limits().memory_bytes, std::size_t(512) << 20);
    EXPECT_EQ(one.limits().processors, 2.5);
    FakeSystem two;  // a name space of its own calls its group the topmost one
    two.with("/proc/self/cgroup", "0::/\n").with("/proc/self/mountinfo", kMountOfTwo);
    two.with("/sys/fs/cgroup/memory.max", "536870912\n");
    EXPECT_EQ(two.limits().memory_bytes, std::size_t(512) << 20);
    FakeSystem outside;  // the process was moved to a group that the container does not see
    outside.with("/proc/self/cgroup", "12:memory:/docker/abcdef\n").with("/proc/self/mountinfo", kMountsOfOne);
    outside.with("/sys/fs/cgroup/memory/memory.limit_in_bytes", "536870912\n");
    EXPECT_EQ(outside.limits().memory_bytes, std::size_t(512) << 20);
}

TEST(ContainerLimits, AreNoneWhereFilesSayNothingThatCanBeUnderstood)
{
    const auto expect_none = [](const ContainerLimits& limits, const std::string& what) {
        EXPECT_EQ(limits.memory_bytes, 0u) << what;
        EXPECT_EQ(limits.processors, 0) << what;
    };
    expect_none(container_limits("/no such folder"), "no files");
    for (const std::string group : {"", "0", "0:", "0::", "::::", "12:memory\n", "0::/a/../..\n", "0::no slash\n"})
        for (const std::string mounts : {"", " - ", "- - - -", "1 2 3 4 5 - cgroup2", "25 1 0:22 / /sys/fs/cgroup rw"}) {
            FakeSystem system;
            system.with("/proc/self/cgroup", group).with("/proc/self/mountinfo", mounts);
            expect_none(system.limits(), group + " and " + mounts);
        }
    for (const std::string text : {"", "\n", "0", "-5", "nan", "-inf", "inf", "1e999", "many", "12x", "0x10", "100000 0",
                                   "100000 -1", "100000 x", "nan 5"}) {
        FakeSystem system;
        system.with("/proc/self/cgroup", "0::/\n").with("/proc/self/mountinfo", kMountOfTwo);
        system.with("/sys/fs/cgroup/cpu.max", text);
        if (text.find(' ') == text.npos) system.with("/sys/fs/cgroup/memory.max", text);
        expect_none(system.limits(), text);
    }
}

TEST(ContainerLimits, BoundWhatTheMachineIsTakenFor)
{
    const ContainerLimits limits = container_limits();
    if (limits.memory_bytes > 0) {
        EXPECT_LE(machine_memory_bytes(), limits.memory_bytes);
    }
    EXPECT_GT(machine_memory_bytes(), 0u);
    if (limits.processors > 0) {
        EXPECT_LT(processor_count(), limits.processors + 1);
    }
    EXPECT_GE(processor_count(), 1);
    EXPECT_LE(processor_count(), processors_of_set());
}

}  // namespace
}  // namespace occam::test
