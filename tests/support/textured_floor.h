// A floor with textures under a lamp, for tests of materials.
#pragma once

#include <occam/occam.h>

#include <functional>

#include "scenegraph/scene.h"

namespace occam::test {

inline constexpr int kTexels = 64;  ///< along a side

/// `of(x, y)` is a texel's value, data.
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
/// Smooth, and repeats without a seam.
Texture waves(float phase);

/// A floor of 4 x 4 faces over [-2, 2] in x and z, with coordinates from 0 to 1, seen from the outside from above.
Cage floor_of(MaterialId material, Scheme scheme);

/// Such a floor, a lamp over it and a camera that looks down at it; the background is left out.
struct TexturedFloor {
    TexturedFloor(Scheme scheme, const std::function<Material(Scene&)>& make);

    Image picture(Settings settings);
    Image picture(render::ShadeAt at, float rate = 1);
    /// Between what vertices and what hits look up: root mean square.
    double difference(float rate);

    Scene scene;
    Material material;
    Renderer renderer{{.threads = 2}};
    FrameStats stats;
};

}  // namespace occam::test
