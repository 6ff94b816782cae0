#include "lod/mesh_part.h"

#include <algorithm>

#include "lod/derived_points.h"

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
    // Where the rule leaves out faces at borders, those that are left touch none or sharp ones, but cutting makes some.
    mesh.boundary = boundary == BoundaryRule::None ? BoundaryRule::EdgeOnly : boundary;
}

MeshPart::MeshPart(const OpenSubdiv::Far::TopologyLevel& level, const MeshRules& rules, int uv_set)
    : MeshPart(level, rules.boundary)
{
    mesh.face_varying = rules.face_varying;
    uv_set_ = uv_set;
    if (uv_set >= 0) mesh.uv_sets.emplace_back();
}

std::uint32_t MeshPart::number_of_value(int value)
{
    const auto [at, is_new] = value_numbers_.emplace(value, static_cast<std::uint32_t>(values.size()));
    if (is_new) {
        values.push_back(value);
        mesh.uv_sets[0].values.emplace_back(0);
    }
    return at->second;
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
    if (uv_set_ < 0) return;
    const auto of_corners = level_.GetFaceFVarValues(sector.face, uv_set_);
    for (int i = 0; i < count; ++i)
        mesh.uv_sets[0].indices.push_back(number_of_value(of_corners[(sector.corner + i) % count]));
}

void MeshPart::add_around(int vertex)
{
    const auto faces = level_.GetVertexFaces(vertex);
    const auto places = level_.GetVertexFaceLocalIndices(vertex);
    for (int f = 0; f < faces.size(); ++f) add({faces[f], places[f]});
}

void MeshPart::add_fans(const Sector& sector)
{
    add(sector);
    const auto corners = level_.GetFaceVertices(sector.face);
    for (int corner = 0; corner < corners.size(); ++corner)
        for (const bool counter_clockwise : {true, false})
            for (const Sector& next : sectors_after(level_, {sector.face, corner}, counter_clockwise,
                                                    static_cast<std::size_t>(level_.GetVertexFaces(corners[corner]).size())))
                add(next);
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
