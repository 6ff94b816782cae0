// The number of bytes that this process has read, for tests of what is read more than once.
#pragma once

#include <fstream>
#include <stdexcept>
#include <string>

namespace occam::test {

/// Returns the bytes that all calls of read() have returned since the process began.
inline std::size_t bytes_read()
{
    std::ifstream counters("/proc/self/io");
    std::string name;
    std::size_t bytes = 0;
    if (!(counters >> name >> bytes) || name != "rchar:") throw std::runtime_error("/proc/self/io cannot be read");
    return bytes;
}

}  // namespace occam::test
