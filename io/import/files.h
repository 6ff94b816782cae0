// File access of the importers: they read only whole regular files.
#pragma once

#include <cstdio>
#include <filesystem>
#include <istream>
#include <memory>
#include <span>
#include <streambuf>
#include <string>
#include <string_view>

namespace occam::import {

/// The limit is more than any scene of ours needs in one file, and less than the memory of a machine.
inline constexpr std::size_t kMaxFileBytes = std::size_t(8) << 30;

/// Holds one open file.
class FileReader {
public:
    /// Throws Error if the file is not a regular file, cannot be read, or is larger than `max_bytes`.
    explicit FileReader(const std::filesystem::path& file, std::size_t max_bytes = kMaxFileBytes);

    std::size_t size() const noexcept { return size_; }
    /// Fills `to` from the position `at`. Throws Error if the file does not reach that far.
    void read(std::size_t at, std::span<char> to) const;

private:
    std::string name_;
    std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream_;
    std::size_t size_ = 0;
};

/// Returns the whole file. Throws the same errors as FileReader.
std::string read_file(const std::filesystem::path& file, std::size_t max_bytes = kMaxFileBytes);

/// Returns the text without the mark that some editors put before UTF-8.
std::string_view without_mark(std::string_view text) noexcept;

/// Returns the whole of a text, without that mark. Throws the same errors as FileReader.
std::string read_text(const std::filesystem::path& file, std::size_t max_bytes = kMaxFileBytes);

/// A std::istream over memory that is owned elsewhere.
class TextStream : private std::streambuf, public std::istream {
public:
    explicit TextStream(std::string_view text) : std::istream(static_cast<std::streambuf*>(this))
    {
        char* begin = const_cast<char*>(text.data());  // the text is only read
        setg(begin, begin, begin + text.size());
    }
};

}  // namespace occam::import
