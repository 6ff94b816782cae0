// Compares a blurred picture with the mean of still pictures of moments while the shutter is open.
//
// Both sides are estimates. The variance of a blurred pixel is known from its own samples and from those of the still
// pictures, and that of a mean of still pictures from how they vary; samples are stratified, so both are bounds from above.
// A pixel exceeds if the two differ by more than four standard errors and by what many pictures of few moments cannot
// resolve.
#pragma once

#include <occam/occam.h>

#include <functional>

namespace occam::test {

/// Holds what moves while the shutter is open, at tau from 0 (it opens) to 1 (it closes).
struct Moving {
    Scene scene;
    std::function<void(Scene&, double tau)> pose;
    std::function<Camera(double tau)> camera;
    Settings settings{.width = 40, .height = 30, .spp = 64};
};

/// Holds what the comparison of a blurred picture with the mean of still ones has found.
struct BlurComparison {
    std::size_t pixels = 0;
    std::size_t exceeding = 0;  ///< pixels that differ by more than four standard errors
    double difference = 0;      ///< sum over all pixels of the blurred picture's luminance minus that of the mean
    double error = 0;           ///< standard error of that sum
    double blur = 0;            ///< mean variance of a pixel over the still pictures
};

struct StillPictures {
    int count = 32;
    int samples =
        4;  ///< of a pixel; as many as the blurred picture has where there are textures, whose filter depends on it
};

/// Renders both pictures and compares them. The blurred one has 32 shutter segments.
BlurComparison compare_with_stills(Moving& moving, const StillPictures& stills = {});

}  // namespace occam::test
