#include "lod/mesh_part.h"

#include <algorithm>

namespace occam::lod {

Sector child_at(const OpenSubdiv::Far::TopologyLevel& coarse, const OpenSubdiv::Far::TopologyLevel& fine,
                const Sector& corner)
{
    const int vertex = coarse.GetVertexChildVertex(coarse.GetFaceVertices(corner.face)[corner.corner]);
    // The children of a face are in the order of its corners.
    Sector quad{coarse.GetFaceChildFaces(corner.face)[corner.corner], 0};
    while (fine.GetFaceVertices(quad.face)[quad.corner] != vertex) ++quad.corner;
    return quad;
}

MeshPart::MeshPart(const OpenSubdiv::Far::TopologyLevel& level, BoundaryRule boundary) : level_(level)
{
    // Where the rule leaves out faces at borders, those that are left touch none, but cutting makes some.
    mesh.boundary = boundary == BoundaryRule::None ? BoundaryRule::EdgeAndCorner : boundary;
}

std::uint32_t MeshPart::number_of(int vertex)
{
    const auto [at, is_new] = numbers_.emplace(vertex, static_cast<std::uint32_t>(vertices.size()));
    if (is_new) {
        vertices.push_back(vertex);
        mesh.positions.emplace_back(0);
    }
    return at->second;
}

void MeshPart::add(const Sector& sector)
{
    if (!faces_.insert(sector.face).second) return;
    const auto corners = level_.GetFaceVertices(sector.face);
    const int count = corners.size();
    mesh.face_sizes.push_back(static_cast<std::uint32_t>(count));
    for (int i = 0; i < count; ++i) mesh.face_vertices.push_back(number_of(corners[(sector.corner + i) % count]));
    for (const int edge : level_.GetFaceEdges(sector.face)) edges_.push_back(edge);
}

void MeshPart::add_around(int vertex)
{
    const auto faces = level_.GetVertexFaces(vertex);
    const auto places = level_.GetVertexFaceLocalIndices(vertex);
    for (int f = 0; f < faces.size(); ++f) add({faces[f], places[f]});
}

void MeshPart::add_with_neighbours(const Sector& sector)
{
    add(sector);
    for (const int vertex : level_.GetFaceVertices(sector.face)) add_around(vertex);
}

void MeshPart::add_sharpness()
{
    std::set<int> known;
    for (const int edge : edges_) {
        const float sharpness = level_.GetEdgeSharpness(edge);
        if (!(sharpness > 0) || level_.IsEdgeBoundary(edge) || !known.insert(edge).second) continue;
        const auto ends = level_.GetEdgeVertices(edge);
        const std::uint32_t a = number_of(ends[0]), b = number_of(ends[1]);
        mesh.creases.push_back({std::min(a, b), std::max(a, b), sharpness});
    }
    for (std::uint32_t v = 0; v < vertices.size(); ++v)
        if (const float sharpness = level_.GetVertexSharpness(vertices[v]); sharpness > 0)
            mesh.corners.push_back({v, sharpness});
}

}  // namespace occam::lod
