// The importer of glTF: it reads the node tree, and decides the order in which the file's parts are read.
#include "io/import/gltf.h"

#include <algorithm>
#include <map>
#include <unordered_map>
#include <unordered_set>

#include "io/import/files.h"
#include "io/import/gltf_animation.h"
#include "io/import/gltf_cage_files.h"
#include "io/import/gltf_far_nodes.h"
#include "io/import/gltf_file.h"
#include "io/import/gltf_instancing.h"
#include "io/import/gltf_meshes.h"
#include "io/import/gltf_uri.h"
#include "io/import/gltf_value.h"
#include "scenegraph/content_rules.h"
#include "scenegraph/shown_nodes.h"

namespace occam::import {

namespace {

constexpr std::size_t kMaxDepth = 4096;

Light punctual(const tinygltf::Light& in)
{
    Light light;
    light.name = in.name;
    const Vec3f color = vector_of(in.color, Vec3f(1)) * static_cast<float>(in.intensity);
    if (in.type == "directional") {
        light.kind = SunLight{color};
        return light;
    }
    PointLight point;
    point.intensity = color;
    point.range = static_cast<float>(in.range);
    if (in.type == "spot") {
        point.inner_angle = static_cast<float>(in.spot.innerConeAngle);
        point.outer_angle = static_cast<float>(in.spot.outerConeAngle);
    }
    light.kind = point;
    return light;
}

class SceneImporter {
public:
    SceneImporter(const std::filesystem::path& file, const LoadOptions& options)
        : report_(file, options.strict),
          options_(options),
          model_(open_gltf(report_)),
          accessors_(model_, report_),
          materials_(model_, accessors_, scene_, report_),
          meshes_(model_, accessors_, materials_, scene_, report_, options_),
          cage_files_(materials_, scene_, report_, accessors_.copies(), options_)
    {
    }

    Scene run()
    {
        nodes_.resize(model_.nodes.size());
        choose_variant();
        add_tree();
        warn_of_groups();
        SkinPaths paths(scene_, report_);
        const std::vector<SkinId> skins = add_skins(model_, accessors_, nodes_, scene_, paths, report_);
        for (std::size_t n = 0; n < nodes_.size(); ++n) {
            const int index = model_.nodes[n].skin;
            if (!nodes_[n] || index < 0 || static_cast<std::size_t>(index) >= skins.size()) continue;
            const SkinId skin = skins[static_cast<std::size_t>(index)];
            if (!skin) continue;  // it was left out
            paths.charge_wearer(nodes_[n], scene_.skin(skin).joints, "nodes[" + std::to_string(n) + "]");
            scene_.set_skin(nodes_[n], skin);
            check_joints(n, skin);
        }
        add_clips(model_, accessors_, nodes_, instances_of_, scene_, report_);
        add_environment();
        accessors_.check_values(report_);
        leave_out_far_nodes(scene_, nodes_, report_);
        note_cages();
        finish(scene_, report_);
        return std::move(scene_);
    }

private:
    void choose_variant()
    {
        const tinygltf::Value& variants = member(extension(model_.extensions, "KHR_materials_variants"), "variants");
        for (std::size_t v = 0; variants.IsArray() && v < variants.ArrayLen(); ++v)
            scene_.variants.push_back(text(variants.Get(static_cast<int>(v)), "name"));
        // Of several with one name the first counts, as of clips.
        const auto chosen = std::find(scene_.variants.begin(), scene_.variants.end(), options_.variant);
        if (!options_.variant.empty() && chosen != scene_.variants.end())
            meshes_.set_variant(static_cast<int>(chosen - scene_.variants.begin()));
    }

    // A joint that the skin lacks stays where the mesh is.
    void check_joints(std::size_t node, SkinId id)
    {
        std::size_t needed = 0;
        for (const CageId cage : scene_.node(nodes_[node]).cages) needed = std::max(needed, joints_needed_by(cage));
        if (needed > scene_.skin(id).joints.size())
            report_.warn("a vertex has a joint that its skin lacks", "nodes[" + std::to_string(node) + "]");
    }

    // Returns how many joints a skin must have for the cage. Many nodes may show it, so it is searched once.
    std::size_t joints_needed_by(CageId cage)
    {
        const auto [known, is_new] = joints_needed_.try_emplace(cage, 0);
        if (!is_new) return known->second;
        const SkinBinding& binding = scene_.cage(cage).cage.skin;
        for (std::size_t i = 0; i < binding.joints.size(); ++i)
            for (int k = 0; k < 4; ++k)
                if (binding.weights[i][k] > 0)
                    known->second = std::max(known->second, std::size_t(binding.joints[i][k]) + 1);
        return known->second;
    }

