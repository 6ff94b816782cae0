// Formats of files by the extensions of their names.
#pragma once

#include <algorithm>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace occam {

/// Returns the extension of a file in lower case, with its dot.
inline std::string extension_of(const std::filesystem::path& file)
{
    std::string extension = file.extension().string();
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return extension;
}

/// Returns whether a list with spaces between has the extension.
inline bool has_extension(std::string_view extensions, std::string_view extension) noexcept
{
    while (!extensions.empty()) {
        const std::string_view first = extensions.substr(0, extensions.find(' '));
        if (first == extension) return true;
        extensions.remove_prefix(std::min(first.size() + 1, extensions.size()));
    }
    return false;
}

/// Returns the row whose `extensions` have that of the file, or null.
template <class Row>
const Row* find_by_extension(std::span<const Row> rows, const std::filesystem::path& file)
{
    const std::string extension = extension_of(file);
    for (const Row& row : rows)
        if (has_extension(row.extensions, extension)) return &row;
    return nullptr;
}

/// Returns the extensions of all rows, with spaces between: all of them, or the first one of each row.
template <class Row>
std::string extensions_of(std::span<const Row> rows, bool only_first = false)
{
    std::string all;
    for (const Row& row : rows)
        all.append(all.empty() ? "" : " ")
            .append(only_first ? row.extensions.substr(0, row.extensions.find(' ')) : row.extensions);
    return all;
}

}  // namespace occam
