#include "tests/support/refined_cages.h"

#include <map>
#include <random>
#include <span>

namespace occam::test {
namespace {

struct Edge {
    Vec3d ends{0}, faces{0};  ///< sums of both ends and of the middles of both faces
};

using Pair = std::pair<std::uint32_t, std::uint32_t>;
Pair key_of(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

template <class Visit>
void for_faces(const Cage& cage, Visit&& visit)
{
    std::size_t first = 0;
    for (std::size_t f = 0; f < cage.face_sizes.size(); first += cage.face_sizes[f++])
        visit(f, std::span(cage.face_vertices).subspan(first, cage.face_sizes[f]));
}

}  // namespace

Cage refined(const Cage& cage, bool is_smooth)
{
    const std::size_t vertices = cage.positions.size(), faces = cage.face_sizes.size();
    std::vector<Vec3d> middles(faces, Vec3d(0)), face_sums(vertices, Vec3d(0)), edge_sums(vertices, Vec3d(0));
    std::vector<double> valence(vertices);
    std::map<Pair, Edge> edges;
    for_faces(cage, [&](std::size_t f, auto face) {
        for (const std::uint32_t v : face) middles[f] += Vec3d(cage.positions[v]) / double(face.size());
        for (std::size_t i = 0; i < face.size(); ++i) {
            const std::uint32_t a = face[i], b = face[(i + 1) % face.size()];
            const Vec3d ends = Vec3d(cage.positions[a]) + Vec3d(cage.positions[b]);
            Edge& edge = edges[key_of(a, b)];
            edge.ends = ends;
            edge.faces += middles[f];
            face_sums[a] += middles[f];
            edge_sums[a] += ends * 0.5;  // in a closed cage a vertex has as many edges as faces
            valence[a] += 1;
        }
    });
    Cage out;
    for (std::size_t v = 0; v < vertices; ++v) {
        const double n = valence[v];
        const Vec3d old(cage.positions[v]);
        out.positions.emplace_back(is_smooth ? (face_sums[v] / n + edge_sums[v] * (2 / n) + old * (n - 3)) / n : old);
    }
    std::map<Pair, std::uint32_t> edge_vertex;
    for (const auto& [key, edge] : edges) {
        edge_vertex[key] = static_cast<std::uint32_t>(out.positions.size());
        out.positions.emplace_back(is_smooth ? (edge.ends + edge.faces) * 0.25 : edge.ends * 0.5);
    }
    const auto first_middle = static_cast<std::uint32_t>(out.positions.size());
    for (const Vec3d& middle : middles) out.positions.emplace_back(middle);
    for_faces(cage, [&](std::size_t f, auto face) {
        for (std::size_t i = 0; i < face.size(); ++i) {
            const std::uint32_t v = face[i], next = face[(i + 1) % face.size()],
                                before = face[(i + face.size() - 1) % face.size()];
            out.face_vertices.insert(out.face_vertices.end(),
                                     {v, edge_vertex[key_of(v, next)], first_middle + static_cast<std::uint32_t>(f),
                                      edge_vertex[key_of(before, v)]});
            out.face_sizes.push_back(4);
        }
    });
    return out;
}

Cage with_triangles(const Cage& cage, std::uint32_t seed)
{
    Cage out;
    out.positions = cage.positions;
    std::mt19937 random(seed);
    for_faces(cage, [&](std::size_t, auto face) {
        const std::uint32_t choice = random() % 4;
        if (face.size() != 4 || choice < 2) {
            out.face_vertices.insert(out.face_vertices.end(), face.begin(), face.end());
            out.face_sizes.push_back(static_cast<std::uint32_t>(face.size()));
            return;
        }
        const std::size_t s = choice - 2;
        out.face_vertices.insert(out.face_vertices.end(), {face[s], face[s + 1], face[s + 2]});
        out.face_vertices.insert(out.face_vertices.end(), {face[s], face[s + 2], face[(s + 3) % 4]});
        out.face_sizes.insert(out.face_sizes.end(), {3, 3});
    });
    return out;
}

}  // namespace occam::test
