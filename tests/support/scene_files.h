// Finds all scene files below a folder.
#pragma once

#include <algorithm>
#include <filesystem>
#include <vector>

#include "io/import/import.h"

namespace occam::test {

/// Returns the files with the extensions that load() knows, sorted by path.
inline std::vector<std::filesystem::path> scene_files_below(const std::filesystem::path& folder)
{
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
        if (entry.is_regular_file() && scene_format_of(entry.path())) files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    return files;
}

}  // namespace occam::test
