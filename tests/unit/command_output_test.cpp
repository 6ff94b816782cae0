// Tests of outputs that cannot be finished: full disks, limits of the file size, closed pipes, killed runs, signals.
#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/mount.h>
#include <sys/resource.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "base/error.h"
#include "io/output_file.h"
#include "render/image.h"
#include "tests/support/campaign.h"
#include "tests/support/command_test.h"

namespace occam {
namespace {

using namespace test;

class Outputs : public CommandTest {
protected:
    void TearDown() override
    {
        if (is_mounted_) umount(small().c_str());
        CommandTest::TearDown();
    }
    fs::path small() const { return folder / "small"; }
    // This is false where the user may not mount a file system.
    bool mount_small(const char* size)
    {
        fs::create_directories(small());
        is_mounted_ = mount("tmpfs", small().c_str(), "tmpfs", 0, (std::string("size=") + size).c_str()) == 0;
        return is_mounted_;
    }
    void limit_file_size(rlim_t bytes)
    {
        before_exec = [bytes] {
            const rlimit limit{bytes, bytes};
            setrlimit(RLIMIT_FSIZE, &limit);
        };
    }
    void print_to(const char* file)
    {
        before_exec = [file] { dup2(open(file, O_WRONLY), STDOUT_FILENO); };
    }
    // The light has noise, which no format packs into a kilobyte.
    std::vector<std::string> detailed(const std::string& output, const std::vector<std::string>& more = {}) const
    {
        std::vector<std::string> all{"render", "triangle.obj", "-o", output, "--size", "64x48", "--spp", "1"};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
    std::vector<std::string> files_in(const fs::path& where) const
    {
        std::vector<std::string> names;
        for (const auto& entry : fs::directory_iterator(where)) names.push_back(entry.path().filename().string());
        std::sort(names.begin(), names.end());
        return names;
    }

private:
    bool is_mounted_ = false;
};

TEST_F(Outputs, ALimitOfTheFileSizeIsExitCode3AndLeavesNothing)
{
    limit_file_size(1024);
    for (const char* name : {"a.png", "a.jpg"}) {
        const Outcome o = run(detailed(name));
        EXPECT_EQ(o.exit_code, kOutput) << name << ": " << o.err;
        EXPECT_NE(o.err.find(std::string(name) + ": cannot be written: File too large"), std::string::npos) << o.err;
        EXPECT_EQ(files_in(folder), (std::vector<std::string>{"stderr.txt", "stdout.txt", "triangle.obj"})) << name;
    }
}

// Makes noise of 96 x 96 pixels, which no format packs into four kilobytes.
render::Image noise()
{
    render::Image image(96, 96);
    std::uint32_t state = 1;
    for (float& value : image.add_layer("beauty", {"R", "G", "B", "A"}).pixels)
        value = float((state = state * 1664525u + 1013904223u) >> 8) * 0x1p-24f;
    return image;
}

TEST_F(Outputs, AFullDiskIsAnErrorInEveryFormatAndLeavesNothing)
{
    if (!mount_small("4k")) GTEST_SKIP() << "this user may not mount a file system";
    for (const char* extension : {"exr", "png", "jpg", "tif", "hdr"}) {
        try {
            noise().write(small() / (std::string("a.") + extension));
            ADD_FAILURE() << extension << " was written";
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), Error::Kind::Output) << extension;
            EXPECT_NE(std::string(error.what()).find("No space left on device"), std::string::npos) << error.what();
        }
        EXPECT_TRUE(files_in(small()).empty()) << extension;
    }
}

TEST_F(Outputs, ASequenceOnAFullDiskKeepsItsWholeFramesAlone)
{
    if (!mount_small("20k")) GTEST_SKIP() << "this user may not mount a file system";
    const Outcome o = run(
        {"animate", "triangle.obj", "-o", "small/a.##.png", "--frames", "0-9", "--size", "48x36", "--spp", "1"});
    EXPECT_EQ(o.exit_code, kOutput) << o.err;
    const auto names = files_in(small());
    EXPECT_FALSE(names.empty());
    EXPECT_LT(names.size(), 10u);
    for (const std::string& name : names) {
        ASSERT_EQ(name[0], 'a') << name;
        EXPECT_EQ(render::Image::read(small() / name).width, 48) << name;
    }
}

TEST_F(Outputs, AFolderThatCannotBeWrittenToIsRefusedWithTheSystemsReason)
{
    if (!mount_small("4k")) GTEST_SKIP() << "this user may not mount a file system";
    ASSERT_EQ(mount(nullptr, small().c_str(), nullptr, MS_REMOUNT | MS_RDONLY, nullptr), 0);
    const Outcome o = run({"render", "triangle.obj", "-o", "small/a.png", "--size", "8x4", "--spp", "1"});
    EXPECT_EQ(o.exit_code, kOutput);
    EXPECT_EQ(o.err, "occam: small/a.png: cannot be written in folder small: Read-only file system\n");
}

TEST_F(Outputs, AnOlderPictureSurvivesARunThatCannotReplaceIt)
{
    ASSERT_EQ(run(detailed("a.png")).exit_code, kDone);
    const std::string before = text_of(folder / "a.png");
    limit_file_size(1024);
    EXPECT_EQ(run(detailed("a.png", {"--seed", "1"})).exit_code, kOutput);
    EXPECT_EQ(text_of(folder / "a.png"), before);
}

TEST_F(Outputs, StatisticsAreWholeOrNotThere)
{
    limit_file_size(1024);
    const Outcome o = run({"render", "triangle.obj", "-o", "a.png", "--size", "16x12", "--spp", "1", "--stats", "s.json"});
    EXPECT_EQ(o.exit_code, kOutput);
    EXPECT_NE(o.err.find("s.json"), std::string::npos) << o.err;
    EXPECT_TRUE(fs::exists(folder / "a.png"));
    EXPECT_EQ(files_in(folder), (std::vector<std::string>{"a.png", "stderr.txt", "stdout.txt", "triangle.obj"}));
    before_exec = nullptr;
    EXPECT_EQ(run({"render", "triangle.obj", "-o", "b.png", "--stats", "missing/s.json"}).exit_code, kOutput);
    EXPECT_FALSE(fs::exists(folder / "b.png")) << "found before the picture is made";
    EXPECT_EQ(run({"render", "triangle.obj", "-o", "b.png", "--size", "8x8", "--stats", "/dev/null"}).exit_code, kDone);
}

// A slip of the hand must not cost a scene, or one of its images.
TEST_F(Outputs, WhatIsReadForAPictureIsNotOverwritten)
{
    ASSERT_EQ(run({"render", "triangle.obj", "-o", "image.png", "--size", "8x4", "--spp", "1"}).exit_code, kDone);
    std::ofstream(folder / "red.mtl") << "newmtl red\nmap_Kd image.png\n";
    std::ofstream(folder / "scene.obj") << "mtllib red.mtl\nv -1 -1 0\nv 1 -1 0\nv 0 1 0\nusemtl red\nf 1 2 3\n";
    fs::create_hard_link(folder / "image.png", folder / "other.png");
    fs::create_symlink("image.png", folder / "linked.png");
    fs::create_directory_symlink(".", folder / "here");
    std::ofstream(folder / "braces.bin") << "{{{{";
    const std::string image = text_of(folder / "image.png");
    const std::vector<std::string> scene{"render", "scene.obj", "--size", "8x4", "--spp", "1", "-o"};
    const std::vector<std::string> lit{"render", "triangle.obj",  "--size",    "8x4", "--spp",
                                       "1",      "--environment", "image.png", "-o"};
    const auto with = [](std::vector<std::string> words, std::initializer_list<std::string> more) {
        words.insert(words.end(), more);
        return words;
    };
    const std::pair<std::vector<std::string>, const char*> calls[] = {
        {with(scene, {"image.png"}), "image.png: is an input, so it cannot be written"},
        {with(scene, {"other.png"}), "other.png: is an input, so it cannot be written"},
        {with(scene, {"linked.png"}), "linked.png: is an input, so it cannot be written"},
        {with(lit, {"./image.png"}), "image.png: is an input, so it cannot be written"},
        {with(scene, {"a.png", "--stats", "scene.obj"}), "scene.obj: is there already and holds no statistics"},
        {with(scene, {"a.png", "--stats", "red.mtl"}), "red.mtl: is there already and holds no statistics"},
        {with(scene, {"a.png", "--stats", "a.png"}), "cannot be written to one file"},
        {with(scene, {"a.png", "--stats", "./a.png"}), "cannot be written to one file"},
        {with(scene, {"here/a.png", "--stats", "a.png"}), "cannot be written to one file"},
        {{"animate", "triangle.obj", "-o", "f.##.png", "--frames", "0-3", "--shard", "1/2", "--stats", "./f.01.png"},
         "cannot be written to one file"},
        {with(scene, {"a.png", "--stats", "braces.bin"}), "braces.bin: is there already and holds no statistics"},
        {{"compare", "image.png", "image.png", "--heat", "other.png"}, "other.png: is an input, so it cannot be written"},
    };
    for (const auto& [words, why] : calls) {
        const Outcome o = run(words);
        EXPECT_EQ(o.exit_code, kBadInput) << why;
        EXPECT_NE(o.err.find(why), std::string::npos) << why << ": " << o.err;
    }
    EXPECT_EQ(text_of(folder / "image.png"), image);
    EXPECT_TRUE(text_of(folder / "scene.obj").starts_with("mtllib"));
    EXPECT_TRUE(text_of(folder / "red.mtl").starts_with("newmtl"));
    EXPECT_EQ(run(with(scene, {"a.png", "--stats", "s.json"})).exit_code, kDone);
    EXPECT_EQ(run(with(scene, {"a.png", "--stats", "s.json"})).exit_code, kDone) << "older statistics are replaced";
}

// A run that was stopped is started again with the same words.
TEST_F(Outputs, StatisticsOfASequenceAreReplacedByThoseOfTheNextRun)
{
    const std::vector<std::string> words{"animate", "triangle.obj", "-o",    "f.#.png", "--frames", "0-1",
                                         "--size",  "8x4",          "--spp", "1",       "--stats",  "s.json"};
    for (const char* frames : {"0", "0-1", "0-1", "0-2"}) {
        std::vector<std::string> some = words;
        some[5] = frames;
        const Outcome o = run(some);
        EXPECT_EQ(o.exit_code, kDone) << frames << ": " << o.err;
    }
    EXPECT_TRUE(text_of(folder / "s.json").starts_with("[\n{\"frame\": 2,")) << "the last run has made one frame";
    for (const char* other : {"[1, 2]", "[[{}]]", "[", "[section]\na = 1\n"}) {
        std::ofstream(folder / "other.json") << other;
        std::vector<std::string> some = words;
        some.back() = "other.json";
        EXPECT_EQ(run(some).exit_code, kBadInput) << other;
        EXPECT_EQ(text_of(folder / "other.json"), other);
    }
}

// A shell may have redirected the open file, so that the name leads to a regular one, but it must not be replaced.
TEST_F(Outputs, StatisticsGoToTheOpenFileThatLinksLeadTo)
{
    fs::create_symlink("/proc/self/fd/1", folder / "out");
    fs::create_symlink("out", folder / "linked");
    const auto words = [](const char* name, const char* progress) {
        return std::vector<std::string>{"render", "triangle.obj", "-o", "a.png",      "--size", "8x4", "--spp",
                                        "1",      "--stats",      name, "--progress", progress};
    };
    before_exec = [] { dprintf(STDOUT_FILENO, "before\n"); };
    for (const char* name : {"out", "linked", "/dev/fd/1"}) {
        const Outcome o = run(words(name, "plain"));
        EXPECT_EQ(o.exit_code, kDone) << name << ": " << o.err;
        EXPECT_TRUE(o.out.starts_with("before\n{\n  \"scene\": {")) << "what was printed before is kept: " << o.out;
        EXPECT_TRUE(o.out.ends_with("}\n")) << o.out;
    }
    for (const char* name : {"-", "out", "/dev/stdout"}) {
        const Outcome o = run(words(name, "openjd"));
        EXPECT_EQ(o.exit_code, kBadInput) << name << ": a render farm reads the lines of standard output";
        EXPECT_NE(o.err.find("--progress openjd (--stats)"), std::string::npos) << o.err;
    }
    EXPECT_TRUE(fs::is_symlink(folder / "out") && fs::is_symlink(folder / "linked"));
    fs::remove(folder / "a.png");
    for (const char* name : {"/dev/fd/0", "/dev/fd/77"}) {
        before_exec = [] { dup2(open("/dev/null", O_RDONLY), STDIN_FILENO); };
        EXPECT_EQ(run({"render", "triangle.obj", "-o", "a.png", "--stats", name}).exit_code, kOutput) << name;
        EXPECT_FALSE(fs::exists(folder / "a.png")) << "found before the picture is made";
    }
}

// libpng writes to standard error what it finds wrong, unless it is told where to report it.
TEST_F(Outputs, NothingIsOnStandardErrorButALineOfOurs)
{
    std::string text("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x08\0\0\0\x08\x63\x02\0\0\0\0\0\0\0\0\0\0\0IEND\xae\x42\x60\x82",
                     45);
    std::ofstream(folder / "bad.png", std::ios::binary) << text;
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"render", "triangle.obj", "-o", "a.png", "--environment", "bad.png", "--size", "4x4"},
          {"compare", "bad.png", "bad.png"}}) {
        const Outcome o = run(words);
        EXPECT_EQ(o.exit_code, kBadInput);
        EXPECT_TRUE(o.err.starts_with("occam: bad.png: ")) << o.err;
        EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
    }
}

