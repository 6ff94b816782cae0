// Lets allocations of the executable `occam` fail: OCCAM_FAILING="12 1" lets its 13th allocation fail, and "12 0" that and
// all further ones. They count from main() on, about: what is allocated before cannot be caught by any program. At its end
// their number is written to the file that OCCAM_ALLOCATIONS names.
#include <cstdio>
#include <cstdlib>
#include <optional>

#include "tests/faults/failing_allocations.h"

namespace occam::test {
namespace {

struct Armed {
    Armed()
    {
        unsigned long first = 0, count = 0;
        const char* const text = std::getenv("OCCAM_FAILING");
        if (text && std::sscanf(text, "%lu %lu", &first, &count) == 2)
            failing.emplace(first, count == 0 ? kAllFurther : count);
    }
    ~Armed()
    {
        const char* const name = std::getenv("OCCAM_ALLOCATIONS");
        if (!failing || !name) return;
        const unsigned long made = failing->made();
        if (std::FILE* const file = std::fopen(name, "w")) {
            std::fprintf(file, "%lu", made);
            std::fclose(file);
        }
    }
    std::optional<FailingAllocations> failing;
};

const Armed armed;

}  // namespace
}  // namespace occam::test
