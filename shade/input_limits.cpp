#include "shade/input_limits.h"

#include <algorithm>
#include <set>
#include <unordered_set>
#include <variant>

#include "base/overloaded.h"
#include "io/texture/texture_store.h"
#include "scenegraph/far_places.h"
#include "scenegraph/material_limits.h"
#include "scenegraph/shown_nodes.h"
#include "shade/frame_lights.h"

namespace occam::shade {
namespace {

bool is_beyond(Vec3f c) noexcept { return limited(c) != c; }

bool is_beyond(const Light& light, const FrameScale& scale) noexcept
{
    const auto is_kind_beyond = Overloaded{
        [&](const PointLight& point) {
            return is_beyond(Vec3f(Vec3d(point.intensity) * (scale.to_frame() * scale.to_frame())));
        },
        [](const SunLight& sun) { return is_beyond(sun.irradiance); },
        [](const AreaLight& area) { return is_beyond(area.radiance); }};
    return std::visit(is_kind_beyond, light.kind);
}

// A strength within the limit may be multiplied by a texel of up to 65504.
bool is_beyond(Vec3f strength, const TextureUse& image, const TextureStore& textures) noexcept
{
    return is_beyond(strength) || is_beyond(strength * textures.brightest(image));
}

// Returns true if a surface would reflect more light than it receives. The colour of an unlit material is not limited.
bool is_too_white(const Material& m) noexcept { return !m.unlit && !has_base_color_within_limits(m); }

// Counts the placed lights that the frame leaves out.
std::size_t lights_out_of_reach(const Scene& scene, const FrameScale& scale)
{
    std::size_t count = 0;
    const Vec3d middle = middle_of(scene, scale);
    const auto look = [&](NodeId, const Node& node, const Mat4d& world_from_node) {
        const Light* light = scene.find(node.light);
        if (light && !WorldLight::place(*light, world_from_node, scale).is_in_reach(middle)) ++count;
    };
    scene.for_placements_of(Contents::Lights, look, Scene::Shown::MidShutter);
    return count;
}

// Counts the nodes that reach beyond the largest coordinate at a key of the shutter, though not in their pose.
std::size_t nodes_that_leave(const Scene& scene)
{
    std::size_t count = 0;
    for_each_shown_node(scene, Contents::Moving, [&](NodeId, const Node& node) {
        const auto is_far = [&](const Mat4d& parent_from_node) {
            const Box3d box = transform_box(parent_from_node, node.bounds);
            return !box.is_empty() && !(box.largest_coordinate() <= double(kMaxCoordinate));
        };
        count += !is_far(node.parent_from_node) &&
                 std::ranges::any_of(node.keys, [&](const NodeKey& key) { return is_far(key.parent_from_node); });
    });
    return count;
}

// Counts the nodes that lie too far away, in the pose that the scene is in.
struct FarNodes {
    std::size_t hiding = 0;  ///< those beside which all others vanish
    std::size_t lost = 0;    ///< those whose place in the world is not finite

    /// Visits nothing unless the bounds of the scene reach beyond the largest coordinate.
    explicit FarNodes(const Scene& scene)
    {
        // Instances of instances may be more than can be visited.
        constexpr std::size_t kMostLookedAt = std::size_t(1) << 20;
        const Box3d all = box_in_parent(scene.node(scene.root()));
        if (all.is_empty() || all.largest_coordinate() <= double(kMaxCoordinate)) return;
        FarPlaces places;
        std::size_t looked_at = 0, far = 0;
        scene.for_each_placement([&](NodeId, const Node& node, const Mat4d& world_from_node) {
            if (++looked_at > kMostLookedAt) return false;
            Box3d own;
            for (const CageId id : node.cages)
                if (const CageSlot* slot = scene.find(id)) own.add(cage_bounds(node, *slot, scene.find(node.skin)));
            if (own.is_empty()) return true;
            const FarPlaces::Place place = places.add(transform_box(world_from_node, own));
            far += place == FarPlaces::Place::Far;
            lost += place == FarPlaces::Place::Lost;
            return true;
        });
        if (places.hide_near()) hiding = far;
    }
};

}  // namespace

std::vector<std::string> input_warnings(const Scene& scene, const TextureStore& textures, float sky_strength,
                                        const FrameScale& scale)
{
    std::set<const Material*> materials;
    std::set<const Light*> lights;
    const auto look = [&](const std::vector<MaterialId>& ids) {
        for (const MaterialId id : ids)
            if (const Material* m = scene.find(id)) materials.insert(m);
    };
    std::unordered_set<CageId> cages;  // those that were looked at: many nodes may show one of many materials
    constexpr Contents::Kinds kKinds = Contents::OverLimit | Contents::Emitters | Contents::Lights;
    for_each_shown_node(scene, kKinds, [&](NodeId, const Node& node) {
        look(node.materials);
        for (const CageId id : node.cages)
            if (const CageSlot* slot = scene.find(id); slot && cages.insert(id).second) look(slot->cage.materials);
        if (const Light* light = scene.find(node.light)) lights.insert(light);
    });
    const auto too_white = std::count_if(materials.begin(), materials.end(),
                                         [](const Material* m) { return is_too_white(*m); });
    const auto too_large = std::count_if(materials.begin(), materials.end(),
                                         [](const Material* m) { return !has_factors_within_limits(*m); });
    const auto too_far = std::count_if(materials.begin(), materials.end(),
                                       [](const Material* m) { return !has_transforms_within_limits(*m); });
    const auto glows_too_much = [&](const Material* m) { return is_beyond(m->emission, m->emission_texture, textures); };
    TextureUse sky;
    sky.texture = scene.environment.image;
    const auto too_bright = std::count_if(materials.begin(), materials.end(), glows_too_much) +
                            std::count_if(lights.begin(), lights.end(),
                                          [&](const Light* l) { return is_beyond(*l, scale); }) +
                            is_beyond(scene.environment.radiance, sky, textures) + is_beyond(Vec3f(sky_strength));
    std::vector<std::string> lines;
    if (too_white > 0)
        lines.push_back("materials whose base colour is above 1, which reflect as if it were 1: " +
                        std::to_string(too_white));
    if (too_large > 0)
        lines.push_back(
            "materials with an alpha, a reflectance or a colour of sheen or attenuation above 1, an index of refraction "
            "above 100 or a scale of a normal map above 10000, which were clamped: " +
            std::to_string(too_large));
    if (too_far > 0)
        lines.push_back(
            "materials with numbers above 1e6 in the transform of a texture, which tell no texel from another: " +
            std::to_string(too_far));
    if (too_bright > 0)
        lines.push_back(
            "lights, environments and emissions that are not a number or brighter than 1e12, which were clamped: " +
            std::to_string(too_bright));
    if (const std::size_t far = lights_out_of_reach(scene, scale); far > 0)
        lines.push_back("lights that are farther away than 1e15 times the size of the scene, which were left out: " +
                        std::to_string(far));
    if (const std::size_t leave = nodes_that_leave(scene); leave > 0)
        lines.push_back(
            "nodes that reach beyond 1e16 while the shutter is open, beside which the rest of the scene may vanish: " +
            std::to_string(leave));
    const FarNodes far(scene);
    if (far.hiding > 0)
        lines.push_back("nodes that reach beyond 1e16, beside which the rest of the scene vanishes: " +
                        std::to_string(far.hiding));
    if (far.lost > 0)
        lines.push_back("nodes whose place in the world is not finite, which are not seen: " + std::to_string(far.lost));
    return lines;
}

}  // namespace occam::shade