    // Meshes of triangles are the usual case, so no note is made of them.
    void note_cages()
    {
        std::unordered_set<CageId> cages, all;
        for_each_shown_node(scene_, 0, [&](NodeId, const Node& node) {
            for (const CageId id : node.cages) {
                all.insert(id);
                if (scene_.cage(id).cage.scheme != Scheme::Triangles) cages.insert(id);
            }
        });
        if (cages.empty()) return;
        const char* why = options_.subdivide == Subdivide::On ? " (--subdivide on)" : ", as extras.occam says";
        scene_.notes.push_back(std::to_string(cages.size()) + " of " + std::to_string(all.size()) +
                               " meshes are cages of subdivision surfaces" + why);
    }

    const tinygltf::Scene* scene_in_file() const
    {
        const std::size_t index = model_.defaultScene >= 0 ? static_cast<std::size_t>(model_.defaultScene) : 0;
        return index < model_.scenes.size() ? &model_.scenes[index] : nullptr;
    }

    // A file without a scene is a library: every node without a parent is shown.
    std::vector<int> roots() const
    {
        if (const tinygltf::Scene* scene = scene_in_file()) return scene->nodes;
        std::vector<bool> has_parent(model_.nodes.size(), false);
        for (const tinygltf::Node& node : model_.nodes)
            for (int child : node.children) has_parent[static_cast<std::size_t>(child)] = true;
        std::vector<int> list;
        for (std::size_t n = 0; n < has_parent.size(); ++n)
            if (!has_parent[n]) list.push_back(static_cast<int>(n));
        return list;
    }

    void add_tree()
    {
        struct Step {
            int node;
            NodeId parent;
            std::size_t depth;
        };
        std::vector<Step> todo;
        const std::vector<int> top = roots();
        for (auto r = top.rbegin(); r != top.rend(); ++r) todo.push_back({*r, scene_.root(), 1});
        while (!todo.empty()) {
            const Step step = todo.back();
            todo.pop_back();
            const std::string where = "nodes[" + std::to_string(step.node) + "]";
            if (step.node < 0 || static_cast<std::size_t>(step.node) >= nodes_.size())
                throw Error(report_.name(), "there is no such node", where);
            if (step.depth > kMaxDepth) throw Error(report_.name(), "the tree is deeper than 4096 nodes", where);
            NodeId& id = nodes_[static_cast<std::size_t>(step.node)];
            if (id) throw Error(report_.name(), "a node has two parents, or is its own ancestor", where);
            const tinygltf::Node& node = model_.nodes[static_cast<std::size_t>(step.node)];
            id = add_node(step.parent, node, where);
            for (auto c = node.children.rbegin(); c != node.children.rend(); ++c) todo.push_back({*c, id, step.depth + 1});
        }
    }

    // With EXT_mesh_gpu_instancing the node itself shows nothing, and each of the instances below it shows the mesh.
    NodeId add_node(NodeId parent, const tinygltf::Node& node, const std::string& where)
    {
        std::vector<Trs> places = instance_places(node, accessors_, kMaxInstances - instances_, report_, where);
        NodeDesc desc = describe(node, where);
        if (places.empty()) return scene_.add_node(parent, std::move(desc));
        instances_ += places.size();
        tidy_instances(places, desc, where);
        if (node.skin >= 0) report_.warn("instances are not deformed by the skin of their node", where);
        accessors_.copies().charge(places.size(), bytes_of_lists(desc) + desc.name.size(), where);
        NodeDesc instance = desc;
        instance.matrix.reset(), instance.camera = {}, instance.light = {};
        desc.cages.clear(), desc.materials.clear(), desc.morph_weights.clear();
        const NodeId id = scene_.add_node(parent, std::move(desc));
        std::vector<NodeId>& instances = instances_of_[id];
        for (const Trs& place : places) {
            instance.place = place;
            instances.push_back(scene_.add_node(id, instance));
        }
        return id;
    }

    // Instances in one place would all be met by the same rays: equal ones are left out, and too many others are refused.
    void tidy_instances(std::vector<Trs>& places, const NodeDesc& desc, const std::string& where)
    {
        if (const std::size_t equal = remove_equal(places); equal > 0)
            report_.warn(std::to_string(equal) + " instances are left out, since others of their node have the same place",
                         where);
        Box3d shape;
        for (const CageId cage : desc.cages) shape.add(scene_.cage(cage).bounds);
        const double overlap = overlap_of(places, shape);
        if (overlap > kMostOverlap)
            throw Error(report_.name(),
                        "a ray would meet " + std::to_string(std::lround(overlap)) + " of " + std::to_string(places.size()) +
                            " overlapping instances; at most " + std::to_string(std::lround(kMostOverlap)) +
                            " can be rendered",
                        where + ".EXT_mesh_gpu_instancing");
    }

