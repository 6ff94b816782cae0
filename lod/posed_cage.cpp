#include "lod/posed_cage.h"

#include <cmath>

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
    is_mirrored = glm::determinant(Mat3d(world_from_object)) < 0;
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

bool PosedCage::is_mirrored_at(KeyTime time) const noexcept
{
    const PosedCage &a = at_key(time.key), &b = at_key(segments > 0 ? time.key + 1 : 0);
    if (a.is_mirrored == b.is_mirrored) return a.is_mirrored;
    if (deformed) return time.share < 0.5f ? a.is_mirrored : b.is_mirrored;
    Mat3d between;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
            between[c][r] = glm::mix(a.frame_from_object[r][c], b.frame_from_object[r][c], double(time.share));
    return glm::determinant(between) < 0;
}

Vec3f PosedCage::pose_normal(Vec3f n) const noexcept
{
    // The cofactors of the map are its inverse transpose times its determinant.
    const auto& m = frame_from_object;
    const Vec3d a{m[0][0], m[1][0], m[2][0]}, b{m[0][1], m[1][1], m[2][1]}, c{m[0][2], m[1][2], m[2][2]};
    const Vec3d turned = glm::cross(b, c) * double(n.x) + glm::cross(c, a) * double(n.y) + glm::cross(a, b) * double(n.z);
    const double length = glm::length(turned);
    if (!(length > 0)) return n;
    return Vec3f(turned * ((is_mirrored ? -1.0 : 1.0) / length));
}

}  // namespace occam::lod
