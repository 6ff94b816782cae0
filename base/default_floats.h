// Lets floating-point numbers be computed as IEEE 754 asks by default: rounded to nearest, with denormals, and without
// traps.
//
// An application may have set its threads otherwise, such as by -ffast-math. The same frame has the same bits there.
#pragma once

#include <cfenv>

namespace occam {

/// Holds the calling thread's settings while it lives, and then gives them back. It takes some ten nanoseconds.
class DefaultFloats {
public:
    DefaultFloats() noexcept
    {
        std::fegetenv(&before_);
        std::fesetenv(FE_DFL_ENV);
    }
    ~DefaultFloats() { std::fesetenv(&before_); }
    DefaultFloats(const DefaultFloats&) = delete;
    DefaultFloats& operator=(const DefaultFloats&) = delete;

private:
    std::fenv_t before_;
};

}  // namespace occam
