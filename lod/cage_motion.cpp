#include "lod/cage_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace occam::lod {
namespace {

/// Returns the images of the corners of a box under an affine map.
std::array<Vec3d, 8> images_of_corners(const Mat4d& map, const Box3d& box) noexcept
{
    std::array<Vec3d, 8> images;
    for (std::size_t i = 0; i < images.size(); ++i) {
        const Vec4d corner(i & 1 ? box.hi.x : box.lo.x, i & 2 ? box.hi.y : box.lo.y, i & 4 ? box.hi.z : box.lo.z, 1);
        images[i] = Vec3d(map * corner);
    }
    return images;
}

/// Returns the largest distance from the origin of the image of a box under an affine map.
double farthest_image(const Mat4d& map, const Box3d& box) noexcept
{
    if (box.is_empty()) return 0;
    double farthest = 0;
    for (const Vec3d image : images_of_corners(map, box)) farthest = std::max(farthest, glm::length(image));
    return farthest;
}

/// Returns a bound on the factor by which a map lengthens a vector.
double stretch_bound(const Mat4d& map) noexcept
{
    double squares = 0;
    for (int c = 0; c < 3; ++c) squares += glm::dot(Vec3d(map[c]), Vec3d(map[c]));
    return std::sqrt(squares);
}

/// The least and the largest factor by which a map lengthens a vector: its singular values.
struct Stretches {
    double least = 0, largest = 0;
};

Stretches stretches(Mat3d map) noexcept
{
    // Columns are turned against each other, two at a time, until all are at right angles (Jacobi rotations): their lengths
    // are the singular values then. Each sweep squares the cosines of what is left.
    constexpr int kMostSweeps = 12;
    constexpr double kRightAngle = 1e-14;
    for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
        bool are_at_right_angles = true;
        for (const auto& [p, q] : {std::pair(0, 1), std::pair(0, 2), std::pair(1, 2)}) {
            const Vec3d a = map[p], b = map[q];
            const double aa = glm::dot(a, a), bb = glm::dot(b, b), ab = glm::dot(a, b);
            if (!(std::abs(ab) > kRightAngle * std::sqrt(aa) * std::sqrt(bb))) continue;
            are_at_right_angles = false;
            const double slope = (bb - aa) / (2 * ab);
            const double tangent = std::copysign(1 / (std::abs(slope) + std::sqrt(1 + slope * slope)), slope);
            const double cosine = 1 / std::sqrt(1 + tangent * tangent), sine = cosine * tangent;
            map[p] = a * cosine - b * sine;
            map[q] = a * sine + b * cosine;
        }
        if (are_at_right_angles) break;
    }
    const double x = glm::length(map[0]), y = glm::length(map[1]), z = glm::length(map[2]);
    return {std::min({x, y, z}), std::max({x, y, z})};
}

Mat4d between(const Mat4d& a, const Mat4d& b, double share) noexcept { return a * (1 - share) + b * share; }
double share_of(int key, int before, int after) noexcept { return double(key - before) / double(after - before); }

}  // namespace

CageMotion::CageMotion(const CageSlot& slot, const Node& node, const SkinSlot* skin, std::span<const Mat4d> world_from_node,
                       int segments)
    : slot_(slot), node_(node), skin_(skin), world_(world_from_node), segments_(segments)
{
    is_skinned_ = skin && slot.cage.skin.sets > 0;
    if (segments == 0) return;
    moves_positions_ = !slot.key_positions.empty();
    moves_maps_ = world_.size() > 1 || (is_skinned_ && !skin->key_poses.empty());
    // What keys hold is the motion, even if it is the same at all of them: the node itself is as in the middle of the
    // shutter.
    for (const NodeKey& key : node.keys) {
        moves_maps_ = moves_maps_ || (is_skinned_ && key.node_from_skin != node.node_from_skin);
        moves_weights_ = moves_weights_ || (!slot.cage.morph_targets.empty() && key.morph_weights != node.morph_weights);
    }
    changes_ = int(moves_maps_) + int(moves_weights_) + int(moves_positions_);
    if (changes_ != 1 || moves_maps_) return;
    // Meshes have normals of their own, or those of their triangles.
    constexpr std::size_t kFaces = 4096;
    if (slot.cage.is_displaced()) faces_ = faces_of(slot.cage);
    else if (segments > 1 && slot.cage.scheme != Scheme::Triangles)
        faces_ = faces_of(slot.cage, (slot.cage.face_count() + kFaces - 1) / kFaces);
}

Box3d CageMotion::world_box_at(int key) const
{
    return transform_box(world(key), cage_bounds(node_, slot_, skin_, static_cast<std::size_t>(key)));
}

Box3d CageMotion::world_box() const noexcept
{
    const Box3d bounds = cage_bounds(node_, slot_, skin_);
    Box3d box;
    for (const Mat4d& world : world_) box.add(transform_box(world, bounds));
    return box;
}