    NodeDesc describe(const tinygltf::Node& node, const std::string& where)
    {
        NodeDesc desc;
        desc.name = node.name;
        if (node.matrix.size() == 16) {
            Mat4d m;
            for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = node.matrix[static_cast<std::size_t>(i)];
            for (int c = 0; c < 4; ++c) m[c][3] = c == 3 ? 1 : 0;  // what is not affine has a warning
            desc.matrix = m;
        }
        desc.place.translation = vector_of(node.translation, Vec3d(0));
        desc.place.scale = vector_of(node.scale, Vec3d(1));
        const Vec4d rotation = vector_of(node.rotation, Vec4d(0, 0, 0, 1));
        const double length = std::sqrt(glm::dot(rotation, rotation));
        if (length > 0) desc.place.rotation = rotation / length;
        add_camera(node, desc);
        const tinygltf::Mesh* mesh = node.mesh >= 0 && static_cast<std::size_t>(node.mesh) < model_.meshes.size()
                                         ? &model_.meshes[static_cast<std::size_t>(node.mesh)]
                                         : nullptr;
        const NodeExtras extras = node_extras(node.extras, mesh ? extras_of_mesh(node.mesh, where) : NodeExtras(), where,
                                              report_);
        if (!extras.cage.empty()) desc.cages = {cage_files_.cage(extras, where)};
        else if (mesh) desc.cages = meshes_.cages(node.mesh, extras.style);
        if (extras.material >= 0) override_materials(extras.material, desc, where);
        add_weights(node, desc, where);
        accessors_.copies().charge(1, bytes_of_lists(desc) + (node.name.empty() ? desc.name.size() : 0), where);
        add_light(node, extras, desc, where);
        desc.seen_by = static_cast<std::uint8_t>(RayKind::All & ~extras.hidden_from);
        if (extras.lit_by) {
            desc.lit_by = 0;
            for (const std::string& group : *extras.lit_by) desc.lit_by |= light_group(group, where);
        }
        return desc;
    }

    // Weights of targets that no primitive has are left out.
    void add_weights(const tinygltf::Node& node, NodeDesc& desc, const std::string& where)
    {
        std::size_t targets = 0;
        for (const CageId cage : desc.cages) targets = std::max(targets, scene_.cage(cage).cage.morph_targets.size());
        for (const double weight : node.weights) {
            const auto w = static_cast<float>(weight);
            if (!std::isfinite(w)) report_.warn("a morph weight is not finite", where);
            if (desc.morph_weights.size() < targets) desc.morph_weights.push_back(std::isfinite(w) ? w : 0.0f);
        }
    }

    // Returns the bytes that the node has of its own, however many nodes and instances show its mesh.
    static std::size_t bytes_of_lists(const NodeDesc& desc)
    {
        return desc.cages.size() * sizeof(CageId) + desc.materials.size() * sizeof(MaterialId) +
               desc.morph_weights.size() * sizeof(float);
    }

    // Many nodes may show the mesh, so its extras are read for the first of them only.
    const NodeExtras& extras_of_mesh(int mesh, const std::string& where)
    {
        const auto [known, is_new] = mesh_extras_.try_emplace(mesh);
        if (is_new)
            known->second = node_extras(model_.meshes[static_cast<std::size_t>(mesh)].extras, {}, where + ".mesh", report_);
        return known->second;
    }

    void add_camera(const tinygltf::Node& node, NodeDesc& desc)
    {
        const auto index = static_cast<std::size_t>(node.camera);
        if (node.camera < 0 || index >= model_.cameras.size()) return;
        const tinygltf::Camera& camera = model_.cameras[index];
        CameraLens lens{.orthographic = camera.type == "orthographic"};
        if (lens.orthographic) {
            lens.height = static_cast<float>(2 * std::abs(camera.orthographic.ymag));
            lens.aspect = static_cast<float>(std::abs(camera.orthographic.xmag / camera.orthographic.ymag));
        } else {
            constexpr double kWidest = 3.1;
            const auto warn = [&](const char* what) { report_.warn(what, named_element("cameras", index, camera.name)); };
            if (camera.perspective.yfov > kWidest) warn("a camera's angle above 3.1 radians is made smaller");
            if (camera.perspective.yfov < double(kNarrowestView))
                warn("a camera's angle below 0.00001 radians is made larger");
            lens.fov = std::max(static_cast<float>(std::min(camera.perspective.yfov, kWidest)), kNarrowestView);
            lens.aspect = static_cast<float>(camera.perspective.aspectRatio);
        }
        desc.camera = scene_.add(lens);
        if (desc.name.empty()) desc.name = camera.name.empty() ? "camera " + std::to_string(node.camera) : camera.name;
    }

