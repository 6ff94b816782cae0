#include "io/builtin/panelled_ball.h"

#include <array>
#include <map>
#include <utility>
#include <vector>

namespace occam::builtin {
namespace {

using Panel = std::vector<std::uint32_t>;

// The corners run counter-clockwise as seen from outside.
struct Polyhedron {
    std::vector<Vec3f> vertices;
    std::vector<Panel> faces;
};

Polyhedron icosahedron()
{
    constexpr float kGolden = 1.61803398875f;
    Polyhedron p;
    for (int axis = 0; axis < 3; ++axis)
        for (int k = 0; k < 4; ++k) {
            Vec3f v(0);
            v[axis] = k & 1 ? 1.0f : -1.0f;
            v[(axis + 1) % 3] = k & 2 ? kGolden : -kGolden;
            p.vertices.push_back(v);
        }
    // The faces are the triples of vertices whose mutual distance is 2, the length of an edge.
    const auto is_edge = [&](std::uint32_t a, std::uint32_t b) {
        const Vec3f d = p.vertices[a] - p.vertices[b];
        return glm::dot(d, d) < 5;
    };
    for (std::uint32_t a = 0; a < 12; ++a)
        for (std::uint32_t b = a + 1; b < 12; ++b)
            for (std::uint32_t c = b + 1; c < 12; ++c) {
                if (!is_edge(a, b) || !is_edge(b, c) || !is_edge(c, a)) continue;
                const Vec3f *v = p.vertices.data(), normal = glm::cross(v[b] - v[a], v[c] - v[a]);
                p.faces.push_back(glm::dot(normal, v[a]) > 0 ? Panel{a, b, c} : Panel{a, c, b});
            }
    return p;
}

// Cuts off every corner at a third of its edges: a face of n corners becomes one of 2n corners, and each vertex becomes a
// face.
Polyhedron truncated(const Polyhedron& p)
{
    Polyhedron out;
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> cuts;  // the one near `first` on its edge to `second`
    const auto cut = [&](std::uint32_t near, std::uint32_t far) {
        const auto [it, is_new] = cuts.try_emplace({near, far}, static_cast<std::uint32_t>(out.vertices.size()));
        if (is_new) out.vertices.push_back((p.vertices[near] * 2.0f + p.vertices[far]) / 3.0f);
        return it->second;
    };
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t>
        before;  // (vertex, next in a face) -> previous in that face
    for (const Panel& f : p.faces) {
        Panel face;
        for (std::size_t k = 0; k < f.size(); ++k) {
            const std::uint32_t a = f[k], b = f[(k + 1) % f.size()];
            face.push_back(cut(a, b));
            face.push_back(cut(b, a));
            before[{a, b}] = f[(k + f.size() - 1) % f.size()];
        }
        out.faces.push_back(face);
    }
    for (std::uint32_t v = 0; v < p.vertices.size(); ++v) {
        const std::uint32_t first = before.lower_bound({v, 0})->first.second;
        Panel face;
        std::uint32_t next = first;
        do {
            face.push_back(cut(v, next));
            next = before.at({v, next});
        } while (next != first);
        out.faces.push_back(face);
    }
    return out;
}

}  // namespace

Cage panelled_ball(std::string name, float radius, float puff, float sharpness)
{
    const Polyhedron p = truncated(icosahedron());
    Cage cage;
    cage.name = std::move(name);
    for (const Vec3f v : p.vertices) cage.positions.push_back(glm::normalize(v) * radius);

    const auto add_face = [&](const Panel& corners, std::uint16_t slot) {
        cage.face_sizes.push_back(static_cast<std::uint32_t>(corners.size()));
        cage.face_vertices.insert(cage.face_vertices.end(), corners.begin(), corners.end());
        cage.face_slots.push_back(slot);
    };
    for (const Panel& panel : p.faces) {
        const std::size_t n = panel.size();
        const std::uint16_t slot = n == 5 ? 1 : 0;
        Vec3f middle(0);
        for (const std::uint32_t v : panel) middle += cage.positions[v] / float(n);
        Panel inner;
        for (const std::uint32_t v : panel) {
            const Vec3f inset = glm::mix(cage.positions[v], middle, 0.25f);
            inner.push_back(static_cast<std::uint32_t>(cage.positions.size()));
            cage.positions.push_back(glm::normalize(inset) * (radius * (1 + puff)));
        }
        add_face(inner, slot);
        for (std::size_t k = 0; k < n; ++k) {
            const std::size_t l = (k + 1) % n;
            add_face({panel[k], panel[l], inner[l], inner[k]}, slot);
            if (panel[k] < panel[l]) cage.creases.push_back({panel[k], panel[l], sharpness});
        }
    }
    return cage;
}

}  // namespace occam::builtin
