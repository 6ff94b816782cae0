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

/// The stops that bring a picture's log-average luminance (Reinhard et al. 2002, "Photographic tone reproduction for digital
/// images", sec. 3) to within one stop of 0.25.
///
/// Pictures that are lit as usual are left as they are: the result is 0 for log-averages from 0.125 to 0.5, and no jump lies
/// at the ends of this range. The average leaves out transparent pixels, and all that are ten stops darker than the
/// brightest hundredth of the picture: a spot light on a stage counts for what it shows. No picture is brightened until its
/// brightest hundredth is above 2, nor changed by more than kMostStops.
///
/// A pure function of the pixels, added in their order. 0 for a picture that is no light (Image::is_light), or black.
float automatic_exposure(const Image& image) noexcept;
inline constexpr float kMostStops = 12;

}  // namespace occam::render
