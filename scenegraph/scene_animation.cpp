// Writes the values of clips into nodes, and copies subtrees so that each copy has a pose of its own.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <unordered_set>

#include "base/error_without_file.h"
#include "scenegraph/scene_state.h"

namespace occam {
namespace {

// Holds the weighted sums of the values that clips give to one node.
struct Sum {
    Vec3d translation{0}, scale{0};
    Vec4d rotation{0};
    std::vector<double> weights;
    double of_translation = 0, of_scale = 0, of_rotation = 0, of_weights = 0;

    void add(const Channel& channel, double seconds, double weight)
    {
        std::vector<double>& v = values;
        v.resize(static_cast<std::size_t>(channel.width));
        evaluate(channel, seconds, v);
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
    }

private:
    void add_vector(Vec3d& to, double& sum, double weight)
    {
        to += Vec3d(values[0], values[1], values[2]) * weight;
        sum += weight;
    }
    std::vector<double> values;
};

bool same(const Trs& a, const Trs& b)
{
    return a.translation == b.translation && a.rotation == b.rotation && a.scale == b.scale;
}

}  // namespace

void Scene::State::restore(NodeRecord& node, NodeId id)
{
    if (!node.rest) return;
    const Rest rest = std::move(*node.rest);
    node.rest.reset();
    if (rest.place) {
        node.place = *rest.place;
        node.matrix = rest.matrix;
        place(id, node, rest.matrix ? *rest.matrix : rest.place->matrix());
    }
    if (rest.weights && node.morph_weights != *rest.weights) {
        about_to_change(id, node);
        node.morph_weights = *rest.weights;
        mark_dirty(id);
    }
}

void Scene::pose(std::span<const ClipAt> clips, NodeId of)
{
    State& s = *state_;
    s.require_editable();
    if (of && !s.posed.contains(of)) throw error_without_file("only what copy() made has a pose of its own", node(of).name);
    for (const ClipAt& at : clips) {
        State::at(s.clips, at.clip, "clip");
        if (!std::isfinite(at.seconds) || !(at.weight >= 0) || !std::isfinite(at.weight))
            throw error_without_file("a clip needs finite seconds and a weight of 0 or more", clip(at.clip).name);
    }
    State::Posed& posed = s.posed[of];
    std::vector<NodeId> order;
    std::unordered_map<NodeId, Sum> sums;
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
            entry->second.add(channel, at.seconds, at.weight);
        }

    for (const NodeId id : posed.nodes)
        if (State::NodeRecord* node = s.nodes.find(id); node && !sums.contains(id)) {
            s.about_to_pose(id, *node);
            s.restore(*node, id);
        }
    for (const NodeId id : order) {
        State::NodeRecord& node = *s.nodes.find(id);
        s.about_to_pose(id, node);
        const Sum& sum = sums.at(id);
        if (!node.rest) node.rest = std::make_unique<State::Rest>();
        if (sum.of_translation + sum.of_rotation + sum.of_scale > 0) {
            if (!node.rest->place) node.rest->place = node.place, node.rest->matrix = node.matrix;
            Trs place = *node.rest->place;
            if (sum.of_translation > 0) place.translation = sum.translation / sum.of_translation;
            if (sum.of_scale > 0) place.scale = sum.scale / sum.of_scale;
            const double length = std::sqrt(glm::dot(sum.rotation, sum.rotation));
            if (sum.of_rotation > 0 && length > 0) place.rotation = sum.rotation / length;
            if (node.matrix || !same(place, node.place)) {
                node.place = place;
                node.matrix.reset();
                s.place(id, node, place.matrix());
            }
        }
        if (sum.of_weights > 0) {
            if (!node.rest->weights) node.rest->weights = node.morph_weights;
            std::vector<float> weights;
            for (const double w : sum.weights) weights.push_back(static_cast<float>(w / sum.of_weights));
            if (weights != node.morph_weights) {
                s.about_to_change(id, node);
                node.morph_weights = std::move(weights);
                s.mark_dirty(id);
            }
        }
    }
    posed.nodes = std::move(order);
}

void Scene::pose(ClipId id, double seconds)
{
    const ClipAt at{id, seconds};
    pose({&at, 1});
}

NodeId Scene::copy(NodeId subtree, NodeId parent)
{
    State& s = *state_;
    s.require_unrecorded();
    State::at(s.nodes, subtree, "node");
    State::at(s.nodes, parent, "node");
    if (s.lowest_common(subtree, parent) == subtree)
        throw error_without_file("a subtree cannot be copied into itself", node(subtree).name);

    State::Posed copy;
    std::vector<NodeId> originals{subtree};
    for (std::size_t i = 0; i < originals.size(); ++i) {
        const Node& from = node(originals[i]);
        NodeDesc desc = from;
        desc.instance_of = {};
        desc.skin = {};
        std::erase_if(desc.cages, [&](CageId id) { return !s.cages.find(id); });
        if (!s.lights.find(desc.light)) desc.light = {};
        if (!s.cameras.find(desc.camera)) desc.camera = {};
        // The current pose is not part of a copy's rest values.
        if (const auto& rest = s.nodes.find(originals[i])->rest) {
            if (rest->place) desc.place = *rest->place, desc.matrix = rest->matrix;
            if (rest->weights) desc.morph_weights = *rest->weights;
        }
        std::copy_if(from.children.begin(), from.children.end(), std::back_inserter(originals),
                     [](NodeId child) { return bool(child); });
        const NodeId above = i == 0 ? parent : copy.node_of.at(from.parent);
        copy.node_of[originals[i]] = add_node(above, std::move(desc));
    }
    std::unordered_map<SkinId, SkinId> skin_of;
    for (const NodeId original : originals) {
        const Node from = node(original);
        const NodeId to = copy.node_of.at(original);
        const auto counterpart = [&](NodeId id) {
            const auto found = copy.node_of.find(id);
            return found == copy.node_of.end() ? id : found->second;
        };
        if (s.nodes.find(from.instance_of)) {
            State::NodeRecord& record = *s.nodes.find(to);
            record.instance_of = counterpart(from.instance_of);
            s.nodes.find(record.instance_of)->instances.add(to, [&](NodeId known) {
                return s.nodes.find(known) != nullptr;
            });
        }
        if (!s.skins.find(from.skin)) continue;
        const auto [entry, is_new] = skin_of.try_emplace(from.skin, from.skin);
        if (is_new) {
            Skin skin = this->skin(from.skin);
            for (NodeId& joint : skin.joints) joint = counterpart(joint);
            if (skin.joints != this->skin(from.skin).joints) copy.skins.push_back(entry->second = add(std::move(skin)));
        }
        set_skin(to, entry->second);
    }
    const NodeId made = copy.node_of.at(subtree);
    s.posed.emplace(made, std::move(copy));
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
