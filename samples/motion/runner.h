// A wooden figure that runs: limbs on hinges, which are nodes.
#pragma once

#include <occam/occam.h>

namespace sample {

class Runner {
public:
    /// Adds the figure below the root. It is about 1.8 high and looks along +x.
    explicit Runner(occam::Scene& scene);

    /// Puts it at x, z on the ground, in the middle of a stride.
    /// stride   1 is a whole cycle: a step with each leg
    void pose(occam::Scene& scene, double x, double z, double stride) const;

private:
    struct Limb {
        occam::NodeId upper, lower;  ///< their own origins are the hinges
    };
    occam::NodeId body_;
    Limb legs_[2], arms_[2];
};

}  // namespace sample
