// Writes the values of clips into nodes, and copies subtrees so that each copy has a pose of its own.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <unordered_set>

#include "base/error_without_file.h"
#include "scenegraph/content_rules.h"
#include "scenegraph/scene_state.h"

namespace occam {

struct Scene::State::PoseSum {
    Vec3d translation{0}, scale{0};
    Vec4d rotation{0};
    std::vector<double> weights;
    double of_translation = 0, of_scale = 0, of_rotation = 0, of_weights = 0;

    /// Returns false if a value is beyond the largest float.
    bool add(const Channel& channel, double seconds, double weight)
    {
        std::vector<double>& v = values;
        v.resize(static_cast<std::size_t>(channel.width));
        evaluate(channel, seconds, v);
        for (const double value : v)
            if (!(std::abs(value) <= double(std::numeric_limits<float>::max()))) return false;
        switch (channel.path) {
            case Channel::Path::Translation:
                add_vector(translation, of_translation, weight);
                break;
            case Channel::Path::Scale:
                add_vector(scale, of_scale, weight);
                break;
            case Channel::Path::Rotation: {
                Vec4d q(v[0], v[1], v[2], v[3]);
                if (glm::dot(q, rotation) < 0) q = -q;
                rotation += q * weight;
                of_rotation += weight;
                break;
            }
            case Channel::Path::Weights:
                weights.resize(std::max(weights.size(), v.size()), 0.0);
                for (std::size_t k = 0; k < v.size(); ++k) weights[k] += v[k] * weight;
                of_weights += weight;
        }
        return true;
    }

