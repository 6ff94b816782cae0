// Sets a thread's floating-point numbers as an application may have them.
#pragma once

#include <xmmintrin.h>

#include <cfenv>

namespace occam::test {

/// Sets what -ffast-math sets in a program's threads, and a rounding of its own.
struct OtherFloats {
    OtherFloats()
    {
        std::fesetround(FE_UPWARD);
        _mm_setcsr(_mm_getcsr() | 0x8040);
    }
    ~OtherFloats() { std::fesetenv(FE_DFL_ENV); }
    OtherFloats(const OtherFloats&) = delete;
    OtherFloats& operator=(const OtherFloats&) = delete;
};

}  // namespace occam::test
