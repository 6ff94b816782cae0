// A motion file (BVH) of an older rig of MakeHuman's, put on the bones of today's.
#pragma once

#include "body.h"

namespace sample {

struct Walk {
    occam::ClipId clip;
    double period = 0;  ///< seconds; the clip is a cycle of two steps
    double way = 0;     ///< how far a cycle goes, decimetres along +z
    double floor = 0;   ///< y of the floor below the lower foot
};

/// Throws occam::Error.
Walk add_walk(occam::Scene& scene, const Body& body, const std::filesystem::path& file);

}  // namespace sample
