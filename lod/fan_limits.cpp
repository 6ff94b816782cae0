#include "lod/fan_limits.h"

#include <opensubdiv/sdc/crease.h>

#include <algorithm>
#include <cmath>

#include "lod/derived_points.h"

namespace occam::lod {

using namespace OpenSubdiv;

namespace {

/// Returns whether each face around a vertex belongs to a fan that runs from an edge of many faces to another one.
bool have_fans_two_ends(const Far::TopologyLevel& level, int vertex)
{
    const auto faces = level.GetVertexFaces(vertex);
    const auto places = level.GetVertexFaceLocalIndices(vertex);
    const auto count = static_cast<std::size_t>(faces.size());
    std::size_t found = 0;
    for (int f = 0; f < faces.size(); ++f) {
        const Sector first{faces[f], places[f]};
        const int begin = level.GetFaceEdges(first.face)[first.corner];
        if (!level.IsEdgeNonManifold(begin)) continue;
        const std::vector<Sector> others = sectors_after(level, first, true, count);
        const Sector& last = others.empty() ? first : others.back();
        const auto edges = level.GetFaceEdges(last.face);
        if (edges[(last.corner + edges.size() - 1) % edges.size()] == begin) return false;
        found += 1 + others.size();
    }
    return found == count;
}

/// Returns whether all that is semi-sharp at a vertex and becomes smooth in the last step is equally sharp.
bool softens_alike(const Far::TopologyLevel& level, int vertex)
{
    std::vector<float> sharpness{level.GetVertexSharpness(vertex)};
    for (const int edge : level.GetVertexEdges(vertex)) sharpness.push_back(level.GetEdgeSharpness(edge));
    std::erase_if(sharpness, [](float s) { return Sdc::Crease::IsInfinite(s); });
    if (sharpness.empty()) return true;
    const float largest = *std::ranges::max_element(sharpness);
    return std::ranges::all_of(sharpness, [&](float s) { return s == largest || std::ceil(s) < std::ceil(largest); });
}

}  // namespace

std::vector<int> vertices_without_one_limit(const Far::TopologyLevel& level)
{
    std::vector<int> found;
    for (int v = 0; v < level.GetNumVertices(); ++v)
        if (level.IsVertexNonManifold(v) && !level.IsVertexInfSharp(v) &&
            !(have_fans_two_ends(level, v) && softens_alike(level, v)))
            found.push_back(v);
    return found;
}

}  // namespace occam::lod
