// The difference between a picture of Occam's and a reference picture made with other software, as shares of pixels that
// agree.
//
// The rules are those of the README of the shared reference images, "How to compare". The functions are pure functions of
// pictures and read no files.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace occam::test {

/// Holds a picture, row-major from the top left. Layers that it does not have are empty.
struct ReferencePicture {
    int width = 0, height = 0;
    std::vector<float> depth;                             ///< 1 a pixel; 0 or infinity: nothing hit
    std::vector<float> normal_geometric, normal_shading;  ///< 3 a pixel, of any length; 0: not known
    std::vector<float> albedo;                            ///< 4 a pixel: times coverage, and coverage
    std::vector<float> uv;                                ///< 2 a pixel, v upwards
    std::vector<std::uint8_t> exclude;                    ///< 1 a pixel; a pixel that is not 0 is left out

    std::size_t pixel_count() const noexcept { return std::size_t(width) * std::size_t(height); }
    bool is_hit(std::size_t pixel) const noexcept
    {
        return depth[pixel] > 0 && depth[pixel] < std::numeric_limits<float>::infinity();
    }
};

/// Holds the tolerances within which values agree, in the units of cases.json.
struct ReferenceLimits {
    double depth_relative = 1e-3, normal_geometric_degrees = 1, normal_shading_degrees = 2, uv_absolute = 2e-3;
    double albedo_absolute = 0.05;  ///< limit for each channel
};

/// Holds the shares of the interior pixels that agree; none for a layer that the reference does not have.
struct ReferenceShares {
    std::size_t hits = 0, interior = 0;  ///< pixels of the reference, without those that are left out
    double coverage_mismatch = 0;        ///< pixels that one picture hits and the other does not, over the reference's hits
    std::optional<double> depth, normal_geometric, normal_shading, uv, albedo;
    std::optional<double> albedo_mean_absolute;  ///< over interior pixels and R, G, B
};

/// Marks the pixels whose 3 x 3 neighbours are all in the picture, hit, and at most a factor of 1.05 apart in depth, and
/// which are not left out.
std::vector<std::uint8_t> interior_pixels(const ReferencePicture& reference);

/// Compares two pictures. A pixel that `ours` misses, or that holds NaN, disagrees in every layer. Both pictures have one
/// size, and `ours` has all layers that the reference has (except exclude).
ReferenceShares compare(const ReferencePicture& ours, const ReferencePicture& reference, const ReferenceLimits& limits);

}  // namespace occam::test
