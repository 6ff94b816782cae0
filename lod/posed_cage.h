// One cage as one node shows it, for one frame, and the dicing frame in which it is diced.
//
// Space    *dicing frame*: world axes and lengths, translated by `anchor`, a point of a power-of-two lattice near the cage.
//          So an edge length there is a world length, coordinates stay small far from the world's origin, and a ray gets
//          there by one subtraction in double.
// Memory   plain data in the arena of a tree; it borrows scene and topology for the frame.
//
// A placed cage that moves in the shutter is an array of these, one at each key of its motion (cage_motion.h). They share
// all that is not a position: the dicing frame, the radius and what displacement adds at most. So they are diced alike. If
// its nodes alone move it, the keys serve for rates and boxes, and what is diced is one more pose, its still pose; where it
// goes far, each key then has a dicing frame of its own.
#pragma once

#include <algorithm>
#include <span>

#include "lod/affine_motion.h"
#include "lod/clusters.h"
#include "lod/deformed_cage.h"
#include "lod/displacement.h"
#include "lod/graph_path.h"
#include "lod/key_time.h"
#include "lod/longest_edges.h"
#include "lod/rates.h"
#include "lod/topology.h"
#include "scenegraph/posed_faces.h"
#include "scenegraph/scene.h"

namespace occam::lod {

struct PosedCage {
    static constexpr std::uint32_t kAllSegments = ~0u;

    const CageSlot* slot = nullptr;
    const Topology* topology = nullptr;  ///< null for Scheme::Triangles
    const ClusterTree* clusters = nullptr;
    DeformedCage* deformed = nullptr;                     ///< null: rigid
    const DeformedClusters* deformed_clusters = nullptr;  ///< set if `deformed` is
    const Vec3f* positions = nullptr;                     ///< of the vertices at rest; place() takes the slot's
    const Box3f* cluster_boxes = nullptr;  ///< dicing frame, one for each cluster; null: they follow from the cage's tables
    const Vec3f* derived = nullptr;        ///< derived points in the dicing frame, if the topology has some
    const Vec3f* rest_derived = nullptr;   ///< those of the vertices at rest, in object axes, if the cage is displaced
    const PosedCage* keys = nullptr;       ///< this placed cage at all keys of its motion; null: it stands still
    int segments = 0;                      ///< of its motion, one less than there are keys
    const PosedCage* still_pose =
        nullptr;  ///< of the first key: what is diced in place of the keys; null: the keys are diced
    const AffineMotion* affine = nullptr;  ///< of a still pose: how it moves; null for all other poses
    int normal_key = -1;  ///< of the first key: the key from whose normals those of all times follow; -1: each key's serve
    const Node* node = nullptr;
    NodeId node_id;
    NodeId instance;  ///< the innermost node that shows that node by instance_of; null: none does
    CageId cage_id;
    std::uint8_t seen_by = RayKind::All;  ///< combined over all nodes that lead here, as is lit_by
    LightGroups lit_by = kAllGroups;
    std::uint32_t visible_in = kAllSegments;  ///< bit k: whether it is visible in segment k of the scene's shutter
    GraphPath path;                           ///< leads here; it orders hits at equal distance
    double frame_from_object[3][4] = {};      ///< rows: rotation and scale, then translation
    double columns[4][4] = {};       ///< the same map by columns, the last row 0, so that four sums are computed at a time
    Vec3d anchor{0};                 ///< world
    float radius = 0;                ///< radius of a ball around the anchor that holds the cage, world length
    float largest_radius = 0;        ///< of a still pose: a radius that holds the cage at each key, world length
    float longest_at_poles = 0;      ///< no edge at a pole (scenegraph/poles.h) is longer at any key, world length
    int coarsened = 0;               ///< by how many levels its finest level is coarser than that of other cages
    int least_level = kFinestLevel;  ///< all finer levels are the same as this one
    int level = 0;                   ///< LevelMode::PerInstance: the level for all rays
    bool is_mirrored = false;        ///< the placement reverses the orientation of faces
    PosedDisplacement displacement;  ///< displacement of the limit surface, if there is one

