#include "scenegraph/cage_creases.h"

#include <algorithm>
#include <array>
#include <span>
#include <unordered_map>
#include <unordered_set>

#include "scenegraph/cage_faces.h"

namespace occam {

namespace {

constexpr std::uint32_t kNone = ~0u;

/// Finds what lies across the edges at the vertices of creases.
class Neighbours {
public:
    explicit Neighbours(const Cage& cage) : across_(cage.face_vertices.size(), kNone)
    {
        std::vector<bool> has_crease(cage.positions.size());
        for (const Crease& crease : cage.creases) has_crease[crease.v0] = has_crease[crease.v1] = true;
        std::vector<Side> sides;
        std::uint32_t number = 0;
        for_each_face(cage, [&](std::span<const std::uint32_t> face, std::size_t first) {
            for (std::size_t c = 0; c < face.size(); ++c) {
                const std::uint32_t from = face[c], to = face[(c + 1) % face.size()];
                if (has_crease[from] || has_crease[to])
                    sides.push_back({edge_key(from, to), static_cast<std::uint32_t>(first + c), number, from < to});
            }
            ++number;
        });
        std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.key < b.key; });
        for (std::size_t from = 0, to = 0; from < sides.size(); from = to) {
            while (to < sides.size() && sides[to].key == sides[from].key) ++to;
            const Side &a = sides[from], &b = sides[to - 1];
            if (to - from != 2 || a.face == b.face || a.rises == b.rises) continue;
            across_[a.corner] = b.face;
            across_[b.corner] = a.face;
        }
    }

    /// Returns whether two faces close around corner c of a face, whose first corner is `first`: it shares the edges before
    /// and after that corner with one other face of its orientation, and nothing else has these edges.
    bool is_pair(std::size_t first, std::size_t size, std::size_t c) const noexcept
    {
        const std::uint32_t other = across_[first + c];
        return other != kNone && across_[first + (c > 0 ? c : size) - 1] == other;
    }

private:
    /// An edge as a face has it, from the corner on.
    struct Side {
        std::uint64_t key;
        std::uint32_t corner, face;
        bool rises;  ///< to the larger number of a vertex
    };

    std::vector<std::uint32_t> across_;  ///< by corner: the face beyond the edge that begins there, or kNone
};

/// Finds the vertices around which two faces close or that two faces share and nothing else touches, with the two vertices
/// at the other ends of the edges between these faces.
class Pairs {
public:
    using Ends = std::array<std::uint32_t, 2>;

    Pairs(const Cage& cage, const Neighbours& neighbours)
    {
        std::vector<std::uint32_t> corners(cage.positions.size());
        for (const std::uint32_t v : cage.face_vertices) ++corners[v];
        std::unordered_map<std::uint32_t, Ends> first_face;  // of vertices of two faces
        for_each_face(cage, [&](std::span<const std::uint32_t> face, std::size_t first) {
            for (std::size_t c = 0; c < face.size(); ++c) {
                const auto [a, b] = std::minmax(face[(c + face.size() - 1) % face.size()], face[(c + 1) % face.size()]);
                const Ends ends{a, b};
                if (corners[face[c]] == 2) {
                    const auto [known, is_first] = first_face.emplace(face[c], ends);
                    if (!is_first && known->second == ends) ends_[face[c]].push_back(ends);
                } else if (neighbours.is_pair(first, face.size(), c)) {
                    ends_[face[c]].push_back(ends);
                }
            }
        });
    }

    /// Calls visit(v, ends) for each such vertex and each pair of faces there.
    template <class Visit>
    void for_each(Visit&& visit) const
    {
        for (const auto& [v, all] : ends_)
            for (const Ends& ends : all) visit(v, ends);
    }
    /// Returns those of a vertex; none if it is no such vertex.
    std::span<const Ends> at(std::uint32_t v) const
    {
        const auto found = ends_.find(v);
        return found == ends_.end() ? std::span<const Ends>() : found->second;
    }

private:
    std::unordered_map<std::uint32_t, std::vector<Ends>> ends_;
};

}  // namespace

std::size_t drop_creases_off_edges(Cage& cage)
{
    if (cage.creases.empty()) return 0;
    std::unordered_map<std::uint64_t, bool> is_edge;
    for (const Crease& crease : cage.creases) is_edge.emplace(edge_key(crease.v0, crease.v1), false);
    for_each_face(cage, [&](std::span<const std::uint32_t> face, std::size_t) {
        for (std::size_t c = 0; c < face.size(); ++c)
            if (const auto found = is_edge.find(edge_key(face[c], face[(c + 1) % face.size()])); found != is_edge.end())
                found->second = true;
    });
    return std::erase_if(cage.creases, [&](const Crease& crease) { return !is_edge.at(edge_key(crease.v0, crease.v1)); });
}

std::size_t drop_creases_of_two_faces(Cage& cage)
{
    if (cage.creases.empty() || cage.scheme != Scheme::CatmullClark) return 0;
    const Pairs pairs(cage, Neighbours(cage));
    std::unordered_map<std::uint64_t, float> sharpness;  // the last crease of an edge is the one that counts
    for (const Crease& c : cage.creases) sharpness[edge_key(c.v0, c.v1)] = c.sharpness;
    std::unordered_set<std::uint64_t> dropped;
    std::vector<std::uint32_t> smooth;  // vertices whose creases go
    pairs.for_each([&](std::uint32_t v, const Pairs::Ends& ends) {
        for (const std::uint32_t w : ends) {
            const auto crease = sharpness.find(edge_key(v, w));
            if (crease == sharpness.end() || crease->second < kInfiniteSharpness) smooth.push_back(v);
        }
    });
    // A crease that is dropped at one end may leave a vertex of two faces at its other end with one crease.
    while (!smooth.empty()) {
        const std::uint32_t v = smooth.back();
        smooth.pop_back();
        for (const Pairs::Ends& ends : pairs.at(v))
            for (const std::uint32_t w : ends)
                if (dropped.insert(edge_key(v, w)).second && !pairs.at(w).empty()) smooth.push_back(w);
    }
    return std::erase_if(cage.creases, [&](const Crease& c) { return dropped.contains(edge_key(c.v0, c.v1)); });
}

}  // namespace occam
