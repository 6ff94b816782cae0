// Tests of outputs that could be written, but could never get their name: these are refused before anything is rendered.
#include <fcntl.h>
#include <linux/capability.h>
#include <linux/fs.h>
#include <sys/ioctl.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/stat.h>

#include "io/output_file.h"
#include "render/image.h"
#include "tests/support/command_test.h"

namespace occam {
namespace {

using namespace test;

constexpr int kKeepsRights = 97;

class OutputPlaces : public CommandTest {
protected:
    void SetUp() override
    {
        CommandTest::SetUp();
        render::Image image(2, 2);
        image.add_layer("beauty", {"R", "G", "B"}).pixels.assign(12, 0.5f);
        for (const char* name : {"one.png", "taken.1.png", "taken.png"}) image.write(folder / name);
    }
    // Whoever may do with all files what their owners may loses that right with the start of the program.
    void lose_rights_of_owners()
    {
        before_exec = [] {
            if (geteuid() == 0 && prctl(PR_CAPBSET_DROP, CAP_FOWNER, 0, 0, 0) != 0) _exit(kKeepsRights);
        };
    }
    // Calls all commands that would replace taken.png or taken.1.png, each of which must refuse that before it makes
    // anything.
    void expect_refusals(const std::string& why)
    {
        const std::string before = text_of(folder / "taken.png");
        const std::string all = "is there already and cannot be replaced: " + why;
        const std::vector<std::string> calls[] = {
            {"render", "triangle.obj", "-o", "taken.png", "--size", "4x4", "--spp", "1"},
            {"render", "triangle.obj", "-o", "new.png", "--size", "4x4", "--spp", "1", "--stats", "taken.json"},
            {"compare", "one.png", "one.png", "--heat", "taken.png"},
            {"texture", "one.png", "taken.png"},
            {"animate", "triangle.obj", "-o", "taken.#.png", "--frames", "0-1", "--size", "4x4", "--spp", "1",
             "--overwrite"}};
        for (const std::vector<std::string>& words : calls) {
            const Outcome o = run(words);
            ASSERT_NE(o.exit_code, kKeepsRights);
            EXPECT_EQ(o.exit_code, kOutput) << words[0] << ": " << o.err;
            EXPECT_NE(o.err.find(all), std::string::npos) << words[0] << ": " << o.err;
        }
        EXPECT_EQ(text_of(folder / "taken.png"), before);
        for (const char* name : {"taken.0.png", "new.png"}) EXPECT_FALSE(fs::exists(folder / name)) << name;
        for (const auto& entry : fs::directory_iterator(folder))
            EXPECT_EQ(entry.path().filename().string().find(".part"), std::string::npos) << entry.path();
    }
};

TEST_F(OutputPlaces, OfAnotherUserInAStickyFolderAreRefused)
{
    constexpr uid_t kOther = 12345;
    std::ofstream(folder / "taken.json");
    for (const char* name : {"taken.png", "taken.1.png", "taken.json", "."})
        if (chown((folder / name).c_str(), kOther, gid_t(-1)) != 0) GTEST_SKIP() << "this user may not give files away";
    ASSERT_EQ(chmod(folder.c_str(), 01777), 0);
    lose_rights_of_owners();
    if (run({"--version"}).exit_code == kKeepsRights) GTEST_SKIP() << "this user may not give up rights";
    expect_refusals("it belongs to another user, and folder . is sticky");
    // A finished frame of somebody else is left alone, and does not stop the rest of the sequence.
    const std::vector<std::string> sequence{"animate", "triangle.obj", "-o", "shared.#.png", "--frames", "0-1", "--size",
                                            "4x4",     "--spp",        "1",  "--exposure",   "0"};
    std::vector<std::string> first = sequence;
    first[5] = "0";
    ASSERT_EQ(run(first).exit_code, kDone);
    ASSERT_EQ(chown((folder / "shared.0.png").c_str(), kOther, gid_t(-1)), 0);
    const Outcome rest = run(sequence);
    EXPECT_EQ(rest.exit_code, kDone) << rest.err;
    EXPECT_TRUE(fs::exists(folder / "shared.1.png"));
}

TEST_F(OutputPlaces, OnWhichAFileIsMountedAreRefused)
{
    std::ofstream(folder / "taken.json");
    std::vector<std::string> mounted;
    for (const char* name : {"taken.png", "taken.1.png", "taken.json"})
        if (const std::string file = (folder / name).string(); mount(file.c_str(), file.c_str(), "", MS_BIND, nullptr) == 0)
            mounted.push_back(file);
    if (mounted.size() == 3) expect_refusals("a file is mounted on it");
    for (const std::string& file : mounted) umount(file.c_str());
    if (mounted.size() != 3) GTEST_SKIP() << "this user may not mount a file";
}

// Returns whether the file system has the attribute and has set it.
bool set_attribute(const fs::path& file, int attribute, bool is_on)
{
    const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC);
    int flags = 0;
    bool is_set = descriptor >= 0 && ioctl(descriptor, FS_IOC_GETFLAGS, &flags) == 0;
    flags = is_on ? flags | attribute : flags & ~attribute;
    is_set = is_set && ioctl(descriptor, FS_IOC_SETFLAGS, &flags) == 0;
    close(descriptor);
    return is_set;
}

TEST_F(OutputPlaces, ThatCannotBeChangedAreRefused)
{
    std::ofstream(folder / "taken.json");
    const char* const names[] = {"taken.png", "taken.1.png", "taken.json"};
    bool can_be_set = true;
    for (const char* name : names) can_be_set = can_be_set && set_attribute(folder / name, FS_IMMUTABLE_FL, true);
    if (can_be_set) expect_refusals("it has the attribute immutable or append-only");
    for (const char* name : names) set_attribute(folder / name, FS_IMMUTABLE_FL, false);
    if (!can_be_set) GTEST_SKIP() << "the file system has no such attribute, or this user may not set it";
    fs::create_directory(folder / "log");
    ASSERT_TRUE(set_attribute(folder / "log", FS_APPEND_FL, true));
    const Outcome o = run({"render", "triangle.obj", "-o", "log/a.png", "--size", "4x4", "--spp", "1"});
    set_attribute(folder / "log", FS_APPEND_FL, false);
    EXPECT_EQ(o.exit_code, kOutput);
    EXPECT_EQ(o.err, "occam: log/a.png: cannot be written in folder log, which has the attribute append-only\n");
    EXPECT_TRUE(fs::is_empty(folder / "log"));
}

TEST_F(OutputPlaces, ThatAreLinksAreReplacedThemselves)
{
    fs::create_symlink("taken.png", folder / "link.png");
    EXPECT_NO_THROW(check_output(folder / "link.png"));
    EXPECT_EQ(run({"render", "triangle.obj", "-o", "link.png", "--size", "4x4", "--spp", "1"}).exit_code, kDone);
    EXPECT_FALSE(fs::is_symlink(folder / "link.png"));
}

// The file would replace the link, and /dev/stdout is one: what the shell has opened behind it may well be a regular file.
TEST_F(OutputPlaces, ThatLeadToOpenFilesAreRefused)
{
    const std::string why = "is open already, and this output has to be a file of its own";
    for (const char* name : {"link.png", "link.0.png"}) fs::create_symlink("/dev/stdout", folder / name);
    const std::vector<std::string> calls[] = {
        {"render", "triangle.obj", "-o", "link.png", "--size", "4x4", "--spp", "1"},
        {"compare", "one.png", "one.png", "--heat", "link.png"},
        {"texture", "one.png", "link.png"},
        {"animate", "triangle.obj", "-o", "link.#.png", "--frames", "0", "--size", "4x4", "--spp", "1", "--overwrite"}};
    for (const std::vector<std::string>& words : calls) {
        const Outcome o = run(words);
        EXPECT_EQ(o.exit_code, kOutput) << words[0];
        EXPECT_NE(o.err.find(why), std::string::npos) << words[0] << ": " << o.err;
        for (const char* name : {"link.png", "link.0.png"}) EXPECT_TRUE(fs::is_symlink(folder / name)) << words[0];
    }
    EXPECT_EQ(run({"texture", "one.png", "-"}).err, "occam: standard output: " + why + "\n");
    EXPECT_FALSE(fs::exists(folder / "-"));
}

}  // namespace
}  // namespace occam
