#include "body.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

namespace sample {

using namespace occam;
using Json = nlohmann::json;

namespace {

std::ifstream open(const std::filesystem::path& file)
{
    std::ifstream in(file);
    if (!in) throw Error(file.string(), "cannot be read");
    return in;
}

// Reads base.obj. Its groups are the body, helper geometry that clothes are fitted to, and small cubes about the joints.
struct Mesh {
    std::vector<Vec3f> positions;
    std::map<std::string, std::vector<std::array<std::uint32_t, 4>>> faces;  ///< the faces of each group
};

Mesh read_mesh(const std::filesystem::path& folder, const std::string& shape)
{
    Mesh mesh;
    std::string group;
    std::ifstream in = open(folder / "base.obj");
    for (std::string line; std::getline(in, line);) {
        std::istringstream words(line);
        std::string word;
        words >> word;
        if (word == "v") {
            Vec3f p;
            words >> p.x >> p.y >> p.z;
            mesh.positions.push_back(p);
        } else if (word == "g") {
            words >> group;
        } else if (word == "f") {
            std::array<std::uint32_t, 4> face{};
            for (std::uint32_t& v : face) {
                words >> word;
                v = static_cast<std::uint32_t>(std::stoul(word)) - 1;  // what follows a slash is a texture coordinate
            }
            mesh.faces[group].push_back(face);
        }
    }
    std::ifstream target = open(folder / "targets" / shape);
    for (std::string line; std::getline(target, line);) {
        std::istringstream words(line);
        std::size_t v;
        Vec3f offset;
        if (words >> v >> offset.x >> offset.y >> offset.z && v < mesh.positions.size()) mesh.positions[v] += offset;
    }
    return mesh;
}

// Reads the bones. A bone's head is the mean of some vertices, so bones follow the shape.
std::vector<Bone> read_bones(const Json& file, const std::vector<Vec3f>& positions)
{
    std::vector<Bone> bones;
    std::map<std::string, int> known;
    const Json& all = file.at("bones");
    while (bones.size() < all.size()) {
        const std::size_t before = bones.size();
        for (const auto& [name, bone] : all.items()) {
            const Json& parent = bone.at("parent");
            if (known.count(name) || (!parent.is_null() && !known.count(parent.get<std::string>()))) continue;
            Bone made{name, parent.is_null() ? -1 : known.at(parent.get<std::string>())};
            const Json& vertices = file.at("joints").at(bone.at("head").get<std::string>());
            for (const Json& v : vertices) made.head += Vec3d(positions.at(v.get<std::size_t>())) / double(vertices.size());
            known[name] = static_cast<int>(bones.size());
            bones.push_back(std::move(made));
        }
        if (bones.size() == before) throw Error("", "bones are each other's parents");
    }
    return bones;
}

// Holds the bones of each vertex, the heaviest first.
using Share = std::pair<float, int>;
std::vector<std::vector<Share>> read_weights(const Json& weights, const std::map<std::string, int>& bone_of,
                                             std::size_t vertices)
{
    std::vector<std::vector<Share>> shares(vertices);
    for (const auto& [name, list] : weights.items())
        for (const Json& entry : list)
            shares.at(entry.at(0).get<std::size_t>()).push_back({entry.at(1).get<float>(), bone_of.at(name)});
    for (std::vector<Share>& of_vertex : shares) std::sort(of_vertex.rbegin(), of_vertex.rend());
    return shares;
}

// Keeps the four heaviest bones, with their shares scaled to a sum of 1.
void add_vertex(Cage& cage, Vec3f position, std::vector<Share> shares)
{
    shares.resize(4, {0, 0});
    const float sum = shares[0].first + shares[1].first + shares[2].first + shares[3].first;
    cage.positions.push_back(position);
    cage.skin.joints.push_back({shares[0].second, shares[1].second, shares[2].second, shares[3].second});
    cage.skin.weights.push_back(sum > 0 ? Vec4f(shares[0].first, shares[1].first, shares[2].first, shares[3].first) / sum
                                        : Vec4f(1, 0, 0, 0));
}

// Returns true for vertices of the legs. Clothes deform a little differently from the body below, so the body's legs, which
// are not visible, are left out.
bool is_leg(const std::vector<Bone>& bones, const std::vector<Share>& shares)
{
    const std::string name = shares.empty() ? "" : bones[shares[0].second].name;
    return name.starts_with("upperleg") || name.starts_with("lowerleg");
}

Cage cage_of(const Mesh& mesh, const std::string& group, const std::vector<std::vector<Share>>& shares,
             const std::vector<Bone>& bones)
{
    Cage cage;
    cage.name = group;
    cage.skin.sets = 1;
    std::map<std::uint32_t, std::uint32_t> place_of;
    for (const auto& face : mesh.faces.at(group)) {
        if (group == "body" &&
            std::all_of(face.begin(), face.end(), [&](std::uint32_t v) { return is_leg(bones, shares.at(v)); }))
            continue;
        cage.face_sizes.push_back(4);
        for (const std::uint32_t v : face) {
            const auto [place, is_new] = place_of.try_emplace(v, static_cast<std::uint32_t>(cage.positions.size()));
            if (is_new) add_vertex(cage, mesh.positions.at(v), shares.at(v));
            cage.face_vertices.push_back(place->second);
        }
    }
    return cage;
}

}  // namespace

Body add_body(Scene& scene, const std::filesystem::path& folder, const std::string& shape, Vec3f clothes)
{
    const Mesh mesh = read_mesh(folder, shape);
    Body body;
    body.bones = read_bones(Json::parse(open(folder / "default.mhskel")), mesh.positions);
    for (std::size_t b = 0; b < body.bones.size(); ++b) body.bone_of[body.bones[b].name] = static_cast<int>(b);

    const auto shares = read_weights(Json::parse(open(folder / "default_weights.mhw")).at("weights"), body.bone_of,
                                     mesh.positions.size());
    const std::pair<const char*, Vec3f> pieces[] = {{"body", {0.75f, 0.55f, 0.45f}},
                                                    {"helper-tights", clothes},
                                                    {"helper-l-eye", Vec3f(0.8f)},
                                                    {"helper-r-eye", Vec3f(0.8f)}};
    NodeDesc shown;
    for (const auto& [group, color] : pieces) {
        Material material;
        material.base_color = Vec4f(color, 1);
        material.roughness = 0.6f;
        Cage cage = cage_of(mesh, group, shares, body.bones);
        cage.materials = {scene.add(material)};
        for (const Vec3f p : cage.positions) body.sole = std::min(body.sole, double(p.y));
        shown.cages.push_back(scene.add(std::move(cage)));
    }

    body.node = scene.add_node(scene.root(), {.name = "person"});
    Skin skin;
    for (Bone& bone : body.bones) {
        const bool is_root = bone.parent < 0;
        const Bone* above = is_root ? nullptr : &body.bones[static_cast<std::size_t>(bone.parent)];
        NodeDesc desc{.name = bone.name};
        desc.place.translation = bone.head - (is_root ? Vec3d(0) : above->head);
        bone.node = scene.add_node(is_root ? body.node : above->node, desc);
        Mat4d joint_from_mesh(1);
        joint_from_mesh[3] = Vec4d(-bone.head, 1);
        skin.joints.push_back(bone.node);
        skin.joint_from_mesh.push_back(joint_from_mesh);
    }
    shown.skin = scene.add(std::move(skin));
    scene.add_node(body.node, shown);
    return body;
}

}  // namespace sample
