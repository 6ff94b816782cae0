// The directional albedo of a single-scattering GGX layer with two widths, tabulated.
//
// The albedo depends on the direction's cosine and azimuth and on both widths. The table holds its difference from the
// albedo of an isotropic layer with the geometric mean of the widths (albedo_table.h), so that equal widths give that
// albedo exactly. With the albedo, the light that single scattering loses is given back in the same way as for isotropic
// layers (Kulla and Conty 2017), whose energy does not depend on the lobe's shape.
//
// Memory   10 x 8 x 5 x 16 pairs of floats, made once per process on first use (some 0.1 s), and read only from then on.
// Threads  any.
#pragma once

#include <array>

#include "shade/albedo_table.h"
#include "shade/microfacet.h"

namespace occam::shade {

class StrokeAlbedo {
public:
    static const StrokeAlbedo& instance();

    /// Returns the albedo for a direction in the axes of the strokes. Requires widths.x >= widths.y.
    /// alpha   the geometric mean of the widths
    LayerAlbedo at(Vec3f direction, Widths widths, float alpha) const noexcept;
    /// Returns the cosine-weighted mean of at() over all directions.
    LayerAlbedo mean(Widths widths, float alpha) const noexcept;

    /// The largest error of at() against the integral that it tabulates, measured between the nodes.
    static constexpr float kError = 0.02f;

private:
    static constexpr std::size_t kAcross = 10;  ///< nodes, evenly spaced in the fourth root of the width across the strokes
    static constexpr std::size_t kStrengths = 8;  ///< nodes, evenly spaced in the strength of KHR_materials_anisotropy
    static constexpr std::size_t kAzimuths = 5;   ///< nodes over a quarter of a turn
    static constexpr std::size_t kCosines = 16;   ///< nodes, evenly spaced in the square root of the cosine
    using Directions = std::array<std::array<LayerAlbedo, kCosines>, kAzimuths>;

    StrokeAlbedo();
    static LayerAlbedo in(const Directions& table, Vec3f direction) noexcept;
    static LayerAlbedo mean_of(const Directions& table) noexcept;
    template <class Get>
    static LayerAlbedo between(Widths widths, Get&& get) noexcept;

    std::array<std::array<Directions, kStrengths>, kAcross> rows_;
    std::array<std::array<LayerAlbedo, kStrengths>, kAcross> means_;
};

}  // namespace occam::shade
