#include "sequence.h"

#include <algorithm>
#include <stdexcept>
#include <unordered_set>

#include "base/number_in.h"
#include "values.h"

namespace occam::command {
namespace {

constexpr int kLastFrame = 1'000'000;

// Returns the whole number in the text.
std::optional<int> whole(std::string_view text, int least, int most)
{
    const auto value = number_in<int>(text);
    return value && *value >= least && *value <= most ? value : std::nullopt;
}

}  // namespace

FramePattern::FramePattern(const std::filesystem::path& pattern) : folder_(pattern.parent_path())
{
    const auto refuse = [&]() -> void {
        throw std::invalid_argument(
            "expected one place for the frame's number in the name of the file, as in out.####.exr or out.%04d.exr, not '" +
            pattern.string() + "'");
    };
    const std::string name = pattern.filename().string();
    std::size_t first = name.find_first_of("#%"), end = first;
    if (first == std::string::npos) refuse();
    if (name[first] == '#') {
        end = std::min(name.find_first_not_of('#', first), name.size());
        digits_ = static_cast<int>(end - first);
    } else {
        end = name.find('d', first);
        if (end == std::string::npos) refuse();
        const std::string width = name.substr(first + 1, end - first - 1);
        if (!width.empty()) {
            const std::optional<int> digits = width.size() > 1 && width[0] == '0' ? whole(width.substr(1), 1, 64)
                                                                                  : std::nullopt;
            if (!digits) refuse();
            digits_ = *digits;
        }
        ++end;
    }
    before_ = name.substr(0, first);
    after_ = name.substr(end);
    if (after_.find_first_of("#%") != std::string::npos) refuse();
}

std::filesystem::path FramePattern::file(int frame) const
{
    const std::string number = std::to_string(frame);
    const std::size_t digits = std::max(number.size(), static_cast<std::size_t>(digits_));
    return folder_ / (before_ + std::string(digits - number.size(), '0') + number + after_);
}

std::vector<int> frames_of(std::string_view text)
{
    std::vector<int> frames;
    std::unordered_set<int> seen;
    for (const std::string_view word : words_of(text)) {
        const std::size_t x = word.find('x'), dash = word.substr(0, x).find('-');
        const auto first = whole(word.substr(0, std::min(dash, x)), 0, kLastFrame);
        const auto last = dash == std::string_view::npos
                              ? first
                              : whole(word.substr(dash + 1, x - std::min(x, dash + 1)), 0, kLastFrame);
        const auto step = x == std::string_view::npos ? std::optional(1) : whole(word.substr(x + 1), 1, kLastFrame);
        if (!first || !last || !step || (dash == std::string_view::npos && x != std::string_view::npos) || *last < *first)
            throw std::invalid_argument("expected frames from 0 to 1000000 like 1-240, 1-240x10 or 1,5,9, not '" +
                                        std::string(text) + "'");
        for (int frame = *first; frame <= *last; frame += *step)
            if (seen.insert(frame).second) frames.push_back(frame);
    }
    return frames;
}

std::vector<int> Shard::of(const std::vector<int>& frames) const
{
    std::vector<int> own;
    for (std::size_t i = static_cast<std::size_t>(index - 1); i < frames.size(); i += static_cast<std::size_t>(count))
        own.push_back(frames[i]);
    return own;
}

Shard shard_of(std::string_view text)
{
    const std::size_t slash = text.find('/');
    const auto count = slash == std::string_view::npos ? std::nullopt : whole(text.substr(slash + 1), 1, kLastFrame);
    const auto index = count ? whole(text.substr(0, slash), 1, *count) : std::nullopt;
    if (!index) throw std::invalid_argument("expected K/N with K from 1 to N, not '" + std::string(text) + "'");
    return {*index, *count};
}

std::optional<Shard> slurm_shard(const std::function<const char*(const char*)>& variable)
{
    const auto number = [&](const char* name) -> std::optional<int> {
        const char* text = variable(name);
        return text ? whole(text, 0, std::numeric_limits<int>::max()) : std::nullopt;
    };
    const auto id = number("SLURM_ARRAY_TASK_ID"), count = number("SLURM_ARRAY_TASK_COUNT");
    if (!id || !count || *count < 1) return std::nullopt;
    const int least = number("SLURM_ARRAY_TASK_MIN").value_or(0),
              step = std::max(1, number("SLURM_ARRAY_TASK_STEP").value_or(1));
    // A list of tasks with gaps ("1,5,7") gives neither their places nor a step, so no part of the sequence is certain.
    if (*id < least || (*id - least) % step != 0 || (*id - least) / step >= *count) return std::nullopt;
    return Shard{(*id - least) / step + 1, *count};
}

}  // namespace occam::command
