#include "shade/mesh_lights.h"

#include <algorithm>
#include <cfloat>
#include <functional>
#include <limits>
#include <unordered_set>

#include "base/error_without_file.h"
#include "base/luminance.h"
#include "base/matrix.h"
#include "base/morton.h"
#include "scenegraph/cage_faces.h"
#include "scenegraph/contents.h"
#include "scenegraph/hidden_nodes.h"
#include "scenegraph/shutter.h"
#include "shade/input_limits.h"
#include "shade/surface.h"

namespace occam::shade {
namespace {

// A shadow ray ends this far before the plane of the emissive triangle, in ulps of the length of the ray and of the extent
// of the cage: rounding moves the end of the ray and the vertices by less (accel/ray_starts.h has the same for starts).
constexpr double kEndUlps = 16;

// Returns the mean over the whole texture: the filter is as wide as the image.
float mean_luminance(const Material& m, const TextureStore& textures) noexcept
{
    if (m.unlit || m.emission == Vec3f(0)) return 0;
    const Vec3f texture = m.emission_texture ? Vec3f(textures.sample(m.emission_texture, Vec2f(0.5f), 1e6f)) : Vec3f(1);
    return luminance(limited(m.emission) * glm::max(texture, Vec3f(0)));
}

const Material* material_of(const Scene& scene, const Node& node, const Cage& cage, std::size_t slot) noexcept
{
    const auto& from = node.materials.empty() ? cage.materials : node.materials;
    return slot < from.size() ? scene.find(from[slot]) : nullptr;
}

// Returns the number of material slots of a cage as the node shows it.
std::size_t slots_of(const Node& node, const Cage& cage) noexcept
{
    return std::max<std::size_t>(1, (node.materials.empty() ? cage.materials : node.materials).size());
}

bool emits(const Material* material) noexcept { return material && !material->unlit && material->emission != Vec3f(0); }

// Returns the area of a polygon in world axes.
double area_in_world(const Cage& cage, std::size_t first, std::size_t corners, const Mat4d& world_from_object) noexcept
{
    return polygon_area(corners, [&](std::size_t corner) {
        return transform_point(world_from_object, Vec3d(cage.positions[cage.face_vertices[first + corner]]));
    });
}

// The edges of the box that holds a node's cage, in world axes.
struct BoxEdges {
    Vec3d x{0}, y{0}, z{0};

    BoxEdges(const Node& node, const CageSlot& slot, const SkinSlot* skin, const Mat4d& world_from_object) noexcept
    {
        const Box3d box = cage_bounds(node, slot, skin);
        if (box.is_empty()) return;
        const Vec3d size = box.hi - box.lo;
        const auto edge = [&](Vec3d along) { return transform_vector(world_from_object, along); };
        x = edge({size.x, 0, 0});
        y = edge({0, size.y, 0});
        z = edge({0, 0, size.z});
    }
    double area() const noexcept
    {
        return 2 * (glm::length(glm::cross(x, y)) + glm::length(glm::cross(y, z)) + glm::length(glm::cross(z, x)));
    }
    /// Returns at least the distance of any two points of the box.
    double extent() const noexcept { return glm::length(x) + glm::length(y) + glm::length(z); }
};

// The faces of a cage and their area in world axes, for each slot of its materials.
struct SlotFaces {
    std::vector<std::uint32_t> faces;  ///< only those of slots that are asked for, slot after slot, in their order
    std::vector<std::size_t> end;      ///< of each slot, in `faces`
    std::vector<double> area;          ///< of each slot

