// A cart on spoked wheels, with a worm for a passenger.
#pragma once

#include <occam/occam.h>

#include "worm.h"

namespace sample {

class Cart {
public:
    /// Adds the cart below the root. It is about 2.6 long and drives along +x.
    explicit Cart(occam::Scene& scene);

    /// Puts it at x, z on the ground. Its wheels have rolled there from x = 0.
    void pose(occam::Scene& scene, double x, double z, double seconds) const;

private:
    occam::NodeId body_;
    occam::NodeId wheels_[4];
    occam::NodeId passenger_;
    occam::ClipId crawl_;
};

}  // namespace sample
