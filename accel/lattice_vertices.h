// Reads the vertices of a lattice as rays see them: one ray, or each ray of a packet.
#pragma once

#include "accel/coordinates.h"
#include "accel/grid_hit.h"
#include "accel/igrid.h"
#include "accel/ray_lanes.h"

namespace occam::accel {

/// Holds positions along a ray's kx, ky, kz, at the rays' key, and how the rays blend them.
template <class Coordinates>
struct LatticeVertices {
    LatticeVertices(const Coordinates& of_rays, std::ptrdiff_t floats_of_a_key) noexcept
        : coordinates(of_rays), next_key(floats_of_a_key)
    {
    }

    Coordinates coordinates;
    std::ptrdiff_t next_key;  ///< number of floats to the same coordinate at the next key
    const float* fine[3] = {};
    const float* coarse[3] = {};
    const float* const* still = nullptr;  ///< the positions for rays that do not blend
    VertexBlend blend;                    ///< valid if the igrid blends

    OCCAM_ALWAYS_INLINE vfloat read(const float* p) const noexcept { return coordinates.one(p, next_key); }
    OCCAM_ALWAYS_INLINE VecLanes plain(std::uint32_t at) const noexcept
    {
        return {read(still[0] + at), read(still[1] + at), read(still[2] + at)};
    }
    OCCAM_ALWAYS_INLINE VecLanes blended(std::uint32_t at) const noexcept
    {
        return blend.between({read(fine[0] + at), read(fine[1] + at), read(fine[2] + at)},
                             {read(coarse[0] + at), read(coarse[1] + at), read(coarse[2] + at)});
    }
    /// Returns whether a vertex moves from the fine to the coarse level.
    OCCAM_ALWAYS_INLINE bool blends_at(std::uint32_t at) const noexcept
    {
        const auto is_same = [&](int a) { return coordinates.are_same(fine[a] + at, coarse[a] + at, next_key); };
        return !is_same(0) || !is_same(1) || !is_same(2);
    }
    VecLanes hanging(const lod::Hanging& hanging, bool blends) const noexcept
    {
        VecLanes low = blends ? blended(hanging.a) : plain(hanging.a), high = blends ? blended(hanging.c) : plain(hanging.c);
        for (int d = hanging.depth; d > 0; --d) {
            const VecLanes m = middle(low, high);
            (hanging.path >> (d - 1) & 1 ? low : high) = m;
        }
        return middle(low, high);
    }
};

/// Returns the corners of a triangle of a block's quad.
template <bool kBlends, class Coordinates>
struct QuadCorners {
    const LatticeVertices<Coordinates>& vertices;
    const LatticeGrid& grid;
    const LatticeBlock& block;
    int column, row, triangle;

    VecLanes operator()(int p) const noexcept
    {
        const int c = column + kQuadCorners[triangle][p][0], r = row + kQuadCorners[triangle][p][1];
        // A T-vertex is where it was diced only if neither levels nor time are blended.
        if constexpr (kBlends || Coordinates::kMove)
            for (std::uint32_t h = block.hanging; h < block.hanging + block.hanging_count; ++h) {
                const BlockHanging& of_block = grid.block_hanging[h];
                if (of_block.row == r && of_block.column == c)
                    return vertices.hanging(grid.hanging[of_block.hanging], kBlends);
            }
        const std::uint32_t at = block.first + static_cast<std::uint32_t>(r) * block.stride + static_cast<std::uint32_t>(c);
        return kBlends ? vertices.blended(at) : vertices.plain(at);
    }
};

}  // namespace occam::accel
