// A part of a mesh, as a mesh of its own: the faces around some of its faces, with the sharpness of their edges.
//
// Memory   its own.
// Threads  one at a time.
// This header is private to lod/.
#pragma once

#include <opensubdiv/far/topologyLevel.h>

#include <array>
#include <cstdint>
#include <set>
#include <unordered_map>
#include <vector>

#include "scenegraph/cage.h"

namespace occam::lod {

/// A face around a vertex, and which of its corners the vertex is.
struct Sector {
    int face = 0, corner = 0;
};

/// Returns the quad at a corner of a face after a step of refinement, from that corner on.
Sector child_at(const OpenSubdiv::Far::TopologyLevel& coarse, const OpenSubdiv::Far::TopologyLevel& fine,
                const Sector& corner);

/// The rules of a mesh for its borders and its seams.
struct MeshRules {
    BoundaryRule boundary = BoundaryRule::EdgeAndCorner;
    FaceVaryingRule face_varying = FaceVaryingRule::CornersPlus1;
};

class MeshPart {
public:
    /// level   what this is a part of, which must outlive it
    MeshPart(const OpenSubdiv::Far::TopologyLevel& level, BoundaryRule boundary);
    /// Takes the texture coordinates of the level's set `uv_set` along, if there is one (-1: none).
    MeshPart(const OpenSubdiv::Far::TopologyLevel& level, const MeshRules& rules, int uv_set);

    /// Adds a face, from its corner on, unless it is there.
    void add(const Sector& sector);
    /// Adds the faces around a vertex.
    void add_around(int vertex);
    /// Adds a face, which comes first, and around each of its corners the faces that follow on either side up to a border.
    void add_fans(const Sector& sector);
    /// Adds the faces around all corners of a face, which comes first.
    void add_with_neighbours(const Sector& sector);
    /// Returns the number of a vertex of the level here.
    std::uint32_t number_of(int vertex);
    /// Adds the sharpness of all edges inside, and of the vertices.
    void add_sharpness();

    Cage mesh;                  ///< its vertices have no positions
    std::vector<int> vertices;  ///< of the level
    std::vector<int> values;    ///< of the level's texture coordinates, if they are taken along

private:
    std::uint32_t number_of_value(int value);

    const OpenSubdiv::Far::TopologyLevel& level_;
    int uv_set_ = -1;
    std::unordered_map<int, std::uint32_t> numbers_, value_numbers_;
    std::set<int> faces_;
    std::vector<int> edges_;  ///< in the order of the faces, some of them twice
};

/// Returns parameters counted from a corner of a quad: along the edge to the next corner, and along the one from the corner
/// before.
inline std::array<double, 2> from_corner(int corner, double s, double t) noexcept
{
    switch (corner) {
        case 0:
            return {s, t};
        case 1:
            return {t, 1 - s};
        case 2:
            return {1 - s, 1 - t};
        default:
            return {1 - t, s};
    }
}
/// Does the inverse of from_corner().
inline std::array<double, 2> to_quad(int corner, double x, double y) noexcept { return from_corner((4 - corner) % 4, x, y); }
/// Returns derivatives by the quad's parameters where dx and dy are those by parameters counted from a corner.
inline std::array<double, 2> derivatives_in_quad(int corner, double dx, double dy) noexcept
{
    const auto d = to_quad(corner, dx, dy), none = to_quad(corner, 0, 0);
    return {d[0] - none[0], d[1] - none[1]};
}

}  // namespace occam::lod
