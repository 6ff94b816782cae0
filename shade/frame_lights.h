// All light of one frame, gathered from the scene graph: placed lights, surfaces that shine, the environment.
//
// A scene without a placed light, an environment or surfaces that shine brightly enough to light it gets a soft key light
// from over the camera's shoulder and a sky, unless Sky says otherwise. The scene's bounds must be up to date for that.
//
// Space    world; positions double, directions float.
// Threads  const after construction.
#pragma once

#include <vector>

#include "base/maths.h"
#include "shade/environment.h"
#include "shade/lights.h"
#include "shade/mesh_lights.h"
#include "shade/sky.h"

namespace occam::shade {

class FrameLights {
public:
    /// A placed light is left to its own samples (direct.h) if no lobe of the surface finds it with more than about this
    /// chance. A sample of the light then varies less alone than weighed with a scattered direction
    /// (DirectLight.ALightLeftToItsSamplesIsNoNoisier).
    static constexpr float kLeastChance = 1.0f / 16;

    /// start   where rays leave the surface; peak: its peak_density()
    static bool is_left_to_samples(const WorldLight& light, Vec3d start, float peak) noexcept
    {
        return light.cover(start) * (peak * maths::kPi) < kLeastChance;
    }
    /// Textures must be prepared. `camera` places the key light of a scene that has none.
    FrameLights(const Scene& scene, const Camera& camera, const TextureStore& textures, Sky sky = Sky::Auto,
                float sky_strength = 1);
    FrameLights(std::vector<WorldLight> lights, Environment environment);

    const std::vector<WorldLight>& lights() const noexcept { return lights_; }
    const Environment& environment() const noexcept { return environment_; }
    const MeshLights& meshes() const noexcept { return meshes_; }

    /// True if scattered rays from `start` can bring nothing that samples of lights do not.
    bool leaves_all_to_samples(Vec3d start, float peak, LightGroups groups) const noexcept;

    /// Calls use(const WorldLight&, const LightCrossing&) for every area light that the ray meets within t_far, but those
    /// that are left to their samples where it starts.
    template <class Use>
    void for_crossings(Vec3d origin, Vec3f direction, float t_far, float peak, Use&& use) const
    {
        for (const std::uint32_t i : with_area_) {
            if (is_left_to_samples(lights_[i], origin, peak)) continue;
            const LightCrossing c = lights_[i].crossing(origin, direction);
            if (c.density > 0 && c.distance < t_far) use(lights_[i], c);
        }
    }

private:
    void list_areas();

    std::vector<WorldLight> lights_;
    std::vector<std::uint32_t> with_area_;
    MeshLights meshes_;
    Environment environment_;
};

}  // namespace occam::shade
