// Which frames of a sequence are made, by whom, and what their files are called.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace occam::command {

/// A file name with a number in it: "out.####.exr" (as many digits as #) or "out.%04d.exr". Throws std::invalid_argument
/// that says what was expected if there is not exactly one such place, or if it is in the folder's name.
class FramePattern {
public:
    explicit FramePattern(const std::filesystem::path& pattern);
    std::filesystem::path file(int frame) const;

private:
    std::filesystem::path folder_;
    std::string before_, after_;
    int digits_ = 1;
};

/// "1-240", "1-240x10", "1-10,20,31-40x2": frames in that order, each once. Numbers from 0 to a million; at most a million
/// of them. Throws std::invalid_argument.
std::vector<int> frames_of(std::string_view text);

/// One of `count` equal parts of a sequence; index from 1.
struct Shard {
    int index = 1, count = 1;
    /// Frames that fall to it: every count-th.
    std::vector<int> of(const std::vector<int>& frames) const;
};
/// "2/8": the second of eight. Throws std::invalid_argument.
Shard shard_of(std::string_view text);
/// What an array job of Slurm says about itself (SLURM_ARRAY_TASK_ID, _MIN, _STEP, _COUNT); none outside of one.
/// variable   its value by name, or null; as std::getenv
std::optional<Shard> slurm_shard(const char* (*variable)(const char*));

}  // namespace occam::command
