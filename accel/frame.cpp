#include "accel/frame.h"

#include <cmath>

#include "accel/frame_state.h"

namespace occam::accel {

Frame::Frame(const Scene& scene, lod::TopologyCache& topologies, const lod::LevelSettings& levels)
    : state_(std::make_unique<State>())
{
    state_->scene = &scene;
    state_->topologies = &topologies;
    state_->levels = levels;
    const Node& root = scene.node(scene.root());
    const Box3d world = root.visible ? transform_box(root.parent_from_node, root.bounds) : Box3d();
    if (world.is_empty()) return;
    const double step = std::ldexp(1.0, std::ilogb(std::max(world.radius(), 1e-30)));
    state_->anchor = glm::round(world.centre() / step) * step;
    state_->bounds = outward_float(world, state_->anchor, 8);
    state_->radius = static_cast<float>(world.radius() + glm::distance(world.centre(), state_->anchor)) * 1.001f;
}

Frame::~Frame() = default;

}  // namespace occam::accel
