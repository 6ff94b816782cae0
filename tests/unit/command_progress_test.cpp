// Tests of what the command says while it works: on terminals of every kind, and to render farms.
#include <fcntl.h>
#include <pty.h>
#include <sys/ioctl.h>

#include <csignal>
#include <limits>
#include <sstream>

#include "render/image.h"
#include "tests/support/command_test.h"

namespace occam {
namespace {

using namespace test;

class CommandProgress : public CommandTest {
protected:
    // Returns what the command writes on a terminal of that name and width while it makes a small picture.
    std::string shown_on(const char* terminal, unsigned short columns, const std::string& picture)
    {
        int master = -1, slave = -1;
        const winsize size{24, columns, 0, 0};
        EXPECT_EQ(openpty(&master, &slave, nullptr, nullptr, &size), 0);
        before_exec = [&] {
            dup2(slave, STDERR_FILENO);
            setenv("TERM", terminal, 1);
        };
        const pid_t child = start({"render", "triangle.obj", "-o", picture, "--size", "8x4", "--spp", "1"});
        EXPECT_EQ(finish(child).exit_code, kDone);
        fcntl(master, F_SETFL, O_NONBLOCK);
        std::string text(4096, '\0');
        const ssize_t got = read(master, text.data(), text.size());
        text.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
        close(slave);
        close(master);
        return text;
    }

    static constexpr int kSignal = -1;  ///< the exit code of a command that a signal has ended

