// Where samples become pixels.
//
// A pixel's samples are added by one worker, in their order, in double: so the sums have the same bits in every run.
// Colour layers are means. Depth, normals, uv, position and id are those of the one sample nearest the middle of the
// pixel: the mean of two depths lies on no surface.
#pragma once

#include <limits>

#include "render/image.h"
#include "render/settings.h"
#include "scenegraph/base/vec.h"

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
    FirstHit first;
};

class PixelSums {
public:
    /// place    of the sample in its pixel, from the top left. A radiance that is not finite counts as black.
    void add(const SampleResult& sample, Vec2f place) noexcept;

    Vec4f beauty() const noexcept;
    Vec4f albedo() const noexcept;
    const FirstHit& first() const noexcept { return first_; }
    float variance() const noexcept;  ///< of the mean of the luminance

private:
    Vec4d beauty_{0}, albedo_{0};
    double luminance_ = 0, luminance2_ = 0;
    int count_ = 0;
    float nearest_ = std::numeric_limits<float>::infinity();
    FirstHit first_;
};

/// Pixels are stored once each, by any thread.
class Film {
public:
    explicit Film(const Settings& settings);

    /// x, y     of the whole frame, inside the crop
    void store(int x, int y, const PixelSums& sums) noexcept;
    Image take() && { return std::move(image_); }

private:
    void put(Aov aov, std::size_t pixel, const float* values, std::size_t count) noexcept;

    Settings settings_;
    PixelRect rect_;
    Image image_;
    std::size_t layer_of_[std::size(kAllAovs)] = {};  ///< index of each wanted layer
};

}  // namespace occam::render
