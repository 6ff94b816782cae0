#include "tests/support/limit_oracle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace occam::test {
namespace {

using Real = long double;

Real after_a_step(Real sharpness)
{
    return sharpness >= Real(kInfiniteSharpness) ? sharpness : std::max(sharpness - 1, Real(0));
}

Vec3l edge_point(Vec3l a, Vec3l b, Vec3l left, Vec3l right, Real sharpness)
{
    const Vec3l sharp = (a + b) / Real(2), smooth = (a + b + left + right) / Real(4);
    return smooth + (sharp - smooth) * std::min(sharpness, Real(1));
}

enum class Rule { Smooth, Crease, Corner };

/// A vertex with its neighbours: the ends of its edges, the sharpness of these, and the middles of its faces.
struct Star {
    Vec3l p;
    std::vector<Vec3l> ends, middles;
    std::vector<Real> sharpness;
    Real corner = 0;

    Rule rule() const
    {
        const auto sharp = std::count_if(sharpness.begin(), sharpness.end(), [](Real s) { return s > 0; });
        return corner > 0 || sharp > 2 ? Rule::Corner : sharp == 2 ? Rule::Crease : Rule::Smooth;
    }

    Vec3l moved_by(Rule rule) const
    {
        if (rule == Rule::Corner) return p;
        Vec3l sum(0);
        if (rule == Rule::Crease) {
            for (std::size_t i = 0; i < ends.size(); ++i)
                if (sharpness[i] > 0) sum += ends[i];
            return (sum + p * Real(6)) / Real(8);
        }
        for (const Vec3l v : ends) sum += v;
        for (const Vec3l v : middles) sum += v;
        const auto n = static_cast<Real>(ends.size());
        return p * ((n - 2) / n) + sum / (n * n);
    }

    Star softer() const
    {
        Star out = *this;
        out.corner = after_a_step(corner);
        for (Real& s : out.sharpness) s = after_a_step(s);
        return out;
    }

    /// Returns how much of the vertex still follows the rule of before the step: the mean of what ends within it.
    Real share_of_old_rule(const Star& next) const
    {
        Real sum = 0, count = 0;
        const auto add = [&](Real before, Real after) {
            if (before > 0 && after <= 0) sum += before, ++count;
        };
        add(corner, next.corner);
        for (std::size_t i = 0; i < ends.size(); ++i) add(sharpness[i], next.sharpness[i]);
        return count > 0 ? std::min(sum / count, Real(1)) : Real(0);
    }

    Vec3l moved() const
    {
        const Star next = softer();
        const Vec3l old_rule = moved_by(rule());
        if (rule() == next.rule() || rule() == Rule::Smooth) return old_rule;
        const Vec3l new_rule = next.moved_by(next.rule());
        return new_rule + (old_rule - new_rule) * share_of_old_rule(next);
    }

    /// Returns the same vertex after a step, when its ring is of quads.
    Star subdivided() const
    {
        Star out = softer();
        const std::size_t n = ends.size();
        out.p = moved();
        for (std::size_t i = 0; i < n; ++i)
            out.ends[i] = edge_point(p, ends[i], middles[i], middles[(i + n - 1) % n], sharpness[i]);
        for (std::size_t i = 0; i < n; ++i)
            out.middles[i] = (out.p + out.ends[i] + out.ends[(i + 1) % n] + middles[i]) / Real(4);
        return out;
    }
};

}  // namespace

SubdivisionMesh::SubdivisionMesh(const Cage& cage)
{
    for (const Vec3f p : cage.positions) points_.push_back(Vec3l(p));
    corners_.assign(points_.size(), 0);
    for (const Corner& c : cage.corners) corners_[c.vertex] = Real(c.sharpness);
    for (const Crease& c : cage.creases) creases_[std::minmax(c.v0, c.v1)] = Real(c.sharpness);
    auto at = cage.face_vertices.begin();
    for (std::uint32_t f = 0; f < cage.face_sizes.size(); ++f) {
        faces.push_back({std::vector<std::uint32_t>(at, at + cage.face_sizes[f]), f});
        at += cage.face_sizes[f];
    }
    connect();
}

