#include <cmath>
#include <map>
#include <set>

#include "io/import/gltf_json.h"
#include "io/import/gltf_rules.h"
#include "scenegraph/interpolation.h"

namespace occam::import {

namespace {

using nlohmann::json;

class SceneRules {
public:
    SceneRules(const json& root, Report& report) : root_(root), report_(report)
    {
        for (const json& name : list(root_, "extensionsUsed")) is_quantized_ |= name == "KHR_mesh_quantization";
    }

    void check()
    {
        each("meshes", [&](const json& mesh, const std::string&) { count_joints(mesh); });
        check_tree();
        number_tree();
        each("nodes", [&](const json& node, const std::string& where) { check_node(node, where); });
        each("skins", [&](const json& skin, const std::string& where) { check_skin(skin, where); });
        each("cameras", [&](const json& camera, const std::string& where) { check_camera(camera, where); });
        each("meshes", [&](const json& mesh, const std::string& where) { check_mesh(mesh, where); });
        each("animations", [&](const json& animation, const std::string& where) { check_animation(animation, where); });
        check_lights();
    }

private:
    template <class Check>
    void each(const char* kind, Check&& check)
    {
        const json& all = list(root_, kind);
        for (std::size_t i = 0; i < all.size(); ++i) check(all[i], element(kind, i));
    }
    const json& at(const char* kind, const json& index) const { return list(root_, kind)[index.get<std::size_t>()]; }
    std::size_t morph_targets(const json& mesh) const
    {
        const json& primitives = list(mesh, "primitives");
        return primitives.empty() ? 0 : list(primitives[0], "targets").size();
    }

    void check_tree()
    {
        const json& nodes = list(root_, "nodes");
        parent_.assign(nodes.size(), -1);
        for (std::size_t n = 0; n < nodes.size(); ++n)
            for (const json& child : list(nodes[n], "children")) {
                std::int64_t& parent = parent_[child.get<std::size_t>()];
                if (parent >= 0)
                    throw Error(report_.name(), "a node has two parents", element("nodes", child.get<std::size_t>()));
                parent = static_cast<std::int64_t>(n);
            }
        // Every node has at most one parent, so a climb of more steps than there are nodes is in a cycle.
        std::vector<bool> is_in_tree(nodes.size(), false);
        for (std::size_t n = 0; n < nodes.size(); ++n) {
            std::vector<std::size_t> path;
            for (std::int64_t up = static_cast<std::int64_t>(n); up >= 0 && !is_in_tree[static_cast<std::size_t>(up)];
                 up = parent_[static_cast<std::size_t>(up)]) {
                path.push_back(static_cast<std::size_t>(up));
                if (path.size() > nodes.size())
                    throw Error(report_.name(), "a node is its own ancestor", element("nodes", n));
            }
            for (std::size_t step : path) is_in_tree[step] = true;
        }
        each("scenes", [&](const json& scene, const std::string& where) {
            for (const json& node : list(scene, "nodes"))
                if (parent_[node.get<std::size_t>()] >= 0)
                    throw Error(report_.name(), element("nodes", node.get<std::size_t>()) + " is not a root", where);
        });
    }

    void check_node(const json& node, const std::string& where)
    {
        const bool has_parts = node.contains("translation") || node.contains("rotation") || node.contains("scale");
        if (node.contains("matrix")) {
            if (has_parts) report_.warn("matrix and translation, rotation or scale: the matrix is taken", where);
            const json& m = node["matrix"];
            if (m.size() == 16 && (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1))
                report_.warn("the matrix is not affine", where);
        }
        if (const json& q = list(node, "rotation"); q.size() == 4) {
            double sum = 0;
            for (const json& part : q) sum += part.get<double>() * part.get<double>();
            if (!(std::abs(sum - 1) < 1e-3)) report_.warn("the rotation is not of unit length", where);
        }
        if (node.contains("skin") && !node.contains("mesh")) report_.warn("skin without a mesh", where);
        if (node.contains("weights")) {
            if (!node.contains("mesh")) report_.warn("weights without a mesh", where);
            else if (morph_targets(at("meshes", node["mesh"])) != node["weights"].size())
                report_.warn("needs one weight a morph target", where);
        }
        if (!node.contains("mesh")) return;
        const Joints joints = joints_of_mesh_[node["mesh"].get<std::size_t>()];
        if (node.contains("skin") && joints.are_missing) report_.warn("skin, but its mesh has no joints", where);
        if (!node.contains("skin") && joints.are_there) report_.warn("mesh with joints, but no skin", where);
    }