    /// Runs the command with a stream that is a pipe whose reader has gone away.
    Outcome without_reader(int stream, std::vector<std::string> words, const std::vector<std::string>& more = {})
    {
        int ends[2] = {};
        EXPECT_EQ(pipe2(ends, O_CLOEXEC), 0);
        close(ends[0]);
        before_exec = [&] {
            dup2(ends[1], stream);
            signal(SIGPIPE, SIG_DFL);
        };
        words.insert(words.end(), more.begin(), more.end());
        const Outcome o = run(words);
        close(ends[1]);
        return o;
    }
};

// A bar that went on in a second row would leave its first one behind.
TEST_F(CommandProgress, ABarFitsInOneRowOfTheTerminal)
{
    const std::string long_name = std::string(60, 'a') + "\xc3\xa9.png";
    const std::string clear = "\r\033[K";
    for (const unsigned short columns : {20, 69, 70, 71, 74, 120}) {
        const std::string text = shown_on("xterm", columns, long_name);
        EXPECT_NE(text.find(clear + "reading "), std::string::npos) << text;
        for (std::size_t at = text.find(clear); at != std::string::npos; at = text.find(clear, at + 1)) {
            const std::size_t begin = at + clear.size();
            const std::string line = text.substr(begin, text.find('\r', begin) - begin);
            EXPECT_LT(line.size(), columns + 1u) << line;
            EXPECT_FALSE(line.ends_with('\xc3')) << "the character is cut in two";
        }
        EXPECT_EQ(text.find(long_name) != std::string::npos, columns == 120) << text;
    }
}

TEST_F(CommandProgress, ADumbTerminalGetsLines)
{
    for (const char* terminal : {"dumb", ""}) {
        const std::string text = shown_on(terminal, 80, "a.png");
        EXPECT_EQ(text.find('\033'), std::string::npos) << text;
        EXPECT_TRUE(text.starts_with("reading triangle.obj\r\n")) << text;
        EXPECT_NE(text.find("writing a.png\r\n"), std::string::npos) << text;
    }
}

TEST_F(CommandProgress, ARenderFarmLearnsWhyAPictureWasNotMade)
{
    for (const auto& [scene, output] : {std::pair("missing.obj", "a.png"), std::pair("triangle.obj", "missing/a.png")}) {
        const Outcome o = run({"render", scene, "-o", output, "--progress", "openjd"});
        const std::size_t at = o.out.find("openjd_fail: ");
        ASSERT_NE(at, std::string::npos) << o.out;
        EXPECT_EQ("occam: " + o.out.substr(at + 13), o.err);
    }
}

// The last part of a pipeline, such as head in `| head -1`, may end first. What is made is in files.
TEST_F(CommandProgress, AReaderWhoHasGoneAwayLosesNoPicture)
{
    const std::vector<std::string> small{"--size", "8x4", "--spp", "1"};
    for (const auto& [style, stream] : {std::pair("openjd", STDOUT_FILENO), {"plain", STDERR_FILENO}}) {
        const std::vector<std::string> calls[] = {
            {"render", "triangle.obj", "-o", "a.0.png", "--progress", style},
            {"render", "triangle.obj", "-o", "a.0.png", "--progress", style, "--checkpoint", "on"},
            {"animate", "triangle.obj", "-o", "a.#.png", "--frames", "0-1", "--progress", style}};
        for (const auto& words : calls) {
            fs::remove(folder / "a.0.png");
            EXPECT_EQ(without_reader(stream, words, small).exit_code, kDone) << words[0] << ' ' << style;
            EXPECT_TRUE(fs::exists(folder / "a.0.png")) << words[0] << ' ' << style;
        }
        EXPECT_TRUE(fs::exists(folder / "a.1.png"));
        fs::remove(folder / "a.1.png");
    }
    fs::remove(folder / "a.0.png");
    const Outcome stats = without_reader(STDOUT_FILENO, {"render", "triangle.obj", "-o", "a.0.png", "--stats", "-"}, small);
    EXPECT_EQ(stats.exit_code, kOutput);
    EXPECT_EQ(stats.err, "occam: standard output: cannot be written: Broken pipe\n");
    EXPECT_TRUE(fs::exists(folder / "a.0.png"));
    // What only prints ends as other programs do.
    EXPECT_EQ(without_reader(STDOUT_FILENO, {"render", "triangle.obj", "--replay", "2,2"}, small).exit_code, kSignal);
    EXPECT_EQ(without_reader(STDOUT_FILENO, {"info", "triangle.obj"}).exit_code, kSignal);
}

TEST_F(CommandProgress, AReaderWhoHasGoneAwayLosesNoOtherFile)
{
    render::Image image(4, 4);
    image.add_layer("beauty", {"R", "G", "B"}, false).pixels.assign(48, std::numeric_limits<float>::infinity());
    for (int i = 0; i < 64; ++i)
        image.add_layer(std::string(100, 'a') + std::to_string(i), {"Y"}, false).pixels.assign(16, 1);
    image.write(folder / "many.exr");
    EXPECT_EQ(without_reader(STDERR_FILENO, {"texture", "many.exr", "out.tx"}).exit_code, kDone) << "it prints a line";
    EXPECT_TRUE(fs::exists(folder / "out.tx"));
    const std::vector<std::string> compare{"compare", "many.exr", "many.exr"};
    EXPECT_EQ(without_reader(STDOUT_FILENO, compare, {"--heat", "heat.png"}).exit_code, kOutput);
    EXPECT_TRUE(fs::exists(folder / "heat.png"));
    EXPECT_EQ(without_reader(STDOUT_FILENO, compare).exit_code, kSignal);
}

TEST_F(CommandProgress, ANameWithALineEndMakesNoLineOfItsOwn)
{
    const std::string name = "a\nopenjd_progress: 100\033[31m.";
    for (const std::vector<std::string>& words : {std::vector<std::string>{"render", "triangle.obj", "-o", name + "png"},
                                                  {"animate", "triangle.obj", "-o", name + "#.png", "--frames", "1"}}) {
        std::vector<std::string> all = words;
        all.insert(all.end(), {"--size", "8x4", "--spp", "1", "--progress", "openjd"});
        const Outcome o = run(all);
        EXPECT_EQ(o.exit_code, kDone) << o.err;
        EXPECT_EQ(o.out.find("\033"), std::string::npos) << o.out;
        EXPECT_NE(o.out.find("a; openjd_progress: 100\\x1b[31m."), std::string::npos) << o.out;
        std::istringstream lines(o.out);
        for (std::string line; std::getline(lines, line);) EXPECT_EQ(line.find("openjd_"), 0u) << line;
    }
}

TEST_F(CommandProgress, ACheckpointThatCannotBeWrittenIsFoundBeforeThePictureIsMade)
{
    const std::string name = std::string(245, 'a') + ".png";  // the name of the checkpoint is too long
    const Outcome o = run({"render", "triangle.obj", "-o", name, "--size", "8x4", "--spp", "1", "--checkpoint", "on"});
    EXPECT_EQ(o.exit_code, kOutput) << o.err;
    EXPECT_NE(o.err.find(".png.checkpoint: cannot be written: File name too long"), std::string::npos) << o.err;
    EXPECT_FALSE(fs::exists(folder / name));
    EXPECT_EQ(run({"render", "triangle.obj", "-o", name, "--size", "8x4", "--spp", "1"}).exit_code, kDone);
}

}  // namespace
}  // namespace occam
