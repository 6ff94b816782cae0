// What a sample says when it ends by an exception.
#pragma once

#include <occam/occam.h>

#include <cstdio>
#include <exception>
#include <new>

namespace sample {

/// Prints why the program ends, in one line, and returns its exit code: 2 for what is wrong with its input, else 3. Is
/// called where an exception is handled.
inline int exit_code_of_failure(const char* program)
try {
    throw;
} catch (const occam::Error& error) {
    std::fprintf(stderr, "%s: %s\n", program, error.what());
    return error.kind() == occam::Error::Kind::Output ? 3 : 2;
} catch (const std::bad_alloc&) {
    std::fprintf(stderr, "%s: there is not enough memory\n", program);
    return 3;
} catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", program, error.what());
    return 3;
}

}  // namespace sample
