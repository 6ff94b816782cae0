#include "lod/level_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace occam::lod {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double distance_to(const Box3d& box, Vec3d eye) noexcept { return glm::distance(eye, glm::clamp(eye, box.lo, box.hi)); }

Vec3d between(Vec3d a, Vec3d b, double share) noexcept { return share >= 1 ? b : a + (b - a) * share; }
Box3d between(const Box3d& a, const Box3d& b, double share) noexcept
{
    return {between(a.lo, b.lo, share), between(a.hi, b.hi, share)};
}

/// Returns the least distance between an eye and a box that both move along straight lines, the faces of the box too. The
/// distance is a convex function of the time.
double least_distance(const Box3d& from, const Box3d& to, Vec3d eye_from, Vec3d eye_to) noexcept
{
    constexpr int kHalvings = 24;
    const double at_ends = std::min(distance_to(from, eye_from), distance_to(to, eye_to));
    const Vec3d eye_moves = eye_to - eye_from, lo_nears = to.lo - from.lo - eye_moves,
                hi_nears = eye_moves - (to.hi - from.hi);
    if (lo_nears == Vec3d(0) && hi_nears == Vec3d(0)) return at_ends;
    // Returns half the derivative of the square of the distance.
    const auto slope = [&](double t) {
        const Vec3d eye = between(eye_from, eye_to, t);
        const Box3d box = between(from, to, t);
        return glm::dot(glm::max(box.lo - eye, Vec3d(0)), lo_nears) + glm::dot(glm::max(eye - box.hi, Vec3d(0)), hi_nears);
    };
    double begin = 0, end = 1;
    if (!(slope(begin) < 0 && slope(end) > 0)) return at_ends;
    for (int i = 0; i < kHalvings; ++i) {
        const double middle = 0.5 * (begin + end);
        (slope(middle) < 0 ? begin : end) = middle;
    }
    return std::min(at_ends, distance_to(between(from, to, begin), between(eye_from, eye_to, begin)));
}

/// A part of the shutter in which the eye and the vertices of a cage move along straight lines.
class PartOfShutter {
public:
    struct Ends {
        double from, to;
    };
    /// at   the part of the way from one key of the cage to the next at which it begins and ends
    PartOfShutter(const PosedCage& first, const PosedCage& next, Ends at, Vec3d eye_from, Vec3d eye_to) noexcept
        : first_(first), next_(next), at_(at), eye_from_(eye_from), eye_to_(eye_to)
    {
    }

    /// Returns the least distance from the eye to the nearest cluster; infinity if none is in view.
    double nearest(const LevelSettings& settings, bool only_in_view) const
    {
        double nearest = kInfinity;
        struct Found {
            std::uint32_t cluster;
            Place place;
        };
        std::vector<Found> todo{{0, place_of(0)}};
        while (!todo.empty()) {
            const auto [cluster, place] = todo.back();
            const ClusterTree::Node& node = first_.clusters->node(cluster);
            todo.pop_back();
            if (place.is_empty() || !(place.distance < nearest) || (only_in_view && is_outside(settings, place))) continue;
            if (node.left == 0) {
                const double radius = std::min(place.from.radius(), place.to.radius());
                nearest = std::min(nearest, std::max(place.distance, radius / 8));
                continue;
            }
            // The nearer child comes on top.
            const Found left{node.left, place_of(node.left)}, right{node.left + 1, place_of(node.left + 1)};
            const bool left_is_nearer = left.place.distance <= right.place.distance;
            todo.push_back(left_is_nearer ? right : left);
            todo.push_back(left_is_nearer ? left : right);
        }
        return nearest;
    }
    /// Returns the least distance from the eye to the box of the whole cage.
    double nearest_of_all() const noexcept { return place_of(0).distance; }
    /// Returns the reach of displacement, which is one for all keys.
    double reach() const noexcept { return double(first_.displacement.reach); }

private:
    /// Where the box of a cluster is when the part begins and ends, and how near it comes.
    struct Place {
        Box3d from, to;
        double distance = kInfinity;
        bool is_empty() const noexcept { return from.is_empty(); }
    };