    /// Keeps positions as they are, so that the dicing frame is object space.
    void keep() noexcept
    {
        for (int a = 0; a < 3; ++a) frame_from_object[a][a] = columns[a][a] = 1;
        positions = slot->cage.positions.data();
    }
    /// Sets frame, anchor, radius and mirroring from the matrix of a placement.
    void place(const Mat4d& world_from_object, const Box3d& object_bounds) noexcept;
    /// Does the first half of place(): sets anchor and radius for a cage that stays in the box.
    void set_frame(const Box3d& world) noexcept;
    /// Does the second half of place(): sets the map and the mirroring.
    void set_map(const Mat4d& world_from_object) noexcept;
    /// Deforms the cage by its skin and morph targets; call it after place().
    void deform(const DeformedClusters& bounds, const CagePose& pose, Arena& arena, DeformCounters& counters);

    /// Displaces the surface, if the cage has a displacement and the coordinates that it needs; call it after place() and
    /// deform().
    void displace(const TextureStore& textures) noexcept;
    bool is_displaced() const noexcept { return displacement.of != nullptr; }
    /// Computes the derived points; call it last.
    void derive(Arena& arena);

    /// Returns a box that holds the surface of a cluster's faces.
    Box3d world_box(std::uint32_t cluster) const noexcept;
    /// Returns a vertex of the cage in the dicing frame.
    Vec3f vertex(std::uint32_t v) const { return deformed ? deformed->position(v) : pose(positions[v]); }
    /// Returns the unit normal of a vertex in world axes; it is 0 if the pose leaves no direction. The cage must have
    /// normals.
    Vec3f vertex_normal(std::uint32_t v) const noexcept
    {
        return deformed ? deformed->normal(v) : pose_normal(slot->cage.normals[v]);
    }

    Mat4d world_from_object() const noexcept;
    /// Returns the linear part of the map from object axes.
    Mat3d linear_map() const noexcept;
    /// Returns a length whose square grows as the areas of these faces of the posed cage do.
    double size_of_faces(std::span<const FaceVertices> faces) const noexcept;
    /// Returns the cage at a key of its motion; itself if it stands still.
    const PosedCage& at_key(int k) const noexcept { return keys ? keys[k] : *this; }
    /// Returns the pose that igrids are made of: the still pose if there is one, else the cage with all its keys.
    const PosedCage& diced() const noexcept { return still_pose ? *still_pose : *this; }
    /// Returns whether faces are reversed at a moment of the cage's motion.
    bool is_mirrored_at(KeyTime time) const noexcept;
    /// Takes a normal at the key normal_key, which must not be -1, to a moment of the cage's motion. The result has unit
    /// length and points outside; it is n if the map of that moment leaves no direction.
    Vec3f moved_normal(Vec3f n, KeyTime time) const noexcept;

    /// Returns the finest level, which keeps all rates within kMaxExponent, and divides faces at poles by no more than
    /// kFinestAtPoles. Finer levels are the same as this one.
    int finest_level() const noexcept
    {
        // The keys of a cage that flies may lie in one dicing frame, which is much larger than what is diced.
        const PosedCage& of = diced();
        const float at_poles = of.longest_at_poles * (float(1 << kMaxExponent) / kFinestAtPoles);
        const float longest = std::max({16 * of.radius, 16 * of.largest_radius, at_poles});
        return std::max(ceil_log2(longest) - kMaxExponent + coarsened, least_level);
    }

    /// Maps object axes to the dicing frame, in double and rounded once: a pure function of the point.
    Vec3f pose(Vec3f p) const noexcept
    {
        double sum[4];
        for (int r = 0; r < 4; ++r)
            sum[r] = columns[0][r] * double(p.x) + columns[1][r] * double(p.y) + columns[2][r] * double(p.z) + columns[3][r];
        return {static_cast<float>(sum[0]), static_cast<float>(sum[1]), static_cast<float>(sum[2])};
    }
    /// Maps a unit normal from object axes by the inverse transpose, and normalises it. It points outside in mirrored
    /// placements, too, and stays as it is if the map leaves no direction.
    Vec3f pose_normal(Vec3f n) const noexcept;
};

}  // namespace occam::lod