    bool has_weights() const noexcept { return of_weights > 0; }
    bool has_place() const noexcept { return of_translation + of_rotation + of_scale > 0; }
    /// Returns the mean of the values, and those of `rest` where there are none.
    Trs place(const Trs& rest) const noexcept
    {
        Trs place = rest;
        if (of_translation > 0) place.translation = translation / of_translation;
        if (of_scale > 0) place.scale = scale / of_scale;
        const double length = std::sqrt(glm::dot(rotation, rotation));
        if (of_rotation > 0 && length > 0) place.rotation = rotation / length;
        return place;
    }

private:
    void add_vector(Vec3d& to, double& sum, double weight)
    {
        to += Vec3d(values[0], values[1], values[2]) * weight;
        sum += weight;
    }
    std::vector<double> values;
};

namespace {

bool same(const Trs& a, const Trs& b)
{
    return a.translation == b.translation && a.rotation == b.rotation && a.scale == b.scale;
}

}  // namespace

void Scene::State::restore_place(NodeId id)
{
    NodeRecord* node = nodes.find(id);
    if (!node) return;
    about_to_pose(id, *node);
    if (!node->rest || !node->rest->place) return;
    Rest& rest = *node->rest;
    place(id, *node, rest.matrix ? *rest.matrix : rest.place->matrix());
    node->place = *rest.place;
    node->matrix = rest.matrix;
    rest.place.reset();
    if (!rest.weights) node->rest.reset();
}

void Scene::State::restore_weights(NodeId id)
{
    NodeRecord* node = nodes.find(id);
    if (!node) return;
    about_to_pose(id, *node);
    if (!node->rest || !node->rest->weights) return;
    if (node->morph_weights != *node->rest->weights) {
        about_to_change(id, *node);
        node->morph_weights = std::move(*node->rest->weights);
        mark_dirty(id);
    }
    node->rest->weights.reset();
    if (!node->rest->place) node->rest.reset();
}

void Scene::State::write_pose(NodeId id, const PoseSum& sum)
{
    NodeRecord& node = *nodes.find(id);
    about_to_pose(id, node);
    if (!node.rest) node.rest = std::make_unique<Rest>();
    if (sum.has_place()) {
        if (!node.rest->place) node.rest->place = node.place, node.rest->matrix = node.matrix;
        const Rest& rest = *node.rest;
        const Trs posed_place = sum.place(rest.matrix ? decomposed(*rest.matrix) : *rest.place);
        if (node.matrix || !same(posed_place, node.place)) {
            place(id, node, posed_place.matrix());
            node.place = posed_place;
            node.matrix.reset();
        }
    }
    if (sum.has_weights()) {
        if (!node.rest->weights) node.rest->weights = node.morph_weights;
        std::vector<float> weights;
        for (const double w : sum.weights) weights.push_back(static_cast<float>(w / sum.of_weights));
        if (weights != node.morph_weights) {
            about_to_change(id, node);
            node.morph_weights = std::move(weights);
            mark_dirty(id);
        }
    }
}

void Scene::State::write_poses(Posed& of, const std::vector<NodeId>& order, const std::unordered_map<NodeId, PoseSum>& sums)
{
    std::vector<NodeId> placed, weighted;
    for (const NodeId id : order) {
        if (sums.at(id).has_place()) placed.push_back(id);
        if (sums.at(id).has_weights()) weighted.push_back(id);
    }
    // If there is not enough memory for all of them, those that were moved are known, and the next call restores them.
    std::vector<NodeId> all_placed = of.placed, all_weighted = of.weighted;
    all_placed.insert(all_placed.end(), placed.begin(), placed.end());
    all_weighted.insert(all_weighted.end(), weighted.begin(), weighted.end());
    const std::vector<NodeId> placed_before = std::exchange(of.placed, std::move(all_placed));
    const std::vector<NodeId> weighted_before = std::exchange(of.weighted, std::move(all_weighted));
    for (const NodeId id : placed_before)
        if (const auto sum = sums.find(id); sum == sums.end() || !sum->second.has_place()) restore_place(id);
    for (const NodeId id : weighted_before)
        if (const auto sum = sums.find(id); sum == sums.end() || !sum->second.has_weights()) restore_weights(id);
    for (const NodeId id : order) write_pose(id, sums.at(id));
    of.placed = std::move(placed);
    of.weighted = std::move(weighted);
}

void Scene::pose(std::span<const ClipAt> clips, NodeId of)
{
    State& s = *state_;
    s.require_editable();
    if (of && !s.posed.contains(of))
        throw error_without_file("only what copy() or add() made has a pose of its own", naming("node", node(of).name));
    for (const ClipAt& at : clips) {
        State::at(s.clips, at.clip, "clip");
        if (!std::isfinite(at.seconds) || !(at.weight >= 0) || !std::isfinite(at.weight))
            throw error_without_file("a clip needs finite seconds and a weight of 0 or more",
                                     naming("clip", clip(at.clip).name));
    }
    // Weights whose sums could overflow count by a smaller unit.
    const bool are_large = std::any_of(clips.begin(), clips.end(), [](const ClipAt& at) { return at.weight > 1e200; });
    const auto weight_of = [&](const ClipAt& at) {
        return are_large ? std::max(at.weight * 1e-200, std::numeric_limits<double>::min()) : at.weight;
    };
    State::Posed& posed = s.posed[of];
    std::vector<NodeId> order;
    std::unordered_map<NodeId, State::PoseSum> sums;
    for (const ClipAt& at : clips)
        for (const Channel& channel : clip(at.clip).channels) {
            NodeId target = channel.target;
            if (of) {
                const auto found = posed.node_of.find(target);
                if (found == posed.node_of.end()) continue;
                target = found->second;
            }
            if (!(at.weight > 0) || channel.times.empty() || !s.nodes.find(target)) continue;
            const auto [entry, is_new] = sums.try_emplace(target);
            if (is_new) order.push_back(target);
            if (!entry->second.add(channel, at.seconds, weight_of(at)))
                throw error_without_file("a clip's value is beyond the largest float", naming("clip", clip(at.clip).name));
        }
    s.write_poses(posed, order, sums);
}

void Scene::pose(ClipId id, double seconds)
{
    const ClipAt at{id, seconds};
    pose({&at, 1});
}

NodeDesc Scene::State::desc_of_copy(NodeId original) const
{
    const NodeRecord& from = *nodes.find(original);
    NodeDesc desc = from;
    desc.instance_of = {};
    desc.skin = {};
    std::erase_if(desc.cages, [&](CageId id) { return !cages.find(id); });
    if (!lights.find(desc.light)) desc.light = {};
    if (!cameras.find(desc.camera)) desc.camera = {};
    // The current pose is not part of a copy's rest values.
    if (from.rest && from.rest->place) desc.place = *from.rest->place, desc.matrix = from.rest->matrix;
    if (from.rest && from.rest->weights) desc.morph_weights = *from.rest->weights;
    return desc;
}

// What the subtree itself shows by an instance within it is copied, too, so only what lies outside can show the copy.
std::vector<NodeId> Scene::State::subtree_to_copy(NodeId subtree, NodeId parent) const
{
    std::vector<NodeId> found{subtree};
    for (std::size_t i = 0; i < found.size(); ++i) {
        const Node& from = *nodes.find(found[i]);
        std::copy_if(from.children.begin(), from.children.end(), std::back_inserter(found),
                     [](NodeId child) { return bool(child); });
    }
    std::unordered_set<NodeId> is_fine(found.begin(), found.end());
    for (const NodeId id : found) {
        const Node& from = *nodes.find(id);
        if (!nodes.find(from.instance_of) || !is_fine.insert(from.instance_of).second) continue;
        if (is_shown_by(parent, from.instance_of)) throw shows_itself(from.name);
    }
    return found;
}

Scene::State::Posed Scene::State::copy_within(const Posed& original, const Posed& copy,
                                              const std::unordered_map<SkinId, SkinId>& skin_of) const
{
    Posed within;
    for (const auto& [from, to] : original.node_of)
        if (const auto counterpart = copy.node_of.find(to); counterpart != copy.node_of.end())
            within.node_of[from] = counterpart->second;
    for (const SkinId skin : original.skins)
        if (const auto made = skin_of.find(skin); made != skin_of.end() && made->second != skin)
            within.skins.push_back(made->second);
    return within;
}

NodeId Scene::copy(NodeId subtree, NodeId parent)
{
    State& s = *state_;
    s.require_unrecorded();
    State::at(s.nodes, subtree, "node");
    State::at(s.nodes, parent, "node");
    if (s.lowest_common(subtree, parent) == subtree)
        throw error_without_file("a subtree cannot be copied into itself", naming("node", node(subtree).name));
    const std::vector<NodeId> originals = s.subtree_to_copy(subtree, parent);

    State::Posed copy;
    Rollback copied([&] {
        for (const SkinId skin : copy.skins) s.skins.remove(skin);
        if (const auto made = copy.node_of.find(subtree); made != copy.node_of.end() && made->second) remove(made->second);
    });
    for (std::size_t i = 0; i < originals.size(); ++i) {
        const Node& from = node(originals[i]);
        const NodeId above = i == 0 ? parent : copy.node_of.at(from.parent);
        NodeId& made = copy.node_of[originals[i]];
        made = add_node(above, s.desc_of_copy(originals[i]));
    }
    std::unordered_map<SkinId, SkinId> skin_of;
    for (const NodeId original : originals) {
        const Node from = node(original);
        const NodeId to = copy.node_of.at(original);
        const auto counterpart = [&](NodeId id) {
            const auto found = copy.node_of.find(id);
            return found == copy.node_of.end() ? id : found->second;
        };
        if (s.nodes.find(from.instance_of)) s.show_instance(to, counterpart(from.instance_of));
        if (!s.skins.find(from.skin)) continue;
        const auto [entry, is_new] = skin_of.try_emplace(from.skin, from.skin);
        if (is_new) {
            Skin skin = this->skin(from.skin);
            for (NodeId& joint : skin.joints) joint = counterpart(joint);
            if (skin.joints != this->skin(from.skin).joints) {
                SkinId& made = copy.skins.emplace_back();
                made = entry->second = s.add_skin(std::move(skin));
            }
        }
        set_skin(to, entry->second);
    }
    // The clips name the first originals. If one of them is copied too, its own counterpart is the one they move.
    for (const NodeId original : originals) {
        const NodeId first = s.nodes.find(original)->first_original, to = copy.node_of.at(original);
        s.nodes.find(to)->first_original = first ? first : original;
        if (first) copy.node_of.try_emplace(first, to);
    }
    for (const NodeId original : originals)
        if (original != subtree && s.posed.contains(original))
            s.posed[copy.node_of.at(original)] = s.copy_within(s.posed.at(original), copy, skin_of);
    const NodeId made = copy.node_of.at(subtree);
    s.posed[made] = std::move(copy);
    copied.keep();
    return made;
}

std::vector<ClipId> Scene::clips_together() const
{
    std::unordered_set<NodeId> moved;
    std::vector<ClipId> together;
    for (const ClipId id : clips()) {
        const std::vector<Channel>& channels = clip(id).channels;
        const auto is_free = [&](const Channel& channel) { return !moved.contains(channel.target); };
        const bool fits = !channels.empty() && std::all_of(channels.begin(), channels.end(), is_free);
        if (!fits && !together.empty()) continue;
        together.push_back(id);
        for (const Channel& channel : channels) moved.insert(channel.target);
    }
    return together;
}

ClipId Scene::find_clip(std::string_view name) const
{
    for (const ClipId id : state_->clip_order)
        if (clip(id).name == name) return id;
    return {};
}

const Clip* Scene::find(ClipId id) const noexcept { return state_->clips.find(id); }

}  // namespace occam
