// The bounds of cages: the vertices that some face has count, at all keys of the shutter.
#include <algorithm>

#include "base/matrix.h"
#include "scenegraph/scene_state.h"

namespace occam {

Box3d box_of_used(const CageSlot& slot, std::span<const Vec3f> positions) noexcept
{
    Box3d box;
    std::size_t v = 0;
    const auto add_until = [&](std::size_t end) {
        for (; v < end; ++v) box.add(Vec3d(positions[v]));
    };
    for (const std::uint32_t unused : slot.unused_vertices) {
        add_until(unused);
        ++v;
    }
    add_until(positions.size());
    return box;
}

std::vector<std::uint32_t> find_unused_vertices(const Cage& cage)
{
    std::vector<bool> is_used(cage.positions.size());
    for (const std::uint32_t v : cage.face_vertices) is_used[v] = true;
    std::vector<std::uint32_t> unused;
    for (std::uint32_t v = 0; v < is_used.size(); ++v)
        if (!is_used[v]) unused.push_back(v);
    return unused;
}

void find_bounds(CageSlot& slot)
{
    // What needs memory comes first.
    auto deform = decltype(slot.deform)();
    auto deformed_poles = decltype(slot.deformed_poles)();
    if (slot.cage.skin.sets > 0 || !slot.cage.morph_targets.empty()) {
        deform.add_all(slot.cage, slot.unused_vertices);
        deformed_poles = DeformedPoles(slot.cage, slot.pole_faces);
    }
    slot.key_bounds.reserve(slot.key_positions.size());
    slot.bounds = grown_by_displacement(slot.cage, box_of_used(slot, slot.cage.positions));
    slot.key_bounds.clear();
    for (const std::vector<Vec3f>& positions : slot.key_positions) {
        slot.key_bounds.push_back(grown_by_displacement(slot.cage, box_of_used(slot, positions)));
        slot.bounds.add(slot.key_bounds.back());
    }
    slot.deform = std::move(deform);
    slot.deformed_poles = std::move(deformed_poles);
    find_poles(slot);
}

void find_poles(CageSlot& slot) noexcept
{
    slot.poles = slot.pole_faces.measure(slot.cage, slot.cage.positions);
    slot.pole_reach = slot.pole_faces.reach(slot.cage, slot.cage.positions);
    for (const std::vector<Vec3f>& positions : slot.key_positions) {
        slot.poles.add(slot.pole_faces.measure(slot.cage, positions));
        slot.pole_reach = glm::max(slot.pole_reach, slot.pole_faces.reach(slot.cage, positions));
    }
}

namespace {

/// What deforms a cage that a node shows, at a key of the shutter.
class Deformation {
public:
    Deformation(const Node& node, const CageSlot& slot, const SkinSlot* skin, std::size_t key) noexcept
        : is_skinned(skin && slot.cage.skin.sets > 0),
          weights(node.keys.empty() ? node.morph_weights : node.keys[key].morph_weights),
          node_from_skin_(node.keys.empty() ? node.node_from_skin : node.keys[key].node_from_skin)
    {
        if (weights.empty()) weights = slot.cage.morph_weights;
        if (is_skinned) poses_ = skin->key_poses.empty() ? skin->mesh_poses : skin->key_poses[key];
    }
    const bool is_skinned;
    std::span<const float> weights;

    /// Returns where a joint takes the mesh, in the node's axes.
    Mat4d operator()(std::size_t joint) const noexcept
    {
        return joint < poses_.size() ? node_from_skin_ * poses_[joint] : node_from_skin_;
    }

private:
    const Mat4d& node_from_skin_;
    std::span<const Mat4d> poses_;
};

std::size_t key_count(const Node& node, const CageSlot& slot, const SkinSlot* skin) noexcept
{
    const std::size_t of_skin = skin ? skin->key_poses.size() : 0;
    return std::max({node.keys.size(), of_skin, slot.key_bounds.size(), std::size_t(1)});
}

}  // namespace

Box3d cage_bounds(const Node& node, const CageSlot& slot, const SkinSlot* skin, std::size_t key) noexcept
{
    if (!slot.is_deformed()) return slot.key_bounds.empty() ? slot.bounds : slot.key_bounds[key];
    const Deformation deformation(node, slot, skin, key);
    DeformBounds deform = slot.deform[0];
    if (!deformation.is_skinned) deform.joints = {};
    return grown_by_displacement(slot.cage, deformed_box(deform, deformation.weights, Mat4d(1), deformation));
}

Box3d cage_bounds(const Node& node, const CageSlot& slot, const SkinSlot* skin) noexcept
{
    const std::size_t keys = key_count(node, slot, skin);
    Box3d box;
    for (std::size_t k = 0; k < keys; ++k) box.add(cage_bounds(node, slot, skin, k));
    return box;
}

Poles cage_poles(const Node& node, const CageSlot& slot, const SkinSlot* skin)
{
    if (!slot.is_deformed() || slot.pole_faces.is_empty()) return slot.poles;
    const std::size_t keys = key_count(node, slot, skin);
    Poles poles;
    for (std::size_t k = 0; k < keys; ++k) {
        const Deformation deformation(node, slot, skin, k);
        const std::span<const float> weights = deformation.weights;
        poles.add(deformation.is_skinned
                      ? slot.deformed_poles.skinned(weights, morph_extent(slot.deform[0].offsets, weights), deformation)
                      : slot.deformed_poles.morphed(slot.poles, weights));
    }
    return poles;
}

double longest_pole_edge(const Node& node, const CageSlot& slot, const SkinSlot* skin, const Mat3d& map)
{
    const double longest = cage_poles(node, slot, skin).longest_of_all() * largest_stretch(map);
    if (slot.is_deformed()) return longest;
    Vec3d reach(0);
    for (int axis = 0; axis < 3; ++axis) reach += glm::abs(map[axis]) * slot.pole_reach[axis];
    return std::min(longest, glm::length(reach));
}

}  // namespace occam
