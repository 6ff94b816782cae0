// All light of one frame, gathered from the scene graph: placed lights, emissive surfaces and the environment. Placed lights
// that are those of the frame before are kept (shade/placed_lights.h).
//
// A scene gets a soft key light from over the camera's shoulder and a sky if it has no placed light, no environment and
// no emissive surfaces that are bright enough to light it, unless Sky says otherwise. The scene's bounds must be up to
// date for that.
//
// Space    world axes, frame lengths (scenegraph/frame_scale.h); positions are double, directions are float.
// Threads  const after construction.
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "base/maths.h"
#include "shade/environment.h"
#include "shade/light_tree.h"
#include "shade/lights.h"
#include "shade/mesh_lights.h"
#include "shade/placed_lights.h"
#include "shade/sky.h"

namespace occam::shade {

/// Says what lights a scene that has no light of its own.
struct DefaultLight {
    Sky sky = Sky::Auto;
    float sky_strength = 1;
    /// Whether a scene without placed lights and environment gets the default light, unless `sky` is off; none: it does if
    /// its emissive surfaces have too little power.
    std::optional<bool> is_wanted{};
};

/// What a renderer keeps of one frame's lights for the next. It belongs to one thread at a time.
struct KeptFrameLights {
    KeptLights placed;
    Environment::Kept environment;
};

/// Returns the middle of a scene that is refitted, from which the distances of its lights are measured, in frame lengths. It
/// is the origin for a scene without finite bounds.
Vec3d middle_of(const Scene& scene, const FrameScale& scale) noexcept;

class FrameLights {
public:
    /// A placed light is left to its own samples (direct.h) if no lobe of the surface finds it with more than about this
    /// chance. A sample of the light alone then varies less than one that is weighted against a scattered direction
    /// (DirectLight.ALightLeftToItsSamplesIsNoNoisier).
    static constexpr float kLeastChance = 1.0f / 16;

    /// Returns true if the light is left to its own samples.
    /// start   where rays leave the surface
    /// peak    peak_density() of the surface
    static bool is_left_to_samples(const WorldLight& light, Vec3d start, float peak) noexcept
    {
        return light.sine2_subtended(start) * (peak * maths::kPi) < kLeastChance;
    }
    /// The textures must be prepared. `camera` places the key light of a scene that has none.
    /// kept   if not null, what is kept of the last frame's lights; becomes that of this one
    FrameLights(const Scene& scene, const Camera& camera, const TextureStore& textures, const DefaultLight& otherwise = {},
                const FrameScale& scale = {}, KeptFrameLights* kept = nullptr);
    FrameLights(std::vector<WorldLight> lights, Environment environment);

    /// Leaves out the light of the backs of single-sided emissive surfaces.
    void hide_backs() noexcept { meshes_.hide_backs(); }

    /// Returns the placed lights: first those outside the tree.
    const std::vector<WorldLight>& lights() const noexcept { return placed_->lights; }
    std::size_t lights_outside_tree() const noexcept { return placed_->outside_tree; }
    const LightTree& tree() const noexcept { return placed_->tree; }
    /// Returns whether lights are drawn for receivers, by a tree of placed lights or of emissive triangles.
    bool needs_receivers() const noexcept { return !tree().is_empty() || !meshes_.tree().is_empty(); }
    /// Returns a point as both trees take it.
    Vec3f relative(Vec3d point) const noexcept { return (tree().is_empty() ? meshes_.tree() : tree()).relative(point); }
    const Environment& environment() const noexcept { return environment_; }
    const MeshLights& meshes() const noexcept { return meshes_; }
    /// Returns true if the key light was added, because the scene has no light of its own that would do.
    bool has_default() const noexcept { return has_default_; }
    /// Returns true if the scene has neither placed lights nor an environment, but emissive surfaces whose power is enough
    /// for it.
    bool relies_on_emitters() const noexcept { return relies_on_emitters_; }

    /// Returns true if scattered rays from `start` can contribute nothing that samples of lights do not.
    bool leaves_all_to_samples(Vec3d start, float peak, LightGroups groups) const noexcept;

    /// A scattered ray from where it starts, and the receiver for which lights were drawn there.
    struct Reach {
        Vec3d origin;
        Vec3f direction;
        float t_far;
    };
    struct Drawn {
        const Receiver& receiver;
        int draws;  ///< lights that were drawn at once
    };
    /// Calls use(const WorldLight&, const LightCrossing&, float expected) for every light with an extent that the ray meets,
    /// except for those that are left to their own samples where the ray starts. `expected` is the number of samples of the
    /// light that was to be expected for each light sample there: 1 for a light outside the tree.
    template <class Use>
    void for_crossings(const Reach& ray, float peak, const Drawn& at, Use&& use) const
    {
        const auto cross = [&](std::uint32_t i, auto&& expected) {
            const WorldLight& light = lights()[i];
            if (is_left_to_samples(light, ray.origin, peak)) return;
            const LightCrossing c = light.crossing(ray.origin, ray.direction);
            const bool is_before_end = c.distance < ray.t_far || std::isinf(ray.t_far);  // a sun is at infinity
            if (c.density > 0 && is_before_end) use(light, c, expected());
        };
        // Each of them is sampled: only where there are many suns are some left out, and a sun with a disc stands alone.
        for (const std::uint32_t i : placed_->with_extent) cross(i, [] { return 1.0f; });
        tree().for_crossed(ray.origin, ray.direction,
                           [&](std::uint32_t i) { cross(i, [&] { return tree().expected(i, at.receiver, at.draws); }); });
    }

private:
    void make_mesh_tree();

    KeptLights placed_;
    MeshLights meshes_;
    Environment environment_;
    bool has_default_ = false, relies_on_emitters_ = false;
};

}  // namespace occam::shade
