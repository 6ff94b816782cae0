// What subtrees hold: how it is summed up, and how what is looked for is found by it.
#include <algorithm>
#include <cstdio>
#include <limits>
#include <string>
#include <unordered_map>
#include <vector>

#include "base/cancellation.h"
#include "base/error_without_file.h"
#include "scenegraph/child_boxes.h"
#include "scenegraph/content_rules.h"
#include "scenegraph/material_limits.h"
#include "scenegraph/scene_state.h"
#include "scenegraph/shown_nodes.h"

namespace occam {

namespace {

// Returns whether a part of the light may pass straight on, beside the holes of an alpha mask.
bool blends_or_is_clear(const Material& m) noexcept
{
    const bool may_be_clear = m.roughness < kClearRoughness || m.metallic_roughness_texture || m.roughness_texture ||
                              m.glossiness_texture;
    return m.alpha_mode == AlphaMode::Blend || (m.transmission > 0 && may_be_clear) || is_straight_body(m);
}

bool bounds_absorbing_body(const Material& m) noexcept
{
    const Vec3f c = m.attenuation_color;
    const bool is_body = m.transmission > 0 && m.thickness > 0 && m.ior >= 1 - kLeastBend;
    const bool is_finite = m.attenuation_distance > 0 && m.attenuation_distance < std::numeric_limits<float>::infinity();
    return is_body && is_finite && (c.x < 1 || c.y < 1 || c.z < 1);
}

std::size_t targets_with_weight(const Cage& cage, const std::vector<float>& weights) noexcept
{
    const std::vector<float>& all = weights.empty() ? cage.morph_weights : weights;
    std::size_t targets = 0;
    for (std::size_t k = 0; k < std::min(all.size(), cage.morph_targets.size()); ++k)
        targets += all[k] != 0 && !cage.morph_targets[k].positions.empty();
    return targets;
}

// Returns Contents::pose_terms for a node that shows the cage, with its keys.
double pose_terms_of(const Cage& cage, const Node& node, const SkinSlot* skin) noexcept
{
    if (cage.morph_targets.empty() && cage.skin.sets == 0) return 0;
    const std::size_t of_joints = skin ? std::size_t(4) * static_cast<std::size_t>(cage.skin.sets) : 0;
    // A node that moves, or that one above it moves, has the same offsets at all keys.
    const auto weighs_otherwise = [](const NodeKey& a, const NodeKey& b) { return a.morph_weights != b.morph_weights; };
    const bool weights_change = !cage.morph_targets.empty() &&
                                std::adjacent_find(node.keys.begin(), node.keys.end(), weighs_otherwise) != node.keys.end();
    const std::size_t poses = of_joints > 0 && skin && !skin->key_poses.empty() ? skin->key_poses.size()
                              : weights_change                                  ? node.keys.size()
                                                                                : 1;
    double terms = double(poses) * double(of_joints);
    if (weights_change) {
        for (const NodeKey& key : node.keys) terms += double(targets_with_weight(cage, key.morph_weights));
    } else {
        const std::vector<float>& weights = node.keys.empty() ? node.morph_weights : node.keys.front().morph_weights;
        terms += double(poses) * double(targets_with_weight(cage, weights));
    }
    return terms * double(cage.positions.size());
}

}  // namespace

bool is_straight_body(const Material& m) noexcept
{
    return m.transmission > 0 && m.thickness > 0 && m.ior >= 1 - kLeastBend && m.ior <= 1 + kLeastBend;
}

bool may_pass(const Material& m) noexcept { return m.alpha_mode == AlphaMode::Mask || blends_or_is_clear(m); }

Contents::Kinds kinds_of(const Material& m) noexcept
{
    const bool is_within = has_base_color_within_limits(m) && has_factors_within_limits(m) &&
                           has_transforms_within_limits(m);
    return static_cast<Contents::Kinds>(
        (m.emission != Vec3f(0) ? Contents::Emitters : 0) | (blends_or_is_clear(m) ? Contents::Passing : 0) |
        (m.alpha_mode == AlphaMode::Mask ? Contents::Masked : 0) | (is_within ? 0 : Contents::OverLimit) |
        (bounds_absorbing_body(m) ? Contents::Absorbing : 0));
}

std::shared_ptr<const Texture> Scene::share(TextureId id) const noexcept
{
    const State::TextureRecord* known = state_->textures.find(id);
    return known ? known->texture : nullptr;
}

bool Scene::is_cut_out_by(TextureId id) const noexcept
{
    const State::TextureRecord* texture = state_->textures.find(id);
    if (!texture || environment.image == id) return false;
    bool is_cut_out = false;
    for (const MaterialId user : texture->materials.ids()) {
        const Material* m = find(user);
        if (!m) continue;
        const bool cuts = m->alpha_mode == AlphaMode::Blend || (m->alpha_mode == AlphaMode::Mask && m->alpha_cutoff > 0);
        for (const TextureUse* use : texture_uses(*m)) {
            if (use->texture != id) continue;
            if (!cuts || use != &m->base_color_texture) return false;
            is_cut_out = true;
        }
    }
    const auto displaces = [&](CageId user) {
        const CageSlot* slot = find(user);
        return slot && slot->cage.displacement && slot->cage.displacement->texture.texture == id;
    };
    const std::vector<CageId>& cages = texture->cages.ids();
    return is_cut_out && std::none_of(cages.begin(), cages.end(), displaces);
}

void Scene::State::take_contents(CageId id, CageRecord& record)
{
    const Cage& cage = record.cage;
    Contents contents;
    if (cage.is_displaced()) contents.kinds |= Contents::Displaced;
    if (record.is_on_demand() || cage.scheme != Scheme::Triangles) contents.kinds |= Contents::Subdivided;
    contents.largest_face = record.largest_face;
    contents.derived_points = record.derived_points * (cage.is_displaced() ? 2 : 1);
    if (record.is_deformed()) contents.deformed_vertices = static_cast<std::uint32_t>(cage.positions.size());
    record.id = id;
    record.contents = contents;
    record.layers = FaceLayers(cage);
    sum_up_materials(record);
    const auto is_alive = [&](CageId known) { return cages.find(known) != nullptr; };
    for (const MaterialId material : cage.materials)
        if (MaterialRecord* known = materials.find(material)) known->cages.add(id, is_alive);
    if (!cage.displacement) return;
    if (TextureRecord* known = textures.find(cage.displacement->texture.texture)) known->cages.add(id, is_alive);
}

void Scene::State::watch_textures(MaterialId id, const Material& material)
{
    const auto is_alive = [&](MaterialId known) { return materials.find(known) != nullptr; };
    for (const TextureUse* use : texture_uses(material))
        if (TextureRecord* known = textures.find(use->texture)) known->materials.add(id, is_alive);
}

void Scene::State::watch_contents(NodeId id, const NodeRecord& node)
{
    const auto is_alive = [&](NodeId known) { return nodes.find(known) != nullptr; };
    for (const CageId cage : node.cages)
        if (CageRecord* known = cages.find(cage)) known->users.add(id, is_alive);
    if (LightRecord* light = lights.find(node.light)) light->users.add(id, is_alive);
    if (CameraRecord* camera = cameras.find(node.camera)) camera->users.add(id, is_alive);
    for (const MaterialId material : node.materials)
        if (MaterialRecord* known = materials.find(material)) known->users.add(id, is_alive);
}

void Scene::State::mark_users_dirty(MaterialRecord& material) noexcept
{
    const auto is_among = [&](const std::vector<MaterialId>& list) {
        return std::any_of(list.begin(), list.end(), [&](MaterialId id) { return materials.find(id) == &material; });
    };
    const auto overrides_by_it = [&](NodeId id) { return nodes.find(id) && is_among(nodes.find(id)->materials); };
    const auto has_it = [&](CageId id) { return cages.find(id) && is_among(cages.find(id)->cage.materials); };
    for (const NodeId user : material.users.those_that(overrides_by_it)) mark_dirty(user);
    for (const CageId id : material.cages.those_that(has_it)) {
        sum_up_materials(*cages.find(id));
        mark_users_dirty(*cages.find(id));
    }
}

Contents::Kinds Scene::State::kinds_of_all(const std::vector<MaterialId>& list) const noexcept
{
    note_looked_at(list.size());
    Contents::Kinds kinds = 0;
    for (const MaterialId id : list)
        if (const Material* m = materials.find(id)) kinds |= kinds_of(*m);
    return kinds;
}

FaceLayers::Passing Scene::State::passing_faces(const CageRecord& cage, const std::vector<MaterialId>& shown) const noexcept
{
    note_looked_at(shown.size());
    const auto passes = [&](const MaterialId& id) {
        const Material* m = materials.find(id);
        return m && (kinds_of(*m) & Contents::Passing) != 0;
    };
    // Nobody knows which slots the faces of a cage on demand have, nor how large they are.
    if (cage.is_on_demand())
        return std::any_of(shown.begin(), shown.end(), passes)
                   ? FaceLayers::Passing{cage.layers.all.held, Contents::area_of(cage.bounds)}
                   : FaceLayers::Passing();
    return cage.layers.of_those(shown.size(), [&](std::size_t slot) { return passes(shown[slot]); });
}

void Scene::State::sum_up_materials(CageRecord& cage) const noexcept
{
    cage.material_kinds = kinds_of_all(cage.cage.materials);
    cage.passing = (cage.material_kinds & Contents::Passing) != 0 ? passing_faces(cage, cage.cage.materials)
                                                                  : FaceLayers::Passing();
}

void Scene::State::count_faces(const CageRecord& record, int sign) noexcept
{
    const std::size_t count = record.cage.face_count();
    faces = sign > 0 ? faces + count : faces - count;
    if (record.cage.scheme == Scheme::Triangles) mesh_triangles = sign > 0 ? mesh_triangles + count : mesh_triangles - count;
}

Contents Scene::State::own_contents(const NodeRecord& node) const noexcept
{
    Contents contents;
    if (lights.find(node.light)) contents.kinds |= Contents::Lights;
    const SkinRecord* skin = skins.find(node.skin);
    if (!node.keys.empty() || (skin && !skin->key_poses.empty())) contents.kinds |= Contents::Moving;
    const Contents::Kinds own_kinds = kinds_of_all(node.materials);
    for (const CageId id : node.cages) {
        const CageRecord* cage = cages.find(id);
        if (!cage) continue;
        contents.add(cage->contents);
        contents.kinds |= node.materials.empty() ? cage->material_kinds : own_kinds;
        contents.pose_terms += pose_terms_of(cage->cage, node, skin);
        if (!cage->key_positions.empty()) {
            contents.kinds |= Contents::Moving;
            contents.written_faces = std::max(contents.written_faces, static_cast<std::uint32_t>(cage->cage.face_count()));
        }
        if (skin) contents.joints = std::max(contents.joints, static_cast<std::uint32_t>(skin->skin.joints.size()));
    }
    contents.levels = 1;
    contents.widest = static_cast<std::uint32_t>(ChildBoxes::most_at_once(node.children.size()) + node.cages.size() + 1);
    return contents;
}

std::string naming(const Node& node) { return node.name.empty() ? "a node without a name" : naming("node", node.name); }

Error too_many_placements(const Node& node)
{
    return error_without_file(
        "nodes are placed more than " + std::to_string(kMostListed) + " times, by instances of instances", naming(node));
}

namespace {

/// Returns the node that a refusal names: the innermost of those at fault is that with the smallest excess, and one with a
/// name is better.
/// has_too_many   whether the node is at fault
/// most           the largest figure in its subtree
template <class HasTooMany, class Most>
const Node& node_at_fault(const Scene& scene, const HasTooMany& has_too_many, const Most& most)
{
    const Node* worst = &scene.node(scene.root());
    for_each_shown_node(scene, 0, [&](NodeId, const Node& node) {
        if (!has_too_many(node) || (node.name.empty() && !worst->name.empty())) return;
        const bool is_first_name = worst->name.empty() && !node.name.empty();
        if (is_first_name || most(node) < most(*worst)) worst = &node;
    });
    return *worst;
}

std::string figure(double number)
{
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", number);
    return text;
}

/// A limit on the surfaces that rays may have to meet in a node.
struct LayerLimit {
    double (Contents::*in)(const Box3d&) const noexcept;  ///< what is limited, of a node with a box
    double Contents::*largest;                            ///< the largest of it among the nodes below
    double most;
    const char *before, *after;  ///< what a refusal says before and after the figure
};

constexpr LayerLimit kLayerLimits[] = {
    {&Contents::layers_in, &Contents::most_layers, kMostLayers,
     "too many surfaces lie in one place: a ray would have to meet about ", " of them"},
    {&Contents::depth_in, &Contents::most_depth, kMostDepth,
     "too many surfaces that light passes overlap: behind each of them a ray would have to look at about ", " others"},
    {&Contents::passed_in, &Contents::most_passed, kMostPassed,
     "too many surfaces that light passes lie one behind the other: a ray would have to pass about ", " of them"},
};

}  // namespace

void check_layers(const Scene& scene)
{
    const Contents& all = scene.node(scene.root()).contents;
    for (const LayerLimit& limit : kLayerLimits) {
        if (!(all.*limit.largest > limit.most)) continue;
        const Node& worst = node_at_fault(
            scene, [&](const Node& n) { return (n.contents.*limit.in)(n.bounds) > limit.most; },
            [&](const Node& n) { return n.contents.*limit.largest; });
        throw error_without_file(limit.before + figure(worst.contents.*limit.largest) + limit.after + ", and " +
                                     std::to_string(static_cast<int>(limit.most)) + " is the limit",
                                 naming(worst));
    }
    if (all.pose_terms > kMostPoseTerms) {
        const auto terms = [](const Node& n) { return n.contents.pose_terms; };
        const Node& worst = node_at_fault(
            scene, [&](const Node& n) { return terms(n) > kMostPoseTerms; }, terms);
        throw error_without_file(
            "morph targets or joints would move vertices too often: the frame would have to add up about " +
                figure(terms(worst)) + " offsets and shares of joints, and " + figure(kMostPoseTerms) + " is the limit",
            naming(worst));
    }
}

Contents Scene::contents() const
{
    const Node& top = *state_->nodes.find(state_->root);
    if (!top.dirty) return top.is_visible_in_shutter() ? top.contents : Contents();
    Contents all;
    std::unordered_map<NodeId, std::uint32_t> levels;
    for_each_shown_node_bottom_up(*this, [&](NodeId id, const Node& node) {
        all.add(state_->own_contents(*state_->nodes.find(id)));
        std::uint32_t below = 0;
        for_each_shown_below(*this, node, [&](NodeId part) { below = std::max(below, levels.at(part)); });
        all.levels = std::max(all.levels, levels[id] = below + 1);
    });
    return all;
}

const ChildBoxes* Scene::child_boxes(NodeId id) const noexcept
{
    const State::NodeRecord* node = state_->nodes.find(id);
    return node ? node->child_boxes.get() : nullptr;
}

std::size_t Scene::child_count(NodeId id) const
{
    const State::NodeRecord& node = State::at(state_->nodes, id, "node");
    return node.children.size() - node.removed_children;
}

void Scene::for_placements_of(Contents::Kinds kinds, const VisitPlacement& visit, Shown shown) const
{
    const State& s = *state_;
    const Holders holders(*this);
    std::size_t visits = 0;
    struct Place {
        NodeId id;
        Mat4d world_from_node;
    };
    std::vector<Place> todo;
    const auto is_visible = [&](const Node& node) {
        return shown == Shown::MidShutter ? node.visible : node.is_visible_in_shutter();
    };
    const auto push = [&](NodeId id, const Mat4d& above, bool is_instance) {
        const Node* node = s.nodes.find(id);
        if (!node || !holders.may_hold(*node, kinds) || !(is_instance || is_visible(*node))) return;
        todo.push_back({id, is_instance ? above : above * node->parent_from_node});
    };
    push(s.root, Mat4d(1), false);
    while (!todo.empty()) {
        const Place place = todo.back();
        todo.pop_back();
        const State::NodeRecord& node = *s.nodes.find(place.id);
        throw_if_cancelled();
        if (++visits > kMostListed) throw too_many_placements(node);
        if (s.own_contents(node).has(kinds)) visit(place.id, node, place.world_from_node);
        // As in for_each_placement(): what an instance shows comes before the children, and these in their order.
        const auto first = static_cast<std::ptrdiff_t>(todo.size());
        holders.for_each_child(place.id, kinds, [&](NodeId child) { push(child, place.world_from_node, false); });
        std::reverse(todo.begin() + first, todo.end());
        if (node.instance_of) push(node.instance_of, place.world_from_node, true);
    }
}

}  // namespace occam
