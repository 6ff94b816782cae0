// The import of a motion file (BVH) of an older MakeHuman rig onto the bones of today's rig.
#pragma once

#include "body.h"

namespace sample {

struct Walk {
    occam::ClipId clip;
    double period = 0;  ///< seconds; the clip is a cycle of two steps
    double way = 0;     ///< length of a cycle, in decimetres along +z
    double floor = 0;   ///< y of the floor below the lower foot
};

/// Adds the clip. Throws occam::Error.
Walk add_walk(occam::Scene& scene, const Body& body, const std::filesystem::path& file);

}  // namespace sample
