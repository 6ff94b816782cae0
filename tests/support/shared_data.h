// Finds the shared test data: in the folder OCCAM_SHARED, or in the folder "shared" beside the repository.
#pragma once

#include <filesystem>

namespace occam::test {

/// Returns the folder, or an empty path if there is none; a test that needs it then skips and says so.
std::filesystem::path shared_data();

/// Returns the folder of the repository from which the tests were built.
std::filesystem::path source_folder();

}  // namespace occam::test
