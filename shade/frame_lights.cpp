#include "shade/frame_lights.h"

#include <algorithm>

#include "base/error_without_file.h"
#include "scenegraph/contents.h"

namespace occam::shade {
namespace {

// Returns a light from over the camera's left shoulder that is wide enough for soft shadows.
WorldLight key_light(const Camera& camera)
{
    WorldLight key;
    key.kind = WorldLight::Kind::Sun;
    key.direction = Vec3f(glm::normalize(transform_vector(camera.world_from_camera, Vec3d(0.5, -0.8, -0.6))));
    key.strength = Vec3f(1.6f, 1.5f, 1.35f);
    key.sun_spread = 0.05f;
    return key;
}

// This irradiance decides whether emissive surfaces are lamps of the scene or merely glowing details: their light, spread
// evenly over the sphere around the scene, has to reach it. A white surface there would have a radiance of about 0.006,
// which is less than a hundredth of what the default light gives it.
constexpr double kLeastIrradiance = 0.02;

/// A frame in which a ray would cross more area lights than about this in one place is refused: each of them adds its light
/// to all rays that are scattered there.
constexpr double kMostCrossed = 512;

Box3d box_of(const WorldLight& light) noexcept
{
    const Vec3d half = light.kind == WorldLight::Kind::Sphere ? Vec3d(double(light.radius))
                                                              : Vec3d(glm::abs(light.half_x) + glm::abs(light.half_y));
    return {light.position - half, light.position + half};
}

// Returns false for a box whose corners are not numbers, or whose size would overflow.
bool is_within_numbers(const Box3d& box) noexcept { return glm::dot(box.lo, box.lo) + glm::dot(box.hi, box.hi) < 1e300; }

// Estimates as Contents::layers_in() does how many of the lights a ray crosses in the box of all, and in the boxes of ever
// smaller groups of neighbours.
void check_boxes(std::span<Box3d> lights)
{
    while (double(lights.size()) > kMostCrossed) {
        Box3d all;
        double sum = 0;
        for (const Box3d& light : lights) {
            all.add(light);
            sum += Contents::size_of(light);
        }
        if (sum > kMostCrossed * Contents::size_of(all))
            throw error_without_file("too many area lights lie in one place: a ray would cross about " +
                                     std::to_string(static_cast<int>(sum / Contents::size_of(all))) + " of them, and " +
                                     std::to_string(static_cast<int>(kMostCrossed)) + " is the limit");
        const Vec3d e = all.extent();
        const int axis = e.x >= e.y && e.x >= e.z ? 0 : e.y >= e.z ? 1 : 2;
        const auto middle = lights.begin() + static_cast<std::ptrdiff_t>(lights.size() / 2);
        std::nth_element(lights.begin(), middle, lights.end(),
                         [axis](const Box3d& a, const Box3d& b) { return a.centre()[axis] < b.centre()[axis]; });
        check_boxes({lights.begin(), middle});
        lights = {middle, lights.end()};
    }
}

void check_crossed(const std::vector<WorldLight>& lights)
{
    std::vector<Box3d> boxes;
    for (const WorldLight& light : lights)
        if (light.has_area() && is_within_numbers(box_of(light))) boxes.push_back(box_of(light));
    check_boxes(boxes);
}

bool are_lamps(const MeshLights& meshes, const Scene& scene, const FrameScale& scale) noexcept
{
    if (!(meshes.power() > 0)) return false;
    const Box3d& box = scene.node(scene.root()).bounds;
    if (box.is_empty()) return true;
    const Mat4d placed = scale.placed(scene.node(scene.root()).parent_from_node);
    const Vec3d half = 0.5 * Vec3d(transform_vector(placed, box.hi - box.lo));
    return meshes.power() >= kLeastIrradiance * 4 * glm::dot(half, half);
}

}  // namespace

Vec3d middle_of(const Scene& scene, const FrameScale& scale) noexcept
{
    const Node& root = scene.node(scene.root());
    const Vec3d middle = transform_box(scale.placed(root.parent_from_node), root.bounds).centre();
    const bool is_known = std::isfinite(middle.x) && std::isfinite(middle.y) && std::isfinite(middle.z);
    return is_known && !root.bounds.is_empty() ? middle : Vec3d(0);
}

FrameLights::FrameLights(const Scene& scene, const Camera& camera, const TextureStore& textures,
                         const DefaultLight& otherwise, const FrameScale& scale, KeptFrameLights* kept)
    : meshes_(scene, textures, scale), environment_(scene.environment, textures, kept ? &kept->environment : nullptr)
{
    LightGathering gathering(kept ? kept->placed : nullptr);
    const Vec3d middle = middle_of(scene, scale);
    const auto add = [&](NodeId, const Node& node, const Mat4d& world_from_node) {
        const Light* light = scene.find(node.light);
        if (!light) return;
        const WorldLight placed = WorldLight::place(*light, world_from_node, scale);
        if (placed.is_in_reach(middle)) gathering.add(placed);
    };
    scene.for_placements_of(Contents::Lights, add, Scene::Shown::MidShutter);
    const bool is_dark = environment_.is_black();
    const bool has_none = is_dark && gathering.is_empty();
    relies_on_emitters_ = has_none && are_lamps(meshes_, scene, scale);
    has_default_ = has_none && otherwise.sky != Sky::Off && otherwise.is_wanted.value_or(!relies_on_emitters_);
    if (has_default_) gathering.add(key_light(camera));
    if (is_dark && (otherwise.sky == Sky::On || has_default_)) environment_ = Environment::sky(otherwise.sky_strength);
    placed_ = gathering.finish(middle);
    if (!kept || placed_ != kept->placed) check_crossed(placed_->lights);
    if (kept) kept->placed = placed_;
    make_mesh_tree();
}

FrameLights::FrameLights(std::vector<WorldLight> lights, Environment environment)
    : placed_(std::make_shared<const PlacedLights>(std::move(lights))), environment_(std::move(environment))
{
    make_mesh_tree();
}

bool FrameLights::leaves_all_to_samples(Vec3d start, float peak, LightGroups groups) const noexcept
{
    if (meshes_.any_emitter() || !environment_.is_black()) return false;
    const auto is_found = [&](std::uint32_t i) {
        return (lights()[i].groups & groups) != 0 && !is_left_to_samples(lights()[i], start, peak);
    };
    return std::none_of(placed_->with_extent.begin(), placed_->with_extent.end(), is_found) &&
           !tree().any_covering(start, kLeastChance / (peak * maths::kPi), is_found);
}

void FrameLights::make_mesh_tree() { meshes_.make_tree(tree().is_empty() ? std::optional<Vec3d>() : tree().origin()); }

}  // namespace occam::shade
