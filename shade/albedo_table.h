// How much a rough layer reflects in all: the directional albedo of single-scattering GGX, tabulated.
//
// With Schlick's Fresnel curve f0 (1 - g) + f90 g the albedo is f0 A + f90 B: two tables over the eye's cosine and the
// roughness (the split of Karis 2013). What is missing to one is light that met several microfacets; it is given back as a
// lobe (Kulla and Conty 2017), and what the layer does not reflect is what its base gets.
//
// Memory   two tables of 64 x 48 floats, made once a process on first use (some 60 ms), then read only.
// Threads  any.
#pragma once

#include <array>

namespace occam::shade {

/// Of one direction, or the mean over all weighted with the cosine.
struct LayerAlbedo {
    float f0 = 1, f90 = 0;  ///< factors of f0 and f90; their sum is the albedo of a layer that reflects all
    float sum() const noexcept { return f0 + f90; }
};

class AlbedoTable {
public:
    static const AlbedoTable& instance();

    /// cosine in [0, 1], alpha the GGX width.
    LayerAlbedo at(float cosine, float alpha) const noexcept;
    LayerAlbedo mean(float alpha) const noexcept;

private:
    static constexpr int kCosines = 64;      ///< nodes, even in the root of the cosine
    static constexpr int kRoughnesses = 48;  ///< nodes, even in the fourth root of alpha, from that of kMinAlpha

    AlbedoTable();

    std::array<std::array<LayerAlbedo, kCosines>, kRoughnesses> rows_;
    std::array<LayerAlbedo, kRoughnesses> means_;
};

}  // namespace occam::shade