double CageMotion::deviation_of_maps(int key, int before, int after) const
{
    const double share = share_of(key, before, after);
    const CagePose at = pose(key), a = pose(before), b = pose(after);
    if (!is_skinned_) {
        const Mat4d off = world(key) - between(world(before), world(after), share);
        return farthest_image(off, slot_.is_deformed() ? cage_bounds(node_, slot_, skin_) : slot_.bounds);
    }
    const Box3d moved = morph_extent(slot_.deform[0].offsets, at.morph_weights);
    // Displacement turns with the joints.
    const Vec3d reach(slot_.cage.is_displaced() ? double(slot_.cage.displacement->bound) : 0.0);
    double farthest = 0;
    for (const JointBox& joint : slot_.deform[0].joints) {
        const auto map = [&](int k, const CagePose& pose) {
            const Mat4d mesh = joint.joint < pose.joints.size() ? pose.joints[joint.joint] : Mat4d(1);
            return world(k) * pose.node_from_skin * mesh;
        };
        const Mat4d off = map(key, at) - between(map(before, a), map(after, b), share);
        farthest = std::max(
            farthest, farthest_image(off, {Vec3d(joint.box.lo) + moved.lo - reach, Vec3d(joint.box.hi) + moved.hi + reach}));
    }
    return farthest;
}

double CageMotion::deviation_of_weights(int key, int before, int after) const
{
    const double share = share_of(key, before, after);
    const std::span<const float> at = pose(key).morph_weights, a = pose(before).morph_weights, b = pose(after).morph_weights;
    const std::span<const Box3f> offsets = slot_.deform[0].offsets;
    double stretch = stretch_bound(world(0));
    if (is_skinned_) {
        const CagePose first = pose(0);
        double largest = stretch_bound(first.node_from_skin);
        for (const Mat4d& joint : first.joints) largest = std::max(largest, stretch_bound(first.node_from_skin * joint));
        stretch *= largest;
    }
    double sum = 0;
    for (std::size_t t = 0; t < std::min({at.size(), a.size(), b.size(), offsets.size()}); ++t) {
        if (offsets[t].is_empty()) continue;
        const double off = std::abs(double(at[t]) - (double(a[t]) * (1 - share) + double(b[t]) * share));
        sum += off * glm::length(Vec3d(glm::max(glm::abs(offsets[t].lo), glm::abs(offsets[t].hi))));
    }
    return sum * stretch;
}

double CageMotion::deviation_of_positions(int key, int before, int after) const
{
    const double share = share_of(key, before, after);
    const auto &at = slot_.key_positions[std::size_t(key)], &a = slot_.key_positions[std::size_t(before)],
               &b = slot_.key_positions[std::size_t(after)];
    double squared = 0;
    for (std::size_t v = 0; v < at.size(); ++v) {
        const Vec3d off = Vec3d(at[v]) - glm::mix(Vec3d(a[v]), Vec3d(b[v]), share);
        squared = std::max(squared, glm::dot(off, off));
    }
    return std::sqrt(squared) * stretch_bound(world(0));
}

Vec3d CageMotion::normal_at(int key, FaceVertices face) const
{
    const CagePose at = pose(key);
    return face_normal(face, [&](std::uint32_t v) { return morphed(slot_.cage, at.positions, at.morph_weights, v); });
}

double CageMotion::deviation_of_displacement(int key, int before, int after) const
{
    const double share = share_of(key, before, after);
    double farthest = 0;
    for (const FaceVertices face : faces_)
        farthest = std::max(
            farthest, glm::distance(normal_at(key, face), glm::mix(normal_at(before, face), normal_at(after, face), share)));
    return farthest * double(slot_.cage.displacement->bound) * stretch_bound(world(0));
}

bool CageMotion::keeps_normals(int key, int before, int after) const
{
    const double share = share_of(key, before, after);
    return std::all_of(faces_.begin(), faces_.end(), [&](FaceVertices face) {
        return is_near_normal(glm::mix(normal_at(before, face), normal_at(after, face), share), normal_at(key, face));
    });
}

double CageMotion::least_distance_across(Vec3d eye) const
{
    constexpr double kMostOfSight = 0.7, kChordOfSine = 1.1;  // chords of angles whose sine is at most 0.7
    if (!is_rigid() || slot_.bounds.is_empty()) return 0;
    const Box3d& bounds = slot_.bounds;
    double least = std::numeric_limits<double>::infinity();
    for (int key = 0; key < segments_; ++key) {
        // Each point of the cage moves by a mean of how the corners of its box move.
        const std::array<Vec3d, 8> moves = images_of_corners(world(key + 1) - world(key), bounds);
        Vec3d mean(0);
        for (const Vec3d move : moves) mean += move / double(moves.size());
        double spread = 0;
        for (const Vec3d move : moves) spread = std::max(spread, glm::distance(move, mean));
        Box3d box = transform_box(world(key), bounds);
        box.add(transform_box(world(key + 1), bounds));
        // The lines of sight to the points of a ball lie within a cone; the sine of its angle is `sine`.
        const Vec3d sight = box.centre() - eye;
        const double distance = glm::length(sight), sine = box.radius() / distance;
        if (!(sine < kMostOfSight)) return 0;
        const double across = glm::length(glm::cross(mean, sight)) / distance;
        least = std::min(least, across - kChordOfSine * sine * glm::length(mean) - spread);
    }
    return std::isfinite(least) ? std::max(0.0, least * segments_) : 0;
}

