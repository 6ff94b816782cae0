// Writes vectors and boxes to streams, for people who look for a fault.
//
// Numbers have as many digits as the precision of the stream says; 9 digits give a float back, and 17 a double.
#pragma once

#include <locale>
#include <ostream>

#include "base/box.h"
#include "base/handle.h"

// Vectors are types of GLM, so their operator is found in its namespace.
namespace glm {

template <length_t L, class T, qualifier Q>
std::ostream& operator<<(std::ostream& out, const vec<L, T, Q>& v)
{
    out << '(';
    for (length_t i = 0; i < L; ++i) out << (i > 0 ? ", " : "") << v[i];
    return out << ')';
}

}  // namespace glm

namespace occam {

template <class Vec>
std::ostream& operator<<(std::ostream& out, const Box<Vec>& box)
{
    if (box.is_empty()) return out << "an empty box";
    return out << box.lo << " to " << box.hi;
}

/// Writes the number of the slot, and the generation if the slot was used before.
template <class Tag>
std::ostream& operator<<(std::ostream& out, Handle<Tag> id)
{
    if (!id) return out << "none";
    out << id.slot;
    return id.generation > 0 ? out << '.' << id.generation : out;
}

/// Sets the precision of a stream for a scope, and how it writes numbers: as in C, whatever the locale of the application.
class Precision {
public:
    Precision(std::ostream& out, int digits)
        : out_(out), before_(out.precision(digits)), locale_(out.imbue(std::locale::classic()))
    {
    }
    ~Precision()
    {
        out_.precision(before_);
        out_.imbue(locale_);
    }
    Precision(const Precision&) = delete;
    Precision& operator=(const Precision&) = delete;

private:
    std::ostream& out_;
    std::streamsize before_;
    std::locale locale_;
};

}  // namespace occam
