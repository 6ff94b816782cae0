#include "io/output_file.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstring>
#include <map>
#include <optional>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/error_without_file.h"
#include "base/hash.h"
#include "base/number_in.h"
#include "io/output_place.h"

namespace occam {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPartMark = ".part";

fs::path folder_of(const fs::path& file) { return file.has_parent_path() ? file.parent_path() : fs::path("."); }

[[noreturn]] void refuse_output(const fs::path& file, const std::string& why)
{
    throw Error(file.string(), why, {}, Error::Kind::Output);
}

// Holds the name of an output as its temporaries have it: as it is, or shortened so that they have room for their number.
struct HeldName {
    std::string stem, extension;  // readers choose the format by the extension
};

HeldName held_name(const fs::path& file)
{
    constexpr std::size_t kLongestNumber = 16;     // of a process and an attempt
    constexpr std::size_t kLongestExtension = 32;  // that is kept
    constexpr std::size_t kFitsAnywhere = 128;     // so that the file system need not be asked
    HeldName name{file.stem().string(), file.extension().string()};
    if (name.extension.size() > kLongestExtension) name = {file.filename().string(), {}};
    const std::size_t others = 1 + kPartMark.size() + kLongestNumber + name.extension.size();
    if (name.stem.size() + others <= kFitsAnywhere) return name;
    const long most = pathconf(folder_of(file).c_str(), _PC_NAME_MAX);
    const std::size_t room = most > 0 ? static_cast<std::size_t>(most) : NAME_MAX;
    if (name.stem.size() + others <= room) return name;
    char hash[18];  // tells apart what begins alike, such as the frames of a sequence
    std::snprintf(hash, sizeof hash, "~%016llx",
                  static_cast<unsigned long long>(fnv1a(name.stem.data(), name.stem.size(), kFnvStart)));
    const std::size_t taken = others + sizeof hash - 1;
    std::size_t end = room > taken ? std::min(room - taken, name.stem.size()) : 0;
    while (end > 0 && (name.stem[end] & 0xc0) == 0x80) --end;  // a character of UTF-8 is not cut in two
    name.stem.resize(end);
    name.stem += hash;
    return name;
}

fs::path temporary_name(const fs::path& file, int attempt)
{
    const HeldName held = held_name(file);
    std::string name(".");
    name += held.stem;
    name += kPartMark;
    name += std::to_string(getpid());
    if (attempt > 0) name.append("-").append(std::to_string(attempt));
    name += held.extension;
    return folder_of(file) / name;
}

// Returns the name of the output that a temporary file belongs to, as HeldName has it; empty for any other file.
std::string output_of(const std::string& temporary)
{
    const std::size_t mark = temporary.rfind(kPartMark);
    if (temporary.empty() || temporary[0] != '.' || mark == std::string::npos || mark < 1) return {};
    const std::size_t digits = mark + kPartMark.size();
    const std::size_t end = std::min(temporary.find_first_not_of("0123456789-", digits), temporary.size());
    if (end == digits) return {};
    return temporary.substr(1, mark - 1) + temporary.substr(end);
}

int sync_again(int descriptor)
{
    int result = 0;
    do result = fsync(descriptor);
    while (result != 0 && errno == EINTR);
    return result;
}

bool write_all(int descriptor, std::string_view bytes)
{
    while (!bytes.empty()) {
        const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0 && errno == EAGAIN) {  // the pipe's reader has made it non-blocking
            pollfd wait = {descriptor, POLLOUT, 0};
            poll(&wait, 1, -1);
            continue;
        }
        if (written <= 0) return false;
        bytes.remove_prefix(static_cast<std::size_t>(written));
    }
    return true;
}

void remove_if_abandoned(const fs::path& temporary) noexcept
{
    const int descriptor = open(temporary.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    if (descriptor < 0) return;
    // Its writer may have ended meanwhile, and another one may have made a file of the same name.
    if (flock(descriptor, LOCK_EX | LOCK_NB) == 0 && is_same_file(descriptor, temporary.c_str())) unlink(temporary.c_str());
    close(descriptor);
}

// Returns the number of the open file that is meant by "-", or to which links like /dev/stdout and /dev/fd/3 lead; none for
// any other name. Such an open file may be a regular one, to which a shell has redirected the output.
std::optional<int> descriptor_of(const fs::path& file)
{
    if (file == "-") return STDOUT_FILENO;
    constexpr int kMostLinks = 40;  // as in Linux
    std::error_code error;
    const fs::path open_files = fs::canonical("/proc/self/fd", error);
    fs::path name = file;
    for (int links = 0; !error && links < kMostLinks; ++links) {
        const fs::path folder = fs::canonical(folder_of(name), error);
        if (!error && folder == open_files) {
            const auto number = number_in<int>(name.filename().string());
            return number && *number >= 0 ? number : std::nullopt;
        }
        const fs::path target = fs::read_symlink(name, error);
        name = folder / target;  // which is the target itself if that is absolute
    }
    return std::nullopt;
}

fs::path shown_name(const fs::path& file) { return file == "-" ? "standard output" : file; }

bool is_writable(int descriptor)
{
    const int flags = fcntl(descriptor, F_GETFL);
    return flags >= 0 && (flags & O_ACCMODE) != O_RDONLY;
}

}  // namespace

