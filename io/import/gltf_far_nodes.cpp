#include "io/import/gltf_far_nodes.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <unordered_set>

namespace occam::import {

namespace {

// The area of a square with sides that much smaller than a frame is the least that a float holds.
constexpr double kLargestRatio = 1e22;

double largest_side(const Box3d& box)
{
    const Vec3d extent = box.extent();
    return box.is_empty() ? 0 : std::max({extent.x, extent.y, extent.z});
}

// Holds what is shown, by whether it lies beyond the largest coordinate. Skinned meshes are placed by their joints, whose
// matrices do not count here.
struct Placements {
    explicit Placements(const Scene& scene)
    {
        scene.for_each_placement([&](NodeId id, const Node& node, const Mat4d& world_from_node) {
            Box3d box;
            if (!node.skin)
                for (const CageId cage : node.cages) box.add(transform_box(world_from_node, scene.cage(cage).bounds));
            const bool has_other_use = node.skin || node.light || node.camera;
            const double reach = box.is_empty() ? 0 : box.largest_coordinate();
            const bool is_far = !(reach <= double(kMaxCoordinate));
            if (has_other_use || (!is_far && !box.is_empty())) needed.push_back(id);
            if (is_far) far.push_back(id);
            if (std::isfinite(reach)) all.add(box);
            else is_finite = false;
            if (!is_far) largest_near = std::max(largest_near, largest_side(box));
        });
    }
    bool vanish() const
    {
        return !far.empty() && largest_near > 0 && (!is_finite || largest_near < largest_side(all) / kLargestRatio);
    }

    std::vector<NodeId> far, needed;
    Box3d all;
    double largest_near = 0;
    bool is_finite = true;
};

}  // namespace

void leave_out_far_nodes(Scene& scene, const std::vector<NodeId>& nodes, Report& report)
{
    const Placements placements(scene);
    if (!placements.vanish()) return;
    std::unordered_map<NodeId, std::size_t> index_of;
    for (std::size_t n = 0; n < nodes.size(); ++n) index_of.emplace(nodes[n], n);
    std::unordered_set<NodeId> needed;  // with what is above them
    for (NodeId id : placements.needed)
        for (; scene.find(id) && needed.insert(id).second;) id = scene.node(id).parent;
    for (const NodeId id : placements.far) {
        const auto known = index_of.contains(id) ? index_of.find(id) : index_of.find(scene.node(id).parent);
        const std::string where = known == index_of.end() ? std::string() : "nodes[" + std::to_string(known->second) + "]";
        if (needed.contains(id)) {
            report.warn("the scene vanishes beside a node that reaches beyond 1e16", where);
            continue;
        }
        report.warn("a node is left out that reaches beyond 1e16: the rest of the scene would vanish beside it", where);
        scene.set_visible(id, false);
    }
}

}  // namespace occam::import
