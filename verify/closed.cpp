#include "verify/closed.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include "verify/verify.h"

namespace occam {

namespace {

/// Adds angles up, each given as a complex number of that argument. Their product has the argument of their sum but for
/// whole turns, which the signs of imaginary parts tell; so one arc tangent serves them all.
class AngleSum {
public:
    /// Adds the argument of x + i y, in (-pi, pi]; nothing for 0.
    void add(double x, double y) noexcept
    {
        const double re = re_ * x - im_ * y, im = re_ * y + im_ * x;
        const double size = std::max(std::fabs(re), std::fabs(im));
        if (!(size > kSmall && size < kLarge)) [[unlikely]]
            return rescale(x, y);
        // A sum of two angles of one sign has passed pi if its sine has the other sign.
        turns_ += int(im_ >= 0) & int(y >= 0) & int(im < 0);
        turns_ -= int(im_ < 0) & int(y < 0) & int(im >= 0);
        re_ = re, im_ = im;
    }
    double in_turns() const noexcept { return turns_ + std::atan2(im_, re_) / (2 * 3.14159265358979323846); }

private:
    static constexpr double kSmall = 1e-100, kLarge = 1e100;

    // Adds the angle with both numbers scaled to about 1.
    void rescale(double x, double y) noexcept
    {
        const double own = std::max(std::fabs(re_), std::fabs(im_)), other = std::max(std::fabs(x), std::fabs(y));
        if (!(other > 0)) return;
        re_ /= own, im_ /= own;
        add(x / other, y / other);
    }

    double re_ = 1, im_ = 0;
    int turns_ = 0;
};

// The tangent of half of a triangle's solid angle is a quotient (Van Oosterom and Strackee 1983).
template <class Corner>
double solid_angles(std::span<const Corner> corners, Vec3d at)
{
    AngleSum halves;
    for (std::size_t t = 0; t + 2 < corners.size(); t += 3) {
        const Vec3d a = Vec3d(corners[t]) - at, b = Vec3d(corners[t + 1]) - at, c = Vec3d(corners[t + 2]) - at;
        const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
        const double scale = la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb;
        halves.add(scale, glm::dot(a, glm::cross(b, c)));
    }
    return halves.in_turns();
}

/// An edge as a face passes it, with the vertex that precedes it in the face.
struct FaceEdge {
    std::uint32_t from, to, before;

    friend bool operator<(const FaceEdge& a, const FaceEdge& b) { return std::tie(a.from, a.to) < std::tie(b.from, b.to); }
};

/// Returns the first of the sorted edges that does not come before the given one.
std::vector<FaceEdge>::const_iterator find(const std::vector<FaceEdge>& edges, std::uint32_t from, std::uint32_t to)
{
    return std::lower_bound(edges.begin(), edges.end(), FaceEdge{from, to, 0});
}

/// Returns the number of faces that pass an edge in this direction, or 2 if there are more.
std::size_t faces_along(const std::vector<FaceEdge>& edges, std::uint32_t from, std::uint32_t to)
{
    std::size_t count = 0;
    for (auto at = find(edges, from, to); at != edges.end() && at->from == from && at->to == to && count < 2; ++at) ++count;
    return count;
}

}  // namespace

double winding_number(std::span<const Vec3f> corners, Vec3d at) { return solid_angles(corners, at); }
double winding_number(std::span<const Vec3d> corners, Vec3d at) { return solid_angles(corners, at); }

std::string why_not_closed(const Cage& cage)
{
    std::vector<bool> is_hole(cage.face_count());
    for (const std::uint32_t h : cage.holes) is_hole[h] = true;
    std::vector<FaceEdge> edges;
    std::size_t first = 0;
    for (std::size_t f = 0; f < cage.face_count(); ++f) {
        const std::size_t n = cage.scheme == Scheme::Triangles ? 3 : cage.face_sizes[f];
        const auto vertex = [&](std::size_t k) { return cage.face_vertices[first + k % n]; };
        for (std::size_t k = 0; k < n && !is_hole[f]; ++k) edges.push_back({vertex(k), vertex(k + 1), vertex(k + n - 1)});
        first += n;
    }
    if (edges.empty()) return "it has no face";
    std::sort(edges.begin(), edges.end());
    for (const FaceEdge& edge : edges) {
        const std::size_t there = faces_along(edges, edge.from, edge.to), back = faces_along(edges, edge.to, edge.from);
        if (there == 1 && back == 1) continue;
        const char* const why = back > 0    ? " has more than two faces"
                                : there > 1 ? " has several faces that pass it in one direction, and none in the other"
                                            : " has a face on one side only";
        return "edge " + std::to_string(edge.from) + "-" + std::to_string(edge.to) + why;
    }
    // The walk goes around a vertex from face to face; one turn must reach all of its faces.
    for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
        while (end < edges.size() && edges[end].from == edges[begin].from) ++end;
        std::size_t met = 0;
        std::uint32_t to = edges[begin].to;
        do {
            to = find(edges, edges[begin].from, to)->before;  // the next edge around, seen from the vertex
            ++met;
        } while (to != edges[begin].to && met <= end - begin);
        if (met != end - begin) return "vertex " + std::to_string(edges[begin].from) + " has more than one fan of faces";
    }
    return {};
}

}  // namespace occam
