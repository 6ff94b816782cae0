#include "tests/support/reference_compare.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "base/check.h"
#include "base/vec.h"

namespace occam::test {
namespace {

constexpr float kSilhouetteFactor = 1.05f;
constexpr double kDegrees = 57.29577951308232;  ///< degrees in a radian

bool is_left_out(const ReferencePicture& reference, std::size_t pixel)
{
    return !reference.exclude.empty() && reference.exclude[pixel] != 0;
}

Vec3d vector_at(const std::vector<float>& from, std::size_t pixel)
{
    return {double(from[3 * pixel]), double(from[3 * pixel + 1]), double(from[3 * pixel + 2])};
}

// Returns the angle between two vectors, computed from its tangent, since the arc cosine of a float near 1 is precise to
// 0.03 degrees at best. It is NaN if our vector is zero.
double degrees_between(Vec3d a, Vec3d b)
{
    if (glm::dot(a, a) == 0) return NAN;
    return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * kDegrees;
}

double largest_difference(const std::vector<float>& a, const std::vector<float>& b, std::size_t first, std::size_t count)
{
    double largest = 0;
    for (std::size_t i = first; i < first + count; ++i) {
        const double d = std::abs(double(a[i]) - double(b[i]));
        if (std::isnan(d)) return d;
        largest = std::max(largest, d);
    }
    return largest;
}

// Counts the values that are at most the limit; NaN does not count.
class Share {
public:
    explicit Share(double limit) : limit_(limit) {}
    void add(double error)
    {
        ++count_;
        within_ += error <= limit_;
    }
    void add_miss() { ++count_; }
    std::optional<double> value() const { return count_ ? std::optional(double(within_) / double(count_)) : std::nullopt; }

private:
    double limit_;
    std::size_t count_ = 0, within_ = 0;
};

std::optional<double> share_of_normals(const std::vector<float>& ours, const std::vector<float>& reference, double degrees,
                                       const std::vector<std::uint8_t>& interior, const ReferencePicture& picture)
{
    if (reference.empty()) return std::nullopt;
    Share share(degrees);
    for (std::size_t i = 0; i < interior.size(); ++i) {
        const Vec3d n = vector_at(reference, i);
        if (!interior[i] || glm::dot(n, n) == 0) continue;
        picture.is_hit(i) ? share.add(degrees_between(vector_at(ours, i), n)) : share.add_miss();
    }
    return share.value();
}

}  // namespace

std::vector<std::uint8_t> interior_pixels(const ReferencePicture& reference)
{
    std::vector<std::uint8_t> interior(reference.pixel_count(), 0);
    for (int y = 1; y + 1 < reference.height; ++y)
        for (int x = 1; x + 1 < reference.width; ++x) {
            const auto index = [&](int column, int row) {
                return std::size_t(row) * std::size_t(reference.width) + std::size_t(column);
            };
            float near = std::numeric_limits<float>::infinity(), far = 0;
            bool is_hit = true;
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx) {
                    const std::size_t i = index(x + dx, y + dy);
                    is_hit = is_hit && reference.is_hit(i);
                    near = std::min(near, reference.depth[i]);
                    far = std::max(far, reference.depth[i]);
                }
            interior[index(x, y)] = is_hit && far <= near * kSilhouetteFactor && !is_left_out(reference, index(x, y));
        }
    return interior;
}

ReferenceShares compare(const ReferencePicture& ours, const ReferencePicture& reference, const ReferenceLimits& limits)
{
    OCCAM_CHECK_EQ(ours.width, reference.width);
    OCCAM_CHECK_EQ(ours.height, reference.height);
    ReferenceShares shares;
    std::size_t mismatches = 0;
    for (std::size_t i = 0; i < reference.pixel_count(); ++i) {
        if (is_left_out(reference, i)) continue;
        shares.hits += reference.is_hit(i);
        mismatches += ours.is_hit(i) != reference.is_hit(i);
    }
    shares.coverage_mismatch = double(mismatches) / double(std::max<std::size_t>(shares.hits, 1));

    const std::vector<std::uint8_t> interior = interior_pixels(reference);
    Share depth(limits.depth_relative), uv(limits.uv_absolute), albedo(limits.albedo_absolute);
    double albedo_sum = 0;
    for (std::size_t i = 0; i < interior.size(); ++i) {
        if (!interior[i]) continue;
        ++shares.interior;
        const bool is_hit = ours.is_hit(i);
        const double z = double(reference.depth[i]);
        is_hit ? depth.add(std::abs(double(ours.depth[i]) - z) / z) : depth.add_miss();
        if (!reference.uv.empty()) is_hit ? uv.add(largest_difference(ours.uv, reference.uv, 2 * i, 2)) : uv.add_miss();
        if (reference.albedo.empty()) continue;
        // Coverage is a mean over the pixel, so whether the ray through its middle hits does not matter here.
        albedo.add(largest_difference(ours.albedo, reference.albedo, 4 * i, 3));
        for (std::size_t c = 4 * i; c < 4 * i + 3; ++c)
            albedo_sum += std::abs(double(ours.albedo[c]) - double(reference.albedo[c]));
    }
    shares.depth = depth.value();
    shares.uv = uv.value();
    shares.albedo = albedo.value();
    if (shares.albedo) shares.albedo_mean_absolute = albedo_sum / (3 * double(shares.interior));
    shares.normal_geometric = share_of_normals(ours.normal_geometric, reference.normal_geometric,
                                               limits.normal_geometric_degrees, interior, ours);
    shares.normal_shading = share_of_normals(ours.normal_shading, reference.normal_shading, limits.normal_shading_degrees,
                                             interior, ours);
    return shares;
}

}  // namespace occam::test
