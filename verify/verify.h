// Is the surface closed for every ray? Rays from inside closed cages, aimed where surfaces leak.
//
// A ray that starts inside a closed cage and meets nothing has *escaped*. Random directions are blind to such faults, so
// rays are aimed to an ulp at T-vertices, vertices and edges as each ray itself blends them, with transitions between pairs
// of levels at and near the hit (docs/watertightness.md).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenegraph/scene.h"

namespace occam {

class TextureStore;

struct VerifySettings {
    std::uint64_t rays = 1'000'000;  ///< for each placed cage
    std::uint64_t seed = 0;
    int largest_rate = 32;  ///< of a patch, at the finest level that rays see
    /// By how much segments of a ray overlap, in ulps of the largest coordinate alone: the engine's overlap is wider, and
    /// hides faults near the origin. What passes because of that alone is counted as grazing. 0: as the engine does.
    float overlap_ulps = 4;
};

struct VerifiedCage {
    std::string node, cage;  ///< names
    std::uint64_t faces = 0;
    std::string not_testable;  ///< why; empty: it was tested
    std::uint64_t starts = 0;  ///< points inside that rays start from
    std::uint64_t rays = 0, escaped = 0;
    /// Rays that met nothing and started outside: coarse meshes of thin parts leave some fine point outside of the surface
    /// that one ray sees. Found by that surface's winding number, for rays that met nothing alone.
    std::uint64_t outside = 0;
    /// Rays so flat to the surface that they passed between two levels through a gap of rounding, where these overlap by
    /// overlap_ulps alone. The engine's overlap closes it: each of them has met the surface when it was traced so.
    std::uint64_t grazing = 0;
    std::uint64_t not_finite = 0;  ///< hits with a NaN or an infinity
    std::uint64_t front_side = 0;  ///< hits on the outside, which a ray from inside meets only where coarse triangles fold
    double worst_front = 0;        ///< of those: largest cosine between the outward normal and the way back
    std::vector<std::string> replay;  ///< the first escapes: origin, direction, footprint

    bool holds() const noexcept { return escaped == 0 && not_finite == 0; }
};

/// Every edge in exactly two faces that run along it in opposite senses, one fan of faces at every vertex, holes removed.
/// Empty if the cage is closed, else why it is not.
std::string why_not_closed(const Cage& cage);

/// Tests one cage where `world_from_object` places it, without a skin.
/// textures   with the texture of its displacement, prepared; null: it is tested without
VerifiedCage verify(const Cage& cage, const Mat4d& world_from_object, const VerifySettings& settings,
                    const TextureStore* textures = nullptr);

/// Tests every cage of a scene, at each of its places and as it is posed there. Refits the scene.
std::vector<VerifiedCage> verify(Scene& scene, const VerifySettings& settings);

}  // namespace occam
