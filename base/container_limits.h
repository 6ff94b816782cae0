// What the system lets a container use of its machine.
#pragma once

#include <cstddef>
#include <string>

namespace occam {

/// The limits of the control groups that this process is in (Linux, versions 1 and 2): of its own group and of all around
/// it. Containers and batch systems set them.
struct ContainerLimits {
    std::size_t memory_bytes = 0;  ///< 0: there is no limit
    double processors = 0;         ///< how much time of processors a second the process gets; 0: there is no limit
};

/// Returns the limits as they are now. A file that is missing, or that says nothing that can be understood, limits nothing.
/// root   of the file system; tests have one of their own
ContainerLimits container_limits(const std::string& root = "") noexcept;

/// Returns the limits of this process. They are read once, because reading them takes as long as a small frame.
inline const ContainerLimits& own_container_limits() noexcept
{
    static const ContainerLimits limits = container_limits();
    return limits;
}

}  // namespace occam
