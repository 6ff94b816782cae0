#include "lod/posed_cage.h"

#include <cmath>

#include "base/matrix.h"

namespace occam::lod {

void PosedCage::place(const Mat4d& world_from_object, const Box3d& object_bounds) noexcept
{
    set_frame(transform_box(world_from_object, object_bounds));
    set_map(world_from_object);
}

void PosedCage::set_frame(const Box3d& world) noexcept
{
    radius = static_cast<float>(world.radius()) * 1.0001f;
    // The lattice's step is a power of two near the radius, so an anchor has few bits and survives small movements.
    const double step = std::ldexp(1.0, std::ilogb(std::max(double(radius), 1e-30)));
    anchor = glm::round(world.centre() / step) * step;
    radius += static_cast<float>(glm::distance(anchor, world.centre()));
}

void PosedCage::set_map(const Mat4d& world_from_object) noexcept
{
    if (slot) positions = slot->cage.positions.data();
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) frame_from_object[r][c] = world_from_object[c][r];
        frame_from_object[r][3] = world_from_object[3][r] - anchor[r];
        for (int c = 0; c < 4; ++c) columns[c][r] = frame_from_object[r][c];
    }
    is_mirrored = mirrors(Mat3d(world_from_object));
}

Mat4d PosedCage::world_from_object() const noexcept
{
    Mat4d m(1);
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 4; ++c) m[c][r] = frame_from_object[r][c];
        m[3][r] += anchor[r];
    }
    return m;
}

void PosedCage::deform(const DeformedClusters& bounds, const CagePose& pose, Arena& arena, DeformCounters& counters)
{
    deformed = arena.make<DeformedCage>(*slot, pose, frame_from_object, arena, counters);
    deformed_clusters = &bounds;
    is_mirrored = deformed->is_mirrored();
}

void PosedCage::displace(const TextureStore& textures) noexcept
{
    if (topology)
        displacement = PosedDisplacement(slot->cage, textures, frame_from_object, is_mirrored, deformed != nullptr, radius);
}

void PosedCage::derive(Arena& arena)
{
    const std::size_t count = topology ? topology->derived_count() : 0;
    if (count == 0) return;
    std::vector<Vec3f> vertices(slot->cage.positions.size());
    for (std::uint32_t v = 0; v < vertices.size(); ++v) vertices[v] = vertex(v);
    const std::span<Vec3f> points = arena.make_array<Vec3f>(count);
    topology->derive(vertices, points);
    derived = points.data();
    if (!is_displaced()) return;
    const std::span<Vec3f> at_rest = arena.make_array<Vec3f>(count);
    topology->derive(slot->cage.positions, at_rest);
    rest_derived = at_rest.data();
}

Box3d PosedCage::world_box(std::uint32_t cluster) const noexcept
{
    const auto grown = [&](const Box3d& box) {
        return box.is_empty() ? box : Box3d{box.lo - double(displacement.reach), box.hi + double(displacement.reach)};
    };
    if (cluster_boxes) {
        const Box3f& box = cluster_boxes[cluster];
        return box.is_empty() ? Box3d() : grown({Vec3d(box.lo) + anchor, Vec3d(box.hi) + anchor});
    }
    if (deformed) {
        const Box3d box = deformed->box((*deformed_clusters)[cluster]);
        return grown({box.lo + anchor, box.hi + anchor});
    }
    const Box3f& box = clusters->node(cluster).box;
    return grown(transform_box(world_from_object(), {Vec3d(box.lo), Vec3d(box.hi)}));
}

namespace {

// A surface and its image under a map have normals that the map's cofactors take to each other. These are its inverse
// transpose times its determinant.
Vec3d turned_by_cofactors(const Mat3d& map, Vec3d n) noexcept
{
    return glm::cross(map[1], map[2]) * n.x + glm::cross(map[2], map[0]) * n.y + glm::cross(map[0], map[1]) * n.z;
}

Mat3d between(const Mat3d& a, const Mat3d& b, float share) noexcept { return a * (1 - double(share)) + b * double(share); }

}  // namespace

Mat3d PosedCage::linear_map() const noexcept
{
    Mat3d map;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) map[c][r] = frame_from_object[r][c];
    return map;
}

double PosedCage::size_of_faces(std::span<const FaceVertices> faces) const noexcept
{
    double areas = 0;
    for (const FaceVertices face : faces)
        areas += glm::length(
            vector_area(face, [&](std::uint32_t v) { return Vec3d(deformed ? deformed->posed(v) : pose(positions[v])); }));
    return std::sqrt(areas);
}

bool PosedCage::is_mirrored_at(KeyTime time) const noexcept
{
    const PosedCage &a = at_key(time.key), &b = at_key(segments > 0 ? time.key + 1 : 0);
    const Mat3d from = a.linear_map(), to = b.linear_map();
    if (!deformed || !deformed->is_skinned()) return mirrors(between(from, to, time.share));
    // Joints may undo what the map does.
    if (a.is_mirrored == b.is_mirrored) return a.is_mirrored;
    const bool joints_mirror = a.is_mirrored != mirrors(from);
    if (joints_mirror != (b.is_mirrored != mirrors(to))) return time.share < 0.5f ? a.is_mirrored : b.is_mirrored;
    return mirrors(between(from, to, time.share)) != joints_mirror;
}

Vec3f PosedCage::moved_normal(Vec3f n, KeyTime time) const noexcept
{
    const Mat3d map = between(at_key(time.key).linear_map(), at_key(time.key + 1).linear_map(), time.share);
    const Vec3d at_rest = glm::transpose(at_key(normal_key).linear_map()) * Vec3d(n);
    const Vec3d turned = turned_by_cofactors(map, at_rest);
    const double length = glm::length(turned);
    if (!(length > 0)) return n;
    return Vec3f(turned * ((mirrors(map) ? -1.0 : 1.0) / length));
}

Vec3f PosedCage::pose_normal(Vec3f n) const noexcept
{
    const Vec3d turned = turned_by_cofactors(linear_map(), Vec3d(n));
    const double length = glm::length(turned);
    if (!(length > 0)) return n;
    return Vec3f(turned * ((is_mirrored ? -1.0 : 1.0) / length));
}

}  // namespace occam::lod