    void add_light(const tinygltf::Node& node, const NodeExtras& extras, NodeDesc& desc, const std::string& where)
    {
        const int light = integer(extension(node.extensions, "KHR_lights_punctual"), "light", -1);
        const bool is_punctual = light >= 0 && static_cast<std::size_t>(light) < model_.lights.size();
        if (!is_punctual && !extras.area_light) {
            if (!extras.light_group.empty()) report_.warn("light_group has no effect on a node without a light", where);
            return;
        }
        if (extras.hidden_from != 0) report_.warn("hidden_from has no effect on the light of a node", where);
        LightGroups groups = kAllGroups;
        if (!extras.light_group.empty()) {
            groups = light_group(extras.light_group, where);
            groups_with_lights_ |= groups;
        }
        if (extras.area_light) {
            if (is_punctual) report_.warn("a node has room for one light: the area light is taken", where);
            desc.light = scene_.add(Light{node.name, *extras.area_light, groups});
        } else {
            desc.light = punctual_light(light, groups);
        }
    }

    // Lights that no node has are left out, so that the scene counts those that it shows.
    LightId punctual_light(int index, LightGroups groups)
    {
        const auto [known, is_new] = lights_.try_emplace({index, groups});
        if (!is_new) return known->second;
        Light light = punctual(model_.lights[static_cast<std::size_t>(index)]);
        light.groups = groups;
        return known->second = scene_.add(std::move(light));
    }

    LightGroups light_group(const std::string& name, const std::string& where)
    {
        const auto [known, is_new] = light_groups_.try_emplace(name, LightGroups(1)
                                                                         << light_groups_.size() % kMostLightGroups);
        if (light_groups_.size() > kMostLightGroups)
            throw Error(report_.name(), "a scene has at most 32 light groups", where);
        return known->second;
    }

    void warn_of_groups()
    {
        for (const auto& [name, group] : light_groups_)
            if ((groups_with_lights_ & group) == 0) report_.warn("no light belongs to the group that lit_by names", name);
    }

    void override_materials(int material, NodeDesc& desc, const std::string& where)
    {
        const MaterialId id = materials_.material(material);
        if (!id) throw Error(report_.name(), "there is no material " + std::to_string(material), where);
        std::size_t slots = 1;
        for (CageId cage : desc.cages) slots = std::max(slots, scene_.cage(cage).cage.materials.size());
        desc.materials.assign(slots, id);
    }

    void add_environment()
    {
        const tinygltf::Scene* scene = scene_in_file();
        if (!scene) return;
        const auto extras = environment_extras(scene->extras, "scene", report_);
        if (!extras) return;
        scene_.environment.radiance = Vec3f(extras->strength);
        scene_.environment.rotation = extras->rotation_deg * 0.01745329252f;
        if (extras->image.empty()) return;
        const auto& [path, is_file] = report_.folder().find(decode_uri(extras->image));
        if (!path) throw Error(report_.name(), "the environment is not in the scene's folder: " + extras->image, "scene");
        if (!is_file) throw Error(report_.name(), "the environment is missing: " + extras->image, "scene");
        report_.add_file(*path);
        Texture texture;
        texture.name = report_.name() + ": " + extras->image, texture.path = *path;
        scene_.environment.image = scene_.add(std::move(texture));
    }

    Report report_;
    const LoadOptions options_;
    Scene scene_;
    const tinygltf::Model model_;
    AccessorReader accessors_;
    MaterialImporter materials_;
    MeshImporter meshes_;
    CageFiles cage_files_;
    std::vector<NodeId> nodes_;                              // one for each node of the file
    std::map<std::pair<int, LightGroups>, LightId> lights_;  // punctual ones, by index and groups
    std::size_t instances_ = 0;                              // instances of EXT_mesh_gpu_instancing so far
    InstancesOf instances_of_;                               // by the node whose mesh they show
    std::map<std::string, LightGroups> light_groups_;
    LightGroups groups_with_lights_ = 0;
    std::unordered_map<int, NodeExtras> mesh_extras_;  // by mesh
    std::unordered_map<CageId, std::size_t> joints_needed_;
};

}  // namespace

Scene load_gltf(const std::filesystem::path& file, const LoadOptions& options) { return SceneImporter(file, options).run(); }

}  // namespace occam::import
