// Nodes that are so far away, or so large, that nothing else of their scene could be rendered.
#pragma once

#include "io/import/report.h"

namespace occam::import {

/// Leaves out, with a warning, nodes beyond kMaxCoordinate if all that is nearer is so small beside them that areas of it
/// would be 0 in the unit of a frame (scenegraph/frame_scale.h). A scene of any size stays as it is if it fits into a frame.
/// nodes   those of the file, in its order
void leave_out_far_nodes(Scene& scene, const std::vector<NodeId>& nodes, Report& report);

}  // namespace occam::import
