// The interface of phase one of shading for code that stores its results: floats at grid vertices, interpolated to hits
// (Djeu et al. 2011, sec. 5.3). Only the code in shade/ that writes and reads these floats knows their meaning.
//
// Threads  const: all workers call it at once.
#pragma once

#include <span>

#include "base/vec.h"
#include "scenegraph/material.h"

namespace occam::lod {

struct VertexToShade {
    Vec2f uv[2]{};
    float uv_width[2]{};  ///< width of the texture filter, in units of uv
};

/// Vertices in rows and columns, so that differences between neighbours can be computed.
struct LatticeToShade {
    std::span<const VertexToShade> vertices;  ///< row after row
    int columns = 2;                          ///< vertices in a row, at least two; there are at least two rows
};

class VertexShader {
public:
    static constexpr int kMaxChannels = 33;

    virtual ~VertexShader() = default;

    /// Returns the number of floats at each vertex of the material, at most kMaxChannels; 0 if nothing varies over the
    /// surface.
    virtual int channels(const Material& material) const noexcept = 0;
    /// Shades the vertices: a pure function of each vertex and its neighbours.
    /// out   receives channels() floats for each vertex, in the order of the vertices
    virtual void shade(const Material& material, const LatticeToShade& lattice, float* out) const noexcept = 0;
};

class HitFilter;

/// Says what a frame looks up of materials while rays are traced.
struct VertexShading {
    const VertexShader* shader = nullptr;  ///< null: materials are looked up at hits
    float texture_width = 1;            ///< width of a hit's texture filter, in footprints; denser vertices filter no less
    const HitFilter* filter = nullptr;  ///< lets rays pass the holes of alpha masks, and hidden backs; null: there are none
};

}  // namespace occam::lod
