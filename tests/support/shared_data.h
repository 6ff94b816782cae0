// Where the shared test data lies: OCCAM_SHARED, or the folder "shared" beside the repository.
#pragma once

#include <filesystem>

namespace occam::test {

/// Empty path if there is none; a test that needs it then skips and says so.
std::filesystem::path shared_data();

/// The folder of the repository that the tests were built from.
std::filesystem::path source_folder();

}  // namespace occam::test
