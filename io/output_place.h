// Whether a file that is there can be replaced by another one that gets its name.
#pragma once

#include <filesystem>
#include <string>

namespace occam {

/// Returns why no other file can be renamed to this name, as an Error says it; empty if there is no file, or nothing is
/// known that would prevent it. It knows files that cannot be changed, files of other users in folders where only the owner
/// may rename them (sticky ones, as /tmp is), and files on which another one is mounted.
std::string why_not_replaceable(const std::filesystem::path& file);

/// Returns true if names can be added to the folder, but neither changed nor removed.
bool keeps_all_names(const std::filesystem::path& folder);

}  // namespace occam
