// The benchmark program: occam_bench [SUITE...] [--only TEXT] [--json FILE] [--list]

#include <cstdio>
#include <cstring>
#include <exception>

#include "io/output_file.h"
#include "tests/bench/suites.h"

namespace {

const occam::bench::Suite* find_suite(const char* name)
{
    for (const occam::bench::Suite& suite : occam::bench::kSuites)
        if (std::strcmp(suite.name, name) == 0) return &suite;
    return nullptr;
}

}  // namespace

int main(int argc, char** argv)
try {
    std::vector<const occam::bench::Suite*> wanted;
    const char* json = nullptr;
    const char* only = "";
    for (int i = 1; i < argc; ++i) {
        if (std::strcmp(argv[i], "--list") == 0) {
            for (const occam::bench::Suite& suite : occam::bench::kSuites)
                std::printf("%-8s %s\n", suite.name, suite.summary);
            return 0;
        }
        if (std::strcmp(argv[i], "--only") == 0 && i + 1 < argc) {
            only = argv[++i];
        } else if (std::strcmp(argv[i], "--json") == 0 && i + 1 < argc) {
            json = argv[++i];
        } else if (const occam::bench::Suite* suite = find_suite(argv[i])) {
            wanted.push_back(suite);
        } else {
            std::fprintf(
                stderr,
                "occam_bench: '%s' is no suite\nusage: occam_bench [SUITE...] [--only TEXT] [--json FILE] [--list]\n",
                argv[i]);
            return 2;
        }
    }
    if (wanted.empty())
        for (const occam::bench::Suite& suite : occam::bench::kSuites) wanted.push_back(&suite);

    if (json) occam::check_whole(json);  // before minutes of work
    occam::bench::Report report(only);
    for (const occam::bench::Suite* suite : wanted) suite->run(report);
    if (json) occam::write_whole(json, report.json());
    return 0;
} catch (const std::exception& error) {
    std::fprintf(stderr, "occam_bench: %s\n", error.what());
    return 3;
}
