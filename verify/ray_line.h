// The line by which a ray of the test is written down, so that it can be traced again.
//
// Space    world lengths.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/vec.h"

namespace occam {

struct RayLine {
    std::size_t cage = 0;  ///< number of the placed cage among those that the test reports
    Vec3d origin{0};
    Vec3f direction{0, 0, -1};
    double width = 0;  ///< of the beam at the origin
    float spread = 0;  ///< by which the beam grows per length
    float time = 0;
    /// The finest level of the test. If there is none, it is the first at which a point inside is found.
    std::optional<int> level{};

    /// Returns "cage N, origin X Y Z, direction X Y Z, footprint WIDTH SPREAD, time T, level L", with all digits. Cage 0,
    /// time 0 and no level are left out.
    std::string text() const;
};

/// Reads such a line. Throws Error that says what is missing or wrong.
RayLine read_ray_line(std::string_view text);

}  // namespace occam
