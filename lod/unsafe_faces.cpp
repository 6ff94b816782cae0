#include "lod/unsafe_faces.h"

#include <algorithm>

#include "scenegraph/large_parts.h"

namespace occam::lod {

using namespace OpenSubdiv;

namespace {

bool is_sharp(const Far::TopologyLevel& level, int edge) { return level.GetEdgeSharpness(edge) > 0; }
bool is_border(const Far::TopologyLevel& level, int edge)
{
    return level.IsEdgeBoundary(edge) || level.IsEdgeNonManifold(edge);
}
bool is_seam(const Far::TopologyLevel& level, int edge)
{
    for (int set = 0; set < level.GetNumFVarChannels(); ++set)
        if (!level.DoesEdgeFVarTopologyMatch(edge, set)) return true;
    return false;
}

/// Returns whether there may be more sharp edges than vertices around a face, for which Bfr::IrregularPatchBuilder::Build
/// has room. Around a corner whose faces are triangles there is one edge more than that. Where two faces close around a
/// vertex, vertices of the others may coincide. Small arrays have room to spare.
bool may_overflow(const Far::TopologyLevel& level, int face)
{
    const auto corners = level.GetFaceVertices(face);
    const auto own = level.GetFaceEdges(face);
    const auto is_own = [&](int edge) { return std::find(own.begin(), own.end(), edge) != own.end(); };
    const auto size = static_cast<std::size_t>(corners.size());
    auto sharp = static_cast<std::size_t>(std::count_if(own.begin(), own.end(), [&](int e) { return is_sharp(level, e); }));
    std::size_t faces = 1, indices = size;
    bool may_have_more = false;
    for (const int v : corners) {
        const auto around = level.GetVertexFaces(v);
        for (const int f : around) indices += static_cast<std::size_t>(level.GetFaceVertices(f).size());
        faces += static_cast<std::size_t>(around.size());
        std::size_t others = 0;
        for (const int e : level.GetVertexEdges(v))
            if (!is_own(e) && is_sharp(level, e)) ++others;
        sharp += others;
        may_have_more |= around.size() == 2 || level.IsVertexNonManifold(v) ||
                         (others > 0 && others + 2 >= static_cast<std::size_t>(around.size()));
    }
    if (!may_have_more || sharp == 0) return false;
    // At a border its edges are added once more.
    sharp += size;
    return faces + indices + size + 2 * sharp > kLeastInts || size + sharp > kLeastFloats;
}

/// Returns the face across an edge of a face, or -1 if the edge is a border.
int across(const Far::TopologyLevel& level, int face, int edge)
{
    if (is_border(level, edge)) return -1;
    const auto faces = level.GetEdgeFaces(edge);
    return faces[0] == face ? faces[1] : faces[0];
}

/// Returns whether two faces close around a corner: the face and one other share both edges there, and nothing else does.
bool is_pair(const Far::TopologyLevel& level, int face, int corner)
{
    const auto edges = level.GetFaceEdges(face);
    const int other = across(level, face, edges[corner]);
    return other >= 0 && other == across(level, face, edges[(corner + edges.size() - 1) % edges.size()]);
}

bool has_pair(const Far::TopologyLevel& level, int face)
{
    for (int corner = 0; corner < level.GetFaceVertices(face).size(); ++corner)
        if (is_pair(level, face, corner)) return true;
    return false;
}

/// Returns whether a face has such a corner and another one at a border. At a seam, Bfr overwrites only sharp edges.
bool is_crowded(const Far::TopologyLevel& level, int face, bool has_creases)
{
    if (!has_pair(level, face)) return false;
    bool has_seam = false, has_crease = false;
    for (const int v : level.GetFaceVertices(face))
        for (const int e : level.GetVertexEdges(v)) {
            if (is_border(level, e)) return true;
            has_seam |= is_seam(level, e);
            has_crease |= has_creases && is_sharp(level, e);
        }
    return has_seam && has_crease;
}

/// Returns the edge of a triangle at a vertex that is not `edge`; -1 if the face has another number of corners.
int other_edge(const Far::TopologyLevel& level, int face, int vertex, int edge)
{
    const auto edges = level.GetFaceEdges(face);
    if (edges.size() != 3) return -1;
    return *std::find_if(edges.begin(), edges.end(), [&](int e) {
        const auto ends = level.GetEdgeVertices(e);
        return e != edge && (ends[0] == vertex || ends[1] == vertex);
    });
}

}  // namespace

bool joins_border(const Far::TopologyLevel& level, int face)
{
    const auto edges = level.GetFaceEdges(face);
    const auto corners = level.GetFaceVertices(face);
    int borders = 0, in = edges[edges.size() - 1];
    for (int c = 0; c < corners.size(); ++c) {
        const int out = edges[c], before = across(level, face, out), after = across(level, face, in);
        if (before < 0 || after < 0 || before == after) return false;
        const int end = other_edge(level, before, corners[c], out);
        if (end < 0 || end != other_edge(level, after, corners[c], in)) return false;
        borders += is_border(level, end);
        in = out;
    }
    return borders == 1;
}

bool has_pairs(const Far::TopologyLevel& level)
{
    for (int v = 0; v < level.GetNumVertices(); ++v) {
        const auto faces = level.GetVertexFaces(v);
        if (faces.size() == 2 && level.GetVertexEdges(v).size() == 2) return true;
        if (!level.IsVertexNonManifold(v)) continue;
        const auto places = level.GetVertexFaceLocalIndices(v);
        for (int f = 0; f < faces.size(); ++f)
            if (is_pair(level, faces[f], places[f])) return true;
    }
    return false;
}

bool is_unsafe(const Far::TopologyLevel& level, int face, bool has_creases)
{
    return (has_creases && may_overflow(level, face)) || is_crowded(level, face, has_creases);
}

}  // namespace occam::lod
