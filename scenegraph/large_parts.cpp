#include "scenegraph/large_parts.h"

#include <algorithm>
#include <span>
#include <vector>

#include "scenegraph/cage_faces.h"

namespace occam {
namespace {

/// What is around a vertex.
struct Around {
    std::uint32_t faces = 0, vertices = 0;  ///< each face counts all of its vertices but two
    std::uint32_t before = 0, after = 0;    ///< the neighbours of the vertex in the first of these faces
    bool is_pair = false;                   ///< whether some face has the same neighbours the other way around
};

std::vector<Around> look_around(const Cage& cage)
{
    std::vector<Around> all(cage.positions.size());
    for_each_face(cage, [&](std::span<const std::uint32_t> corners, std::size_t) {
        std::uint32_t before = corners.back();
        for (std::size_t c = 0; c < corners.size(); ++c) {
            Around& at = all[corners[c]];
            const std::uint32_t after = c + 1 < corners.size() ? corners[c + 1] : corners.front();
            if (at.faces == 0) at.before = before, at.after = after;
            else at.is_pair |= at.before == after && at.after == before;
            ++at.faces;
            at.vertices += static_cast<std::uint32_t>(corners.size()) - 2;
            before = corners[c];
        }
    });
    return all;
}

/// Returns whether a face may take derived points although it is not large and touches no large vertex: its corners see very
/// many vertices, or lod::is_unsafe() may be true.
bool may_take_points(const std::vector<Around>& around, std::span<const std::uint32_t> corners, bool has_creases)
{
    std::size_t controls = 0, faces = 1, indices = corners.size(), edges = corners.size();
    for (const std::uint32_t v : corners) {
        const Around& at = around[v];
        if (at.is_pair) return true;
        controls += at.vertices;
        faces += at.faces;
        indices += std::size_t(at.vertices) + 2 * at.faces;
        edges += std::size_t(at.faces) + 2;
    }
    return controls > kMostControls || (has_creases && (faces + indices + corners.size() + 2 * edges > kLeastInts ||
                                                        corners.size() + edges > kLeastFloats));
}

std::size_t count_edges(const Cage& cage)
{
    std::vector<std::uint64_t> edges;
    edges.reserve(cage.face_vertices.size());
    for_each_face(cage, [&](std::span<const std::uint32_t> corners, std::size_t) {
        for (std::size_t c = 0; c < corners.size(); ++c)
            edges.push_back(edge_key(corners[c], corners[(c + 1) % corners.size()]));
    });
    std::ranges::sort(edges);
    return static_cast<std::size_t>(std::unique(edges.begin(), edges.end()) - edges.begin());
}

}  // namespace

std::size_t most_derived_points(const Cage& cage)
{
    if (cage.scheme == Scheme::Triangles) return 0;
    // After a step of refinement, large faces are large vertices.
    auto large = static_cast<std::size_t>(
        std::ranges::count_if(cage.face_sizes, [](std::uint32_t size) { return size >= kLargeFrom; }));
    const bool is_smooth = cage.scheme == Scheme::CatmullClark;
    bool takes = large > 0;
    if (is_smooth) {
        const std::vector<Around> around = look_around(cage);
        large += static_cast<std::size_t>(
            std::ranges::count_if(around, [](const Around& at) { return at.faces >= kLargeFrom; }));
        takes = large > 0;
        for_each_face(cage, [&](std::span<const std::uint32_t> corners, std::size_t) {
            takes = takes || may_take_points(around, corners, !cage.creases.empty());
        });
    }
    if (!takes) return 0;
    const std::size_t moves = is_smooth ? large * kMovesOfALargeVertex : 0;
    return cage.positions.size() + cage.face_sizes.size() + count_edges(cage) + moves;
}

}  // namespace occam
