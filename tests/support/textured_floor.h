// A floor with textures under a lamp, for tests of materials.
#pragma once

#include <occam/occam.h>

#include <functional>

#include "accel/frame.h"
#include "accel/tracer.h"
#include "scenegraph/scene.h"
#include "shade/material_values.h"

namespace occam::test {

inline constexpr int kTexels = 64;  ///< texels along a side

/// Makes a texture of data; `of(x, y)` is the value of a texel.
template <class Of>
Texture texture_of(Of&& of)
{
    Texture texture;
    texture.role = TextureRole::Data;
    texture.width = texture.height = kTexels;
    for (int y = 0; y < kTexels; ++y)
        for (int x = 0; x < kTexels; ++x) texture.pixels.push_back(of(float(x), float(y)));
    return texture;
}
/// Returns a smooth pattern that repeats without a seam.
Texture waves(float phase);

/// Returns a floor of 4 x 4 faces over [-2, 2] in x and z, with coordinates from 0 to 1; its outside faces up.
Cage floor_of(MaterialId material, Scheme scheme);

/// Holds such a floor, a lamp over it and a camera that looks down at it; the background is left out.
struct TexturedFloor {
    TexturedFloor(Scheme scheme, const std::function<Material(Scene&)>& make);

    Image picture(Settings settings);
    Image picture(render::ShadeAt at, float rate = 1);
    /// Returns the root mean square of the difference between lookups at vertices and at hits.
    double difference(float rate);

    Scene scene;
    Material material;
    Renderer renderer{{.threads = 2}};
    FrameStats stats;
};

/// Traces rays into a scene of such floors, with phase one at vertices or not. Borrows the scene.
struct FloorTracer {
    FloorTracer(Scene& scene, bool at_vertices);

    TextureStore textures{std::size_t(1) << 24};
    shade::PhaseOne phase_one;
    lod::TopologyCache topologies;
    accel::Frame frame;
    accel::Tracer tracer;
};

}  // namespace occam::test