bool is_written_directly(const fs::path& file)
{
    std::error_code error;
    return descriptor_of(file) || (fs::exists(file, error) && !fs::is_regular_file(file, error));
}

bool is_standard_output(const fs::path& file) { return descriptor_of(file) == STDOUT_FILENO; }

OutputFile::OutputFile(const fs::path& file) : final_(file)
{
    constexpr int kAttempts = 1000;
    // The temporary may have a shorter name.
    if (struct stat there = {}; lstat(file.c_str(), &there) != 0 && errno == ENAMETOOLONG) refuse(errno);
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
        temporary_ = temporary_name(file, attempt);
        descriptor_ = open(temporary_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        // A process of the same number, on another machine or in another container, may use this name.
        if (descriptor_ < 0 && errno == EEXIST) continue;
        if (descriptor_ < 0) refuse(errno);
        // Between the two calls another process that tidies up may have taken the file for abandoned: it has removed the
        // file, or holds the lock and is about to. On file systems without locks no other process can remove the file, so
        // that any other failure does not matter.
        const bool is_taken = flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
        if (!is_taken && is_same_file(descriptor_, temporary_.c_str())) {
            listed_.list(temporary_, descriptor_);
            return;
        }
        close(descriptor_);
    }
    descriptor_ = -1;
    refuse(EEXIST);
}

OutputFile::~OutputFile()
{
    if (!is_published_ && descriptor_ >= 0 && is_same_file(descriptor_, temporary_.c_str())) unlink(temporary_.c_str());
    listed_.unlist();
    if (descriptor_ >= 0) close(descriptor_);
}

void OutputFile::refuse(int error) const
{
    refuse_output(final_, "cannot be written: " + std::string(std::strerror(error)));
}

void OutputFile::write_at(const void* bytes, std::size_t size, std::uint64_t offset) noexcept
{
    const char* next = static_cast<const char*>(bytes);
    size_ = std::max(size_, offset + size);
    is_finished_ = false;
    while (size > 0 && error_ == 0) {
        const ssize_t written = pwrite(descriptor_, next, size, static_cast<off_t>(offset));
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) {
            error_ = written < 0 ? errno : ENOSPC;
            return;
        }
        next += written;
        size -= static_cast<std::size_t>(written);
        offset += static_cast<std::uint64_t>(written);
    }
}

std::size_t OutputFile::read_at(void* bytes, std::size_t size, std::uint64_t offset) const noexcept
{
    ssize_t got = 0;
    do got = pread(descriptor_, bytes, size, static_cast<off_t>(offset));
    while (got < 0 && errno == EINTR);
    return got < 0 ? 0 : static_cast<std::size_t>(got);
}

void OutputFile::finish()
{
    if (error_ != 0) refuse(error_);
    // EINVAL and EROFS say that this file cannot be synced (on a special file system), which does not lose any bytes.
    if (sync_again(descriptor_) != 0 && errno != EINVAL && errno != EROFS) refuse(errno);
    struct stat status = {};
    if (fstat(descriptor_, &status) != 0) refuse(errno);
    if (static_cast<std::uint64_t>(status.st_size) != size_)
        refuse_output(final_, "cannot be written: " + std::to_string(status.st_size) + " of " + std::to_string(size_) +
                                  " bytes are in the file");
    if (!is_same_file(descriptor_, temporary_.c_str()))
        refuse_output(final_, "cannot be written: its temporary file is gone");
    is_finished_ = true;
}

void OutputFile::publish()
{
    if (!is_finished_) finish();
    const fs::path folder_path = folder_of(final_);  // nothing may fail once the file has its name
    std::error_code error;
    fs::rename(temporary_, final_, error);
    if (error) refuse_output(final_, "cannot be written: " + error.message());
    is_published_ = true;
    listed_.unlist();
    // The name is an entry of the folder, which is synced separately where the file system allows it.
    if (const int folder = open(folder_path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); folder >= 0) {
        (void)sync_again(folder);
        close(folder);
    }
}

