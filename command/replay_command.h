// The command that traces a ray of `occam verify` again, so that it can be pasted into a shell.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace occam::command {

/// Returns the words of a command line of `occam verify` that describe the scene: those that choose rays, or only how they
/// are reported, are left out. words   argv, which begins with the name of the program
std::vector<std::string> words_of_scene(std::span<char* const> words);

/// Returns a command for a shell: these words, and --replay with the line of a ray.
std::string replay_command(const std::vector<std::string>& words, std::string_view line);

}  // namespace occam::command
