// The executable `occam`: exit codes, and errors as one line each.
#include <fcntl.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <iostream>
#include <new>

#include "arguments.h"
#include "base/error_without_file.h"

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
    try {
        return run_command(argc, argv);
    } catch (const occam::Error& error) {
        std::fprintf(stderr, "occam: %s\n", error.what());
        return error.kind() == occam::Error::Kind::Output ? kOutput : kBadInput;
    } catch (const std::bad_alloc&) {
        std::fputs("occam: there is not enough memory\n", stderr);
        return kOutput;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "occam: %s\n", error.what());
        return kOutput;
    }
}
