#include "scenegraph/cage_creases.h"

#include <algorithm>
#include <array>
#include <span>
#include <unordered_map>
#include <unordered_set>

namespace occam {

namespace {

std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) noexcept
{
    return std::uint64_t(std::min(a, b)) << 32 | std::max(a, b);
}

class Crowding {
public:
    explicit Crowding(const Cage& cage) : cage_(cage), is_crowded_(cage.positions.size()) {}

    /// Returns a flag for each vertex; the result is empty if no flag is set.
    const std::vector<bool>& run()
    {
        if (!find_pairs()) return none_;
        count_edges();
        find_borders();
        for_each_face([&](std::span<const std::uint32_t> face, std::size_t) {
            const auto is_inner_pair = [&](std::size_t c) {
                const std::uint32_t v = face[c], before = face[(c + face.size() - 1) % face.size()],
                                    after = face[(c + 1) % face.size()];
                return corners_[v] == 2 && uses(before, v) == 2 && uses(v, after) == 2;
            };
            bool has_pair = false, has_border = false;
            for (std::size_t c = 0; c < face.size(); ++c) has_pair |= is_inner_pair(c), has_border |= is_border_[face[c]];
            if (!has_pair || !has_border) return;
            any_ = true;
            for (std::uint32_t v : face) is_crowded_[v] = true;
        });
        return any_ ? is_crowded_ : none_;
    }

    int uses(std::uint32_t a, std::uint32_t b) const
    {
        const auto found = edges_.find(edge_key(a, b));
        return found == edges_.end() ? 0 : found->second;
    }

private:
    template <class Visit>
    void for_each_face(Visit&& visit) const
    {
        std::size_t at = 0;
        for (const std::uint32_t size : cage_.face_sizes) {
            visit(std::span(cage_.face_vertices).subspan(at, size), at);
            at += size;
        }
    }

    bool find_pairs()
    {
        corners_.assign(cage_.positions.size(), 0);
        for (std::uint32_t v : cage_.face_vertices) ++corners_[v];
        return std::find(corners_.begin(), corners_.end(), 2u) != corners_.end();
    }
    void count_edges()
    {
        for_each_face([&](std::span<const std::uint32_t> face, std::size_t) {
            for (std::size_t c = 0; c < face.size(); ++c) ++edges_[edge_key(face[c], face[(c + 1) % face.size()])];
        });
    }
    // Finds the ends of edges whose number of faces is not two, and vertices whose corners have different texture
    // coordinates.
    void find_borders()
    {
        is_border_.assign(cage_.positions.size(), false);
        for (const auto& [edge, count] : edges_)
            if (count != 2) is_border_[edge >> 32] = is_border_[edge & 0xffffffff] = true;
        for (const UvSet& set : cage_.uv_sets) {
            std::vector<std::uint32_t> first(set.indices.empty() ? 0 : cage_.positions.size(), 0xffffffff);
            for (std::size_t c = 0; c < set.indices.size(); ++c) {
                std::uint32_t& seen = first[cage_.face_vertices[c]];
                if (seen == 0xffffffff) seen = set.indices[c];
                else if (seen != set.indices[c]) is_border_[cage_.face_vertices[c]] = true;
            }
        }
    }

    const Cage& cage_;
    std::vector<std::uint32_t> corners_;  // the number of faces of each vertex
    std::unordered_map<std::uint64_t, int> edges_;
    std::vector<bool> is_border_, is_crowded_, none_;
    bool any_ = false;
};

/// Finds the vertices that two faces share and nothing else touches, with the two vertices at their edges' other ends.
class Pairs {
public:
    explicit Pairs(const Cage& cage)
    {
        std::vector<std::uint32_t> corners(cage.positions.size());
        for (const std::uint32_t v : cage.face_vertices) ++corners[v];
        std::size_t at = 0;
        for (const std::uint32_t size : cage.face_sizes) {
            const std::span face = std::span(cage.face_vertices).subspan(at, size);
            for (std::size_t c = 0; c < size; ++c)
                if (corners[face[c]] == 2) add(face[c], std::minmax(face[(c + size - 1) % size], face[(c + 1) % size]));
            at += size;
        }
        std::erase_if(ends_, [](const auto& entry) { return entry.second.faces != 2; });
    }

    /// Calls visit(v, w) for each such vertex v and both vertices w at its edges' other ends.
    template <class Visit>
    void for_each_edge(Visit&& visit) const
    {
        for (const auto& [v, ends] : ends_)
            for (const std::uint32_t w : ends.ends) visit(v, w);
    }
    /// Returns the vertices at the other ends of a vertex's edges, or nothing if it is no such vertex.
    std::span<const std::uint32_t> ends(std::uint32_t v) const
    {
        const auto found = ends_.find(v);
        return found == ends_.end() ? std::span<const std::uint32_t>() : found->second.ends;
    }

private:
    struct Ends {
        std::array<std::uint32_t, 2> ends{};
        int faces = 0;
    };

    // Counts the faces that go through a vertex along the same two edges.
    void add(std::uint32_t v, std::pair<std::uint32_t, std::uint32_t> ends)
    {
        Ends& known = ends_[v];
        const std::array<std::uint32_t, 2> both{ends.first, ends.second};
        if (known.faces == 0) known.ends = both;
        if (known.ends == both) ++known.faces;
    }

    std::unordered_map<std::uint32_t, Ends> ends_;
};

}  // namespace

std::size_t drop_crowded_creases(Cage& cage)
{
    if (cage.creases.empty() || cage.scheme != Scheme::CatmullClark) return 0;
    Crowding crowding(cage);
    const std::vector<bool>& is_crowded = crowding.run();
    if (is_crowded.empty()) return 0;
    std::size_t dropped = 0;
    std::erase_if(cage.creases, [&](const Crease& crease) {
        if (!is_crowded[crease.v0] && !is_crowded[crease.v1]) return false;
        dropped += crowding.uses(crease.v0, crease.v1) > 1;
        return true;
    });
    return dropped;
}

std::size_t drop_creases_of_two_faces(Cage& cage)
{
    if (cage.creases.empty() || cage.scheme != Scheme::CatmullClark) return 0;
    const Pairs pairs(cage);
    std::unordered_map<std::uint64_t, float> sharpness;  // the last crease of an edge is the one that counts
    for (const Crease& c : cage.creases) sharpness[edge_key(c.v0, c.v1)] = c.sharpness;
    std::unordered_set<std::uint64_t> dropped;
    std::vector<std::uint32_t> smooth;  // vertices whose creases go
    pairs.for_each_edge([&](std::uint32_t v, std::uint32_t w) {
        const auto crease = sharpness.find(edge_key(v, w));
        if (crease == sharpness.end() || crease->second < kInfiniteSharpness) smooth.push_back(v);
    });
    // A crease that is dropped at one end may leave a vertex of two faces at its other end with one crease.
    while (!smooth.empty()) {
        const std::uint32_t v = smooth.back();
        smooth.pop_back();
        for (const std::uint32_t w : pairs.ends(v))
            if (dropped.insert(edge_key(v, w)).second && !pairs.ends(w).empty()) smooth.push_back(w);
    }
    return std::erase_if(cage.creases, [&](const Crease& c) { return dropped.contains(edge_key(c.v0, c.v1)); });
}

}  // namespace occam
