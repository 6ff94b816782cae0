#include "io/output_place.h"

#include <fcntl.h>
#include <linux/capability.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdint>

namespace occam {
namespace {

// Returns whether the process may do with any file what its owner may.
bool acts_as_owner() noexcept
{
    __user_cap_header_struct header = {_LINUX_CAPABILITY_VERSION_3, 0};
    __user_cap_data_struct sets[_LINUX_CAPABILITY_U32S_3] = {};
    return syscall(SYS_capget, &header, sets) == 0 && (sets[0].effective & (std::uint32_t(1) << CAP_FOWNER)) != 0;
}

// Returns whether the system says of the file that it has an attribute. Older systems and many file systems know few of
// them.
bool has(const struct statx& file, std::uint64_t attribute) noexcept
{
    return (file.stx_attributes_mask & file.stx_attributes & attribute) != 0;
}

}  // namespace

std::string why_not_replaceable(const std::filesystem::path& file)
{
    // A link is replaced itself, and not what it leads to.
    struct statx there = {}, folder = {};
    const std::string parent = file.has_parent_path() ? file.parent_path().string() : ".";
    if (statx(AT_FDCWD, file.c_str(), AT_SYMLINK_NOFOLLOW, STATX_BASIC_STATS, &there) != 0) return {};
    if (statx(AT_FDCWD, parent.c_str(), 0, STATX_BASIC_STATS, &folder) != 0) return {};
    if (has(there, STATX_ATTR_IMMUTABLE) || has(there, STATX_ATTR_APPEND))
        return "is there already and cannot be replaced: it has the attribute immutable or append-only";
    if (has(there, STATX_ATTR_MOUNT_ROOT)) return "is there already and cannot be replaced: a file is mounted on it";
    const uid_t user = geteuid();
    if ((folder.stx_mode & S_ISVTX) != 0 && there.stx_uid != user && folder.stx_uid != user && !acts_as_owner())
        return "is there already and cannot be replaced: it belongs to another user, and folder " + parent + " is sticky";
    return {};
}

bool keeps_all_names(const std::filesystem::path& folder)
{
    struct statx found = {};
    return statx(AT_FDCWD, folder.c_str(), 0, STATX_BASIC_STATS, &found) == 0 && has(found, STATX_ATTR_APPEND);
}

}  // namespace occam
