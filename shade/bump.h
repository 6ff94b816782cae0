// Bump maps: heights that a surface's normals show and its places do not (Blinn 1978).
//
// A normal n becomes n minus the height's gradient over the surface (Mikkelsen 2010, eq. 4, in world lengths), which needs
// no frame of tangents: at vertices of grids from differences between neighbours, at hits from differences over the
// footprint.
#pragma once

#include <array>

#include "io/texture/texture_store.h"
#include "lod/level_grid.h"
#include "shade/shade_point.h"

namespace occam::shade {

/// Slopes at the vertices of a lattice.
class BumpLattice {
public:
    /// Looks up the heights at vertices and one step beyond the border. Borrows the lattice.
    BumpLattice(const Material& material, const lod::LatticeToShade& lattice, const TextureStore& textures) noexcept;

    /// Gradient of the height over the surface, from differences to both sides; zero without a bump map.
    Vec3f slope(int i, int j) const noexcept;

private:
    static constexpr int kWidth = lod::TileRef::kMaxSide + 3;
    static std::size_t index(int i, int j) noexcept { return static_cast<std::size_t>((j + 1) * kWidth + i + 1); }

    const lod::LatticeToShade& lattice_;
    bool has_map_;
    double scale_;
    int rows_;
    std::array<float, kWidth * kWidth> heights_;  // not set without a map
};

/// Gradient of the height at a hit, from differences over the filter's width, or a texel's if that is more.
Vec3f bump_slope(const ShadePoint& point, const TextureStore& textures) noexcept;

/// `normal`, on the side of the point's facet, with a slope of the outside. Stays on the side of eye and facet.
Vec3f bumped_normal(Vec3f normal, Vec3f slope, const ShadePoint& point) noexcept;

}  // namespace occam::shade
