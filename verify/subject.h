// Holds a cage in a scene of its own, placed, deformed and moving as another scene shows it, and dices it at any level and
// moment.
#pragma once

#include <vector>

#include "lod/dicer.h"
#include "lod/pose_cage.h"
#include "lod/topology_cache.h"

namespace occam {

/// Describes how another scene shows a cage.
struct ShownCage {
    const CageSlot& slot;
    const Node* node = nullptr;  ///< null: it is not deformed
    const SkinSlot* skin = nullptr;
    std::span<const Mat4d> world_from_object;  ///< at each key of the scene's shutter, or once
    int segments = 0;                          ///< of the scene's shutter
};

/// Returns the cage without its materials, which are those of another scene: nothing is shaded.
Cage without_materials(Cage cage);

class Subject {
public:
    /// size   of those that the cage has while the shutter is open (lod::for_each_size), which number from 0
    Subject(const ShownCage& shown, const TextureStore* textures, std::size_t size);

    const Scene& scene() const noexcept { return scene_; }
    lod::TopologyCache& topologies() noexcept { return topologies_; }
    const lod::PosedCage& posed() const noexcept { return *posed_; }
    bool is_empty() const noexcept { return patches_.empty(); }
    /// Returns the faces that have a surface, in ascending order.
    std::vector<std::uint32_t> faces() const;
    /// Returns how many sizes the cage has while the shutter is open; it is in poses of its own at each of them.
    std::size_t size_count() const noexcept { return size_count_; }
    /// Returns whether the cage has this size in that segment of the shutter.
    bool is_seen_in(int segment) const noexcept { return (posed_->visible_in >> segment & 1) != 0; }

    /// Returns whether nodes or joints reverse the orientation of faces at that moment.
    bool is_mirrored_at(float time) const noexcept;

    /// Returns the coarsest level at which some patch has a rate of at least `rate`.
    int level_of_rate(int rate) const;

    struct Pair {
        int level = 0;
        std::vector<lod::LevelGrid> grids, hanging;  ///< all grids, and those with T-vertices
        std::vector<Vec3f> corners;                  ///< corners of the fine mesh's triangles

        /// Returns those of `grids` or `hanging` that belong to a face.
        static std::span<const lod::LevelGrid> of_face(const std::vector<lod::LevelGrid>& grids, std::uint32_t face);
    };
    /// Returns the number of corners that a pair has at this level.
    std::size_t corner_count(int level) const;
    /// Returns the place of the origin of the diced cage's frame at that moment. A cage that flies far takes its frame with
    /// it, so that its coordinates stay small.
    Vec3d anchor_at(float time) const noexcept;
    /// Returns the radius of a ball that holds the cage at that moment, with which coordinates are rounded.
    float radius_at(float time) const noexcept;
    /// Returns the whole cage at a pair of levels, as rays of this moment see it, about the anchor of the moment.
    Pair dice(int level, float time);

private:
    struct Patch {
        lod::PatchRef ref;
        lod::PatchScale scale;
    };
    void add(const ShownCage& shown);
    lod::LevelGrid grid_at(const lod::TileRef& tile, const lod::PatchRates& coarser, float time);
    /// Moves a grid of the still pose to where rays of this moment see it.
    lod::LevelGrid image_at(lod::LevelGrid grid, float time) const;

    Scene scene_;
    lod::TopologyCache topologies_;
    CageId cage_;
    NodeId node_;
    const lod::PosedCage* posed_ = nullptr;  ///< null if the cage has no faces
    std::size_t size_count_ = 0;
    lod::Dicer dicer_;
    Arena arena_, pose_;
    lod::DeformCounters deform_;
    std::vector<Patch> patches_;
};

}  // namespace occam
