#include "lod/level_choice.h"

#include <limits>

namespace occam::lod {
namespace {

bool is_outside(const LevelSettings& settings, const Box3d& box) noexcept
{
    const Vec3d centre = box.centre() - settings.eye, half = box.extent() * 0.5;
    for (int p = 0; p < settings.plane_count; ++p) {
        const Vec3d n(settings.planes[p]);
        if (glm::dot(n, centre) + glm::dot(glm::abs(n), half) < 0) return true;
    }
    return false;
}

/// Returns the distance from the eye to the nearest cluster; infinity if none is in view.
double nearest_distance(const LevelSettings& settings, const PosedCage& cage, bool only_in_view)
{
    const auto distance_to = [&](const Box3d& box) {
        return glm::distance(settings.eye, glm::clamp(settings.eye, box.lo, box.hi));
    };
    double nearest = std::numeric_limits<double>::infinity();
    std::vector<std::uint32_t> todo{0};
    while (!todo.empty()) {
        const std::uint32_t cluster = todo.back();
        const ClusterTree::Node& node = cage.clusters->node(cluster);
        todo.pop_back();
        const Box3d box = cage.world_box(cluster);
        if (box.is_empty() || distance_to(box) >= nearest || (only_in_view && is_outside(settings, box))) continue;
        if (node.left == 0) {
            nearest = std::min(nearest, std::max(distance_to(box), box.radius() / 8));
            continue;
        }
        // The nearer child comes on top.
        const bool left_is_nearer = distance_to(cage.world_box(node.left)) <= distance_to(cage.world_box(node.left + 1));
        todo.push_back(node.left + (left_is_nearer ? 1 : 0));
        todo.push_back(node.left + (left_is_nearer ? 0 : 1));
    }
    return nearest;
}

}  // namespace

int choose_level(const LevelSettings& settings, const PosedCage& cage)
{
    constexpr int kFinest = -60, kCoarsest = 60;
    double distance = nearest_distance(settings, cage, true);
    if (distance == std::numeric_limits<double>::infinity()) distance = nearest_distance(settings, cage, false);
    // Where the eye is within the reach of displacement nothing tells how near the surface is, and edges much shorter than
    // that reach cost dearly: boxes of tiles are as large as it.
    distance = std::max(distance, double(cage.displacement.reach));
    const float target_edge = settings.target_edge(settings.pixel).at(static_cast<float>(distance));
    if (!(target_edge > 0)) return kFinest;
    return std::isinf(target_edge) ? kCoarsest : std::clamp(std::ilogb(target_edge), kFinest, kCoarsest);
}

}  // namespace occam::lod
