// Tells whether what is placed beyond the largest coordinate of a cage hides the rest of a scene.
//
// The unit of a frame follows from all that it shows (frame_scale.h). What is very much smaller than that vanishes.
//
// Space    world.
#pragma once

#include <algorithm>
#include <cmath>

#include "base/box.h"
#include "scenegraph/cage.h"

namespace occam {

class FarPlaces {
public:
    enum class Place {
        None,  ///< the box is empty
        Near,
        Far,  ///< it reaches beyond kMaxCoordinate
        Lost  ///< it is not finite
    };

    /// Takes the box of something that is placed, and returns where that is.
    Place add(const Box3d& box) noexcept
    {
        if (is_nan(box.lo) || is_nan(box.hi)) return lose();
        if (box.is_empty()) return Place::None;
        const double reach = box.largest_coordinate();
        if (!std::isfinite(reach)) return lose();
        all_.add(box);
        if (reach > double(kMaxCoordinate)) return Place::Far;
        largest_near_ = std::max(largest_near_, largest_side(box));
        return Place::Near;
    }
    bool has_near() const noexcept { return largest_near_ > 0; }
    bool has_lost() const noexcept { return has_lost_; }
    /// Returns whether what is near vanishes beside what is far.
    bool hide_near() const noexcept { return has_near() && largest_near_ < largest_side(all_) / kLargestRatio; }

private:
    /// The area of a square with sides that much smaller than a frame is the least that a float holds.
    static constexpr double kLargestRatio = 1e22;

    static bool is_nan(const Vec3d& v) noexcept { return !(v == v); }
    static double largest_side(const Box3d& box) noexcept
    {
        const Vec3d extent = box.extent();
        return box.is_empty() ? 0 : std::max({extent.x, extent.y, extent.z});
    }
    Place lose() noexcept
    {
        has_lost_ = true;
        return Place::Lost;
    }

    Box3d all_;  // but for what is lost
    double largest_near_ = 0;
    bool has_lost_ = false;
};

}  // namespace occam
