// Where samples become pixels.
//
// A pixel's samples are added by one worker, in their order, in double: so the sums have the same bits in every run.
// Colour layers, normal_mean and occlusion are means with the reconstruction filter's weights. Depth, normals, uv, position
// and id are those of the one sample nearest the middle of the pixel: the mean of two depths lies on no surface.
#pragma once

#include <limits>

#include "base/vec.h"
#include "render/cryptomatte.h"
#include "render/image.h"
#include "render/settings.h"

namespace occam::render {

/// The first surface that a sample met.
struct FirstHit {
    float depth = std::numeric_limits<float>::infinity();  ///< camera z
    Vec3f normal{0}, normal_geometric{0};
    Vec2f uv{0};
    Vec3f position{0};
    float id = 0;
};

/// What one sample of a pixel brought back; colours multiplied by alpha.
struct SampleResult {
    Vec3f radiance{0};
    float alpha = 0;
    Vec4f albedo{0};
    Vec3f normal{0};
    float occlusion = 0;
    FirstHit first;
    Vec2f offset{0};   ///< from the middle of the pixel, in pixels
    float weight = 1;  ///< by the reconstruction filter: 1 or -1
};

class PixelSums {
public:
    /// A radiance that is not finite counts as black, and is counted.
    void add(const SampleResult& sample) noexcept;

    Vec4f beauty() const noexcept;
    Vec4f albedo() const noexcept;
    const FirstHit& first() const noexcept { return first_; }
    Vec3f normal() const noexcept;
    float occlusion() const noexcept;
    float variance() const noexcept;  ///< of the mean of the luminance
    /// Estimated standard error of the mean of the luminance over that mean; of dark pixels over kDarkest, so that noise
    /// which nobody sees asks for no samples. From the sample variance: it knows nothing of light that no sample has found
    /// yet.
    float relative_error() const noexcept;
    int not_finite() const noexcept { return not_finite_; }
    double weight() const noexcept { return weight_; }  ///< of all samples
    static constexpr float kDarkest = 0.02f;

private:
    Vec4d beauty_{0}, albedo_{0};
    Vec3d normal_{0};
    double occlusion_ = 0;
    double luminance_ = 0, luminance2_ = 0, weight_ = 0;
    int count_ = 0, not_finite_ = 0;
    float nearest_ = std::numeric_limits<float>::infinity();
    FirstHit first_;
};

/// Pixels are stored once each, by any thread.
class Film {
public:
    explicit Film(const Settings& settings);

    /// x, y     of the whole frame, inside the crop
    void store(int x, int y, const PixelSums& sums) noexcept;
    /// aov      of the two of Cryptomatte
    void store(int x, int y, Aov aov, MatteSums& mattes, double weight) noexcept;
    std::size_t bytes() const noexcept;
    Image take() && { return std::move(image_); }

private:
    std::size_t pixel_of(int x, int y) const noexcept;
    void put(Aov aov, std::size_t pixel, const float* values, std::size_t count) noexcept;

    Settings settings_;
    PixelRect rect_;
    Image image_;
    std::size_t layer_of_[std::size(kAllAovs)] = {};  ///< index of each wanted layer
};

}  // namespace occam::render