double CageMotion::least_radius(const CageCurvature& curvature) const
{
    // A circle that is squeezed by s in one direction and stretched by t in the other bends with s^2 / t of its radius. No
    // map squeezes by more than its least singular value and stretches by more than its largest one, whatever the
    // directions.
    double least = std::numeric_limits<double>::infinity(), most = 0;
    for (const Mat4d& world : world_) {
        const Stretches of_map = stretches(Mat3d(world));
        least = std::min(least, of_map.least);
        most = std::max(most, of_map.largest);
    }
    return most > 0 ? least * least / most * curvature.least_radius(slot_.cage) : 0;
}

double CageMotion::deviation(int key, int before, int after) const
{
    // Several changes multiply, which no sum of their own deviations bounds. The same holds for displacement, whose length
    // follows the node, on a surface that follows joints.
    const bool is_product = changes_ > 1 || (moves_positions_ && slot_.is_deformed()) ||
                            (is_skinned_ && world_.size() > 1 && slot_.cage.is_displaced());
    if (is_product) return std::numeric_limits<double>::infinity();
    if (moves_maps_) return deviation_of_maps(key, before, after);
    const double off = moves_weights_ ? deviation_of_weights(key, before, after)
                                      : deviation_of_positions(key, before, after);
    return slot_.cage.is_displaced() ? off + deviation_of_displacement(key, before, after) : off;
}

int CageMotion::segments(const std::function<double(int key)>& tolerance) const
{
    for (int segments = 1; segments < segments_; segments *= 2) {
        const int step = segments_ / segments;
        bool is_near = true;
        for (int key = 0; key < segments_ && is_near; ++key) {
            const int before = key / step * step;
            if (key == before) continue;
            is_near = deviation(key, before, before + step) <= tolerance(key) && keeps_normals(key, before, before + step);
        }
        if (is_near) return segments;
    }
    return segments_;
}

namespace {

// A box counts as no nearer than this many of its radii.
constexpr double kNearest = 1.0 / 64;

// Returns the target edge length at a distance from the camera.
float edge_at(const LevelSettings& settings, double distance) noexcept
{
    return settings.target_edge(settings.pixel).at(static_cast<float>(distance));
}

// Returns the target edge length where a box is nearest to the camera, wherever that is while the shutter is open.
float nearest_edge(const LevelSettings& settings, const Box3d& world) noexcept
{
    const double distance = glm::distance(settings.eye, glm::clamp(settings.eye, world.lo, world.hi)) - settings.eye_moves;
    return edge_at(settings, std::max(distance, world.radius() * kNearest));
}

double tolerance_of(const LevelSettings& settings, float edge, double radius) noexcept
{
    constexpr double kRounding = 0x1p-22;  // in radii of the box
    const double allowed = std::isfinite(edge) ? double(settings.motion_edges) * double(edge) : 0;
    return std::max(allowed, radius * kRounding);
}

}  // namespace

double motion_tolerance(const LevelSettings& settings, const Box3d& world) noexcept
{
    return tolerance_of(settings, nearest_edge(settings, world), world.radius());
}

double largest_motion_tolerance(const LevelSettings& settings, const Box3d& world) noexcept
{
    const double farthest = glm::length(glm::max(glm::abs(world.lo - settings.eye), glm::abs(world.hi - settings.eye)));
    return tolerance_of(settings, edge_at(settings, farthest), world.radius());
}

int level_of_motion(const LevelSettings& settings, const CageMotion& motion, const CageCurvature& curvature)
{
    constexpr float kMostPixels = 4;
    // A chord d of an arc of radius r lies inside of it by d^2 / 8 r. Motion hides that nowhere where a surface slides along
    // its own silhouette, so it is at most this part of an edge of full detail.
    constexpr double kMostCutOff = 0.05;
    if (settings.strata <= 0) return kFinestLevel;
    const auto moved = static_cast<float>(motion.least_distance_across(settings.eye) / settings.strata);
    const float nearest = nearest_edge(settings, motion.world_box());
    float edge = std::min(settings.target_edge({moved, 0}).a, kMostPixels * nearest);
    if (edge > nearest)
        edge = std::min(edge,
                        static_cast<float>(std::sqrt(8 * kMostCutOff * double(nearest) * motion.least_radius(curvature))));
    // The level l whose edges d_l are at most as long; ceil_log2() would round up.
    return edge > 0 && std::isfinite(edge) ? std::clamp(-ceil_log2(1 / edge), kFinestLevel, kCoarsestLevel) : kFinestLevel;
}

}  // namespace occam::lod
