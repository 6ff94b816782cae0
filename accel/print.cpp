#include "accel/print.h"

#include <cmath>
#include <ostream>

namespace occam::lod {

std::ostream& operator<<(std::ostream& out, const Footprint& footprint)
{
    return out << footprint.a << (footprint.b < 0 ? " - " : " + ") << std::fabs(footprint.b) << " t";
}

std::ostream& operator<<(std::ostream& out, const PatchRef& patch)
{
    return out << "patch " << patch.sub << " of face " << patch.face;
}

std::ostream& operator<<(std::ostream& out, const TileRef& tile)
{
    return out << tile.columns << " x " << tile.rows << " quads from (" << tile.i0 << ", " << tile.j0 << ") of "
               << tile.patch;
}

}  // namespace occam::lod

namespace occam::accel {

std::ostream& operator<<(std::ostream& out, const PairRange& pairs)
{
    if (pairs.is_empty()) return out << "none";
    if (pairs.finest == pairs.coarsest) return out << pairs.finest;
    return out << pairs.finest << " to " << pairs.coarsest;
}

std::ostream& operator<<(std::ostream& out, const QuadRef& quad)
{
    return out << "triangle " << int(quad.triangle) << " of quad (" << quad.i << ", " << quad.j << ')';
}

std::ostream& operator<<(std::ostream& out, const Slab& slab)
{
    return out << slab.lo << " to " << slab.hi << " along " << slab.normal;
}

std::ostream& operator<<(std::ostream& out, const Ray& ray)
{
    out << "origin " << ray.origin << ", direction " << ray.direction << ", t from " << ray.t_near << " to " << ray.t_far
        << ", footprint " << ray.footprint;
    if (ray.start_level != kAnyLevel) out << ", start level " << int(ray.start_level);
    if (ray.focus > 0) out << " at " << ray.focus;
    if (ray.time > 0) out << ", time " << ray.time;
    return out << ", kinds " << int(ray.kinds);
}

std::ostream& operator<<(std::ostream& out, const SurfaceHit& hit)
{
    if (!hit.is_hit()) return out << "no hit";
    out << "t " << hit.t << ", position " << hit.position << ", node " << hit.node << ", face " << hit.face << ", normal "
        << hit.normal_geometric << ", shading normal " << hit.normal_shading << ", uv " << hit.uv[0] << ", level "
        << hit.level;
    if (hit.blend > 0) out << " blended by " << hit.blend;
    return out << (hit.back_side ? ", from behind" : "");
}

std::ostream& operator<<(std::ostream& out, const FirstHit& hit)
{
    if (!hit.is_hit()) return out << "no hit";
    return out << "t " << hit.t << ", node " << hit.node << ", face " << hit.face;
}

std::ostream& operator<<(std::ostream& out, const RayCost& cost)
{
    return out << cost.nodes << " nodes entered, " << cost.igrids << " igrids tested, " << cost.igrids_built
               << " of them built now, " << cost.tests << " triangles tested";
}

std::ostream& operator<<(std::ostream& out, const TraceCounters& counters)
{
    return out << counters.rays << " rays, " << counters.packets << " packets, " << counters.kd_visited << " nodes visited, "
               << counters.kd_expanded << " expanded, " << counters.grids << " igrids, " << counters.micropolygons
               << " micropolygons, " << counters.flushes << " flushes, at most " << counters.peak_bytes << " bytes";
}

}  // namespace occam::accel
