// Reads coordinates of igrids as rays see them: as they are stored or, for an igrid that moves, between two keys at the time
// of each ray.
#pragma once

#include <cstddef>

#include "base/simd.h"
#include "lod/key_time.h"

namespace occam::accel {

/// Reads an igrid that stands still.
struct StillCoordinates {
    static constexpr bool kMove = false;

    int key() const noexcept { return 0; }
    /// Returns one coordinate in all lanes. The second argument is the number of floats to the next key.
    OCCAM_ALWAYS_INLINE vfloat one(const float* p, std::ptrdiff_t) const noexcept { return vfloat(*p); }
    /// Returns as many consecutive coordinates as there are lanes.
    OCCAM_ALWAYS_INLINE vfloat many(const float* p, std::ptrdiff_t) const noexcept { return vfloat::load(p); }
    /// Returns whether two coordinates are the same for all rays.
    OCCAM_ALWAYS_INLINE bool are_same(const float* p, const float* q, std::ptrdiff_t) const noexcept { return *p == *q; }
};

/// Reads an igrid that moves, between a key and the next one. Pointers lead to that key. All rays are in the same segment.
class MovingCoordinates {
public:
    static constexpr bool kMove = true;

    MovingCoordinates(int key, vfloat share) noexcept : key_(key), share_(share) {}
    int key() const noexcept { return key_; }
    OCCAM_ALWAYS_INLINE vfloat one(const float* p, std::ptrdiff_t next) const noexcept
    {
        return lod::between_keys(share_, vfloat(p[0]), vfloat(p[next]));
    }
    OCCAM_ALWAYS_INLINE vfloat many(const float* p, std::ptrdiff_t next) const noexcept
    {
        return lod::between_keys(share_, vfloat::load(p), vfloat::load(p + next));
    }
    OCCAM_ALWAYS_INLINE bool are_same(const float* p, const float* q, std::ptrdiff_t next) const noexcept
    {
        return p[0] == q[0] && p[next] == q[next];
    }
    vfloat share() const noexcept { return share_; }

private:
    int key_;
    vfloat share_;  ///< of each ray: how far it is from the key to the next one
};

}  // namespace occam::accel
