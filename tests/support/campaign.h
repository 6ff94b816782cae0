// How long the tests are that may be long: their number of rays and whether sanitizers slow them down, as the environment
// says (tests/README.md).
#pragma once

#include <cstddef>
#include <cstdint>

namespace occam::test {

/// Whether this program was built with the address or the thread sanitizer, which has an allocator of its own and is slow.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kIsSanitized = true;
#else
inline constexpr bool kIsSanitized = false;
#endif

/// Returns whether the long campaigns are run (OCCAM_LONG=1).
bool is_long();

/// Returns the number that an environment variable holds, or `otherwise` if it is not set.
std::uint64_t number_from(const char* variable, std::uint64_t otherwise);

/// Returns the number of rays that a long campaign sends at each cage: OCCAM_CAMPAIGN_RAYS, or 10^6.
std::uint64_t rays_of_a_campaign();

/// Returns the number of rays for each cage: rays_of_a_campaign() in the long campaigns, else 1.6 * 10^4.
std::uint64_t rays_per_cage();

/// Returns how many rays are sent at each of two places by tests in which each ray blends the surface for itself: an eighth
/// of rays_of_a_campaign() in the long campaigns, else 8 * 10^3.
std::uint64_t blended_rays_per_place();

/// Chooses among the combinations of nested loops: all of them in the long campaigns, else every `nth` one, from the first
/// on. A number that shares no factor with the lengths of the loops takes each of their values.
class EveryNth {
public:
    explicit EveryNth(unsigned nth) : nth_(is_long() ? 1 : nth) {}
    /// Returns whether the next combination is taken.
    bool takes() { return next_++ % nth_ == 0; }

private:
    unsigned nth_, next_ = 0;
};

}  // namespace occam::test
