// The executable `occam`: exit codes and the one line that an error is.
#include <cstdio>
#include <new>

#include "arguments.h"

namespace occam::command {
namespace {

constexpr int kBadInput = 2, kOutput = 3;

int run(const Finished& finished) { return finished.exit_code; }

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
    try {
        return std::visit([](const auto& arguments) { return run(arguments); }, parse(argc, argv));
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
