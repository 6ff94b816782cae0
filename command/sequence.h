// The frames of a sequence, their division among processes and the names of their files.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace occam::command {

/// A file name with a number in it: "out.####.exr" (as many digits as #) or "out.%04d.exr". Throws std::invalid_argument
/// that says what was expected if there is not exactly one such place in the file's name. The folder's name is taken as it
/// is.
class FramePattern {
public:
    explicit FramePattern(const std::filesystem::path& pattern);
    std::filesystem::path file(int frame) const;

private:
    std::filesystem::path folder_;
    std::string before_, after_;
    int digits_ = 1;
};

/// Parses "1-240", "1-240x10" or "1-10,20,31-40x2" into frames in that order, each once. Numbers go from 0 to a million.
/// Throws std::invalid_argument.
std::vector<int> frames_of(std::string_view text);

/// Describes one of `count` equal parts of a sequence; the index counts from 1.
struct Shard {
    int index = 1, count = 1;
    /// Returns the frames of this part: every count-th one.
    std::vector<int> of(const std::vector<int>& frames) const;
};
/// Parses "2/8", which is the second part of eight. Throws std::invalid_argument.
Shard shard_of(std::string_view text);
/// Returns the part that an array job of Slurm states (SLURM_ARRAY_TASK_ID, _MIN, _STEP, _COUNT), or none outside of one.
/// variable   returns a variable's value by its name, or null, like std::getenv
std::optional<Shard> slurm_shard(const std::function<const char*(const char*)>& variable);

}  // namespace occam::command
