#include "io/import/files.h"

#include <cerrno>
#include <cstring>

#include "base/error.h"

namespace occam::import {

namespace fs = std::filesystem;

FileReader::FileReader(const fs::path& file, std::size_t max_bytes) : name_(file.string()), stream_(nullptr, &std::fclose)
{
    std::error_code error;
    const fs::file_status status = fs::status(file, error);
    if (status.type() == fs::file_type::not_found) throw Error(name_, "no such file");
    if (fs::exists(status) && !fs::is_regular_file(status)) throw Error(name_, "not a regular file");
    const std::uintmax_t size = error ? 0 : fs::file_size(file, error);
    if (error) throw Error(name_, "cannot be read: " + error.message());
    if (size > max_bytes) throw Error(name_, "larger than " + std::to_string(max_bytes >> 20) + " MiB");
    size_ = size;
    stream_.reset(std::fopen(file.c_str(), "rb"));
    if (!stream_) throw Error(name_, "cannot be read: " + std::string(std::strerror(errno)));
    std::setvbuf(stream_.get(), nullptr, _IONBF, 0);  // the parts are read whole, so a buffer would only copy
}

void FileReader::read(std::size_t at, std::span<char> to) const
{
    if (fseeko(stream_.get(), static_cast<off_t>(at), SEEK_SET) != 0 ||
        std::fread(to.data(), 1, to.size(), stream_.get()) != to.size())
        throw Error(name_, "could not be read to its end");
}

std::string read_file(const fs::path& file, std::size_t max_bytes)
{
    const FileReader reader(file, max_bytes);
    std::string bytes(reader.size(), '\0');
    reader.read(0, bytes);
    return bytes;
}

std::string_view without_mark(std::string_view text) noexcept
{
    constexpr std::string_view kMark = "\xef\xbb\xbf";
    if (text.starts_with(kMark)) text.remove_prefix(kMark.size());
    return text;
}

std::string read_text(const fs::path& file, std::size_t max_bytes)
{
    std::string text = read_file(file, max_bytes);
    text.erase(0, text.size() - without_mark(text).size());
    return text;
}

}  // namespace occam::import
