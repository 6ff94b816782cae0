// A worm: a smooth tube with a skin of four joints and a clip that makes it crawl. Two units long, along x.
#pragma once

#include <occam/occam.h>

namespace sample {

struct Worm {
    occam::NodeId node;   ///< holds joints and body: place this one
    occam::ClipId crawl;  ///< one second, repeats
};

/// Adds the worm below the root. For more of them: scene.copy(worm.node, ...), and pose() each copy by itself.
Worm add_worm(occam::Scene& scene, occam::Vec3f color);

/// A square floor about the origin, and a sun.
void add_surroundings(occam::Scene& scene, float half_side);

}  // namespace sample