void write_whole(const fs::path& file, std::string_view bytes)
{
    if (!is_written_directly(file)) {
        OutputFile out(file);
        out.append(bytes);
        out.publish();
        return;
    }
    const std::optional<int> own = descriptor_of(file);
    if (own == STDOUT_FILENO) std::fflush(stdout);
    const int descriptor = own ? *own : open(file.c_str(), O_WRONLY | O_CLOEXEC);
    const bool is_written = descriptor >= 0 && write_all(descriptor, bytes);
    int failure = is_written ? 0 : errno;
    if (!own && descriptor >= 0 && close(descriptor) != 0 && is_written) failure = errno;
    if (failure != 0) refuse_output(shown_name(file), "cannot be written: " + std::string(std::strerror(failure)));
}

void check_output(const fs::path& file)
{
    check_folder(file);
    check_replaceable(file);
}

void check_replaceable(const fs::path& file)
{
    std::error_code error;
    // A file by that name would take the place of a link that all programs use, such as /dev/stdout.
    if (descriptor_of(file)) refuse_output(shown_name(file), "is open already, and this output has to be a file of its own");
    if (fs::exists(file, error) && !fs::is_regular_file(file, error))
        refuse_output(file, "is there already and is not a file");
    if (const std::string why = why_not_replaceable(file); !why.empty()) refuse_output(file, why);
}

void check_folder(const fs::path& file)
{
    std::error_code error;
    const fs::path folder = folder_of(file);
    if (file.empty()) throw error_without_file("the name of the file is empty", {}, Error::Kind::Output);
    if (file.filename().empty()) refuse_output(file, "is the name of a folder, not of a file");
    if (!fs::is_directory(folder, error)) refuse_output(file, "cannot be written: there is no folder " + folder.string());
    if (access(folder.c_str(), W_OK) != 0)
        refuse_output(file, "cannot be written in folder " + folder.string() + ": " + std::strerror(errno));
    if (keeps_all_names(folder))
        refuse_output(file, "cannot be written in folder " + folder.string() + ", which has the attribute append-only");
    // A read-only file system, a name that is too long or a folder without space is detected here, before minutes of work.
    const OutputFile attempt(file);
}

void check_whole(const fs::path& file)
{
    std::error_code error;
    if (fs::is_directory(file, error)) refuse_output(file, "is the name of a folder, not of a file");
    if (!is_written_directly(file)) return check_output(file);
    const std::optional<int> own = descriptor_of(file);
    if (own && !is_writable(*own))
        refuse_output(shown_name(file), "cannot be written: it is closed, or open only for reading");
    if (!own && access(file.c_str(), W_OK) != 0)
        refuse_output(file, "cannot be written: " + std::string(std::strerror(errno)));
}

void refuse_inputs(std::span<const fs::path> outputs, std::span<const fs::path> inputs)
{
    using Place = std::pair<dev_t, ino_t>;
    const auto place_of = [](const fs::path& file) -> std::optional<Place> {
        struct stat status = {};
        if (file.empty() || stat(file.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return std::nullopt;
        return Place(status.st_dev, status.st_ino);
    };
    std::set<Place> known;
    for (const fs::path& input : inputs)
        if (const auto place = place_of(input)) known.insert(*place);
    if (known.empty()) return;
    for (const fs::path& output : outputs)
        if (const auto place = place_of(output); place && known.contains(*place))
            throw Error(output.string(), "is an input, so it cannot be written");
}

void remove_unfinished(std::span<const fs::path> outputs) noexcept
try {
    std::map<fs::path, std::set<std::string>> names_of;
    for (const fs::path& output : outputs) {
        const HeldName held = held_name(output);
        names_of[folder_of(output)].insert(held.stem + held.extension);
    }
    for (const auto& [folder, names] : names_of) {
        std::error_code error;
        fs::directory_iterator entry(folder, error), end;
        std::vector<fs::path> abandoned;
        for (; !error && entry != end; entry.increment(error))
            if (const std::string name = output_of(entry->path().filename().string()); !name.empty() && names.contains(name))
                abandoned.push_back(entry->path());
        for (const fs::path& temporary : abandoned) remove_if_abandoned(temporary);
    }
} catch (const std::exception&) {
    // Tidying up is optional, so its failures are ignored.
}

}  // namespace occam
