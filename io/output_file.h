// A file that appears under its final name only when it is whole and on the disk.
//
// The bytes go to a hidden temporary beside the final name (".name.part1234.exr" for "name.exr", with the number of the
// process; of a long name the beginning and a hash). publish() flushes, checks the size and renames; whatever fails before
// that leaves neither the final name nor the temporary. A handler of signals can remove it, too (open_temporaries.h). A
// process that is killed cannot: its temporaries are removed by the next run with the same output. The writer holds a lock
// (flock) on its temporary, so the work of a process that still lives is never removed.
//
// Threads   one caller at a time for each object.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "io/open_temporaries.h"

namespace occam {

class OutputFile {
public:
    /// Creates the temporary. Throws Error of Kind::Output.
    explicit OutputFile(const std::filesystem::path& file);
    /// Removes the temporary unless it was published.
    ~OutputFile();
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    /// Writes bytes at an offset. A failure is remembered for finish(), since encoders call this function from places that
    /// cannot report one.
    void write_at(const void* bytes, std::size_t size, std::uint64_t offset) noexcept;
    void append(std::string_view bytes) noexcept { write_at(bytes.data(), bytes.size(), size_); }
    /// Reads back what was written; returns the number of bytes.
    std::size_t read_at(void* bytes, std::size_t size, std::uint64_t offset) const noexcept;
    std::uint64_t size() const noexcept { return size_; }  ///< one past the last byte that was written

    /// Writes the bytes to the disk and checks that all of them are there. Throws Error of Kind::Output.
    void finish();
    /// Finishes the file if that was not done yet, and gives it its final name. Throws Error of Kind::Output.
    void publish();

    /// Returns the path of the temporary file, for reading it back between finish() and publish().
    const std::filesystem::path& temporary() const noexcept { return temporary_; }

private:
    [[noreturn]] void refuse(int error) const;

    std::filesystem::path final_, temporary_;
    int descriptor_ = -1;
    int error_ = 0;  ///< the first errno of a write that failed
    std::uint64_t size_ = 0;
    bool is_finished_ = false, is_published_ = false;
    ListedTemporary listed_;
};

/// Returns true for what write_whole() does not replace but writes to: standard output ("-"), open files by their names
/// (/dev/stdout, /dev/fd/3), and anything that exists but is not a regular file (a pipe, a terminal, /dev/null).
bool is_written_directly(const std::filesystem::path& file);

/// Returns true if write_whole() writes that name to standard output.
bool is_standard_output(const std::filesystem::path& file);

/// Writes a whole file through OutputFile, or directly where is_written_directly() says so. Throws Error of Kind::Output.
void write_whole(const std::filesystem::path& file, std::string_view bytes);

/// Throws Error of Kind::Output if a file of that name cannot be written, because of its folder or of what exists there
/// already. The names of open files (-, /dev/stdout) and links to them are refused, too, since a file would replace the
/// link.
void check_output(const std::filesystem::path& file);
/// Do one half of that check each: that of the folder, and that of what exists there.
void check_folder(const std::filesystem::path& file);
void check_replaceable(const std::filesystem::path& file);

/// Does the same check for write_whole(), which also writes to what is not a regular file.
void check_whole(const std::filesystem::path& file);

/// Throws Error if one of the outputs is a file that is there and is one of the inputs, under whatever name.
void refuse_inputs(std::span<const std::filesystem::path> outputs, std::span<const std::filesystem::path> inputs);

/// Removes the temporary files that killed processes left beside these outputs. Each folder is listed once.
void remove_unfinished(std::span<const std::filesystem::path> outputs) noexcept;

}  // namespace occam
