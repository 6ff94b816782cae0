#include "base/container_limits.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <string_view>
#include <vector>

#include "base/number_in.h"

namespace occam {
namespace {

/// The versions of control groups. A system may have both, and each kind of limit in one of them.
enum class Version { One, Two };

std::vector<std::string> words_of(const std::string& line)
{
    std::istringstream stream(line);
    std::vector<std::string> words;
    for (std::string word; stream >> word;) words.push_back(word);
    return words;
}

constexpr std::size_t kMostLines = 65'536;

/// Returns the first kMostLines lines of a file; none if it cannot be read.
std::vector<std::string> lines_of(const std::string& path)
{
    std::ifstream file(path);
    std::vector<std::string> lines;
    for (std::string line; lines.size() < kMostLines && std::getline(file, line);) lines.push_back(line);
    return lines;
}

/// Returns whether a name is in a list whose names are separated by commas.
bool has_name(std::string_view list, std::string_view name)
{
    while (!list.empty()) {
        const std::size_t comma = std::min(list.find(','), list.size());
        if (list.substr(0, comma) == name) return true;
        list.remove_prefix(std::min(comma + 1, list.size()));
    }
    return false;
}

bool is_below(const std::string& path, const std::string& folder)
{
    return path.starts_with(folder) && (path.size() == folder.size() || folder.ends_with('/') || path[folder.size()] == '/');
}

/// The folder of a control group that limits the process, and the folder below which all groups around it are.
struct Group {
    std::string top, own;
};

/// Returns the path of the process's own group among those of a controller; none if the process is in no such group.
std::optional<std::string> path_of_group(const std::string& root, Version version, std::string_view controller)
{
    for (const std::string& line : lines_of(root + "/proc/self/cgroup")) {
        const std::size_t first = line.find(':'), second = first == line.npos ? line.npos : line.find(':', first + 1);
        if (second == line.npos) continue;
        const std::string_view controllers = std::string_view(line).substr(first + 1, second - first - 1);
        if (version == Version::Two ? controllers.empty() : has_name(controllers, controller))
            return line.substr(second + 1);
    }
    return std::nullopt;
}

/// Returns the process's own group of a controller; none if it cannot be seen.
std::optional<Group> group_of(const std::string& root, Version version, std::string_view controller)
{
    const std::optional<std::string> path = path_of_group(root, version, controller);
    if (!path) return std::nullopt;
    for (const std::string& line : lines_of(root + "/proc/self/mountinfo")) {
        const std::vector<std::string> words = words_of(line);
        const auto dash = std::find(words.begin(), words.end(), "-");
        if (words.size() < 5 || words.end() - dash < 4) continue;
        const bool is_it = version == Version::Two ? dash[1] == "cgroup2"
                                                   : dash[1] == "cgroup" && has_name(dash[3], controller);
        if (!is_it) continue;
        // A container often sees a part of the groups, from its own on, and knows its group by the name outside.
        const std::string &seen = words[3], top = root + words[4];
        if (!is_below(*path, seen)) return Group{top, top};
        const std::string below = path->substr(seen.ends_with('/') ? seen.size() - 1 : seen.size());
        return Group{top, below == "/" ? top : top + below};
    }
    return std::nullopt;
}

/// Calls what(folder) for a group and for all around it.
template <class What>
void for_each_around(const Group& group, What&& what)
{
    std::string folder = group.own;
    what(folder);
    while (folder.size() > group.top.size()) {
        folder.resize(std::max(folder.rfind('/'), group.top.size()));
        what(folder);
    }
}

/// Returns a number of a file of one line; none if there is no such number: "max" and -1 say that there is no limit.
std::optional<double> number_at(const std::string& path, std::size_t place = 0)
{
    const std::vector<std::string> lines = lines_of(path);
    if (lines.empty()) return std::nullopt;
    const std::vector<std::string> words = words_of(lines.front());
    if (place >= words.size()) return std::nullopt;
    const std::optional<double> number = number_in<double>(words[place]);
    return number && *number > 0 ? number : std::nullopt;
}

double memory_limit(const std::string& root, Version version)
{
    double least = std::numeric_limits<double>::infinity();
    if (const std::optional<Group> group = group_of(root, version, "memory"))
        for_each_around(*group, [&](const std::string& folder) {
            const auto limit = number_at(folder + (version == Version::Two ? "/memory.max" : "/memory.limit_in_bytes"));
            least = std::min(least, limit.value_or(least));
        });
    return least;
}

double processor_limit(const std::string& root, Version version)
{
    double least = std::numeric_limits<double>::infinity();
    if (const std::optional<Group> group = group_of(root, version, "cpu"))
        for_each_around(*group, [&](const std::string& folder) {
            const bool is_two = version == Version::Two;
            const auto quota = number_at(folder + (is_two ? "/cpu.max" : "/cpu.cfs_quota_us"));
            const auto period = is_two ? number_at(folder + "/cpu.max", 1) : number_at(folder + "/cpu.cfs_period_us");
            if (quota && period) least = std::min(least, *quota / *period);
        });
    return least;
}

}  // namespace

ContainerLimits container_limits(const std::string& root) noexcept
{
    // Version 1 writes a number near the largest one where there is no limit.
    constexpr double kNoLimit = 0x1p62;
    ContainerLimits limits;
    try {
        const double bytes = std::min(memory_limit(root, Version::One), memory_limit(root, Version::Two));
        if (bytes < kNoLimit) limits.memory_bytes = static_cast<std::size_t>(bytes);
        const double processors = std::min(processor_limit(root, Version::One), processor_limit(root, Version::Two));
        if (processors < kNoLimit) limits.processors = processors;
    } catch (...) {  // there was no memory to read them, so nothing is known
    }
    return limits;
}

}  // namespace occam
