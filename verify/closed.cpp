#include "verify/closed.h"

#include <cmath>
#include <map>

#include "verify/verify.h"

namespace occam {

namespace {
template <class Corner>
double solid_angles(std::span<const Corner> corners, Vec3d at)
{
    double sum = 0;
    for (std::size_t t = 0; t + 2 < corners.size(); t += 3) {
        const Vec3d a = Vec3d(corners[t]) - at, b = Vec3d(corners[t + 1]) - at, c = Vec3d(corners[t + 2]) - at;
        const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
        const double scale = la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb;
        sum += 2 * std::atan2(glm::dot(a, glm::cross(b, c)), scale);
    }
    return sum / (4 * 3.14159265358979323846);
}
}  // namespace

double winding_number(std::span<const Vec3f> corners, Vec3d at) { return solid_angles(corners, at); }
double winding_number(std::span<const Vec3d> corners, Vec3d at) { return solid_angles(corners, at); }

std::string why_not_closed(const Cage& cage)
{
    std::vector<bool> is_hole(cage.face_count());
    for (const std::uint32_t h : cage.holes) is_hole[h] = true;
    struct Use {
        std::uint32_t count = 0, before = 0;  // `before` is the vertex that precedes it in its face
    };
    std::map<std::pair<std::uint32_t, std::uint32_t>, Use> uses;
    std::map<std::uint32_t, std::uint32_t> corners;  // number of faces around each vertex
    std::size_t first = 0;
    for (std::size_t f = 0; f < cage.face_count(); ++f) {
        const std::size_t n = cage.scheme == Scheme::Triangles ? 3 : cage.face_sizes[f];
        const auto vertex = [&](std::size_t k) { return cage.face_vertices[first + k % n]; };
        for (std::size_t k = 0; k < n && !is_hole[f]; ++k) {
            Use& use = uses[{vertex(k), vertex(k + 1)}];
            ++use.count;
            use.before = vertex(k + n - 1);
            ++corners[vertex(k)];
        }
        first += n;
    }
    if (uses.empty()) return "it has no face";
    for (const auto& [edge, use] : uses) {
        const auto other = uses.find({edge.second, edge.first});
        const std::string name = "edge " + std::to_string(edge.first) + "-" + std::to_string(edge.second);
        if (other == uses.end()) return name + " has a face on one side only";
        if (use.count != 1 || other->second.count != 1) return name + " has more than two faces";
    }
    // The walk goes around a vertex from face to face; one turn must reach all of its faces.
    std::map<std::uint32_t, std::uint32_t> any_edge;
    for (const auto& [edge, use] : uses) any_edge[edge.first] = edge.second;
    for (const auto& [vertex, count] : corners) {
        std::uint32_t met = 0, to = any_edge[vertex];
        do {
            to = uses[{vertex, to}].before;  // the next edge around, seen from the vertex
            ++met;
        } while (to != any_edge[vertex] && met <= count);
        if (met != count) return "vertex " + std::to_string(vertex) + " has more than one fan of faces";
    }
    return {};
}

}  // namespace occam
