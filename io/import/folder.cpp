#include "io/import/folder.h"

#include <algorithm>
#include <system_error>
#include <vector>

namespace occam::import {

namespace fs = std::filesystem;

namespace {

// Returns what std::filesystem::weakly_canonical() returns for a path below `root`. That one asks for each beginning of the
// path in turn, which for a long name takes the square of its length.
fs::path place_below(const fs::path& root, std::string_view relative, std::error_code& error)
{
    const fs::path whole = fs::canonical(root / relative, error);
    if (!error) return whole;
    // Where a beginning does not exist, no longer one does.
    std::vector<std::size_t> ends{0};
    for (std::size_t i = 1; i <= relative.size(); ++i)
        if (relative[i - 1] != '/' && (i == relative.size() || relative[i] == '/')) ends.push_back(i);
    if (ends.back() < relative.size()) ends.push_back(relative.size());
    const auto is_missing = [&](std::size_t end) { return !fs::exists(fs::status(root / relative.substr(0, end), error)); };
    const auto missing = std::partition_point(ends.begin() + 1, ends.end(),
                                              [&](std::size_t end) { return !is_missing(end); });
    error.clear();
    if (missing != ends.end() && !fs::status_known(fs::status(root / relative.substr(0, *missing), error))) return {};
    const std::size_t there = *std::prev(missing);
    const fs::path known = fs::canonical(root / relative.substr(0, there), error);
    if (error) return {};
    std::string_view rest = relative.substr(there);
    rest.remove_prefix(std::min(rest.find_first_not_of('/'), rest.size()));
    return (known / rest).lexically_normal();
}

std::optional<fs::path> inside_canonical(const fs::path& root, std::string_view relative)
{
    if (relative.empty() || relative.find('\0') != std::string_view::npos || fs::path(relative).is_absolute())
        return std::nullopt;
    std::error_code error;
    const fs::path target = place_below(root, relative, error);
    if (error) return std::nullopt;
    const fs::path rest = target.lexically_relative(root);
    if (rest.empty() || *rest.begin() == ".." || rest == ".") return std::nullopt;
    return target;
}

fs::path canonical_folder(const fs::path& folder, std::error_code& error)
{
    return fs::weakly_canonical(folder.empty() ? fs::path(".") : folder, error);
}

}  // namespace

std::optional<fs::path> inside(const fs::path& folder, std::string_view relative)
{
    std::error_code error;
    const fs::path root = canonical_folder(folder, error);
    return error ? std::nullopt : inside_canonical(root, relative);
}

const Folder::Place& Folder::find(const std::string& relative)
{
    const auto [known, is_new] = places_.try_emplace(relative);
    if (!is_new) return known->second;
    if (!is_canonical_) {
        std::error_code error;
        const fs::path canonical = canonical_folder(folder_, error);
        if (error) return known->second;
        folder_ = canonical;
        is_canonical_ = true;
    }
    Place& place = known->second;
    place.path = inside_canonical(folder_, relative);
    std::error_code ignored;
    place.is_file = place.path && fs::is_regular_file(*place.path, ignored);
    return place;
}

}  // namespace occam::import
