// The film, where samples become pixels.
//
// The samples of a pixel are added by one worker, in their order and in double, so the sums have the same bits in every
// run. Colour layers, normal_mean and occlusion are means with the weights of the reconstruction filter. Depth, normals,
// uv, position, id and motion are those of the one sample nearest to the middle of the pixel, because the mean of two depths
// lies on no surface.
#pragma once

#include <limits>

#include "base/vec.h"
#include "render/cryptomatte.h"
#include "render/image.h"
#include "render/settings.h"

namespace occam::render {

/// Describes the first surface that a sample hits.
struct FirstSurface {
    float depth = std::numeric_limits<float>::infinity();  ///< camera z
    Vec3f normal{0}, normal_geometric{0};
    Vec2f uv{0};
    Vec3f position{0};
    float id = 0;
    Vec2f motion{0};  ///< pixels per frame, to the right and down
};

/// Holds what one sample of a pixel contributes; colours are multiplied by alpha.
struct SampleResult {
    Vec3f radiance{0};
    float alpha = 0;
    Vec4f albedo{0};
    Vec3f normal{0};
    float occlusion = 0;
    float emitted = 0;  ///< the part of the luminance that surfaces emit towards the camera, or that unlit ones show
    FirstSurface first;
    Vec2f offset{0};   ///< offset from the middle of the pixel, in pixels
    float weight = 1;  ///< weight of the reconstruction filter: 1 or -1
};

class PixelSums {
public:
    /// Adds a sample. A radiance that is not finite counts as black, and is counted.
    void add(const SampleResult& sample) noexcept;

    Vec4f beauty() const noexcept;
    Vec4f albedo() const noexcept;
    Vec3f normal() const noexcept;
    float occlusion() const noexcept;
    /// Returns the variance of the mean of the luminance: infinity if too few samples tell it.
    float variance() const noexcept;
    /// Returns the estimated standard error of the mean luminance, divided by that mean. For dark pixels the divisor is
    /// kDarkest, so that invisible noise asks for no samples. The estimate comes from the sample variance, so it knows
    /// nothing of light that no sample has found yet.
    float relative_error() const noexcept;
    /// Writes the channels of a layer that is no Cryptomatte.
    void write(Aov aov, float* to) const noexcept;
    int count() const noexcept { return count_; }  ///< number of samples
    int not_finite() const noexcept { return not_finite_; }
    double weight() const noexcept { return weight_; }  ///< sum over all samples
    static constexpr float kDarkest = 0.02f;

    /// Returns the size of the sums that the beauty picture and these layers need, as bytes without gaps. Sums that are left
    /// out read back as zeros.
    static std::size_t packed_bytes(AovSet aovs) noexcept;
    void pack(AovSet aovs, std::byte* to) const noexcept;
    void unpack(AovSet aovs, const std::byte* from) noexcept;

private:
    template <class Sums, class Visit>
    static void visit_packed(Sums& sums, AovSet aovs, Visit&& visit);

    Vec4d beauty_{0}, albedo_{0};
    Vec3d normal_{0};
    double occlusion_ = 0;
    double luminance_ = 0, luminance2_ = 0;  ///< of the samples, without weights
    double weight_ = 0;
    int count_ = 0, not_finite_ = 0;
    float nearest_ = std::numeric_limits<float>::infinity();
    FirstSurface first_;
};

/// The picture while it is rendered. Any thread may store pixels, but no two threads may store the same pixel at once. A
/// pixel that is stored again replaces the earlier one.
class Film {
public:
    explicit Film(const Settings& settings);

    /// x, y     pixel of the whole frame, inside the crop
    void store(int x, int y, const PixelSums& sums) noexcept;
    /// aov      one of the two Cryptomatte layers
    void store(int x, int y, Aov aov, MatteSums& mattes, double weight) noexcept;
    /// Returns how many bytes the layers of a picture take.
    static std::size_t bytes_for(const Settings& settings) noexcept;
    Image take() && { return std::move(image_); }

private:
    std::size_t pixel_of(int x, int y) const noexcept;

    Settings settings_;
    PixelRect rect_;
    Image image_;
    std::size_t layer_of_[std::size(kAovs)] = {};  ///< index of each requested layer
};

}  // namespace occam::render