    std::span<const std::uint32_t> of(std::size_t slot) const noexcept
    {
        const std::size_t first = slot == 0 ? 0 : end[slot - 1];
        return {faces.data() + first, end[slot] - first};
    }
};

// Looks at each face once. What deforms or is made on demand counts by its bounding box, and by the slot's share of the
// faces where they are known.
// is_asked_for   by slot
SlotFaces faces_of_slots(const Scene& scene, const Node& node, const CageSlot& slot, const std::vector<bool>& is_asked_for,
                         const Mat4d& world_from_object)
{
    const Cage& cage = slot.cage;
    const std::size_t slots = is_asked_for.size(), count = slot.is_on_demand() ? 0 : cage.face_count();
    SlotFaces out{{}, std::vector<std::size_t>(slots), std::vector<double>(slots)};
    const auto slot_of = [&](std::size_t face) { return cage.face_slots.empty() ? 0 : std::size_t(cage.face_slots[face]); };
    const auto is_counted = [&](std::size_t s) { return s < slots && is_asked_for[s]; };
    for (std::size_t face = 0; face < count; ++face)
        if (is_counted(slot_of(face))) ++out.end[slot_of(face)];
    std::vector<std::size_t> next(slots);
    for (std::size_t s = 1; s < slots; ++s) next[s] = out.end[s] += out.end[s - 1];
    for (std::size_t s = slots; s-- > 0;) next[s] = s == 0 ? 0 : out.end[s - 1];
    out.faces.resize(slots == 0 ? 0 : out.end.back());
    const bool is_rigid = !scene.find(node.skin) && !slot.is_deformed();
    std::size_t first = 0;
    for (std::size_t face = 0; face < count; ++face) {
        const std::size_t corners = cage.scheme == Scheme::Triangles ? 3 : cage.face_sizes[face], s = slot_of(face);
        if (is_counted(s)) {
            out.faces[next[s]++] = static_cast<std::uint32_t>(face);
            if (is_rigid) out.area[s] += area_in_world(cage, first, corners, world_from_object);
        }
        first += corners;
    }
    if (is_rigid && !slot.is_on_demand()) return out;
    const double whole = BoxEdges(node, slot, scene.find(node.skin), world_from_object).area();
    for (std::size_t s = 0; s < slots; ++s)
        out.area[s] = slot.is_on_demand() ? whole / double(slots)
                      : count == 0        ? 0
                                          : whole * double(out.of(s).size()) / double(count);
    return out;
}

// Returns the materials of a node whose surfaces are not sampled: the density with which a surface is sampled is known for a
// ray that hits it only if all cages of the node that show the material are triangles that stand still.
std::unordered_set<const Material*> unsampled_materials(const Scene& scene, const Node& node)
{
    std::unordered_set<const Material*> out;
    for (CageId id : node.cages) {
        const CageSlot* slot = scene.find(id);
        if (!slot) continue;
        const bool is_still = slot->cage.scheme == Scheme::Triangles && slot->cage.morph_targets.empty();
        const std::size_t slots = is_still ? 0 : (node.materials.empty() ? slot->cage.materials : node.materials).size();
        for (std::size_t s = 0; s < slots; ++s) out.insert(material_of(scene, node, slot->cage, s));
    }
    return out;
}

}  // namespace

// Returns how far a point is from a triangle: from its plane, or outside of it along the plane.
double MeshLights::distance_to(const TrianglePoints& c, Vec3d point) noexcept
{
    const Vec3d b = c.b - c.a, a = c.c - c.a, to = point - c.a, normal = glm::cross(b, a);
    const double area2 = glm::dot(normal, normal);
    if (!(area2 > 0)) return std::numeric_limits<double>::infinity();
    const double wb = std::clamp(glm::dot(glm::cross(to, a), normal) / area2, 0.0, 1.0),
                 wc = std::clamp(glm::dot(glm::cross(b, to), normal) / area2, 0.0, 1.0 - wb);
    return glm::length(to - b * wb - a * wc);
}

MeshLights::TrianglePoints MeshLights::corners(const Mesh& mesh, std::uint32_t face) noexcept
{
    const auto at = [&](std::uint32_t corner) {
        return transform_point(mesh.world_from_object,
                               Vec3d(mesh.cage->positions[mesh.cage->face_vertices[face * 3 + corner]]));
    };
    return {at(0), at(1), at(2)};
}

/// A placed node, and what holds for all of its cages.
struct MeshLights::Placed {
    const Scene& scene;
    const Node& node;
    NodeId id;
    Mat4d world_from_object;
    /// Whether points on it are sampled: not if it moves while the shutter is open, or is hidden from scattered rays.
    bool is_sampled;
    std::uint8_t kinds;  ///< of the rays that tell whether its light arrives
    std::unordered_set<const Material*> unsampled;
};

void MeshLights::add(const Placed& placed, CageId cage_id, const CageSlot& slot)
{
    const auto& [scene, node, id, world_from_object, is_sampled, kinds, unsampled] = placed;
    const Cage& cage = slot.cage;
    const std::size_t slots = slots_of(node, cage);
    std::vector<bool> glows(slots);
    for (std::size_t s = 0; s < slots; ++s) glows[s] = emits(material_of(scene, node, cage, s));
    if (std::ranges::none_of(glows, std::identity())) return;
    any_emitter_ = true;
    const SlotFaces found = faces_of_slots(scene, node, slot, glows, world_from_object);
    const auto extent = static_cast<float>(BoxEdges(node, slot, scene.find(node.skin), world_from_object).extent());
    for (std::size_t s = 0; s < slots; ++s) {
        if (!glows[s]) continue;
        const Material* material = material_of(scene, node, cage, s);
        const float density = mean_luminance(*material, *textures_);
        if (density > 0 && std::isfinite(found.area[s])) power_ += double(density) * found.area[s];
        if (!(density > 0) || !is_sampled || scene.find(node.skin) || unsampled.contains(material)) continue;
        const bool is_mirrored = mirrors(Mat3d(world_from_object));
        const Mesh mesh{id, cage_id, &cage, material, world_from_object, density, is_mirrored, extent, kinds};
        const std::size_t before = sums_.size();
        for (const std::uint32_t face : found.of(s)) {
            const TrianglePoints c = corners(mesh, face);
            const double area = 0.5 * glm::length(glm::cross(c.b - c.a, c.c - c.a));
            if (!(area > 0)) continue;
            sums_.push_back((sums_.empty() ? 0 : sums_.back()) + area * double(density));
            faces_.push_back(face);
        }
        if (sums_.size() == before) continue;
        mesh_indices_.resize(sums_.size(), static_cast<std::uint32_t>(meshes_.size()));
        meshes_.push_back(mesh);
    }
}

MeshLights::MeshLights(const Scene& scene, const TextureStore& textures, const FrameScale& scale) : textures_(&textures)
{
    const std::unordered_set<NodeId> moving = moving_nodes(scene, Contents::Emitters);
    const std::unordered_set<NodeId> hidden = nodes_hidden_from(
        scene, RayKind::Reflection | RayKind::Transmission | RayKind::Diffuse, Contents::Emitters);
    // Shadow rays would find the far side of such a mesh through its near side, which scattered rays cannot.
    const std::unordered_set<NodeId> unshadowed = nodes_hidden_from(scene, RayKind::Shadow, Contents::Emitters);
    std::size_t faces = 0;
    scene.for_placements_of(Contents::Emitters, [&](NodeId, const Node& node, const Mat4d&) {
        for (CageId id : node.cages)
            if (const CageSlot* slot = scene.find(id))
                faces += std::max(slot->is_on_demand() ? 0 : slot->cage.face_count(), slots_of(node, slot->cage));
        if (faces > kMostFaces)
            throw error_without_file("objects that emit light have more than " + std::to_string(kMostFaces) +
                                         " faces or slots of materials, counted in each place where they are "
                                         "shown",
                                     naming(node));
    });
    scene.for_placements_of(Contents::Emitters, [&](NodeId id, const Node& node, const Mat4d& world_from_node) {
        const Placed placed{scene,
                            node,
                            id,
                            scale.placed(world_from_node),
                            !moving.contains(id) && !hidden.contains(id),
                            unshadowed.contains(id) ? RayKind::Diffuse : RayKind::Shadow,
                            unsampled_materials(scene, node)};
        for (CageId cage : node.cages)
            if (const CageSlot* slot = scene.find(cage)) add(placed, cage, *slot);
    });
}

void MeshLights::sort_by_place()
{
    const auto middle_of = [&](std::uint32_t i) {
        const TrianglePoints c = corners(mesh_of(i), faces_[i]);
        return (c.a + c.b + c.c) / 3.0;
    };
    const auto count = static_cast<std::uint32_t>(sums_.size());
    Box3d middles;
    for (std::uint32_t i = 0; i < count; ++i) middles.add(middle_of(i));
    std::vector<std::pair<std::uint64_t, std::uint32_t>> order(count);
    for (std::uint32_t i = 0; i < count; ++i) order[i] = {morton_code(middle_of(i), middles), i};
    std::sort(order.begin(), order.end());
    const auto sorted = [&](const std::vector<std::uint32_t>& from) {
        std::vector<std::uint32_t> to;
        to.reserve(count);
        for (const auto& [code, i] : order) to.push_back(from[i]);
        return to;
    };
    std::vector<double> sums;
    sums.reserve(count);
    for (const auto& [code, i] : order) sums.push_back((sums.empty() ? 0 : sums.back()) + (sums_[i] - sum_before(i)));
    sums_ = std::move(sums);
    mesh_indices_ = sorted(mesh_indices_);
    faces_ = sorted(faces_);
}

void MeshLights::make_tree(std::optional<Vec3d> origin)
{
    if (sums_.empty()) return;
    constexpr std::size_t kMostLeaves = 65536;
    of_a_leaf_ = (sums_.size() + kMostLeaves - 1) / kMostLeaves;
    if (of_a_leaf_ > 1) sort_by_place();  // else the box of a leaf could be as large as the scene
    const TrianglePoints first = corners(mesh_of(0), faces_.front());
    std::vector<LightTree::Triangle> triangles;
    const auto triangles_of = [&](std::size_t leaf) {
        triangles.clear();
        for (std::uint32_t i = first_of(leaf); i < end_of(leaf); ++i) {
            const TrianglePoints c = corners(mesh_of(i), faces_[i]);
            triangles.push_back({{c.a, c.b, c.c}, sums_[i] - sum_before(i)});
        }
        return std::span<const LightTree::Triangle>(triangles);
    };
    tree_ = LightTree((sums_.size() + of_a_leaf_ - 1) / of_a_leaf_, origin.value_or(first.a), triangles_of);
}

MeshLights::Choice MeshLights::choose(const Receiver& receiver, float number) const noexcept
{
    const auto in = [&](std::uint32_t begin, std::uint32_t end, float share) {
        const double low = sum_before(begin), wanted = low + double(share) * (sum_before(end) - low);
        const auto above = std::upper_bound(sums_.begin() + begin, sums_.begin() + (end - 1), wanted);
        return static_cast<std::uint32_t>(above - sums_.begin());
    };
    LightTree::Pick pick;
    if (tree_.draw(receiver, number, {&pick, 1}) == 0) return {0, 0};
    const std::uint32_t i = in(first_of(pick.light), end_of(pick.light), pick.rest);
    return {i, double(pick.expected) * double(mesh_of(i).area_density) / sum_of(pick.light)};
}

float MeshLights::area_density(const Place& at, const Receiver& receiver) const noexcept
{
    if (tree_.is_empty()) return 0;
    // Where a node is placed several times, each placement has a triangle of this number: the one nearest to the point
    // counts. The point is a hit's, which is rounded as the whole of its cage is: it may be beside a box that is as small,
    // or as flat, as the triangle.
    double nearest = std::numeric_limits<double>::infinity();
    std::uint32_t leaf_hit = 0;
    const Mesh* mesh_hit = nullptr;
    tree_.for_boxes_around(at.position, at.rounding, [&](std::uint32_t leaf) {
        for (std::uint32_t i = first_of(leaf); i < end_of(leaf); ++i) {
            if (faces_[i] != at.face) continue;
            const Mesh& mesh = mesh_of(i);
            if (mesh.node != at.node || mesh.cage_id != at.cage || mesh.material != at.material) continue;
            const double distance = distance_to(corners(mesh, at.face), at.position);
            if (distance >= nearest) continue;
            nearest = distance;
            leaf_hit = leaf;
            mesh_hit = &mesh;
        }
    });
    if (!mesh_hit) return 0;
    return static_cast<float>(double(tree_.expected(leaf_hit, receiver, 1)) * double(mesh_hit->area_density) /
                              sum_of(leaf_hit));
}

LightSample MeshLights::sample(Vec3d point, const Receiver& receiver, LightNumbers numbers) const noexcept
{
    if (meshes_.empty()) return {};
    const Choice chosen = choose(receiver, numbers.choice);
    if (!(chosen.area_density > 0)) return {};
    const Mesh& mesh = mesh_of(chosen.triangle);
    const std::uint32_t face = faces_[chosen.triangle];
    const TrianglePoints c = corners(mesh, face);

    // The point is uniform in the triangle (Turk 1990).
    const float root = std::sqrt(numbers.square.x);
    const double wa = 1 - double(root), wb = double(root) * (1 - double(numbers.square.y)), wc = 1 - wa - wb;
    ShadePoint p;
    p.position = c.a * wa + c.b * wb + c.c * wc;
    const Vec3d to_light = p.position - point;
    const double distance2 = glm::dot(to_light, to_light);
    const Vec3d normal = glm::cross(c.b - c.a, c.c - c.a);
    const double length = glm::length(normal), distance = std::sqrt(distance2);
    const double cosine = std::fabs(glm::dot(normal, to_light)) / (length * distance);
    if (!(cosine > 0) || !(distance > 0)) return {};

    p.material = mesh.material;
    p.to_eye = Vec3f(to_light / -distance);
    const bool is_along_normal = glm::dot(normal, to_light) > 0;
    p.back_side = is_along_normal != mesh.is_mirrored;
    if (p.back_side && !shows_backs_ && is_single_sided(*mesh.material)) return {};
    p.normal_geometric = p.normal_shading = Vec3f(normal / (is_along_normal ? -length : length));
    for (std::size_t s = 0; s < 2 && s < mesh.cage->uv_sets.size(); ++s) {
        const UvSet& set = mesh.cage->uv_sets[s];
        const auto uv = [&](std::uint32_t corner) {
            const std::size_t at = std::size_t(face) * 3 + corner;
            return set.values[set.indices.empty() ? mesh.cage->face_vertices[at] : set.indices[at]];
        };
        p.texture.uv[s] = uv(0) * float(wa) + uv(1) * float(wb) + uv(2) * float(wc);
    }
    if (const Cage& cage = *mesh.cage; !cage.colors.empty()) {
        const auto color = [&](std::uint32_t corner) {
            const std::size_t at = std::size_t(face) * 3 + corner;
            return cage.colors[cage.color_indices.empty() ? cage.face_vertices[at] : cage.color_indices[at]];
        };
        p.color = color(0) * float(wa) + color(1) * float(wb) + color(2) * float(wc);
    }
    const Surface surface = evaluate(p, *textures_);
    const auto density = static_cast<float>(chosen.area_density * distance2 / cosine);
    if (!(density > 0)) return {};
    const double short_by = kEndUlps * FLT_EPSILON * (distance + double(mesh.extent)) / cosine;
    return {Vec3f(to_light / distance), static_cast<float>(std::max(distance - short_by, 0.0)),
            surface.emission * (surface.opacity / density), density, mesh.kinds};
}

}  // namespace occam::shade
