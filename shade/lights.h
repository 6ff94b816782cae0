// The lights of one frame, gathered from the scene graph into world axes, and how each is sampled.
//
// Area lights emit but are not seen by camera rays: they have no surface in the scene. A scene without any light gets a
// soft key light from over the camera's shoulder and a sky.
//
// Space    world; positions double, directions float.
// Threads  const after construction.
#pragma once

#include <vector>

#include "scenegraph/scene.h"
#include "shade/environment.h"

namespace occam::shade {

/// Uniform numbers in [0, 1) for one sample of one light.
struct LightNumbers {
    Vec2f square{0.5f};
    float choice = 0.5f;
};

/// What one sample of a light sends to a point.
struct LightSample {
    Vec3f direction{0};  ///< unit, towards the light
    float distance = 0;  ///< infinity for parallel light
    Vec3f radiance{0};   ///< incoming, divided by the sample's density per solid angle; zero: nothing arrives
};

/// A light in world axes. Which fields are read depends on `kind`.
struct WorldLight {
    enum class Kind : unsigned char { Point, Sun, Rectangle, Disc, Sphere };
    Kind kind = Kind::Point;
    Vec3d position{0};
    Vec3f direction{0, 0, -1};   ///< the node's -z: where spot, sun and flat lights shine to; unit
    Vec3f half_x{0}, half_y{0};  ///< flat lights: from the middle to the edges
    float area = 0;              ///< flat lights
    float radius = 0;            ///< sphere
    bool two_sided = false;
    Vec3f strength{0};                      ///< intensity, irradiance or radiance, by kind
    float range = 0;                        ///< point; 0: no limit
    float spot_scale = 0, spot_offset = 1;  ///< of the cosine to `direction` (KHR_lights_punctual)
    float sun_spread = 0;                   ///< tangent of the half angle that the sun's disc covers

    /// Light is placed by its node; `light` as the scene describes it.
    static WorldLight place(const Light& light, const Mat4d& world_from_node);
    LightSample sample(Vec3d point, LightNumbers numbers) const noexcept;
};

class FrameLights {
public:
    /// Textures must be prepared. `camera` places the key light of a scene that has none.
    FrameLights(const Scene& scene, const Camera& camera, const TextureStore& textures);
    FrameLights(std::vector<WorldLight> lights, Environment environment);

    const std::vector<WorldLight>& lights() const noexcept { return lights_; }
    const Environment& environment() const noexcept { return environment_; }

private:
    std::vector<WorldLight> lights_;
    Environment environment_;
};

}  // namespace occam::shade
