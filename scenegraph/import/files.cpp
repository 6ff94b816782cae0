#include "scenegraph/import/files.h"

#include <cstdio>
#include <memory>

#include "scenegraph/base/error.h"

namespace occam::import {

namespace fs = std::filesystem;

std::string read_file(const fs::path& file, std::size_t max_bytes)
{
    std::error_code error;
    const fs::file_status status = fs::status(file, error);
    if (!fs::exists(status)) throw Error(file.string(), "no such file");
    if (!fs::is_regular_file(status)) throw Error(file.string(), "not a regular file");
    const std::uintmax_t size = fs::file_size(file, error);
    if (error) throw Error(file.string(), "cannot be read", error.message());
    if (size > max_bytes) throw Error(file.string(), "larger than " + std::to_string(max_bytes >> 20) + " MiB");

    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(file.c_str(), "rb"), &std::fclose);
    if (!stream) throw Error(file.string(), "cannot be opened");
    std::string bytes(size, '\0');
    bytes.resize(std::fread(bytes.data(), 1, bytes.size(), stream.get()));
    if (bytes.size() != size) throw Error(file.string(), "could not be read to its end");
    return bytes;
}

std::optional<fs::path> inside(const fs::path& folder, std::string_view relative)
{
    const fs::path path(relative);
    if (relative.empty() || relative.find('\0') != std::string_view::npos || path.is_absolute()) return std::nullopt;
    std::error_code error;
    const fs::path root = fs::weakly_canonical(folder.empty() ? fs::path(".") : folder, error);
    if (error) return std::nullopt;
    const fs::path target = fs::weakly_canonical(root / path, error);
    if (error) return std::nullopt;
    const fs::path rest = target.lexically_relative(root);
    if (rest.empty() || *rest.begin() == ".." || rest == ".") return std::nullopt;
    return target;
}

}  // namespace occam::import
