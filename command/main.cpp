// The executable `occam`: exit codes, and errors as one line each.
#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <new>

#include "arguments.h"
#include "base/error_without_file.h"
#include "base/printable.h"
#include "interrupt.h"
#include "io/picture_codec.h"

namespace occam::command {
namespace {

constexpr int kBadInput = 2, kOutput = 3;

int run(const Finished& finished) { return finished.exit_code; }

// Opens standard streams that were closed on a file that cannot be written. Otherwise the next file that is opened would
// take their place, and would receive what is printed.
void fill_standard_streams()
{
    for (int descriptor = open("/dev/null", O_RDONLY); descriptor >= 0; descriptor = dup(descriptor))
        if (descriptor > STDERR_FILENO) {
            close(descriptor);
            return;
        }
}

// Whether the line is printed with which the command fails. Libraries may run out of memory again while they are unloaded.
constinit std::atomic<bool> has_reported{false};

void report(const char* what) noexcept
{
    if (!has_reported.exchange(true)) std::fprintf(stderr, "occam: %s\n", what);
}
void report_lack_of_memory() noexcept { report("there is not enough memory"); }

// The exit code of a command that has done its work, else -1. Nothing that happens afterwards, while libraries are unloaded,
// makes it fail.
constinit std::atomic<int> exit_code{-1};

std::terminate_handler usual_end = nullptr;

// Ends the process when an exception has met a function that may throw none. If that is for lack of memory it is no fault
// of the program: some libraries allocate where they are loaded, from where nothing can be caught.
[[noreturn]] void end_by_exception() noexcept
{
    if (exit_code >= 0) _exit(exit_code);
    try {
        if (std::current_exception()) throw;
    } catch (const std::bad_alloc&) {
        report_lack_of_memory();
        _exit(kOutput);
    } catch (...) {
    }
    if (occam::is_loading_picture_codec()) {
        report("the libraries for pictures cannot be loaded: there is not enough memory, or no room for a thread");
        _exit(kOutput);
    }
    usual_end();
    std::abort();
}

int run_command(int argc, char** argv)
{
    const int code = std::visit([](const auto& arguments) { return run(arguments); }, parse(argc, argv));
    std::cout.flush();
    if (!std::cout || std::fflush(stdout) != 0 || std::ferror(stdout))
        throw error_without_file("standard output cannot be written", {}, Error::Kind::Output);
    return code;
}

}  // namespace

Scene open_scene(const SceneArguments& arguments)
{
    if (arguments.scene.empty()) return builtin_scene();
    return load(arguments.scene, arguments.load);
}

std::string name_of_scene(const SceneArguments& arguments)
{
    return arguments.scene.empty() ? "the built-in scene" : arguments.scene.string();
}

}  // namespace occam::command

int main(int argc, char** argv)
{
    using namespace occam::command;
    fill_standard_streams();
    catch_interrupts();
    std::signal(SIGXFSZ, SIG_IGN);  // a write beyond `ulimit -f` then fails as on a full disk
    usual_end = std::set_terminate(end_by_exception);
    try {
        return exit_code = run_command(argc, argv);
    } catch (const occam::Error& error) {
        report(error.what());
        return error.kind() == occam::Error::Kind::Output ? kOutput : kBadInput;
    } catch (const std::bad_alloc&) {
        report_lack_of_memory();
        std::fflush(nullptr);
        _exit(kOutput);  // a library that had no memory may not bear to be unloaded
    } catch (const std::exception& error) {
        report(occam::printable_line(error.what()).c_str());
        return kOutput;
    }
}