void SubdivisionMesh::connect()
{
    first_edges_.assign(points_.size(), {~0u, ~0u});
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
        const std::vector<std::uint32_t>& c = faces[f].corners;
        for (std::size_t i = 0; i < c.size(); ++i) {
            const Edge edge = {c[i], c[(i + 1) % c.size()]};
            has_shared_edges_ |= !face_left_.try_emplace(edge, f).second;
            first_edges_[c[i]] = edge;
        }
    }
    inside_.assign(points_.size(), 1);
    for (const auto& [edge, face] : face_left_)
        if (!face_left_.contains({edge.second, edge.first})) inside_[edge.first] = inside_[edge.second] = 0;
}

SubdivisionMesh SubdivisionMesh::around(std::uint32_t vertex) const
{
    SubdivisionMesh out;
    std::map<std::uint32_t, std::uint32_t> numbers{{vertex, 0}};
    std::vector<std::uint8_t> is_taken(faces.size());
    for (int ring = 0; ring < 3; ++ring) {
        const auto known = numbers;
        for (std::size_t f = 0; f < faces.size(); ++f) {
            const std::vector<std::uint32_t>& c = faces[f].corners;
            if (is_taken[f] || std::none_of(c.begin(), c.end(), [&](std::uint32_t v) { return known.contains(v); }))
                continue;
            is_taken[f] = 1;
            Face& face = out.faces.emplace_back(faces[f]);
            for (std::uint32_t& v : face.corners)
                v = numbers.try_emplace(v, static_cast<std::uint32_t>(numbers.size())).first->second;
        }
    }
    out.points_.resize(numbers.size());
    out.corners_.resize(numbers.size());
    for (const auto& [from, to] : numbers) out.points_[to] = points_[from], out.corners_[to] = corners_[from];
    for (const auto& [edge, sharpness] : creases_) {
        const auto a = numbers.find(edge.first), b = numbers.find(edge.second);
        if (a != numbers.end() && b != numbers.end()) out.creases_[std::minmax(a->second, b->second)] = sharpness;
    }
    out.connect();
    return out;
}

bool SubdivisionMesh::is_closed_manifold() const
{
    if (has_shared_edges_) return false;
    for (const auto& [edge, face] : face_left_)
        if (!face_left_.contains({edge.second, edge.first})) return false;
    std::vector<std::size_t> uses(points_.size());
    for (const Face& face : faces)
        for (const std::uint32_t v : face.corners) ++uses[v];
    for (std::uint32_t v = 0; v < points_.size(); ++v)
        if (uses[v] > 0 && ring_of(v).ends.size() != uses[v]) return false;
    return true;
}

SubdivisionMesh::Ring SubdivisionMesh::ring_of(std::uint32_t vertex) const
{
    Ring ring;
    Edge edge = first_edges_[vertex];
    do {
        const std::uint32_t face = face_left_.at(edge);
        ring.ends.push_back(edge.second);
        ring.faces.push_back(face);
        ring.sharpness.push_back(sharpness_of(vertex, edge.second));
        const std::vector<std::uint32_t>& c = faces[face].corners;
        const auto here = static_cast<std::size_t>(std::find(c.begin(), c.end(), vertex) - c.begin());
        edge = {vertex, c[(here + c.size() - 1) % c.size()]};
    } while (edge != first_edges_[vertex]);
    return ring;
}

long double SubdivisionMesh::sharpness_of(std::uint32_t a, std::uint32_t b) const
{
    const auto found = creases_.find(std::minmax(a, b));
    return found == creases_.end() ? 0 : found->second;
}

Vec3l SubdivisionMesh::middle_of(std::uint32_t face) const
{
    Vec3l sum(0);
    for (const std::uint32_t v : faces[face].corners) sum += points_[v];
    return sum / static_cast<Real>(faces[face].corners.size());
}

