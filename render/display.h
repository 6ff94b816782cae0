// Display encoding of scene-linear colour: exposure, tone curve and transfer function. It is used for display formats
// only.
#pragma once

#include "base/vec.h"
#include "render/image.h"

namespace occam::render {

/// The transfer function of IEC 61966-2-1 in both directions, for values in [0, 1].
float srgb_from_linear(float x) noexcept;
float linear_from_srgb(float x) noexcept;

/// Holds beauty as a screen shows it: 3 floats per pixel in [0, 1], or 4 with unassociated alpha if any pixel is
/// transparent. A grey layer is three channels of the same.
struct DisplayImage {
    int channels = 3;
    std::vector<float> pixels;
};
/// Throws Error if the picture has no layer beauty, or that has no colours (color_channels()).
/// most   the integer that the file has for an alpha of 1. A pixel whose alpha rounds to it is not transparent.
DisplayImage display_image(const Image& image, const WriteOptions& options, float most = 255);

/// Returns the stops that bring a picture's log-average luminance (Reinhard et al. 2002, "Photographic tone reproduction
/// for digital images", sec. 3) to within one stop of 0.25.
///
/// Pictures with usual lighting are left as they are: the result is 0 for log-averages from 0.125 to 0.5, and it does not
/// jump at the ends of this range. The average leaves out transparent pixels, and all pixels that are ten stops darker
/// than the brightest hundredth of the picture, so that a spot light on a dark stage is judged by what it shows. No
/// picture is brightened until its brightest hundredth is above 2, nor changed by more than kMostStops.
///
/// The result is a pure function of the pixels, which are added in their order. It is 0 for a black picture, for one
/// without colours (color_channels()), or for one that is not light (Image::is_light).
float automatic_exposure(const Image& image);
inline constexpr float kMostStops = 12;

}  // namespace occam::render
