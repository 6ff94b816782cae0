// Tests of signals that come while somebody holds the command up, and of what a process that ends leaves behind.
#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>

#include <chrono>
#include <csignal>
#include <thread>

#include "command/interrupt.h"
#include "io/output_file.h"
#include "render/image.h"
#include "tests/support/campaign.h"
#include "tests/support/command_test.h"

namespace occam {
namespace {

using namespace test;
using namespace std::chrono_literals;

class Signals : public CommandTest {
protected:
    /// Returns how the command ended, or, if it has not after a minute, that it was killed: an exit code of -1.
    Outcome finish_or_kill(pid_t child) const
    {
        for (int i = 0; i < 6000; ++i) {
            siginfo_t ended = {};
            if (waitid(P_PID, id_t(child), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 && ended.si_pid == child) break;
            if (i == 5999) kill(child, SIGKILL);
            std::this_thread::sleep_for(10ms);
        }
        return finish(child);
    }
    // A picture that takes many times as long as its first per cents.
    std::vector<std::string> long_picture(const std::vector<std::string>& more) const
    {
        std::vector<std::string> all{"render",  "triangle.obj", "-o",  "a.png",     "--size",
                                     "512x512", "--spp",        "256", "--threads", "1"};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
    std::vector<std::string> names_in_folder() const
    {
        std::vector<std::string> names;
        for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
        std::sort(names.begin(), names.end());
        return names;
    }
    void wait_for_text(const std::string& text) const
    {
        for (int i = 0; i < 6000 && text_of(folder / "stderr.txt").find(text) == std::string::npos; ++i)
            std::this_thread::sleep_for(10ms);
    }
    void wait_for_tiles() const
    {
        for (int i = 0; i < 6000 && !has_begun(text_of(folder / "stderr.txt")); ++i) std::this_thread::sleep_for(10ms);
    }
};

// A pipe that nobody reads. Its ends stay open in this process, so that the command's writes block.
class UnreadPipe {
public:
    UnreadPipe()
    {
        if (pipe2(ends_, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    }
    ~UnreadPipe() { close(ends_[0]), close(ends_[1]); }
    UnreadPipe(const UnreadPipe&) = delete;
    UnreadPipe& operator=(const UnreadPipe&) = delete;

    int writer() const { return ends_[1]; }
    /// Reads until is_enough(what has been read).
    template <class IsEnough>
    void read_until(IsEnough&& is_enough) const
    {
        std::string all;
        char block[512];
        while (!is_enough(all)) {
            pollfd ready = {ends_[0], POLLIN, 0};
            if (poll(&ready, 1, 60'000) != 1) return;
            const ssize_t got = read(ends_[0], block, sizeof block);
            if (got <= 0) return;
            all.append(block, std::size_t(got));
        }
    }
    void fill() const
    {
        // Another description of the pipe, since the command shares the flags of this one.
        const int filler = open(("/proc/self/fd/" + std::to_string(ends_[1])).c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
        const std::string block(4096, ' ');
        while (write(filler, block.data(), block.size()) > 0) {
        }
        while (write(filler, " ", 1) > 0) {
        }
        close(filler);
    }

private:
    int ends_[2] = {};
};

TEST_F(Signals, EndARenderWhoseStatisticsNobodyReads)
{
    mkfifo((folder / "s.fifo").c_str(), 0666);
    const pid_t child = start(long_picture({"--progress", "plain", "--stats", "s.fifo"}));
    wait_for_tiles();
    kill(child, SIGTERM);
    const Outcome o = finish_or_kill(child);
    EXPECT_EQ(o.exit_code, kInterrupted) << o.err;
    EXPECT_TRUE(fs::exists(folder / "a.png")) << "what was done of the picture is worth waiting for";
    EXPECT_EQ(names_in_folder(), (std::vector<std::string>{"a.png", "s.fifo", "stderr.txt", "stdout.txt", "triangle.obj"}));
}

// A shell starts what a script runs in the background so that it ignores SIGINT, and nohup does that with SIGHUP.
TEST_F(Signals, EndARenderUnlessItWasStartedToIgnoreThem)
{
    constexpr int kAll[] = {SIGHUP, SIGINT, SIGTERM};
    for (const int number : kAll)
        for (const bool is_ignored : {false, true}) {
            fs::remove(folder / "a.png");
            fs::remove(folder / "stderr.txt");
            before_exec = [&] { signal(number, is_ignored ? SIG_IGN : SIG_DFL); };
            const pid_t child = start(long_picture({"--progress", "plain"}));
            wait_for_tiles();
            kill(child, number);
            if (is_ignored) {
                std::this_thread::sleep_for(50ms);
                EXPECT_EQ(waitpid(child, nullptr, WNOHANG), 0) << "the process goes on";
                EXPECT_EQ(text_of(folder / "stderr.txt").find("stopping"), std::string::npos) << number;
                for (const int other : kAll)
                    if (other != number) kill(child, other);
            }
            EXPECT_EQ(finish_or_kill(child).exit_code, kInterrupted) << number;
            EXPECT_TRUE(fs::exists(folder / "a.png"));
            EXPECT_EQ(names_in_folder(), (std::vector<std::string>{"a.png", "stderr.txt", "stdout.txt", "triangle.obj"}));
        }
}

TEST_F(Signals, EndAFinishedRenderWhoseStatisticsNobodyReads)
{
    mkfifo((folder / "s.fifo").c_str(), 0666);
    const pid_t child = start({"render", "triangle.obj", "-o", "a.png", "--size", "4x4", "--spp", "1", "--stats", "s.fifo"});
    for (int i = 0; i < 6000 && !fs::exists(folder / "a.png"); ++i) std::this_thread::sleep_for(10ms);
    kill(child, SIGTERM);
    EXPECT_EQ(finish_or_kill(child).exit_code, kInterrupted);
    EXPECT_TRUE(fs::exists(folder / "a.png"));
}

TEST_F(Signals, EndASequenceWhoseStatisticsNobodyReads)
{
    mkfifo((folder / "s.fifo").c_str(), 0666);
    const pid_t child = start({"animate", "triangle.obj", "-o", "a.#.png", "--frames", "0-3", "--size", "1024x1024", "--spp",
                               "65536", "--progress", "plain", "--threads", "1", "--exposure", "0", "--stats", "s.fifo"});
    wait_for_text("rendering, 0");
    kill(child, SIGTERM);
    EXPECT_EQ(finish_or_kill(child).exit_code, kInterrupted);
}

TEST_F(Signals, EndARenderWhoseProgressNobodyReadsAndItsPictureIsWritten)
{
    for (const char* style : {"plain", "openjd"}) {
        fs::remove(folder / "a.png");
        const UnreadPipe pipe;
        const int stream = style == std::string("plain") ? STDERR_FILENO : STDOUT_FILENO;
        before_exec = [&] { dup2(pipe.writer(), stream); };
        const pid_t child = start(long_picture({"--progress", style}));
        pipe.read_until(has_begun);
        pipe.fill();
        kill(child, SIGTERM);
        EXPECT_EQ(finish_or_kill(child).exit_code, kInterrupted) << style;
        EXPECT_TRUE(fs::exists(folder / "a.png")) << style;
    }
}

/// Calls `act` in a process of its own, which handles signals as the command does.
pid_t process_of(const std::function<void()>& act)
{
    const pid_t child = fork();
    if (child == 0) {
        end_by_signals();
        command::catch_interrupts();
        act();
        _exit(kDone);
    }
    return child;
}

/// Waits for the end of a process, and returns its exit code.
int exit_code_of(pid_t child)
{
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}
int exit_code_of(const std::function<void()>& act) { return exit_code_of(process_of(act)); }

// Does nothing, until the limit of a second has passed.
void outlast_the_limit() { std::this_thread::sleep_for(1500ms); }

TEST_F(Signals, LeaveASecondUnlessTimeIsAllowed)
{
    using command::HeldInterrupts;
    // They wait at the same time.
    const pid_t without = process_of([] {
        const HeldInterrupts held;
        std::raise(SIGTERM);
        outlast_the_limit();
    });
    const pid_t allowed = process_of([] {
        HeldInterrupts held;
        std::raise(SIGTERM);
        held.allow_time();
        outlast_the_limit();
    });
    const pid_t limited_again = process_of([] {
        HeldInterrupts held;
        std::raise(SIGTERM);
        held.allow_time();
        outlast_the_limit();
        held.limit();
        outlast_the_limit();
    });
    const pid_t allowed_before = process_of([] {
        HeldInterrupts held;
        held.allow_time();
        std::raise(SIGTERM);
        outlast_the_limit();
    });
    const pid_t limited_before = process_of([] {
        HeldInterrupts held;
        held.allow_time();
        held.limit();
        std::raise(SIGTERM);
        outlast_the_limit();
    });
    const pid_t after = process_of([] {
        {
            HeldInterrupts held;
            std::raise(SIGTERM);
            held.allow_time();
        }
        outlast_the_limit();
    });
    EXPECT_EQ(exit_code_of(without), kInterrupted);
    EXPECT_EQ(exit_code_of(allowed), kDone);
    EXPECT_EQ(exit_code_of(limited_again), kInterrupted);
    EXPECT_EQ(exit_code_of(allowed_before), kDone);
    EXPECT_EQ(exit_code_of(limited_before), kInterrupted);
    EXPECT_EQ(exit_code_of(after), kInterrupted);
}

// A parent may block signals, and a process inherits that.
TEST_F(Signals, LeaveASecondAlsoWhereAlarmsWereBlocked)
{
    sigset_t alarms, before;
    sigemptyset(&alarms);
    sigaddset(&alarms, SIGALRM);
    pthread_sigmask(SIG_BLOCK, &alarms, &before);
    const int code = exit_code_of([] {
        const command::HeldInterrupts held;
        std::raise(SIGTERM);
        outlast_the_limit();
    });
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    EXPECT_EQ(code, kInterrupted);
}

TEST_F(Signals, RemoveTheTemporaryFilesOfTheProcess)
{
    const auto write_some = [&](const char* name) {
        const auto out = new OutputFile(folder / name);  // it has no time to end by itself
        out->append("half");
    };
    EXPECT_EQ(exit_code_of([&] {
                  write_some("a.png");
                  write_some("b.exr");
                  std::raise(SIGINT);
              }),
              kInterrupted);
    EXPECT_EQ(names_in_folder(), (std::vector<std::string>{"triangle.obj"}));
    EXPECT_EQ(exit_code_of([&] {
                  const command::HeldInterrupts held;
                  write_some("a.png");
                  std::raise(SIGTERM);
                  outlast_the_limit();
              }),
              kInterrupted);
    EXPECT_EQ(names_in_folder(), (std::vector<std::string>{"triangle.obj"}));
    // What was published, and what somebody else has put in the place of a temporary, stays.
    EXPECT_EQ(exit_code_of([&] {
                  OutputFile done(folder / "done.png");
                  done.append("whole");
                  done.publish();
                  const auto out = new OutputFile(folder / "a.png");
                  fs::rename(out->temporary(), folder / "moved");
                  std::ofstream(out->temporary()) << "of somebody else";
                  std::raise(SIGTERM);
              }),
              kInterrupted);
    const std::vector<std::string> names = names_in_folder();
    ASSERT_EQ(names.size(), 4u);
    EXPECT_TRUE(names[0].starts_with(".a.part")) << names[0];
    EXPECT_EQ(text_of(folder / names[0]), "of somebody else");
    EXPECT_EQ(text_of(folder / "done.png"), "whole");
}

// Returns whether something was written to the temporary file of an output; the first one only tries whether there can be
// one, and is empty.
bool is_writing(const fs::path& folder, const std::string& temporary)
{
    for (const auto& entry : fs::directory_iterator(folder)) {
        std::error_code error;
        const std::uintmax_t size = entry.file_size(error);
        if (entry.path().filename().string().starts_with(temporary) && !error && size > 0) return true;
    }
    return false;
}

// A process that is stopped for more than a second while it writes takes as long as a large picture does.
TEST_F(Signals, WhileAFinishedPictureIsWrittenDoNotLoseIt)
{
    const std::vector<std::string> common{"triangle.obj", "--size", "2048x1024", "--spp", "1", "--exr", "float"};
    for (std::vector<std::string> words :
         {std::vector<std::string>{"render", "-o", "a.0.exr"}, {"animate", "-o", "a.#.exr", "--frames", "0,1"}}) {
        fs::remove(folder / "a.0.exr");
        words.insert(words.end(), common.begin(), common.end());
        const pid_t child = start(words);
        for (int i = 0; i < 20'000 && !is_writing(folder, ".a.0.part"); ++i) std::this_thread::sleep_for(1ms);
        kill(child, SIGTERM);
        std::this_thread::sleep_for(1ms);
        kill(child, SIGSTOP);
        EXPECT_FALSE(fs::exists(folder / "a.0.exr")) << "it is still written when the signal comes";
        std::this_thread::sleep_for(1200ms);
        kill(child, SIGCONT);
        const Outcome o = finish_or_kill(child);
        EXPECT_EQ(o.exit_code, words[0] == "render" ? kDone : kInterrupted) << o.err;
        EXPECT_TRUE(fs::exists(folder / "a.0.exr")) << words[0];
        EXPECT_FALSE(fs::exists(folder / "a.1.exr"));
    }
}

TEST_F(Signals, DuringTextureOrCompareLeaveNoTemporaryFile)
{
    const int side = is_long() ? 3000 : 1200;
    render::Image image(side, side);
    std::uint32_t state = 1;
    for (float& value : image.add_layer("beauty", {"R", "G", "B"}).pixels)
        value = float((state = state * 1664525u + 1013904223u) >> 8) * 0x1p-24f;
    image.write(folder / "noise.exr");
    const std::vector<std::string> calls[] = {{"texture", "noise.exr", "out.exr"},
                                              {"compare", "noise.exr", "noise.exr", "--heat", "out.exr"}};
    for (const std::vector<std::string>& words : calls) {
        fs::remove(folder / "out.exr");
        const pid_t child = start(words);
        for (int i = 0; i < 60'000 && !is_writing(folder, ".out.part") && !fs::exists(folder / "out.exr"); ++i)
            std::this_thread::sleep_for(1ms);
        kill(child, SIGTERM);
        const Outcome o = finish_or_kill(child);
        EXPECT_TRUE(o.exit_code == kInterrupted || fs::exists(folder / "out.exr")) << words[0] << ' ' << o.exit_code;
        for (const std::string& name : names_in_folder()) EXPECT_FALSE(name.starts_with(".")) << words[0] << ": " << name;
    }
}

TEST_F(Signals, LeaveTemporaryFilesOfKilledRunsToTheNextRunOfAnyCommand)
{
    render::Image image(2, 2);
    image.add_layer("beauty", {"R", "G", "B"}).pixels.assign(12, 0.5f);
    image.write(folder / "one.png");
    const std::pair<std::vector<std::string>, const char*> calls[] = {
        {{"compare", "one.png", "one.png", "--heat", "a.png"}, ".a.part7.png"},
        {{"texture", "one.png", "a.tx"}, ".a.part7.tx"},
        {{"render", "triangle.obj", "-o", "a.exr", "--size", "4x4", "--spp", "1"}, ".a.part7.exr"},
        {{"render", "triangle.obj", "-o", "a.exr", "--size", "4x4", "--spp", "1"}, ".a.exr.part7.checkpoint"},
        {{"animate", "triangle.obj", "-o", "a.#.exr", "--frames", "0", "--size", "4x4", "--spp", "1"}, ".a.0.part7.exr"}};
    for (const auto& [words, name] : calls) {
        std::ofstream(folder / name) << "half";
        EXPECT_EQ(run(words).exit_code, kDone) << words[0];
        EXPECT_FALSE(fs::exists(folder / name)) << words[0];
    }
}

}  // namespace
}  // namespace occam
