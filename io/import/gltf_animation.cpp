#include "io/import/gltf_animation.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "io/import/gltf_value.h"
#include "scenegraph/interpolation.h"

namespace occam::import {

namespace {

NodeId node_at(const std::vector<NodeId>& nodes, int index)
{
    return index >= 0 && static_cast<std::size_t>(index) < nodes.size() ? nodes[static_cast<std::size_t>(index)] : NodeId();
}

std::optional<Channel::Path> path_of(const std::string& name)
{
    if (name == "translation") return Channel::Path::Translation;
    if (name == "rotation") return Channel::Path::Rotation;
    if (name == "scale") return Channel::Path::Scale;
    if (name == "weights") return Channel::Path::Weights;
    return std::nullopt;
}

class ClipReader {
public:
    ClipReader(const tinygltf::Model& model, AccessorReader& accessors, const std::vector<NodeId>& nodes, Report& report)
        : model_(model), accessors_(accessors), nodes_(nodes), report_(report)
    {
    }

    std::optional<Channel> channel(const tinygltf::Animation& animation, const tinygltf::AnimationChannel& c,
                                   const std::string& where)
    {
        Channel out;
        out.target = node_at(nodes_, c.target_node);
        const auto path = path_of(c.target_path);
        if (!out.target || !path) return std::nullopt;  // the target is outside the scene or an extension's: ignored
        out.path = *path;
        if (c.sampler < 0 || static_cast<std::size_t>(c.sampler) >= animation.samplers.size())
            return dropped("names no sampler", where);
        const tinygltf::AnimationSampler& sampler = animation.samplers[static_cast<std::size_t>(c.sampler)];
        for (const InterpolationRow& row : kInterpolations)
            if (sampler.interpolation == row.name) out.interpolation = row.mode;
        out.times = accessors_.floats(sampler.input, 1);
        if (!is_rising(out.times)) return dropped("key times must be finite and rise", where);

        const std::size_t values_a_key = row_of(out.interpolation).values_a_key;
        if (out.path == Channel::Path::Weights) {
            const std::size_t values = accessors_.count(sampler.output) / values_a_key;
            out.width = static_cast<int>(values / out.times.size());
            if (out.width == 0 || out.width != morph_targets(c.target_node))
                return dropped("needs one weight a key and morph target", where);
            out.values = accessors_.floats(sampler.output, 1);
        } else {
            out.width = out.path == Channel::Path::Rotation ? 4 : 3;
            if (accessors_.components(sampler.output) != out.width) return dropped("its values have the wrong type", where);
            out.values = accessors_.floats(sampler.output, out.width);
        }
        if (out.values.size() != out.times.size() * static_cast<std::size_t>(out.width) * values_a_key)
            return dropped("needs one value a key", where);
        for (float v : out.values)
            if (!std::isfinite(v)) return dropped("a value is not finite", where);
        if (out.path == Channel::Path::Rotation) mend_rotations(out, where);
        return out;
    }

private:
    // A quaternion of zeros is no rotation at all, so the identity replaces it.
    void mend_rotations(Channel& channel, const std::string& where)
    {
        const std::size_t step = channel.values.size() / channel.times.size(), value = step == 12 ? 4 : 0;
        for (std::size_t key = 0; key < channel.times.size(); ++key) {
            float* q = &channel.values[key * step + value];
            if (q[0] != 0 || q[1] != 0 || q[2] != 0 || q[3] != 0) continue;
            report_.warn("a rotation is zero: the identity replaces it", where);
            q[3] = 1;
        }
    }
    std::optional<Channel> dropped(const std::string& why, const std::string& where)
    {
        report_.warn("animation channel dropped: " + why, where);
        return std::nullopt;
    }
    static bool is_rising(const std::vector<float>& times)
    {
        for (std::size_t i = 0; i < times.size(); ++i)
            if (!std::isfinite(times[i]) || (i > 0 && !(times[i] > times[i - 1]))) return false;
        return !times.empty();
    }
    int morph_targets(int node) const
    {
        const int mesh = model_.nodes[static_cast<std::size_t>(node)].mesh;
        if (mesh < 0 || static_cast<std::size_t>(mesh) >= model_.meshes.size()) return 0;
        const auto& primitives = model_.meshes[static_cast<std::size_t>(mesh)].primitives;
        return primitives.empty() ? 0 : static_cast<int>(primitives[0].targets.size());
    }