    // Says whether some primitives of a mesh have joints, and whether some have none. Many nodes may show the mesh, so its
    // primitives are searched once.
    struct Joints {
        bool are_there = false, are_missing = false;
    };
    void count_joints(const json& mesh)
    {
        Joints joints;
        for (const json& primitive : list(mesh, "primitives"))
            (primitive["attributes"].contains("JOINTS_0") ? joints.are_there : joints.are_missing) = true;
        joints_of_mesh_.push_back(joints);
    }

    // Holds when a walk over the forest enters and leaves a node: the intervals of ancestors enclose those of their
    // descendants.
    struct Interval {
        std::size_t root = 0, enter = 0, leave = 0;
    };
    void number_tree()
    {
        const json& nodes = list(root_, "nodes");
        interval_.resize(nodes.size());
        std::size_t clock = 0;
        for (std::size_t top = 0; top < nodes.size(); ++top) {
            if (parent_[top] >= 0) continue;
            std::vector<std::pair<std::size_t, bool>> todo{{top, false}};
            while (!todo.empty()) {
                const auto [node, is_done] = todo.back();
                todo.pop_back();
                if (is_done) {
                    interval_[node].leave = clock++;
                    continue;
                }
                interval_[node] = {top, clock++, 0};
                todo.push_back({node, true});
                for (const json& child : list(nodes[node], "children")) todo.push_back({child.get<std::size_t>(), false});
            }
        }
    }

    void check_skin(const json& skin, const std::string& where)
    {
        if (skin.contains("inverseBindMatrices")) {
            const json& accessor = at("accessors", skin["inverseBindMatrices"]);
            if (text(accessor, "type") != "MAT4" || integer(accessor, "componentType", 0) != 5126)
                throw Error(report_.name(), "inverse bind matrices must be MAT4 of floats", where);
            check_stride(accessor, "inverse bind matrices", where);
        }
        const json& joints = list(skin, "joints");
        if (joints.empty()) return;
        const std::size_t root = interval_[joints[0].get<std::size_t>()].root;
        for (const json& joint : joints)
            if (interval_[joint.get<std::size_t>()].root != root) report_.warn("joints have no common root", where);
        if (!skin.contains("skeleton")) return;
        const Interval& skeleton = interval_[skin["skeleton"].get<std::size_t>()];
        for (const json& joint : joints) {
            const Interval& j = interval_[joint.get<std::size_t>()];
            if (j.enter < skeleton.enter || j.leave > skeleton.leave)
                report_.warn("skeleton is not a common root of the joints", where);
        }
    }

    void check_stride(const json& accessor, const char* what, const std::string& where)
    {
        if (accessor.contains("bufferView") && at("bufferViews", accessor["bufferView"]).contains("byteStride"))
            report_.warn(std::string(what) + " in a view with byteStride", where);
    }

    void check_camera(const json& camera, const std::string& where)
    {
        const std::string type = text(camera, "type");
        if (camera.contains("perspective") && camera.contains("orthographic")) report_.warn("a camera of both kinds", where);
        if (!camera.contains(type)) throw Error(report_.name(), "'" + type + "' is missing", where);
        const json& lens = camera[type];
        if (lens.contains("zfar") && lens["zfar"].get<double>() <= lens["znear"].get<double>())
            report_.warn("zfar is not behind znear", where);
        if (type == "orthographic" && (lens["xmag"] == 0 || lens["ymag"] == 0))
            throw Error(report_.name(), "xmag and ymag must not be 0", where);
    }

    void check_mesh(const json& mesh, const std::string& where)
    {
        const json& primitives = list(mesh, "primitives");
        for (std::size_t p = 0; p < primitives.size(); ++p) {
            const std::string at_primitive = where + ".primitives[" + std::to_string(p) + "]";
            refuse_draco(primitives[p], at_primitive);
            check_primitive(primitives[p], at_primitive);
            if (list(primitives[p], "targets").size() != morph_targets(mesh))
                report_.warn("primitives with different numbers of morph targets", where);
        }
        if (mesh.contains("weights") && mesh["weights"].size() != morph_targets(mesh))
            report_.warn("needs one weight a morph target", where);
    }

    static bool is_series(const std::string& name, const char* semantic)
    {
        const std::string prefix = semantic;
        return name.starts_with(prefix) && name.size() > prefix.size() && name.size() <= prefix.size() + 3 &&
               name.find_first_not_of("0123456789", prefix.size()) == std::string::npos &&
               (name[prefix.size()] != '0' || name.size() == prefix.size() + 1);
    }

    // Refuses a primitive whose positions are nowhere but in a compressed buffer view.
    void refuse_draco(const json& primitive, const std::string& where) const
    {
        constexpr const char* kDraco = "KHR_draco_mesh_compression";
        const auto extensions = primitive.find("extensions");
        if (extensions == primitive.end() || !extensions->contains(kDraco)) return;
        const auto position = primitive["attributes"].find("POSITION");
        if (position == primitive["attributes"].end()) return;
        const json& accessor = at("accessors", *position);
        if (!accessor.contains("bufferView") && !accessor.contains("sparse"))
            throw Error(report_.name(), std::string("has no data but for ") + kDraco + ", which is not read", where);
    }

