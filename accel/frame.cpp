#include "accel/frame.h"

#include <algorithm>
#include <cmath>

#include "accel/frame_state.h"
#include "accel/placement.h"
#include "lod/longest_edges.h"
#include "lod/posed_cage.h"

namespace occam::accel {
namespace {

/// Returns the largest distance by which any placed cage is ever displaced, in frame lengths.
float farthest_displaced(const Scene& scene, const FrameScale& scale)
{
    double farthest = 0;
    const auto add = [&](const Node& node, const Mat4d& world_from_node) {
        for (const CageId id : node.cages) {
            const CageSlot* slot = scene.find(id);
            if (!slot || !slot->cage.is_displaced()) continue;
            lod::PosedCage posed;
            posed.place(scale.placed(world_from_node), slot->bounds);
            farthest = std::max(farthest,
                                lod::largest_stretch(posed.frame_from_object) * double(slot->cage.displacement->bound));
        }
    };
    if (!scene.contents().has(Contents::Displaced)) return 0;
    if (scene.shutter_segments() == 0)
        scene.for_placements_of(Contents::Displaced,
                                [&](NodeId, const Node& node, const Mat4d& world_from_node) { add(node, world_from_node); });
    else
        for_each_placement(scene, Contents::Displaced, [&](const Node& node, std::span<const Mat4d> world_from_node) {
            for (const Mat4d& world : world_from_node) add(node, world);
        });
    return static_cast<float>(farthest) * (1 + 0x1p-18f);
}

}  // namespace

Frame::Frame(const Scene& scene, lod::TopologyCache& topologies, const lod::LevelSettings& levels,
             const FrameOptions& options)
    : state_(std::make_unique<State>())
{
    check_layers(scene);
    state_->scene = &scene;
    state_->topologies = &topologies;
    state_->levels = levels;
    state_->has_levels = levels.mode != lod::LevelMode::PerInstance && scene.contents().has(Contents::Subdivided);
    state_->textures = options.textures;
    state_->shading = options.shading;
    state_->scale = options.scale;
    state_->refuses_endless = options.refuses_endless;
    if (options.textures) state_->levels.displaced = farthest_displaced(scene, options.scale);
    const Node& root = scene.node(scene.root());
    const double stretch = options.scale.to_frame() * largest_stretch_to_parent(root);
    state_->levels.edges = lod::LongestEdges(scene.contents().poles.scaled(stretch));
    state_->segments = scene.shutter_segments();
    // A box around all that something passes through is hardly hit less often than everything. Few igrids hold the meshes of
    // a scene without cages, and rays find these in fewer steps in the tree of boxes.
    const bool has_cages = scene.contents().has(Contents::Subdivided);
    const TreeKind best = state_->segments > 0 || !has_cages ? TreeKind::Bvh : TreeKind::Kd;
    state_->tree = options.tree == TreeKind::Auto ? best : options.tree;
    const Box3d world = options.scale.placed(box_in_parent(root));
    if (world.is_empty()) return;
    // Floats in the tree's frame are the more precise the nearer they are to its origin. So the origin is the scene's point
    // nearest to the eye: a far thing is seen with a wide footprint, and a telescope sees the near side of the scene.
    state_->anchor = glm::clamp(levels.eye, world.lo, world.hi);
    state_->levels.origin = state_->anchor;
    const auto in_tree = [&](const Box3d& box) {
        const double pad = vertex_rounding(box);
        return outward_float({box.lo - pad, box.hi + pad}, state_->anchor, 8);
    };
    state_->bounds = in_tree(world);
    const Box3d diced = state_->has_levels ? options.scale.placed(bounds_of_diced(scene)) : Box3d();
    state_->diced_bounds = diced.is_empty() ? state_->bounds : in_tree(diced);
    state_->radius = static_cast<float>(glm::length(glm::max(state_->anchor - world.lo, world.hi - state_->anchor))) *
                     1.001f;
}

Frame::~Frame() = default;

TreeKind Frame::tree() const noexcept { return state_->tree; }

}  // namespace occam::accel