    const tinygltf::Model& model_;
    AccessorReader& accessors_;
    const std::vector<NodeId>& nodes_;
    Report& report_;
};

std::vector<Mat4d> matrices(const std::vector<float>& values)
{
    std::vector<Mat4d> out(values.size() / 16);
    for (std::size_t m = 0; m < out.size(); ++m)
        for (int c = 0; c < 4; ++c)
            for (int r = 0; r < 4; ++r) out[m][c][r] = double(values[m * 16 + static_cast<std::size_t>(c * 4 + r)]);
    return out;
}

// Gives a matrix the last row that a skin's must have. Programs that invert matrices leave a last row that is off by the
// rounding of floats, or a factor that all elements have in common.
void make_affine(Mat4d& m, Report& report, const std::string& where)
{
    constexpr double kRounding = 1e-5;
    const double scale = m[3][3];
    double error = std::abs(scale - 1);
    bool is_finite = scale != 0;
    for (int c = 0; c < 4; ++c) {
        if (c < 3) error = std::max(error, std::abs(m[c][3]));
        m[c] /= scale;
        m[c][3] = c == 3 ? 1 : 0;
        for (int r = 0; r < 3; ++r) is_finite &= std::isfinite(m[c][r]);
    }
    if (!is_finite) {
        report.warn("an inverse bind matrix is replaced by the identity: its numbers are not finite, or its last is 0",
                    where);
        m = Mat4d(1);
    } else if (!(error <= kRounding)) {
        report.warn("the last row of an inverse bind matrix is not 0, 0, 0, 1: it is taken as that", where);
    }
}

}  // namespace

std::vector<SkinId> add_skins(const tinygltf::Model& model, AccessorReader& accessors, const std::vector<NodeId>& nodes,
                              Scene& scene, SkinPaths& paths, Report& report)
{
    std::vector<SkinId> ids(model.skins.size());
    for (std::size_t s = 0; s < model.skins.size(); ++s) {
        const tinygltf::Skin& in = model.skins[s];
        const std::string where = named_element("skins", s, in.name);
        Skin skin;
        skin.name = in.name;
        for (int joint : in.joints)
            if (const NodeId id = node_at(nodes, joint)) skin.joints.push_back(id);
        if (skin.joints.empty() || skin.joints.size() != in.joints.size()) {
            report.warn("skin left out: a joint is not in the scene", where);
            continue;
        }
        paths.charge_joints(skin.joints, where);
        if (in.inverseBindMatrices >= 0) {
            if (accessors.components(in.inverseBindMatrices) != 16)
                throw Error(report.name(), "inverse bind matrices must be MAT4", where);
            skin.joint_from_mesh = matrices(accessors.floats(in.inverseBindMatrices, 16));
            if (skin.joint_from_mesh.size() < skin.joints.size())
                throw Error(report.name(), "fewer inverse bind matrices than joints", where);
            skin.joint_from_mesh.resize(skin.joints.size());
            for (Mat4d& m : skin.joint_from_mesh) make_affine(m, report, where);
        }
        ids[s] = scene.add(std::move(skin));
    }
    return ids;
}

void add_clips(const tinygltf::Model& model, AccessorReader& accessors, const std::vector<NodeId>& nodes,
               const InstancesOf& instances, Scene& scene, Report& report)
{
    ClipReader reader(model, accessors, nodes, report);
    for (std::size_t a = 0; a < model.animations.size(); ++a) {
        const tinygltf::Animation& animation = model.animations[a];
        Clip clip{animation.name, {}};
        for (std::size_t c = 0; c < animation.channels.size(); ++c) {
            const std::string where = named_element("animations", a, animation.name) + ".channels[" + std::to_string(c) +
                                      "]";
            auto channel = reader.channel(animation, animation.channels[c], where);
            if (!channel) continue;
            const auto shown_by = channel->path == Channel::Path::Weights ? instances.find(channel->target)
                                                                          : instances.end();
            if (shown_by == instances.end()) {
                clip.channels.push_back(*std::move(channel));
                continue;
            }
            const std::size_t bytes = (channel->times.size() + channel->values.size()) * sizeof(float);
            accessors.copies().charge(shown_by->second.size() - 1, bytes, where);
            for (const NodeId instance : shown_by->second) {
                clip.channels.push_back(*channel);
                clip.channels.back().target = instance;
            }
        }
        scene.add(std::move(clip));
    }
}

}  // namespace occam::import