    void check_primitive(const json& primitive, const std::string& where)
    {
        const json& attributes = primitive["attributes"];
        if (!attributes.contains("POSITION") && !attributes.empty()) report_.warn("primitive without positions", where);
        const auto count_of = [&](const char* series) {
            std::size_t count = 0;
            for (const auto& [name, accessor] : attributes.items()) count += is_series(name, series);
            return count;
        };
        for (const char* series : {"TEXCOORD_", "COLOR_", "JOINTS_", "WEIGHTS_"}) {
            const std::size_t count = count_of(series);
            for (std::size_t i = 0; i < count; ++i)
                if (!attributes.contains(series + std::to_string(i))) {
                    report_.warn(std::string(series) + "n must count from 0 without a gap", where);
                    break;
                }
        }
        if (count_of("JOINTS_") != count_of("WEIGHTS_")) report_.warn("joints and weights come in pairs", where);
        for (const auto& [name, index] : attributes.items()) check_attribute(name, at("accessors", index), where);
        for (const json& target : list(primitive, "targets"))
            for (const auto& [name, index] : target.items()) {
                if (!attributes.contains(name)) report_.warn("morph target of an attribute that is not there", where);
                if (name == "POSITION" && !at("accessors", index).contains("min"))
                    report_.warn("positions without min and max", where);
            }
        if (primitive.contains("indices")) check_indices(at("accessors", primitive["indices"]), where);
        check_materials(primitive, where);
    }

    void check_attribute(const std::string& name, const json& accessor, const std::string& where)
    {
        const std::string type = text(accessor, "type");
        const std::int64_t component = integer(accessor, "componentType", 0);
        const bool is_float = component == 5126;
        const bool is_unsigned_normal = (component == 5121 || component == 5123) && accessor.value("normalized", false);
        bool fits = true;
        if (name == "POSITION") {
            fits = type == "VEC3" && (is_float || is_quantized_);
            if (!accessor.contains("min") || !accessor.contains("max")) report_.warn("positions without min and max", where);
        } else if (name == "NORMAL") {
            fits = type == "VEC3" && (is_float || is_quantized_);
        } else if (name == "TANGENT") {
            fits = type == "VEC4" && (is_float || is_quantized_);
        } else if (is_series(name, "TEXCOORD_")) {
            fits = type == "VEC2" && (is_float || is_unsigned_normal || is_quantized_);
        } else if (is_series(name, "COLOR_")) {
            fits = (type == "VEC3" || type == "VEC4") && (is_float || is_unsigned_normal);
        } else if (is_series(name, "JOINTS_")) {
            fits = type == "VEC4" && (component == 5121 || component == 5123);
        } else if (is_series(name, "WEIGHTS_")) {
            fits = type == "VEC4" && (is_float || is_unsigned_normal);
        } else if (!name.starts_with("_")) {
            report_.warn("unknown attribute '" + name.substr(0, 64) + "'", where);
        }
        if (!fits || component == 5125)
            report_.warn("attribute of a format that is not allowed: " + name.substr(0, 64), where);
        if (accessor.contains("bufferView")) {
            const json& view = at("bufferViews", accessor["bufferView"]);
            if (integer(view, "target", 34962) != 34962) report_.warn("attribute in a view of indices", where);
            const auto [user, is_new] = attribute_of_view_.try_emplace(accessor["bufferView"].get<std::size_t>(), &accessor);
            if (!is_new && user->second != &accessor && !view.contains("byteStride"))
                report_.warn("attributes share a view without byteStride", where);
            const std::int64_t size = (type == "VEC3"   ? 3
                                       : type == "VEC2" ? 2
                                       : type == "VEC4" ? 4
                                                        : 1) *
                                      (component <= 5121   ? 1
                                       : component <= 5123 ? 2
                                                           : 4);
            if (integer(accessor, "byteOffset", 0) % 4 != 0 || integer(view, "byteStride", size) % 4 != 0)
                report_.warn("attribute is not aligned to four bytes", where);
        }
    }

    void check_indices(const json& accessor, const std::string& where)
    {
        const std::int64_t component = integer(accessor, "componentType", 0);
        if (text(accessor, "type") != "SCALAR" || (component != 5121 && component != 5123 && component != 5125))
            throw Error(report_.name(), "indices must be unsigned scalars", where);
        if (!accessor.contains("bufferView")) return;
        const json& view = at("bufferViews", accessor["bufferView"]);
        if (integer(view, "target", 34963) != 34963) report_.warn("indices in a view of attributes", where);
        if (view.contains("byteStride")) report_.warn("byteStride in a view of indices", where);
        if (attribute_of_view_.count(accessor["bufferView"].get<std::size_t>()))
            report_.warn("indices and attributes share a view", where);
    }

