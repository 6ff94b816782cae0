// Checks of the engine's own invariants. A failure is a bug of the engine: it prints both operands and ends the process.
//
// OCCAM_CHECK_* are always on (cold code); OCCAM_DCHECK_* only in debug builds (hot code).
#pragma once

#include <cstdio>
#include <cstdlib>
#include <sstream>

namespace occam::detail {

template <class A, class B>
[[noreturn]] void check_failed(const char* file, int line, const char* text, const A& a, const B& b)
{
    std::ostringstream out;
    out << file << ':' << line << ": broken invariant: " << text << " with " << +a << " and " << +b << '\n';
    std::fputs(out.str().c_str(), stderr);
    std::abort();
}

}  // namespace occam::detail

#define OCCAM_CHECK_OP(a, op, b) \
    ((a)op(b) ? (void)0 : ::occam::detail::check_failed(__FILE__, __LINE__, #a " " #op " " #b, a, b))
#define OCCAM_CHECK_LT(a, b) OCCAM_CHECK_OP(a, <, b)
#define OCCAM_CHECK_LE(a, b) OCCAM_CHECK_OP(a, <=, b)
#define OCCAM_CHECK_EQ(a, b) OCCAM_CHECK_OP(a, ==, b)

#ifdef NDEBUG
#define OCCAM_DCHECK_LT(a, b) ((void)0)
#define OCCAM_DCHECK_LE(a, b) ((void)0)
#define OCCAM_DCHECK_EQ(a, b) ((void)0)
#else
#define OCCAM_DCHECK_LT(a, b) OCCAM_CHECK_LT(a, b)
#define OCCAM_DCHECK_LE(a, b) OCCAM_CHECK_LE(a, b)
#define OCCAM_DCHECK_EQ(a, b) OCCAM_CHECK_EQ(a, b)
#endif
