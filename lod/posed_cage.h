// One cage where one node shows it, for one frame, and the frame that it is diced in.
//
// Space    *dicing frame*: world axes and lengths, translated by `anchor`, a point of a power-of-two lattice near the cage.
// So
//          an edge length there is a world length, coordinates stay small far from the world's origin, and a ray gets there
//          by one subtraction in double.
// Memory   plain data in a worker's arena; borrows scene and topology for the frame.
#pragma once

#include <span>

#include "lod/clusters.h"
#include "lod/deformed_cage.h"
#include "lod/displacement.h"
#include "lod/rates.h"
#include "lod/topology.h"
#include "scenegraph/scene.h"

namespace occam::lod {

struct PosedCage {
    const CageSlot* slot = nullptr;
    const Topology* topology = nullptr;  ///< null for Scheme::Triangles
    const ClusterTree* clusters = nullptr;
    DeformedCage* deformed = nullptr;                     ///< null: rigid
    const DeformedClusters* deformed_clusters = nullptr;  ///< set if `deformed` is
    const Node* node = nullptr;
    NodeId node_id;
    std::uint8_t seen_by = RayKind::All;  ///< by the flags of all nodes that lead here, as is:
    LightGroups lit_by = kAllGroups;
    std::uint64_t key = 0;                ///< of the path of nodes that leads here: orders hits at equal distance
    double frame_from_object[3][4] = {};  ///< rows: rotation and scale, then translation
    double columns[4][4] = {};            ///< the same the other way round, the last row 0: four sums at a time
    Vec3d anchor{0};                      ///< world
    float radius = 0;                     ///< world, of a ball about the anchor that holds it
    int level = 0;                        ///< LevelMode::PerInstance: of all rays
    bool is_mirrored = false;             ///< the placement turns the sense of faces round
    PosedDisplacement displacement;       ///< of the limit surface; none: not displaced

    /// Keeps positions as they are: the dicing frame is the object's.
    void keep() noexcept
    {
        for (int a = 0; a < 3; ++a) frame_from_object[a][a] = columns[a][a] = 1;
    }
    /// Sets frame, anchor, radius and mirroring from a placement.
    void place(const Mat4d& world_from_object, const Box3d& object_bounds) noexcept;
    /// After place(): has skin and morph targets deform the cage.
    /// skin   null: morph targets alone
    void deform(const DeformedClusters& bounds, const SkinSlot* skin, Arena& arena, DeformCounters& counters);

    /// After place() and deform(): has the cage's displacement move its surface, if it has one and the coordinates that it
    /// asks for.
    void displace(const TextureStore& textures) noexcept;
    bool is_displaced() const noexcept { return displacement.of != nullptr; }

    /// Holds the surface of a cluster's faces.
    Box3d world_box(std::uint32_t cluster) const noexcept;
    /// A vertex of the cage, in the dicing frame.
    Vec3f vertex(std::uint32_t v) const { return deformed ? deformed->position(v) : pose(slot->cage.positions[v]); }
    /// A vertex's normal, world axes, not normalised; the cage has normals.
    Vec3f vertex_normal(std::uint32_t v) const noexcept
    {
        return deformed ? deformed->normal(v) : pose_normal(slot->cage.normals[v]);
    }

    Mat4d world_from_object() const noexcept;

    /// No level is finer: all rates stay within kMaxExponent.
    int finest_level() const noexcept { return ceil_log2(16 * radius) - kMaxExponent; }

    /// Object axes to the dicing frame, in double, rounded once: a pure function of the point.
    Vec3f pose(Vec3f p) const noexcept
    {
        double sum[4];
        for (int r = 0; r < 4; ++r)
            sum[r] = columns[0][r] * double(p.x) + columns[1][r] * double(p.y) + columns[2][r] * double(p.z) + columns[3][r];
        return {static_cast<float>(sum[0]), static_cast<float>(sum[1]), static_cast<float>(sum[2])};
    }
    /// A normal of the object's, not normalised (inverse transpose; mirrored placements keep outsides outside).
    Vec3f pose_normal(Vec3f n) const noexcept;
};

}  // namespace occam::lod
