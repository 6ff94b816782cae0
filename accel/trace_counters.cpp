#include "accel/trace_counters.h"

namespace occam::accel {

TraceCounters& TraceCounters::operator+=(const TraceCounters& o) noexcept
{
    rays += o.rays;
    packets += o.packets;
    kd_nodes += o.kd_nodes;
    kd_visited += o.kd_visited;
    kd_expanded += o.kd_expanded;
    grids += o.grids;
    micropolygons += o.micropolygons;
    diced += o.diced;
    diced_for_camera += o.diced_for_camera;
    diced_for_occlusion += o.diced_for_occlusion;
    faces_touched += o.faces_touched;
    flushes += o.flushes;
    vertices_diced += o.vertices_diced;
    vertices_shaded += o.vertices_shaded;
    vertices_looked_up += o.vertices_looked_up;
    peak_bytes += o.peak_bytes;
    build_seconds += o.build_seconds;
    dice_seconds += o.dice_seconds;
    shade_seconds += o.shade_seconds;
    deform.vertices += o.deform.vertices;
    deform.seconds += o.deform.seconds;
    for (int l = 0; l < kLevels; ++l) micropolygons_of_level[l] += o.micropolygons_of_level[l];
    return *this;
}

}  // namespace occam::accel
