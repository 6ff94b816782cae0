// The base of the tests of the command line, which run the executable in a folder of its own.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/child_process.h"

namespace occam::test {

namespace fs = std::filesystem;

struct Outcome {
    int exit_code = -1;
    std::string out, err;
};

inline std::string text_of(const fs::path& file)
{
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
}

/// Gives each test a folder that holds triangle.obj.
class CommandTest : public testing::Test {
protected:
    void SetUp() override
    {
        const auto* test = testing::UnitTest::GetInstance()->current_test_info();
        folder = fs::temp_directory_path() / ("occam_command_" + std::to_string(getpid()) + "_" + test->name());
        fs::create_directories(folder);
        std::ofstream(folder / "triangle.obj") << "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n";
    }
    void TearDown() override { fs::remove_all(folder); }

    /// Starts the executable in the test's folder.
    pid_t start(const std::vector<std::string>& arguments) const
    {
        const pid_t child = fork();
        if (child != 0) return child;
        std::vector<char*> argv;
        argv.push_back(const_cast<char*>(executable));
        for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
        argv.push_back(nullptr);
        if (chdir(folder.c_str()) != 0 || !freopen("stdout.txt", "w", stdout) || !freopen("stderr.txt", "w", stderr))
            _exit(99);
        end_by_signals();
        if (before_exec) before_exec();
        execv(executable, argv.data());
        _exit(98);
    }
    Outcome finish(pid_t child) const
    {
        int status = 0;
        waitpid(child, &status, 0);
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(folder / "stdout.txt"),
                text_of(folder / "stderr.txt")};
    }
    Outcome run(const std::vector<std::string>& arguments) const { return finish(start(arguments)); }
    /// Returns whether plain progress says that the first per cent of a picture is rendered.
    static bool has_begun(const std::string& progress)
    {
        const std::size_t at = progress.rfind("rendering, ");
        return at != std::string::npos && at + 11 < progress.size() && progress[at + 11] != '0';
    }

    const char* executable = test::occam_executable();
    fs::path folder;
    std::function<void()> before_exec;  ///< called in the new process, with its standard streams in place
};

inline constexpr int kDone = 0, kDoesNotHold = 1, kBadInput = 2, kOutput = 3, kInterrupted = 130;

}  // namespace occam::test
