// Limits of Catmull-Clark surfaces by subdivision alone: an opinion that shares no code with the engine or with OpenSubdiv.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "scenegraph/cage.h"

namespace occam::test {

using Vec3l = glm::vec<3, long double>;

/// Holds a closed mesh, or a part of one, whose edges and vertices may be semi-sharp, in long double.
///
/// The rules are those of Catmull and Clark (1978) with the creases of DeRose, Kass and Truong (1998): sharpness falls by
/// one in each step, and a vertex or edge whose sharpness ends within a step is the mean of both rules, weighted by what is
/// left.
class SubdivisionMesh {
public:
    explicit SubdivisionMesh(const Cage& cage);

    /// Returns whether two faces meet at every edge, in opposite directions, and the faces of each vertex are one ring.
    bool is_closed_manifold() const;

    /// Returns the mesh after one step. Of a part of a mesh, it has the faces that the part determines.
    SubdivisionMesh refined() const;

    /// Returns the part within three faces of a vertex, which is vertex 0 there, and after each step.
    SubdivisionMesh around(std::uint32_t vertex) const;

    /// Returns whether all faces around a vertex are in this part of the mesh.
    bool is_inside(std::uint32_t vertex) const { return inside_[vertex] != 0; }

    struct Limit {
        Vec3l point{0}, normal{0};  ///< the normal has any length
        bool has_normal = false;    ///< whether all faces share one tangent plane
        std::size_t valence = 0;
    };
    /// Returns the limit of a vertex, by subdividing its ring until it no longer moves.
    Limit limit(std::uint32_t vertex) const;

    /// Describes a face as a square of a patch of the cage: sub-face `sub` of face `face`, as lod::PatchRef has it.
    struct Face {
        std::vector<std::uint32_t> corners;
        std::uint32_t face = 0, sub = 0;
        double u = 0, v = 0, size = 1;
    };
    std::vector<Face> faces;

private:
    using Edge = std::pair<std::uint32_t, std::uint32_t>;
    /// The neighbours of a vertex in counter-clockwise order: face i lies between the edges i and i + 1.
    struct Ring {
        std::vector<std::uint32_t> ends, faces;
        std::vector<long double> sharpness;
    };

    SubdivisionMesh() = default;
    void connect();
    Ring ring_of(std::uint32_t vertex) const;
    long double sharpness_of(std::uint32_t a, std::uint32_t b) const;
    Vec3l middle_of(std::uint32_t face) const;

    std::vector<Vec3l> points_;
    std::vector<long double> corners_;         ///< the sharpness of each vertex
    std::map<Edge, long double> creases_;      ///< by the smaller vertex and the larger
    std::map<Edge, std::uint32_t> face_left_;  ///< the face that has this edge from its first vertex to its second
    std::vector<Edge> first_edges_;            ///< an edge that begins at each vertex
    std::vector<std::uint8_t> inside_;         ///< of each vertex, whether all faces around it are known
    bool has_shared_edges_ = false;            ///< whether two faces run along an edge in one direction
};

}  // namespace occam::test
