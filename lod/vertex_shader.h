// Phase one of shading as those see it who keep its results: floats at grid vertices, interpolated to hits (Djeu et al.
// 2011, sec. 5.3). What they mean is known to who makes them and to who reads them at a hit, both in shade/.
//
// Threads  const: called by all workers at once.
#pragma once

#include <span>

#include "base/vec.h"
#include "scenegraph/material.h"

namespace occam::lod {

struct VertexToShade {
    Vec2f uv[2]{};
    float uv_width[2]{};  ///< of the texture filter, in units of uv
};

/// Vertices in rows and columns, so that differences between neighbours can be taken.
struct LatticeToShade {
    std::span<const VertexToShade> vertices;  ///< row after row
    std::span<const Vec3f> places;            ///< of each, from any origin: world axes and lengths
    int columns = 2;                          ///< vertices of a row, at least two; as many rows
};

class VertexShader {
public:
    static constexpr int kMaxChannels = 26;

    virtual ~VertexShader() = default;

    /// Floats that a vertex of the material has, at most kMaxChannels; 0: nothing varies over the surface.
    virtual int channels(const Material& material) const noexcept = 0;
    /// A pure function of each vertex and its neighbours. out: channels() floats a vertex, vertex after vertex.
    virtual void shade(const Material& material, const LatticeToShade& lattice, float* out) const noexcept = 0;
};

/// How a frame shades at vertices.
struct VertexShading {
    const VertexShader* shader = nullptr;  ///< null: hits look their materials up themselves
    float texture_width = 1;               ///< of a hit's filter, in footprints: vertices that are closer filter no less
};

}  // namespace occam::lod
