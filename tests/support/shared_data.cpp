#include "tests/support/shared_data.h"

#include <cstdlib>

namespace occam::test {

std::filesystem::path shared_data()
{
    namespace fs = std::filesystem;
    if (const char* named = std::getenv("OCCAM_SHARED"))
        return fs::exists(fs::path(named) / "data") ? fs::path(named) : fs::path();
    const fs::path beside = fs::path(OCCAM_SOURCE_DIR).parent_path() / "shared";
    return fs::exists(beside / "data") ? beside : fs::path();
}

std::filesystem::path source_folder() { return OCCAM_SOURCE_DIR; }

}  // namespace occam::test
