#include "shade/frame_lights.h"

namespace occam::shade {
namespace {

// From over the camera's left shoulder; wide enough for soft shadows.
WorldLight key_light(const Camera& camera)
{
    WorldLight key;
    key.kind = WorldLight::Kind::Sun;
    key.direction = Vec3f(glm::normalize(transform_vector(camera.world_from_camera, Vec3d(0.5, -0.8, -0.6))));
    key.strength = Vec3f(1.6f, 1.5f, 1.35f);
    key.sun_spread = 0.05f;
    return key;
}

}  // namespace

FrameLights::FrameLights(const Scene& scene, const Camera& camera, const TextureStore& textures, Sky sky, float sky_strength)
    : meshes_(scene, textures), environment_(scene.environment, textures)
{
    scene.for_each_placement([&](NodeId, const Node& node, const Mat4d& world_from_node) {
        if (const Light* light = scene.find(node.light)) lights_.push_back(WorldLight::place(*light, world_from_node));
    });
    const bool is_dark = lights_.empty() && environment_.is_black() && !meshes_.any_emitter();
    if (sky == Sky::Auto && is_dark) lights_.push_back(key_light(camera));
    if (environment_.is_black() && (sky == Sky::On || (sky == Sky::Auto && is_dark)))
        environment_ = Environment::sky(sky_strength);
    list_areas();
}

FrameLights::FrameLights(std::vector<WorldLight> lights, Environment environment)
    : lights_(std::move(lights)), environment_(std::move(environment))
{
    list_areas();
}

bool FrameLights::leaves_all_to_samples(Vec3d start, float peak, LightGroups groups) const noexcept
{
    if (meshes_.any_emitter() || !environment_.is_black()) return false;
    for (const std::uint32_t i : with_area_)
        if ((lights_[i].groups & groups) != 0 && !is_left_to_samples(lights_[i], start, peak)) return false;
    return true;
}

void FrameLights::list_areas()
{
    for (std::uint32_t i = 0; i < lights_.size(); ++i)
        if (lights_[i].has_area()) with_area_.push_back(i);
}

}  // namespace occam::shade