    Place place_of(std::uint32_t cluster) const noexcept
    {
        const Box3d a = first_.world_box(cluster);
        if (a.is_empty()) return {};
        if (&first_ == &next_) return {a, a, least_distance(a, a, eye_from_, eye_to_)};
        const Box3d b = next_.world_box(cluster);
        if (b.is_empty()) return {};
        const Box3d from = between(a, b, at_.from), to = between(a, b, at_.to);
        return {from, to, least_distance(from, to, eye_from_, eye_to_)};
    }
    static bool is_outside(const LevelSettings& settings, const Place& place) noexcept
    {
        Box3d box = place.from;
        box.add(place.to);
        const Vec3d centre = box.centre() - settings.eye, half = box.extent() * 0.5;
        for (int p = 0; p < settings.plane_count; ++p) {
            const Vec3d n(settings.planes[p]);
            if (glm::dot(n, centre) + glm::dot(glm::abs(n), half) < 0) return true;
        }
        return false;
    }

    const PosedCage &first_, &next_;
    Ends at_;
    Vec3d eye_from_, eye_to_;
};

/// Calls what(part) for the parts of the shutter, in their order.
template <class What>
void for_each_part(const LevelSettings& settings, const PosedCage& cage, What&& what)
{
    const std::vector<Vec3d>& eyes = settings.eyes;
    const int of_cage = std::max(1, cage.segments), of_eye = std::max(1, static_cast<int>(eyes.size()) - 1);
    const auto eye_at = [&](int key, double share) {
        if (eyes.empty()) return settings.eye;
        const auto k = static_cast<std::size_t>(key);
        return between(eyes[k], eyes[std::min(k + 1, eyes.size() - 1)], share);
    };
    // Moments are counted in parts of both kinds of segments, so that they are whole numbers.
    for (int at = 0, k = 0, e = 0; at < of_cage * of_eye;) {
        const int end = std::min((k + 1) * of_eye, (e + 1) * of_cage);
        const auto share_of_cage = [&](int moment) { return double(moment - k * of_eye) / of_eye; };
        const auto share_of_eye = [&](int moment) { return double(moment - e * of_cage) / of_cage; };
        what(PartOfShutter(cage.at_key(k), cage.at_key(std::min(k + 1, cage.segments)),
                           {share_of_cage(at), share_of_cage(end)}, eye_at(e, share_of_eye(at)),
                           eye_at(e, share_of_eye(end))));
        if (end == (k + 1) * of_eye) ++k;
        if (end == (e + 1) * of_cage) ++e;
        at = end;
    }
}

}  // namespace

int choose_level(const LevelSettings& settings, const PosedCage& cage)
{
    constexpr int kFinest = -60, kCoarsest = 60;
    double nearest = kInfinity;
    for (const bool only_in_view : {true, false}) {
        if (nearest < kInfinity) break;  // something is in view in a part of the shutter
        for_each_part(settings, cage, [&](const PartOfShutter& part) {
            if (!(part.nearest_of_all() < nearest)) return;
            // Where the eye is within the reach of displacement nothing tells how near the surface is, and edges much
            // shorter than that reach cost dearly: boxes of tiles are as large as it.
            nearest = std::min(nearest, std::max(part.nearest(settings, only_in_view), part.reach()));
        });
    }
    const float target_edge = settings.target_edge(settings.pixel).at(static_cast<float>(nearest));
    if (!(target_edge > 0)) return kFinest;
    return std::isinf(target_edge) ? kCoarsest : std::clamp(std::ilogb(target_edge), kFinest, kCoarsest);
}

int level_of_boxes(const LevelSettings& settings, const PosedCage& cage) noexcept
{
    if (!settings.origin) return kFinestLevel;
    const auto coordinate_at = [&](Vec3d place) {
        const Vec3d away = glm::abs(place - *settings.origin);
        return std::max({away.x, away.y, away.z});
    };
    // Edges are longer than steps of floats only where a cage is some hundred times as far away as it is large, so its
    // radius does not count.
    double coordinate = cage.segments > 0 ? kInfinity : coordinate_at(cage.anchor);
    double before = 0;
    for (int k = 0; cage.segments > 0 && k <= cage.segments; ++k) {
        const double at_key = coordinate_at(cage.at_key(k).world_box(0).centre());
        if (k > 0) coordinate = std::min(coordinate, std::max(before, at_key));
        before = at_key;
    }
    const int level = ceil_log2(static_cast<float>(coordinate) * std::numeric_limits<float>::epsilon());
    return std::clamp(level, kFinestLevel, kCoarsestLevel);
}

}  // namespace occam::lod