    void check_materials(const json& primitive, const std::string& where)
    {
        std::set<std::size_t> materials;
        if (primitive.contains("material")) materials.insert(primitive["material"].get<std::size_t>());
        constexpr const char* kVariants = "KHR_materials_variants";
        if (primitive.contains("extensions") && primitive["extensions"].contains(kVariants))
            for (const json& mapping : list(primitive["extensions"][kVariants], "mappings"))
                materials.insert(mapping["material"].get<std::size_t>());
        for (const std::size_t material : materials) {
            const auto [sets, is_new] = sets_of_material_.try_emplace(material);
            if (is_new) sets->second = coordinate_sets(list(root_, "materials")[material]);
            for (const std::int64_t set : sets->second)
                if (!primitive["attributes"].contains("TEXCOORD_" + std::to_string(set)))
                    report_.warn("a texture of its material needs TEXCOORD_" + std::to_string(set), where);
        }
    }

    void check_animation(const json& animation, const std::string& where)
    {
        const json &channels = animation["channels"], &samplers = animation["samplers"];
        std::set<std::pair<std::int64_t, std::string>> targets;
        for (std::size_t c = 0; c < channels.size(); ++c) {
            const std::string at_channel = where + ".channels[" + std::to_string(c) + "]";
            if (integer(channels[c], "sampler", 0) >= static_cast<std::int64_t>(samplers.size()))
                throw Error(report_.name(), "there is no such sampler", at_channel);
            const json& target = channels[c]["target"];
            if (!target.contains("node")) continue;
            const json& node = at("nodes", target["node"]);
            const std::string path = text(target, "path");
            if (!targets.insert({target["node"].get<std::int64_t>(), path}).second)
                report_.warn("two channels with one target", at_channel);
            if (path != "weights" && node.contains("matrix")) report_.warn("channel of a node with a matrix", at_channel);
            if (path == "weights" && (!node.contains("mesh") || morph_targets(at("meshes", node["mesh"])) == 0))
                report_.warn("channel of weights, but there is no morph target", at_channel);
            if (path != "translation" && path != "rotation" && path != "scale" && path != "weights")
                report_.warn("channel of an unknown path", at_channel);
        }
        for (std::size_t s = 0; s < samplers.size(); ++s) {
            const std::string at_sampler = where + ".samplers[" + std::to_string(s) + "]";
            const json& input = at("accessors", samplers[s]["input"]);
            if (text(input, "type") != "SCALAR" || integer(input, "componentType", 0) != 5126)
                throw Error(report_.name(), "key times must be scalar floats", at_sampler);
            if (!input.contains("min") || !input.contains("max")) report_.warn("key times without min and max", at_sampler);
            check_stride(input, "key times", at_sampler);
            check_stride(at("accessors", samplers[s]["output"]), "key values", at_sampler);
            for (const InterpolationRow& row : kInterpolations)
                if (text(samplers[s], "interpolation") == row.name &&
                    integer(input, "count", 2) < static_cast<std::int64_t>(row.least_keys))
                    report_.warn("a cubic spline needs two keys", at_sampler);
        }
    }

    void check_lights()
    {
        const auto extensions = root_.find("extensions");
        if (extensions == root_.end() || !extensions->contains("KHR_lights_punctual")) return;
        const json& lights = list((*extensions)["KHR_lights_punctual"], "lights");
        for (std::size_t l = 0; l < lights.size(); ++l) {
            const std::string where = element("lights", l), type = text(lights[l], "type");
            if (type == "spot" && !lights[l].contains("spot")) throw Error(report_.name(), "'spot' is missing", where);
            if (type == "directional" && lights[l].contains("range"))
                report_.warn("a directional light has no range", where);
            if (!lights[l].contains("spot")) continue;
            const json& spot = lights[l]["spot"];
            if (spot.value("innerConeAngle", 0.0) >= spot.value("outerConeAngle", 0.78539816339))
                report_.warn("inner cone is not inside the outer", where);
            if (type != "spot") report_.warn("only a spot light has cones", where);
        }
    }

    const json& root_;
    Report& report_;
    bool is_quantized_ = false;  // the file uses KHR_mesh_quantization
    std::vector<Joints> joints_of_mesh_;
    std::vector<std::int64_t> parent_;  // by node; -1: none
    std::vector<Interval> interval_;    // by node
    std::map<std::size_t, const json*> attribute_of_view_;
    std::map<std::size_t, std::set<std::int64_t>> sets_of_material_;
};

}  // namespace

void check_scene_rules(const json& root, Report& report) { SceneRules(root, report).check(); }

}  // namespace occam::import
