#include "scenegraph/cage_creases.h"

#include <algorithm>
#include <span>
#include <unordered_map>

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

}  // namespace occam
