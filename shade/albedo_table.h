// The directional albedo of the single-scattering GGX layer, tabulated: the share of light that a rough layer reflects in
// all.
//
// With Schlick's Fresnel curve f0 (1 - g) + f90 g, the albedo is f0 A + f90 B. A and B are two tables over the cosine of
// the eye and the roughness (the split of Karis 2013). The rest to one is light that several microfacets scatter. It is
// given back as a lobe (Kulla and Conty 2017), and the base receives what the layer does not reflect. Directions of that
// lobe are drawn by its own shape, since that of a narrow layer lies close to the horizon.
//
// Memory   two tables of 64 x 48 floats, and one of as many doubles. A row, of one roughness, is made once per process on
//          first use (some 0.2 ms), and read only from then on.
// Threads  any.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <mutex>

#include "base/simd.h"
#include "shade/table_place.h"

namespace occam::shade {

/// Holds the albedo for one direction (F is float) or for several (vfloat), or the cosine-weighted mean over all directions.
template <class F>
struct LayerAlbedoOf {
    F f0 = 1.0f, f90 = 0.0f;  ///< the factors of f0 and f90; their sum is the albedo of a layer that reflects all light
    F sum() const noexcept { return f0 + f90; }
};
using LayerAlbedo = LayerAlbedoOf<float>;

class AlbedoTable {
public:
    static const AlbedoTable& instance() noexcept { return table(); }

    /// A place between two roughnesses of the table.
    using Row = TablePlace;
    /// Returns the place of a GGX width, and makes the rows beside it if they are not there. Whoever asks for an albedo has
    /// its place from here.
    static Row row_of(float alpha) noexcept;

    /// Returns the albedo for a cosine in [0, 1]; `alpha` is the GGX width.
    LayerAlbedo at(float cosine, float alpha) const noexcept { return at(cosine, row_of(alpha)); }
    LayerAlbedo at(float cosine, Row row) const noexcept;
    LayerAlbedo mean(float alpha) const noexcept { return mean(row_of(alpha)); }
    LayerAlbedo mean(Row row) const noexcept;
    /// Returns the mean over all directions of what the albedo lacks to 1, weighted by the cosine.
    float lost(Row row) const noexcept;
    /// Draws the cosine of a direction in proportion to what the albedo lacks there, times the cosine; `number` is uniform
    /// in [0, 1).
    float draw_lost(float number, Row row) const noexcept;

    /// The same for several widths and cosines side by side, with the same bits.
    struct RowLanes {
        std::size_t below[kLanes];
        vfloat share;

        Row at(int lane) const noexcept
        {
            alignas(32) float shares[kLanes];
            share.store(shares);
            return {static_cast<int>(below[lane]), shares[lane]};
        }
    };
    static RowLanes row_of(vfloat alpha) noexcept;
    LayerAlbedoOf<vfloat> at(vfloat cosine, const RowLanes& row) const noexcept;
    LayerAlbedoOf<vfloat> mean(const RowLanes& row) const noexcept;
    vfloat lost(const RowLanes& row) const noexcept;

private:
    static constexpr int kCosines = 64;      ///< nodes, evenly spaced in the square root of the cosine
    static constexpr int kRoughnesses = 48;  ///< nodes, evenly spaced in the fourth root of alpha, from that of kMinAlpha on

    AlbedoTable() = default;
    /// Makes the rows below and above a place unless they are there.
    void make_beside(std::size_t below) noexcept
    {
        for (std::size_t r = below; r < below + 2; ++r)
            if (!is_made_[r].load(std::memory_order_acquire)) make(r);
    }
    void make(std::size_t r) noexcept;
    static AlbedoTable& table() noexcept;

    std::array<std::array<LayerAlbedo, kCosines>, kRoughnesses> rows_;
    std::array<LayerAlbedo, kRoughnesses> means_;
    std::array<float, kRoughnesses> lost_;  ///< of each row, what lost() returns
    /// Of each row and node, the integral of what the albedo lacks, times y cubed, over y from 0 to the node's number. The
    /// cosine is the square of y / (kCosines - 1), so that this is in proportion to the light that is lost below the node.
    std::array<std::array<double, kCosines>, kRoughnesses> lost_below_;
    std::array<std::atomic<bool>, kRoughnesses> is_made_{};
    std::mutex making_;
};

}  // namespace occam::shade
