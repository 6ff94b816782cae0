// Bump maps: heights that change the normals of a surface but not its positions (Blinn 1978).
//
// A normal n becomes n minus the gradient of the height over the surface (Mikkelsen 2010, eq. 4, in world lengths). This
// needs no tangent frame: the derivatives of the height by its coordinates come from differences between neighbours at the
// vertices of grids, and over the footprint at hits, where the gradients of the coordinates are known.
#pragma once

#include <array>

#include "io/texture/texture_store.h"
#include "lod/level_grid.h"
#include "shade/shade_point.h"

namespace occam::shade {

/// Holds how the height of a bump map changes at the vertices of a lattice.
class BumpLattice {
public:
    /// Looks up the heights at the vertices and one step beyond the border. Borrows the lattice.
    BumpLattice(const Material& material, const lod::LatticeToShade& lattice, const TextureStore& textures) noexcept;

    /// Returns the derivatives of the height by the map's coordinates, from differences to both sides. They are zero without
    /// a bump map, and where the coordinates cover no area.
    Vec2f rise(int i, int j) const noexcept;

private:
    static constexpr int kWidth = lod::TileRef::kMaxSide + 3;
    static std::size_t index(int i, int j) noexcept { return static_cast<std::size_t>((j + 1) * kWidth + i + 1); }

    const lod::LatticeToShade& lattice_;
    bool has_map_;
    int set_;
    double scale_;
    int rows_;
    std::array<float, kWidth * kWidth> heights_;  // not set without a map
};

/// Returns the gradient of the height at a hit, from differences over the width of the filter, or of a texel if that is
/// larger.
Vec3f bump_slope(const ShadePoint& point, const TextureStore& textures) noexcept;

/// Returns `normal`, which is on the side of the point's facet, tilted by a slope of the outside. The result stays on the
/// side of the eye and of the facet.
Vec3f bumped_normal(Vec3f normal, Vec3f slope, const ShadePoint& point) noexcept;

}  // namespace occam::shade
