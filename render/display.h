// From scene-linear colour to what a screen shows: exposure, tone curve, transfer. For display formats only.
#pragma once

#include "base/vec.h"
#include "render/image.h"

namespace occam::render {

/// IEC 61966-2-1, both ways, of values in [0, 1].
float srgb_from_linear(float x) noexcept;
float linear_from_srgb(float x) noexcept;

/// Beauty as a screen wants it: 3 floats a pixel in [0, 1], or 4 with unassociated alpha if any pixel is transparent.
struct DisplayImage {
    int channels = 3;
    std::vector<float> pixels;
};
DisplayImage display_image(const Image& image, const WriteOptions& options);

}  // namespace occam::render
