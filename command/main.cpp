// The executable `occam`: exit codes, and errors as one line each.
#include <fcntl.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <new>

#include "arguments.h"
#include "base/error_without_file.h"
#include "base/printable.h"
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

void report_lack_of_memory() noexcept { std::fputs("occam: there is not enough memory\n", stderr); }

std::terminate_handler usual_end = nullptr;

// Ends the process when an exception has met a function that may throw none. If that is for lack of memory it is no fault
// of the program: some libraries allocate where they are loaded, from where nothing can be caught.
[[noreturn]] void end_by_exception() noexcept
{
    try {
        if (std::current_exception()) throw;
    } catch (const std::bad_alloc&) {
        report_lack_of_memory();
        _exit(kOutput);
    } catch (...) {
    }
    if (occam::is_loading_picture_codec()) {
        std::fputs(
            "occam: the libraries for pictures cannot be loaded: there is not enough memory, or no room for a thread\n",
            stderr);
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

}  // namespace occam::command

int main(int argc, char** argv)
{
    using namespace occam::command;
    fill_standard_streams();
    std::signal(SIGXFSZ, SIG_IGN);  // a write beyond `ulimit -f` then fails as on a full disk
    usual_end = std::set_terminate(end_by_exception);
    try {
        return run_command(argc, argv);
    } catch (const occam::Error& error) {
        std::fprintf(stderr, "occam: %s\n", error.what());
        return error.kind() == occam::Error::Kind::Output ? kOutput : kBadInput;
    } catch (const std::bad_alloc&) {
        report_lack_of_memory();
        return kOutput;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "occam: %s\n", occam::printable_line(error.what()).c_str());
        return kOutput;
    }
}
