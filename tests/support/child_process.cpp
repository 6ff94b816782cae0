#include "tests/support/child_process.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "tests/support/temp_folder.h"

namespace occam::test {

namespace {

// This runs after fork(), where only async-signal-safe calls are allowed. An alarm outlives exec.
[[noreturn]] void become(char* const* argv, const char* err_file, unsigned limit_s)
{
    const int err = open(err_file, O_CREAT | O_WRONLY | O_TRUNC, 0600), null = open("/dev/null", O_RDWR);
    if (err < 0 || null < 0 || dup2(null, STDIN_FILENO) < 0 || dup2(null, STDOUT_FILENO) < 0 || dup2(err, STDERR_FILENO) < 0)
        _exit(126);
    alarm(limit_s);
    execv(argv[0], argv);
    _exit(127);
}

}  // namespace

const char* occam_executable() { return OCCAM_EXECUTABLE; }
const char* failing_executable() { return OCCAM_FAILING_EXECUTABLE; }

void end_by_signals() noexcept
{
    for (const int number : {SIGHUP, SIGINT, SIGTERM}) std::signal(number, SIG_DFL);
}

ChildOutcome run_occam(const std::vector<std::string>& arguments, unsigned limit_s)
{
    const TempFolder folder;
    const std::string err_file = (folder.path() / "stderr").string();
    std::vector<std::string> words{occam_executable()};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);

    const auto begin = std::chrono::steady_clock::now();
    const pid_t child = fork();
    if (child < 0) throw std::runtime_error("cannot fork");
    if (child == 0) become(argv.data(), err_file.c_str(), limit_s);
    int status = 0;
    rusage usage{};
    if (wait4(child, &status, 0, &usage) != child) throw std::runtime_error("the child is lost");

    ChildOutcome outcome;
    outcome.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    if (WIFEXITED(status)) outcome.exit_code = WEXITSTATUS(status);
    else outcome.signal = WTERMSIG(status);
    if (outcome.exit_code == 126 || outcome.exit_code == 127) throw std::runtime_error("occam cannot be started");
    outcome.peak_bytes = static_cast<std::size_t>(usage.ru_maxrss) * 1024;  // Linux counts kibibytes
    std::ifstream stream(err_file, std::ios::binary);
    outcome.err.assign(std::istreambuf_iterator<char>(stream), {});
    return outcome;
}

}  // namespace occam::test
