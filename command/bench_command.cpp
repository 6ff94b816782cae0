// Finds and starts the benchmarks. They are a program of their own, since they need Embree, and the library does not.
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "arguments.h"

namespace occam::command {
namespace {

namespace fs = std::filesystem;

// Returns the program beside the command, where it is installed and built, or where the build puts tests.
fs::path find_benchmarks()
{
    std::error_code error;
    const fs::path here = fs::read_symlink("/proc/self/exe", error).parent_path();
    for (const fs::path& candidate : {here / "occam_bench", here / "tests" / "occam_bench"})
        if (fs::is_regular_file(candidate, error)) return candidate;
    throw Error("occam_bench", "is not there: benchmarks are built with OCCAM_BENCH=ON, and need Embree 3");
}

}  // namespace

int run(const BenchArguments& a)
{
    const fs::path program = find_benchmarks();
    std::vector<std::string> words{program.string()};
    words.insert(words.end(), a.words.begin(), a.words.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    execv(program.c_str(), argv.data());
    throw Error(program.string(), std::string("cannot be started: ") + std::strerror(errno), {}, Error::Kind::Output);
}

}  // namespace occam::command
