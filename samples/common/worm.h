// A worm: a smooth tube with a skin of four joints and a clip that makes it crawl. It is two units long, along x.
#pragma once

#include <occam/occam.h>

namespace sample {

struct Worm {
    occam::NodeId node;   ///< holds joints and body: place this one
    occam::ClipId crawl;  ///< one second, repeats
};

/// Adds the worm below the root. For more worms call scene.copy(worm.node, ...), and pose() each copy separately.
Worm add_worm(occam::Scene& scene, occam::Vec3f color);

/// Adds a square floor about the origin, and a sun.
void add_surroundings(occam::Scene& scene, float half_side);

}  // namespace sample
