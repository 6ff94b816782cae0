// Tests whether the surface is closed for every ray: rays start inside closed cages and are aimed where surfaces leak.
//
// A ray that starts inside a closed cage and hits nothing has *escaped*. Random directions rarely find such faults, so
// rays are aimed to an ulp at T-vertices, vertices and edges as each ray itself blends them, with transitions between
// pairs of levels at and near the hit (docs/watertightness.md).
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

#include "scenegraph/scene.h"

namespace occam {

class TextureStore;

/// The largest values of VerifySettings. Time and memory of a test grow with the square of the rate.
inline constexpr std::uint64_t kMostVerifyRays = 1'000'000'000'000;
inline constexpr int kLargestVerifyRate = 256;
inline constexpr float kWidestVerifyOverlap = 65536;

struct VerifySettings {
    std::uint64_t rays = 1'000'000;  ///< number of rays per placed cage, up to kMostVerifyRays
    std::uint64_t seed = 0;
    /// The largest rate of a patch at the finest level that rays see: a power of two from 1 to kLargestVerifyRate.
    int largest_rate = 32;
    /// The overlap of a ray's segments, in ulps of the largest coordinate alone. The engine's overlap is wider and
    /// hides faults near the origin. Rays that escape only because of the shorter overlap are counted as grazing. 0
    /// selects the engine's overlap. From 0 to kWidestVerifyOverlap.
    float overlap_ulps = 4;
};

struct VerifiedCage {
    std::string node, cage;  ///< names
    std::uint64_t faces = 0;
    /// The reason; empty if the cage was tested. If its test ended with an error, as for want of memory, this says so, and
    /// rays that were sent before count all the same.
    std::string not_testable;
    bool has_failed = false;   ///< its test ended with an error
    std::uint64_t starts = 0;  ///< points inside from which rays start
    /// The number of faces that no ray met, at the size of the cage at which there are most of them. Points inside are
    /// looked for behind faces that were not met, until all are, or the finer meshes that this takes would be too large.
    std::uint64_t faces_not_met = 0;
    /// The number of moments of the shutter, of those at which rays were to see the cage, at which no point inside was
    /// found: nothing is known of these.
    std::uint64_t moments_not_tested = 0;
    std::uint64_t rays = 0, escaped = 0;
    /// Counts rays that started outside of the surface that they see, among those that hit nothing or a front side:
    /// coarse meshes of thin parts leave some points of the fine inside outside of the surface that one ray sees. The
    /// winding number of that surface tells; it is computed for all rays that hit nothing, and for the first eight that
    /// hit a front side.
    std::uint64_t outside = 0;
    /// Counts rays at so small an angle to the surface that they passed between two levels through a gap of rounding,
    /// where these overlap by overlap_ulps alone. The engine's overlap closes the gap: each of them hit the surface
    /// when it was traced with it.
    std::uint64_t grazing = 0;
    std::uint64_t not_finite = 0;  ///< hits with a NaN or an infinity
    /// Counts hits on front sides that are narrower than rounding: at the outline of a ridge a ray leaves the surface and
    /// enters it again at once, and either place may be found first. Rays beside such a ray hit back sides.
    std::uint64_t silhouettes = 0;
    /// Counts other hits on front sides. A ray from inside finds them where micropolygons are turned over, or coarse meshes
    /// fold or cross. If it left the cage through its surface before, as into a cavity or across a gap between two parts, it
    /// counts as escaped instead. The winding number at places before the hit tells; it is computed for the first eight of
    /// these and the first eight of the silhouettes.
    std::uint64_t front_side = 0;
    /// The largest cosine among them between the outward normal and the direction back to the origin.
    double worst_front = 0;
    std::vector<std::string> replay;  ///< the first escapes, as lines for replay()

    bool holds() const noexcept { return escaped == 0 && not_finite == 0; }
};

/// Checks that every edge is in exactly two faces that run along it in opposite directions, and that the faces around
/// every vertex form one fan; holes are removed. Returns an empty string if the cage is closed, else the reason why it
/// is not.
std::string why_not_closed(const Cage& cage);

/// Throws Error if a setting is out of its range. What takes settings calls it.
void check(const VerifySettings& settings);

/// Tests one cage where `world_from_object` places it, without a skin.
/// textures   hold the prepared texture of its displacement; if null, the cage is tested without it.
VerifiedCage verify(const Cage& cage, const Mat4d& world_from_object, const VerifySettings& settings,
                    const TextureStore* textures = nullptr);

/// Tests every cage of a scene, in each of its placements and poses. If the scene has a shutter, rays see the cages at
/// several moments of it. Refits the bounds of the scene. An Error of one cage's test is reported as its reason not to be
/// testable; throws Error for a cage that cannot be made, and for a displacement that cannot be read.
std::vector<VerifiedCage> verify(Scene& scene, const VerifySettings& settings);

/// Traces a ray of the test again, as the line describes it (verify/ray_line.h), and writes to `out` what it does. Of the
/// settings the overlap counts, and the largest rate, by which the start is judged. Returns false if the ray escapes or
/// its hit is not finite. Throws Error for a line that cannot be read, and for a cage that cannot be tested.
bool replay(Scene& scene, const VerifySettings& settings, std::string_view line, std::ostream& out);

}  // namespace occam
