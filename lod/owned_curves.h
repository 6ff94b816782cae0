// Computes what several patches share: the points of curves between them and of corners, and the rates of these curves. Each
// is computed by one owner (topology.h), so all patches get the same bits (watertightness rule 1).
//
// Space    the cage's dicing frame.
// Memory   two tables of fixed size, which keep what neighbours and coarser pairs of levels need again.
// Threads  one at a time, as for the dicer that owns it.
#pragma once

#include "lod/cage_table.h"
#include "lod/level_grid.h"
#include "lod/patch_surface.h"

namespace occam::lod {

/// The largest PatchScale::k. With it a patch is one tile at the coarsest level, whatever its size: so the division of its
/// regions ends there. A curve is clamped as a whole, so the patches on both sides of it agree.
inline constexpr int kLargestK = kCoarsestLevel + TileRef::kSideExponent;

class OwnedCurves {
public:
    explicit OwnedCurves(PatchSurface& surface) : surface_(surface) {}

    /// Forgets all posed cages.
    void forget() noexcept;

    /// Returns ceil(log2) of the curve's largest speed, at most kLargestK.
    int k(const PosedCage& cage, std::uint32_t curve);

    // The parameter `filter` is PatchRates::filter of the level.
    /// Computes points of a curve at c0 + i * dc; the parameters 0 and 1 are its ends.
    void points(const PosedCage& cage, std::uint32_t curve, int filter, float c0, float dc, std::span<Vec3f> out);
    /// Computes the ends of the pieces [first, first + out.size()) of a side of the tile's patch.
    void points_of_side(const PosedCage& cage, const TileRef& tile, int side, int first, std::span<Vec3f> out);
    /// Returns the surface's point at a vertex of the cage.
    Vec3f vertex_point(const PosedCage& cage, std::uint32_t vertex, int filter);

private:
    /// What is known of a curve.
    struct Known {
        static constexpr int kUnknown = kMinLength - 1;

        int k = kUnknown;
        bool has_quarters = false, has_middle = false;  ///< which of the following are known
        std::array<Vec3f, 3> p{};                       ///< points at 1/4, 1/2 and 3/4; not for displaced cages
    };

    /// A vertex of the cage, and the level for which a displaced cage is filtered there; 0 for others.
    struct Corner {
        std::uint32_t vertex;
        int filter;
        bool operator==(const Corner&) const = default;
    };

    static constexpr std::size_t kCorners = 4096;

    Known& known(const PosedCage& cage, std::uint32_t curve);
    Vec3f undisplaced_vertex_point(const PosedCage& cage, std::uint32_t vertex);
    /// Computes points of a part of a curve that has one owner, except at ends and knots.
    void points_of_owner(const PosedCage& cage, std::uint32_t curve, int filter, float c0, float dc, std::span<Vec3f> out);
    Vec3f end_point(const PosedCage& cage, std::uint32_t curve, int filter, int end);
    /// Returns the length of the longest displaced piece of sixteen, per unit of the parameter; at least `undisplaced`.
    float displaced_speed(const PosedCage& cage, std::uint32_t curve, float undisplaced);

    PatchSurface& surface_;
    CageTable<std::uint32_t, Known, 4096> curves_;
    CageTable<Corner, Vec3f, kCorners> corners_;  ///< points that several patches share; without displacement all levels do
};

}  // namespace occam::lod