SubdivisionMesh SubdivisionMesh::refined() const
{
    SubdivisionMesh out;
    const auto first_face = static_cast<std::uint32_t>(points_.size());
    out.points_.resize(points_.size());
    for (std::uint32_t f = 0; f < faces.size(); ++f) out.points_.push_back(middle_of(f));
    std::map<Edge, std::uint32_t> edge_vertex;
    for (const auto& [edge, face] : face_left_) {
        if (edge.first > edge.second || !face_left_.contains({edge.second, edge.first})) continue;
        const Real sharpness = sharpness_of(edge.first, edge.second);
        const auto vertex = static_cast<std::uint32_t>(out.points_.size());
        edge_vertex[edge] = vertex;
        out.points_.push_back(edge_point(points_[edge.first], points_[edge.second], middle_of(face),
                                         middle_of(face_left_.at({edge.second, edge.first})), sharpness));
        if (after_a_step(sharpness) > 0)
            for (const std::uint32_t end : {edge.first, edge.second})
                out.creases_[std::minmax(end, vertex)] = after_a_step(sharpness);
    }
    out.corners_.assign(out.points_.size(), 0);
    for (std::uint32_t v = 0; v < points_.size(); ++v) {
        out.points_[v] = points_[v];
        out.corners_[v] = after_a_step(corners_[v]);
        if (first_edges_[v].first == ~0u || !is_inside(v)) continue;
        const Ring ring = ring_of(v);
        Star star{points_[v], {}, {}, ring.sharpness, corners_[v]};
        for (const std::uint32_t end : ring.ends) star.ends.push_back(points_[end]);
        for (const std::uint32_t face : ring.faces) star.middles.push_back(middle_of(face));
        out.points_[v] = star.moved();
    }
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
        const Face& face = faces[f];
        const auto n = static_cast<std::uint32_t>(face.corners.size());
        const bool is_patch = n == 4;
        for (std::uint32_t i = 0; i < n; ++i) {
            const std::uint32_t here = face.corners[i], next = face.corners[(i + 1) % n],
                                last = face.corners[(i + n - 1) % n];
            if (!is_inside(here)) continue;
            Face child = face;
            child.corners = {here, edge_vertex.at(std::minmax(here, next)), first_face + f,
                             edge_vertex.at(std::minmax(last, here))};
            if (is_patch) {
                // Child i lies at corner i and keeps the face's own directions.
                std::rotate(child.corners.begin(), child.corners.begin() + (4 - i) % 4, child.corners.end());
                child.size = face.size / 2;
                child.u += i == 1 || i == 2 ? child.size : 0;
                child.v += i >= 2 ? child.size : 0;
            } else {
                child.sub = i;
            }
            out.faces.push_back(child);
        }
    }
    out.connect();
    return out;
}

SubdivisionMesh::Limit SubdivisionMesh::limit(std::uint32_t vertex) const
{
    const Ring ring = ring_of(vertex);
    Star star{points_[vertex], {}, {}, ring.sharpness, corners_[vertex]};
    for (const std::uint32_t end : ring.ends) star.ends.push_back(points_[end]);
    for (const std::uint32_t face : ring.faces) star.middles.push_back(middle_of(face));

    // After eleven steps nothing is semi-sharp, and the masks of Halstead, Kass and DeRose (1993) give the tangents.
    constexpr int kSteps = 80, kSmooth = 11;
    Limit out;
    const std::size_t n = star.ends.size();
    for (int step = 0; step < kSteps; ++step) {
        const Star next = star.subdivided();
        if (step == kSmooth && next.rule() == Rule::Smooth && n > 2) {
            const Real turn = 2 * std::numbers::pi_v<Real> / static_cast<Real>(n);
            const Real a = 1 + std::cos(turn) + std::cos(turn / 2) * std::sqrt(2 * (9 + std::cos(turn)));
            Vec3l t1(0), t2(0);
            for (std::size_t i = 0; i < n; ++i) {
                const Real at = turn * static_cast<Real>(i), after = turn * static_cast<Real>(i + 1);
                // The face's vertex that lies across from this one is the middle of the coarser face.
                t1 += next.ends[i] * (a * std::cos(at)) + star.middles[i] * (std::cos(at) + std::cos(after));
                t2 += next.ends[i] * (a * std::sin(at)) + star.middles[i] * (std::sin(at) + std::sin(after));
            }
            out.normal = glm::cross(t1, t2);
            const bool is_dart = std::any_of(next.sharpness.begin(), next.sharpness.end(), [](Real s) { return s > 0; });
            out.has_normal = !is_dart && glm::length(out.normal) > Real(1e-6) * std::max(glm::dot(t1, t1), glm::dot(t2, t2));
        }
        star = next;
    }
    out.point = star.p;
    out.valence = n;
    return out;
}

}  // namespace occam::test