// The library for all formats takes a name with a question mark for the address of a resource.
TEST_F(Outputs, NamesMayHoldAnyCharacters)
{
    for (const char* name : {"a?b.jpg", "%s%n\n.png", "a?.exr"}) {
        const std::vector<std::string> words{"render", "triangle.obj", "-o", name, "--size", "4x4", "--spp", "1"};
        const Outcome o = run(words);
        EXPECT_EQ(o.exit_code, kDone) << o.err;
        EXPECT_EQ(render::Image::read(folder / name).width, 4) << name;
    }
}

TEST_F(Outputs, AStandardOutputThatIsFullOrClosedIsExitCode3)
{
    ASSERT_EQ(run({"render", "triangle.obj", "-o", "a.exr", "--size", "8x8"}).exit_code, kDone);
    std::ofstream(folder / "tetrahedron.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
    const std::vector<std::vector<std::string>> printing{
        {"--help"},
        {"--version"},
        {"render", "--help"},
        {"info", "triangle.obj"},
        {"info", "triangle.obj", "--json"},
        {"verify", "tetrahedron.obj", "--subdivide", "on", "--rays", "10"},
        {"compare", "a.exr", "a.exr"},
        {"compare", "a.exr", "a.exr", "--json"},
        {"render", "triangle.obj", "-o", "b.png", "--size", "8x8", "--stats", "-"},
        {"render", "triangle.obj", "-o", "b.png", "--size", "8x8", "--progress", "openjd"}};
    for (const auto& words : printing) {
        print_to("/dev/full");
        const Outcome full = run(words);
        EXPECT_EQ(full.exit_code, kOutput) << words[0] << ' ' << words.back() << full.err;
        EXPECT_NE(full.err.find("standard output"), std::string::npos) << full.err;
        before_exec = [] { close(STDOUT_FILENO); };
        EXPECT_EQ(run(words).exit_code, kOutput) << words[0] << ' ' << words.back();
    }
}

TEST_F(Outputs, TemporariesOfKilledRunsAreRemovedByTheNextOne)
{
    for (const char* name : {".a.part1.png", ".a.part21983-4.png", ".f.0003.part21983.png", ".b.part1.png", ".a.partial.png",
                             ".a.part7.exr", ".s.part5.json"})
        std::ofstream(folder / name) << "half a picture";
    const int living = open((folder / ".a.part2.png").c_str(), O_RDWR | O_CREAT, 0666);
    ASSERT_EQ(flock(living, LOCK_EX), 0);
    ASSERT_EQ(run({"render", "triangle.obj", "-o", "a.png", "--size", "8x8", "--stats", "s.json"}).exit_code, kDone);
    EXPECT_EQ(files_in(folder), (std::vector<std::string>{".a.part2.png", ".a.part7.exr", ".a.partial.png", ".b.part1.png",
                                                          ".f.0003.part21983.png", "a.png", "s.json", "stderr.txt",
                                                          "stdout.txt", "triangle.obj"}));
    close(living);
    ASSERT_EQ(run({"animate", "triangle.obj", "-o", "f.####.png", "--frames", "2-3", "--size", "8x8"}).exit_code, kDone);
    EXPECT_FALSE(fs::exists(folder / ".f.0003.part21983.png"));
}

TEST_F(Outputs, AWriterKeepsItsTemporaryThoughOthersTidyUpWhenItBegins)
{
    const fs::path file = folder / "a.json";
    std::atomic<bool> is_done = false;
    std::jthread others([&] {
        while (!is_done) remove_unfinished(std::span(&file, 1));
    });
    int lost = 0;
    for (int attempt = 0; attempt < (is_long() ? 400 : 100); ++attempt) {
        const OutputFile out(file);
        for (int wait = 0; wait < 3; ++wait) std::this_thread::yield();
        lost += !fs::exists(out.temporary());
    }
    is_done = true;
    EXPECT_EQ(lost, 0);
}

TEST_F(Outputs, AFileIsThereWhenItIsPublishedAndNotBefore)
{
    const fs::path file = folder / "text.json";
    {
        OutputFile out(file);
        out.append("first ");
        EXPECT_FALSE(fs::exists(file));
        remove_unfinished(std::span(&file, 1));
        EXPECT_TRUE(fs::exists(out.temporary())) << "a writer that lives keeps its temporary";
        out.append("second");
        out.publish();
        EXPECT_FALSE(fs::exists(out.temporary()));
    }
    EXPECT_EQ(text_of(file), "first second");
    {
        OutputFile out(file);
        out.append("third");
        fs::remove(out.temporary());
        EXPECT_THROW(out.publish(), Error) << "somebody removed it";
    }
    {
        const OutputFile given_up(file);
    }
    EXPECT_EQ(text_of(file), "first second");
    EXPECT_EQ(files_in(folder), (std::vector<std::string>{"text.json", "triangle.obj"}));
    EXPECT_THROW(check_output(folder / std::string(252, 'x') / "a.png"), Error);
    EXPECT_THROW(check_output(folder / (std::string(252, 'x') + ".png")), Error) << "the name is too long";
    check_output(folder / (std::string(251, 'x') + ".png"));  // that of the temporary is shortened
}

TEST_F(Outputs, ASignalWhileASceneIsReadEndsTheProcess)
{
    {
        std::ofstream large(folder / "large.obj");
        for (int i = 0; i < 300'000; ++i) large << "v " << i << " 0 0\nv " << i << " 1 0\nv " << i << " 0 1\nf -3 -2 -1\n";
    }
    for (const int signal : {SIGINT, SIGTERM}) {
        fs::remove(folder / "stderr.txt");
        const pid_t child = start({"render", "large.obj", "-o", "a.png", "--progress", "plain"});
        for (int i = 0; i < 1000 && text_of(folder / "stderr.txt").find("reading") == std::string::npos; ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        kill(child, signal);
        EXPECT_EQ(finish(child).exit_code, kInterrupted);
        EXPECT_FALSE(fs::exists(folder / "a.png"));
    }
}

TEST_F(Outputs, ASecondSignalOfEitherKindEndsTheProcess)
{
    for (const auto& [first, second] : {std::pair(SIGINT, SIGTERM), std::pair(SIGTERM, SIGINT), std::pair(SIGINT, SIGINT)}) {
        fs::remove(folder / "stderr.txt");  // otherwise the output of the last round would end the waiting
        const pid_t child = start(
            {"render", "triangle.obj", "-o", "a.exr", "--size", "640x480", "--spp", "65536", "--progress", "plain"});
        for (int i = 0; i < 1000 && text_of(folder / "stderr.txt").find("rendering") == std::string::npos; ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        kill(child, first);
        kill(child, second);
        EXPECT_EQ(finish(child).exit_code, kInterrupted);
    }
}

}  // namespace
}  // namespace occam
