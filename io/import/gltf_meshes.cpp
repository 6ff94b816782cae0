#include "io/import/gltf_meshes.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <span>
#include <utility>

#include "io/import/cage_bytes.h"
#include "io/import/file_colors.h"
#include "io/import/gltf_door.h"
#include "io/import/gltf_value.h"
#include "io/import/polygons.h"
#include "io/import/same_triangles.h"
#include "io/import/vertices.h"

namespace occam::import {

namespace {

constexpr std::size_t kMaxMorphTargets = 8192;
constexpr std::size_t kBytesBesideASlot = 512;  // of what a scene knows of a cage, its lists and its handles

int attribute(const tinygltf::Primitive& primitive, const std::string& name)
{
    const auto found = primitive.attributes.find(name);
    return found == primitive.attributes.end() ? -1 : found->second;
}

// FB_ngon_encoding: successive triangles that share their first vertex are a fan that was one polygon.
void restore_polygons(Cage& cage, bool has_polygons)
{
    const std::vector<std::uint32_t> t = std::move(cage.face_vertices);
    cage.face_vertices.clear();
    cage.scheme = Scheme::CatmullClark;
    for (std::size_t i = 0; i + 2 < t.size(); i += 3) {
        const bool goes_on = has_polygons && i > 0 && t[i] == t[i - 3] && t[i + 1] == t[i - 1];
        if (goes_on) {
            cage.face_vertices.push_back(t[i + 2]);
            ++cage.face_sizes.back();
        } else {
            cage.face_vertices.insert(cage.face_vertices.end(), {t[i], t[i + 1], t[i + 2]});
            cage.face_sizes.push_back(3);
        }
    }
}

template <class T>
void append(std::vector<T>& to, std::size_t to_vertices, const std::vector<T>& from, std::size_t from_vertices, T otherwise)
{
    if (to.empty() && from.empty()) return;
    to.resize(to_vertices, otherwise);
    to.insert(to.end(), from.begin(), from.end());
    to.resize(to_vertices + from_vertices, otherwise);
}

// Appends the faces of `part` to those of `cage`, with a material slot of their own. What moves them is left to join().
void append(Cage& cage, const Cage& part)
{
    const std::size_t n = cage.positions.size(), m = part.positions.size();
    if (cage.uv_sets.size() < part.uv_sets.size()) cage.uv_sets.resize(part.uv_sets.size());
    for (std::size_t s = 0; s < cage.uv_sets.size(); ++s) {
        static const std::vector<Vec2f> none;
        std::vector<Vec2f>& values = cage.uv_sets[s].values;
        values.resize(n, Vec2f(0));
        append(values, n, s < part.uv_sets.size() ? part.uv_sets[s].values : none, m, Vec2f(0));
    }
    append(cage.colors, n, part.colors, m, Vec4f(1));
    cage.positions.insert(cage.positions.end(), part.positions.begin(), part.positions.end());
    for (std::uint32_t v : part.face_vertices)
        cage.face_vertices.push_back(v < m ? v + static_cast<std::uint32_t>(n) : kNoIndex);
    cage.face_sizes.insert(cage.face_sizes.end(), part.face_sizes.begin(), part.face_sizes.end());
    cage.face_slots.insert(cage.face_slots.end(), part.face_sizes.size(), static_cast<std::uint16_t>(cage.materials.size()));
    cage.materials.push_back(part.materials.empty() ? MaterialId() : part.materials[0]);
}

// Says what moves the vertices of parts that become one cage.
struct Motion {
    std::vector<bool> moves;  // by morph target: it has offsets in one of the parts at least
    int sets = 0;             // of joints, in the part that has most
};
Motion motion_of(const std::vector<Cage>& parts)
{
    Motion motion;
    for (const Cage& part : parts) {
        motion.sets = std::max(motion.sets, part.skin.sets);
        if (motion.moves.size() < part.morph_targets.size()) motion.moves.resize(part.morph_targets.size());
        for (std::size_t t = 0; t < part.morph_targets.size(); ++t)
            if (!part.morph_targets[t].positions.empty()) motion.moves[t] = true;
    }
    return motion;
}

// Returns how many bytes of zeros join() adds.
std::size_t padding_of(const std::vector<Cage>& parts)
{
    constexpr std::size_t kSet = sizeof(SkinBinding::joints[0]) + sizeof(SkinBinding::weights[0]);
    const Motion motion = motion_of(parts);
    const auto moving = static_cast<std::size_t>(std::count(motion.moves.begin(), motion.moves.end(), true));
    std::size_t bytes = 0;
    for (const Cage& part : parts) {
        std::size_t own = 0;
        for (const MorphTarget& target : part.morph_targets) own += !target.positions.empty();
        bytes += part.positions.size() *
                 ((moving - own) * sizeof(Vec3f) + static_cast<std::size_t>(motion.sets - part.skin.sets) * kSet);
    }
    return bytes;
}

// Makes one cage of several. A part that lacks a morph target, or a set of joints that another part has, gets offsets or
// weights of 0 there, which move nothing.
Cage join(const std::vector<Cage>& parts)
{
    Cage whole;
    whole.name = parts.at(0).name;
    for (const Cage& part : parts) append(whole, part);
    const Motion motion = motion_of(parts);
    const std::size_t vertices = whole.positions.size();
    whole.morph_targets.resize(motion.moves.size());
    for (std::size_t t = 0; t < motion.moves.size(); ++t)
        if (motion.moves[t]) whole.morph_targets[t].positions.resize(vertices, Vec3f(0));
    whole.skin.sets = motion.sets;
    whole.skin.joints.resize(static_cast<std::size_t>(motion.sets) * vertices, glm::u16vec4(0));
    whole.skin.weights.resize(whole.skin.joints.size(), Vec4f(0));
    std::size_t first = 0;
    for (const Cage& part : parts) {
        const std::size_t count = part.positions.size();
        for (std::size_t t = 0; t < part.morph_targets.size(); ++t)
            std::ranges::copy(part.morph_targets[t].positions, whole.morph_targets[t].positions.data() +
                                                                   (part.morph_targets[t].positions.empty() ? 0 : first));
        for (std::size_t set = 0; set < static_cast<std::size_t>(part.skin.sets); ++set) {
            std::copy_n(part.skin.joints.data() + set * count, count, whole.skin.joints.data() + set * vertices + first);
            std::copy_n(part.skin.weights.data() + set * count, count, whole.skin.weights.data() + set * vertices + first);
        }
        first += count;
    }
    return whole;
}

}  // namespace

const std::vector<CageId>& MeshImporter::cages(int mesh, const CageStyle& style)
{
    const auto [entry, is_new] = cages_.try_emplace({mesh, style});
    std::vector<CageId>& ids = entry->second;
    if (!is_new || mesh < 0 || static_cast<std::size_t>(mesh) >= model_.meshes.size()) return ids;
    const tinygltf::Mesh& m = model_.meshes[static_cast<std::size_t>(mesh)];
    const std::string where = named_element("meshes", static_cast<std::size_t>(mesh), m.name);
    const bool is_subdivided = style.scheme ? *style.scheme != CageStyle::Scheme::None : options_.subdivide == Subdivide::On;
    if (const auto source = sources_.find({mesh, is_subdivided}); source != sources_.end()) {
        for (const CageId id : source->second) ids.push_back(add(copy(id, where, is_subdivided), style, where));
        return ids;
    }
    for (Cage& cage : made(m, where, is_subdivided)) ids.push_back(add(std::move(cage), style, where));
    sources_.try_emplace({mesh, is_subdivided}, ids);
    return ids;
}

std::vector<Cage> MeshImporter::made(const tinygltf::Mesh& mesh, const std::string& where, bool is_subdivided)
{
    accessors_.copies().charge(mesh.primitives.size(), mesh.name.size(), where);  // accessors are charged for what they hold
    std::vector<Cage> made;
    for (std::size_t p = 0; p < mesh.primitives.size(); ++p) {
        std::optional<PrimitiveCage> part = read(mesh.primitives[p], where + ".primitives[" + std::to_string(p) + "]");
        if (!part) continue;
        part->cage.name = mesh.name;
        if (is_subdivided) restore_polygons(part->cage, part->has_polygons);
        made.push_back(std::move(part->cage));
    }
    if (is_subdivided) made = joined(std::move(made), where);
    for (Cage& cage : made) {
        if (!is_subdivided) {
            drop_same_triangles(cage, report_);
            check_boxes(cage, report_);
        }
        const auto weights = std::span(mesh.weights).first(std::min(mesh.weights.size(), cage.morph_targets.size()));
        for (const double weight : weights) cage.morph_weights.push_back(static_cast<float>(weight));
    }
    return made;
}

Cage MeshImporter::copy(CageId source, const std::string& where, bool is_subdivided)
{
    const Cage& from = scene_.cage(source).cage;
    accessors_.copies().charge(1, bytes_of(from) + sizeof(CageSlot) + kBytesBesideASlot, where);
    Cage cage = from;
    const Cage none;
    cage.scheme = is_subdivided ? Scheme::CatmullClark : Scheme::Triangles;
    cage.boundary = none.boundary, cage.face_varying = none.face_varying;
    cage.displacement.reset();
    return cage;
}

CageId MeshImporter::add(Cage cage, const CageStyle& style, const std::string& where)
{
    style.apply(cage);
    if (style.displacement) cage.displacement = materials_.displacement(*style.displacement, where);
    return scene_.add(std::move(cage));
}

std::vector<Cage> MeshImporter::joined(std::vector<Cage> parts, const std::string& where)
{
    constexpr std::size_t kMostSlots = 0xffff;
    std::vector<Cage> whole, skinned;
    if (parts.size() > kMostSlots) {
        report_.warn("a mesh has more than 65535 primitives: each is subdivided by itself", where);
        whole = std::move(parts);
    } else {
        const auto is_skinned = [](const Cage& part) { return part.skin.sets > 0; };
        const auto moved = std::stable_partition(parts.begin(), parts.end(), std::not_fn(is_skinned));
        skinned.assign(std::make_move_iterator(moved), std::make_move_iterator(parts.end()));
        parts.erase(moved, parts.end());
        if (!parts.empty() && !skinned.empty())
            report_.warn("primitives with joints are subdivided apart from those without", where);
        for (std::vector<Cage>* group : {&parts, &skinned}) {
            if (group->size() > 1) {
                accessors_.copies().charge(1, padding_of(*group), where);
                whole.push_back(join(*group));
            } else if (!group->empty()) {
                whole.push_back(std::move(group->front()));
            }
            group->clear();
        }
    }
    for (Cage& cage : whole) weld(cage);
    return whole;
}

std::optional<MeshImporter::PrimitiveCage> MeshImporter::read(const tinygltf::Primitive& primitive, const std::string& where)
{
    const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
    if (mode != TINYGLTF_MODE_TRIANGLES && mode != TINYGLTF_MODE_TRIANGLE_STRIP && mode != TINYGLTF_MODE_TRIANGLE_FAN) {
        report_.warn("points and lines are not rendered", where);
        return std::nullopt;
    }
    const int position = attribute(primitive, "POSITION");
    if (position < 0) {
        report_.warn("primitive without positions", where);
        return std::nullopt;
    }
    PrimitiveCage part;
    part.has_polygons = primitive.extensions.count("FB_ngon_encoding") > 0;
    Cage& cage = part.cage;
    cage.scheme = Scheme::Triangles;
    cage.face_vertices = triangles(primitive, position, where);
    if (cage.face_vertices.empty()) {
        report_.warn("primitive without a triangle", where);
        return std::nullopt;
    }
    Vertices vertices{accessors_.count(position), {}};
    vertices.used = choose_used_vertices(cage.face_vertices, vertices.count);
    cage.positions = accessors_.vec3(position, vertices.used);
    read_attributes(primitive, vertices, cage, where);
    read_skin(primitive, vertices, cage, where);
    read_morph_targets(primitive, vertices, cage, where);
    cage.materials = {materials_.material(material_index(primitive))};
    return part;
}

int MeshImporter::material_index(const tinygltf::Primitive& primitive) const
{
    const tinygltf::Value& mappings = member(extension(primitive.extensions, "KHR_materials_variants"), "mappings");
    if (variant_ < 0 || !mappings.IsArray()) return primitive.material;
    for (std::size_t m = 0; m < mappings.ArrayLen(); ++m) {
        const tinygltf::Value& mapping = mappings.Get(m);
        const tinygltf::Value& variants = member(mapping, "variants");
        for (std::size_t v = 0; variants.IsArray() && v < variants.ArrayLen(); ++v)
            if (variants.Get(v).IsNumber() && variants.Get(v).GetNumberAsInt() == variant_)
                return integer(mapping, "material", primitive.material);
    }
    return primitive.material;
}

std::vector<std::uint32_t> MeshImporter::triangles(const tinygltf::Primitive& primitive, int position,
                                                   const std::string& where)
{
    std::vector<std::uint32_t> list;
    const int indices = primitive.indices >= 0 ? primitive.indices : attribute(primitive, kIndicesAttribute);
    if (indices >= 0) {
        list = accessors_.indices(indices);
        const int type = accessors_.at(indices).componentType;
        const std::uint32_t restart = type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE    ? 0xff
                                      : type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ? 0xffff
                                                                                       : 0xffffffff;
        if (std::find(list.begin(), list.end(), restart) != list.end())
            report_.warn("indices hold the value of primitive restart", where);
    } else {
        list = accessors_.numbers(position);
    }
    if (primitive.mode == TINYGLTF_MODE_TRIANGLE_STRIP || primitive.mode == TINYGLTF_MODE_TRIANGLE_FAN) {
        // Every second triangle of a strip is reversed, so that all wind alike (glTF 2.0, sec. 3.7.2.1).
        const bool is_strip = primitive.mode == TINYGLTF_MODE_TRIANGLE_STRIP;
        std::vector<std::uint32_t> out;
        for (std::size_t i = 0; i + 2 < list.size(); ++i) {
            if (is_strip) out.insert(out.end(), {list[i], list[i + 1 + i % 2], list[i + 2 - i % 2]});
            else out.insert(out.end(), {list[i + 1], list[i + 2], list[0]});
        }
        return out;
    }
    if (list.size() % 3 != 0) {
        report_.warn("the number of indices is not a multiple of three", where);
        list.resize(list.size() / 3 * 3);
    }
    return list;
}

int MeshImporter::per_vertex(int accessor, const Vertices& vertices, const char* name, const std::string& where) const
{
    if (accessors_.count(accessor) == vertices.count) return accessor;
    throw Error(report_.name(), std::string(name) + " has another count than POSITION", where);
}

void MeshImporter::read_attributes(const tinygltf::Primitive& primitive, const Vertices& vertices, Cage& cage,
                                   const std::string& where)
{
    if (const int a = attribute(primitive, "NORMAL"); a >= 0) {
        cage.normals = accessors_.vec3(per_vertex(a, vertices, "NORMAL", where), vertices.used);
        const auto is_far_from_unit = [](Vec3f n) { return !(std::abs(glm::dot(n, n) - 1) < 0.02f); };
        if (std::any_of(cage.normals.begin(), cage.normals.end(), is_far_from_unit))
            report_.warn("normals are not of unit length", where);
    }
    for (const char* name : {"TEXCOORD_1", "TEXCOORD_0"}) {
        const int a = attribute(primitive, name);
        if (a < 0 && cage.uv_sets.empty()) continue;
        // The second set keeps its number even if there is no first one.
        std::vector<Vec2f> values = a < 0 ? std::vector<Vec2f>(cage.positions.size(), Vec2f(0))
                                          : accessors_.vec2(per_vertex(a, vertices, name, where), vertices.used);
        cage.uv_sets.insert(cage.uv_sets.begin(), UvSet{std::move(values), {}});
    }
    if (const int a = attribute(primitive, "COLOR_0"); a >= 0) {
        cage.colors = accessors_.vec4(per_vertex(a, vertices, "COLOR_0", where), vertices.used);
        if (accessors_.components(a) == 3)
            for (Vec4f& color : cage.colors) color.w = 1;
        clamp_colors(cage.colors, report_, where);
    }
}

void MeshImporter::read_skin(const tinygltf::Primitive& primitive, const Vertices& vertices, Cage& cage,
                             const std::string& where)
{
    for (int set = 0;; ++set) {
        const std::string number = std::to_string(set);
        const int joints = attribute(primitive, "JOINTS_" + number), weights = attribute(primitive, "WEIGHTS_" + number);
        if (joints < 0 || weights < 0) {
            if (joints >= 0 || weights >= 0) throw Error(report_.name(), "joints and weights come in pairs", where);
            return;
        }
        const auto j = accessors_.joints(per_vertex(joints, vertices, "JOINTS", where), vertices.used);
        const auto w = accessors_.vec4(per_vertex(weights, vertices, "WEIGHTS", where), vertices.used);
        cage.skin.joints.insert(cage.skin.joints.end(), j.begin(), j.end());
        cage.skin.weights.insert(cage.skin.weights.end(), w.begin(), w.end());
        cage.skin.sets = set + 1;
    }
}

void MeshImporter::read_morph_targets(const tinygltf::Primitive& primitive, const Vertices& vertices, Cage& cage,
                                      const std::string& where)
{
    const auto values = [&](int accessor) {
        return accessors_.vec3(per_vertex(accessor, vertices, "morph target", where), vertices.used);
    };
    if (primitive.targets.size() > kMaxMorphTargets)
        throw Error(report_.name(), "has more than " + std::to_string(kMaxMorphTargets) + " morph targets", where);
    for (const auto& attributes : primitive.targets) {
        MorphTarget target;
        for (const auto& [name, accessor] : attributes)
            if (name.starts_with("COLOR_") || name.starts_with("TEXCOORD_"))
                report_.warn("morph targets of " + name.substr(0, 64) + " are not read", where);
        if (const auto a = attributes.find("POSITION"); a != attributes.end()) target.positions = values(a->second);
        if (const auto a = attributes.find("NORMAL"); a != attributes.end()) target.normals = values(a->second);
        cage.morph_targets.push_back(std::move(target));
    }
}

}  // namespace occam::import
