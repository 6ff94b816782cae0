// The interface through which rays pass the holes that alpha masks cut into surfaces, and hidden backs, while they are
// traced.
//
// A point that a ray finds on such a surface is asked about before it counts as a hit, so the ray goes on within the same
// traversal. The answer is a pure function of the ray and of the point.
//
// Threads  const: all workers call it at once.
#pragma once

#include "lod/vertex_shader.h"

namespace occam::lod {

class HitFilter {
public:
    virtual ~HitFilter() = default;

    /// Returns whether a surface has a hole at a point.
    /// at      where textures are looked up, without a width: a filter would close small holes far away, or open them all
    /// color   vertex colour
    virtual bool is_hole(const Material& material, const VertexToShade& at, Vec4f color) const noexcept = 0;
    /// Returns whether rays that come from behind a face of the material pass it as if it were not there.
    virtual bool hides_back(const Material&) const noexcept { return false; }
};

}  // namespace occam::lod
