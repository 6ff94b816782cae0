// Dices a whole cage at one level, with every micropolygon and gap triangle of every patch, for tests that treat M_l as a
// mesh.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "lod/dicer.h"
#include "lod/topology_cache.h"
#include "scenegraph/scene.h"

namespace occam::test {

struct MeshTriangle {
    Vec3f v[3];  ///< dicing frame
    bool is_gap = false;
};

/// Owns what a PosedCage borrows.
class DicedCage {
public:
    /// textures   hold the texture of the cage's displacement; null: the cage is not displaced
    /// joints     world_from_mesh of each joint of the cage's skin; empty: the cage is at rest
    DicedCage(const Cage& cage, int level, const Mat4d& world_from_object = Mat4d(1), const TextureStore* textures = nullptr,
              std::span<const Mat4d> joints = {});

    lod::PosedCage posed;
    lod::Dicer dicer;
    Arena arena;

    const lod::Topology& topology() const { return *posed.topology; }
    /// The scene shows the cage alone. A frame of it with these tables need not make them again.
    const Scene& scene() const { return scene_; }
    lod::TopologyCache& topologies() { return cache_; }
    /// Returns every visible patch, as tiles of at most 16 x 16 quads.
    std::vector<lod::TileRef> tiles();
    std::vector<MeshTriangle> triangles();
    /// Sets and returns the coarsest level at which some patch has 2^exponent pieces along a side.
    int level_of_largest_exponent(int exponent);

private:
    Scene scene_;
    lod::TopologyCache cache_;
    lod::DeformCounters deform_;
    Arena pose_;
};

/// Evaluates the corners of each visible patch with their tangents, and finds the control points of its texture coordinates.
/// Returns whether all points and tangents are finite, and all smooth texture coordinates have control points.
bool has_finite_surface(const DicedCage& diced);

/// Identifies a point by its bits; the two zeros are equal.
using Bits = std::array<std::uint32_t, 3>;
Bits bits_of(Vec3f p);
/// Counts the edges that an odd number of triangles share, with vertices compared by their bits: 0 for a closed mesh.
std::size_t open_edges(const std::vector<MeshTriangle>& mesh);

}  // namespace occam::test
