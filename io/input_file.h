// Why a file that is to be read cannot be opened.
#pragma once

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>

namespace occam {

/// Returns the reason for which a file cannot be opened for reading, as an Error says it; empty if it can. Libraries and
/// streams that cannot open a file tell no more than that there is nothing in it.
inline std::string why_unreadable(const std::filesystem::path& file)
{
    const auto reason = [] { return "cannot be read: " + std::string(std::strerror(errno)); };
    constexpr char kNoFile[] = "is not there or is not a file";
    struct stat status = {};
    if (stat(file.c_str(), &status) != 0) return errno == ENOENT || errno == ENOTDIR ? kNoFile : reason();
    if (!S_ISREG(status.st_mode)) return kNoFile;
    const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) return reason();
    close(descriptor);
    return {};
}

}  // namespace occam
