#include "lod/deformed_clusters.h"

namespace occam::lod {
namespace {

// Holds the faces around each vertex, one list after the other.
struct FacesOfVertices {
    std::vector<std::uint32_t> first, faces;

    FacesOfVertices(const Cage& cage, const std::vector<std::uint32_t>& first_corner) : first(cage.positions.size() + 1, 0)
    {
        for (const std::uint32_t v : cage.face_vertices) ++first[v + 1];
        for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
        faces.resize(cage.face_vertices.size());
        std::vector<std::uint32_t> next = first;
        for (std::uint32_t f = 0; f + 1 < first_corner.size(); ++f)
            for (std::uint32_t c = first_corner[f]; c < first_corner[f + 1]; ++c) faces[next[cage.face_vertices[c]]++] = f;
    }
};

}  // namespace

DeformedClusters::DeformedClusters(const Cage& cage, const ClusterTree& clusters)
{
    const auto faces = static_cast<std::uint32_t>(cage.face_count());
    std::vector<std::uint32_t> first_corner{0};
    for (std::uint32_t f = 0; f < faces; ++f)
        first_corner.push_back(first_corner.back() + (cage.scheme == Scheme::Triangles ? 3 : cage.face_sizes[f]));
    // The control points of a smooth face are those of the faces around its corners.
    const bool is_smooth = cage.scheme == Scheme::CatmullClark;
    const FacesOfVertices around(is_smooth ? cage : Cage{}, is_smooth ? first_corner : std::vector<std::uint32_t>{0});

    // For each vertex and each face, the number of the last node to whose list it was added, plus one.
    std::vector<std::uint32_t> vertices, stamp(cage.positions.size(), 0), face_stamp(faces, 0);
    const auto add_corners = [&](std::uint32_t face, std::uint32_t mark) {
        if (face_stamp[face] == mark) return;
        face_stamp[face] = mark;
        for (std::uint32_t c = first_corner[face]; c < first_corner[face + 1]; ++c) {
            const std::uint32_t v = cage.face_vertices[c];
            if (stamp[v] == mark) continue;
            stamp[v] = mark;
            vertices.push_back(v);
        }
    };
    for (std::uint32_t i = clusters.node_count(); i-- > 0;) {
        const ClusterTree::Node& node = clusters.node(i);
        if (node.left != 0) {
            const auto part_of = [&](std::uint32_t child) { return std::size_t(clusters.node_count() - 1 - child); };
            table_.add_union(part_of(node.left), part_of(node.left + 1));
            continue;
        }
        vertices.clear();
        for (std::uint32_t k = node.begin; k < node.end; ++k) add_corners(clusters.face(k), i + 1);
        const std::size_t own = vertices.size();
        for (std::size_t k = 0; is_smooth && k < own; ++k)
            for (std::uint32_t n = around.first[vertices[k]]; n < around.first[vertices[k] + 1]; ++n)
                add_corners(around.faces[n], i + 1);
        table_.add(cage, vertices);
    }
}

}  // namespace occam::lod
