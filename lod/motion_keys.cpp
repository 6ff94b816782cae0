// The keys at which a cage that moves is diced.
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>

#include "base/matrix.h"
#include "lod/cage_motion.h"
#include "lod/growth.h"

namespace occam::lod {
namespace {

constexpr std::uint32_t kAllSegments = PosedCage::kAllSegments;
/// A cage that moves by its nodes alone, and farther than this many of its radii, has a dicing frame for each of its keys.
/// Boxes grow by 64 ulps of the largest coordinate in their frame: if all keys shared one, by more than a 512th of the
/// radius.
constexpr float kFarInRadii = 256;

/// Returns the map from a pose's dicing frame to object axes, unless the pose is so flat that rounding spoils it.
std::optional<Mat4d> inverse_of(const PosedCage& cage) noexcept
{
    constexpr double kFlattestToInvert = 0x1p-20;
    Mat4d map = cage.world_from_object();
    map[3] -= Vec4d(cage.anchor, 0);
    if (!(std::abs(evenness(Mat3d(map))) > kFlattestToInvert)) return std::nullopt;
    return glm::inverse(map);
}

// Returns the key at which the map enlarges areas most; the middle one if no other is clearly better.
std::size_t largest_key(std::span<const PosedCage> keys) noexcept
{
    constexpr double kClearly = 1.001;
    const auto area_of = [](const PosedCage& cage) {
        const Mat3d m = cage.linear_map();
        const Vec3d a = glm::cross(m[1], m[2]), b = glm::cross(m[2], m[0]), c = glm::cross(m[0], m[1]);
        return std::sqrt(glm::dot(a, a) + glm::dot(b, b) + glm::dot(c, c));
    };
    std::size_t best = (keys.size() - 1) / 2;
    for (std::size_t k = 0; k < keys.size(); ++k)
        if (area_of(keys[k]) > kClearly * area_of(keys[best])) best = k;
    return best;
}

// Returns the key whose map is least flat, so that normals at rest follow best from normals there; -1 if all are so flat
// that too few bits of them are left.
int roundest_key(std::span<const PosedCage> keys) noexcept
{
    double roundest = 0x1p-12;
    int best = -1;
    for (std::size_t k = 0; k < keys.size(); ++k) {
        const Mat3d m = keys[k].linear_map();
        const double length = std::sqrt(glm::dot(m[0], m[0]) + glm::dot(m[1], m[1]) + glm::dot(m[2], m[2]));
        const double roundness = std::abs(glm::determinant(m)) / (length * length * length);
        if (!(roundness > roundest)) continue;
        roundest = roundness;
        best = static_cast<int>(k);
    }
    return best;
}

// A flat pose of a rigid cage has no orientation of its own. It gets that of the nearest key before it, or else after it,
// that is not flat, so that normals do not turn over between keys.
void orient_flat_keys(std::span<PosedCage> keys) noexcept
{
    const auto is_flat = [](const PosedCage& key) { return !key.deformed && flattens(key.linear_map()); };
    const auto first = std::find_if_not(keys.begin(), keys.end(), is_flat);
    if (first == keys.end()) return;
    for (PosedCage& key : std::span(keys.begin(), first)) key.is_mirrored = first->is_mirrored;
    for (auto key = first; key != keys.end(); ++key)
        if (is_flat(*key)) key->is_mirrored = std::prev(key)->is_mirrored;
}

// Makes the filter of the displacement's texture the same part of the surface at all keys. Edges of levels are about the key
// at which the cage is largest.
void share_filters(std::span<PosedCage> keys)
{
    double largest = 0;
    std::vector<double> sizes;
    const std::vector<FaceVertices> faces = some_faces(keys[0].slot->cage);
    for (const PosedCage& key : keys) {
        sizes.push_back(key.size_of_faces(faces));
        largest = std::max(largest, sizes.back());
    }
    for (std::size_t k = 0; k < keys.size() && largest > 0; ++k)
        keys[k].displacement.filter_share = static_cast<float>(sizes[k] / largest);
}

}  // namespace

std::vector<std::uint32_t> CageMotion::segments_by_size(int segments) const
{
    if (segments < 2) return {};
    const int step = segments_ / segments;
    std::array<double, kMostSegments + 1> radii{};
    const auto count = static_cast<std::size_t>(segments) + 1;
    for (std::size_t k = 0; k < count; ++k) radii[k] = world_box_at(static_cast<int>(k) * step).radius();
    return lod::segments_by_size({radii.data(), count}, step);
}

PosedCage& CageMotion::make_keys(const PosedCage& still, int segments, const PosingTools& tools) const
{
    const std::span<PosedCage> keys = pose_keys(still, segments, world_box(), kAllSegments, tools);
    std::array<double, kMostSegments + 1> radii{};
    for (std::size_t k = 0; k < keys.size(); ++k) radii[k] = keys[k].world_box(0).radius();
    const std::span<const double> of_keys(radii.data(), keys.size());
    const std::uint32_t hidden = segments_of_tiny(of_keys, segments_ / segments);
    for (PosedCage& key : keys) key.visible_in &= ~hidden;
    return finish_keys(keys, of_keys, kAllSegments, tools);
}

PosedCage& CageMotion::make_keys_in(const PosedCage& still, std::uint32_t shown, int segments,
                                    const PosingTools& tools) const
{
    Box3d frame;
    for (int key = 0; key <= segments_; key += segments_ / segments)
        if (shown_key(key, shown) == key) frame.add(world_box_at(key));
    const std::span<PosedCage> keys = pose_keys(still, segments, frame, shown, tools);
    std::array<double, kMostSegments + 1> radii{};
    for (std::size_t k = 0; k < keys.size(); ++k) {
        keys[k].visible_in &= shown;
        radii[k] = keys[k].world_box(0).radius();
    }
    return finish_keys(keys, {radii.data(), keys.size()}, shown, tools);
}

int CageMotion::shown_key(int key, std::uint32_t shown) const noexcept
{
    const std::uint64_t keys = std::uint64_t(shown) | std::uint64_t(shown) << 1;
    const auto is_shown = [&](int k) { return (keys >> k & 1) != 0; };
    int at = key;
    while (at > 0 && !is_shown(at)) --at;
    while (at < segments_ && !is_shown(at)) ++at;
    return at;
}

std::span<PosedCage> CageMotion::pose_keys(const PosedCage& still, int segments, const Box3d& frame, std::uint32_t shown,
                                           const PosingTools& tools) const
{
    const std::span<PosedCage> keys = tools.arena.make_array<PosedCage>(static_cast<std::size_t>(segments) + 1);
    const int step = segments_ / segments;
    for (std::size_t k = 0; k < keys.size(); ++k) {
        const int key = shown_key(static_cast<int>(k) * step, shown);
        if (k > 0 && key == shown_key(static_cast<int>(k - 1) * step, shown)) {
            new (&keys[k]) PosedCage(keys[k - 1]);
            continue;
        }
        PosedCage& cage = *new (&keys[k]) PosedCage(still);
        cage.set_frame(frame);
        cage.set_map(world(key));
        cage.longest_at_poles = static_cast<float>(longest_pole_edge(node_, slot_, skin_, Mat3d(world(key))));
        const CagePose at = pose(key);
        cage.positions = at.positions.data();
        if (tools.tables.deformed_clusters) cage.deform(*tools.tables.deformed_clusters, at, tools.arena, tools.counters);
        if (moves_positions_) {
            std::vector<Vec3f> posed(at.positions.size());
            for (std::uint32_t v = 0; v < posed.size(); ++v) posed[v] = cage.vertex(v);
            const std::span<Box3f> boxes = tools.arena.make_array<Box3f>(cage.clusters->node_count());
            cage.clusters->boxes_at(slot_.cage, posed, boxes);
            cage.cluster_boxes = boxes.data();
        }
        if (tools.textures) cage.displace(*tools.textures);
        cage.derive(tools.arena);
    }
    return keys;
}

PosedCage& CageMotion::finish_keys(std::span<PosedCage> keys, std::span<const double> radii, std::uint32_t shown,
                                   const PosingTools& tools) const
{
    orient_flat_keys(keys);
    float reach = 0, at_poles = 0;
    for (const PosedCage& key : keys) {
        reach = std::max(reach, key.displacement.reach);
        at_poles = std::max(at_poles, key.longest_at_poles);
    }
    for (PosedCage& key : keys) {
        key.displacement.reach = reach;
        key.longest_at_poles = at_poles;
        key.coarsened = coarsened_by_growth(radii);
    }
    if (keys[0].is_displaced()) share_filters(keys);
    if (moves_by_nodes_alone()) {
        if (!grows_much(radii)) keys[0].still_pose = make_still_pose(keys, shown, tools);
        if (keys[0].still_pose && keys[0].radius > kFarInRadii * keys[0].still_pose->largest_radius)
            move_keys_apart(keys, shown, tools);
        keys[0].normal_key = roundest_key(keys);
    }
    keys[0].keys = keys.data();
    keys[0].segments = static_cast<int>(keys.size()) - 1;
    return keys[0];
}

void CageMotion::move_keys_apart(std::span<PosedCage> keys, std::uint32_t shown, const PosingTools& tools) const
{
    const int step = segments_ / (static_cast<int>(keys.size()) - 1);
    for (std::size_t k = 0; k < keys.size(); ++k) {
        const int key = shown_key(static_cast<int>(k) * step, shown);
        PosedCage& cage = keys[k];
        const bool is_mirrored = cage.is_mirrored;  // a flat pose has it from other keys
        cage.set_frame(world_box_at(key));
        cage.set_map(world(key));
        const CagePose at = pose(key);
        cage.positions = at.positions.data();
        if (tools.tables.deformed_clusters) cage.deform(*tools.tables.deformed_clusters, at, tools.arena, tools.counters);
        cage.is_mirrored = is_mirrored;
        cage.derive(tools.arena);
    }
}

const PosedCage* CageMotion::make_still_pose(std::span<const PosedCage> keys, std::uint32_t shown,
                                             const PosingTools& tools) const
{
    // Textures are filtered by the sizes that the surface has in this pose, and rates are those of the largest key.
    const std::size_t largest = largest_key(keys);
    const int segments = static_cast<int>(keys.size()) - 1, step = segments_ / segments,
              at_largest = shown_key(static_cast<int>(largest) * step, shown);
    PosedCage still = keys[largest];
    still.set_frame(transform_box(world(at_largest), cage_bounds(node_, slot_, skin_)));
    still.set_map(world(at_largest));
    for (const PosedCage& key : keys)
        still.largest_radius = std::max(still.largest_radius, static_cast<float>(key.world_box(0).radius()));
    const std::span<AffinePose> poses = tools.arena.make_array<AffinePose>(keys.size());
    const std::optional<Mat4d> object_from_still = inverse_of(still);
    if (!object_from_still) return nullptr;
    for (std::size_t k = 0; k < keys.size(); ++k) {
        const Mat4d map = world(shown_key(static_cast<int>(k) * step, shown)) * *object_from_still;
        poses[k] = {{Vec3d(map[0]), Vec3d(map[1]), Vec3d(map[2])}, Vec3d(map[3])};
    }
    const AffineMotion motion{poses};
    if (!motion.is_invertible()) return nullptr;
    const CagePose at = pose(at_largest);
    still.positions = at.positions.data();
    if (tools.tables.deformed_clusters) still.deform(*tools.tables.deformed_clusters, at, tools.arena, tools.counters);
    if (tools.textures) still.displace(*tools.textures);
    still.displacement.reach = keys[0].displacement.reach;
    still.derive(tools.arena);
    still.affine = tools.arena.make<AffineMotion>(motion);
    return tools.arena.make<PosedCage>(still);
}

}  // namespace occam::lod
