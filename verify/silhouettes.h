// Recognizes hits on front sides that are narrower than rounding.
//
// At the outline of a ridge a ray leaves the surface and enters it again at once. Where both places are closer together
// than rounding, either may be found first, so a ray from inside may report the front side. A surface with steep ridges
// has outlines nearly everywhere, and rays that are aimed at its edges meet them (docs/watertightness.md). A turned
// micropolygon, a fold or a hole would also be seen by rays beside this one.
#pragma once

#include "accel/frame.h"
#include "accel/tracer.h"

namespace occam {

/// Traces rays around a ray. It borrows the scene and its tables.
class Silhouettes {
public:
    /// levels   with which the ray was traced
    Silhouettes(const Scene& scene, lod::TopologyCache& topologies, const lod::LevelSettings& levels,
                const TextureStore* textures, float radius);

    /// Returns whether the front side that a ray has hit is narrower than rounding.
    bool explain(const accel::Ray& ray);

private:
    accel::Frame frame_;
    accel::Tracer tracer_;
    float radius_;
};

}  // namespace occam
