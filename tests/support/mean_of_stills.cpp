#include "tests/support/mean_of_stills.h"

#include <algorithm>
#include <cmath>

namespace occam::test {
namespace {

Image blurred(Moving& moving)
{
    Settings settings = moving.settings;
    settings.aovs = Aov::Variance;
    settings.seed = 1000;
    moving.scene.record_shutter(32, [&](double tau) { moving.pose(moving.scene, tau); });
    Camera camera = moving.camera(0.5);
    const Camera first = moving.camera(0), last = moving.camera(1);
    if (first.world_from_camera != last.world_from_camera)
        for (int k = 0; k <= 32; ++k) camera.keys.push_back(moving.camera(k / 32.0).world_from_camera);
    const Image image = Renderer().render(moving.scene, camera, settings);
    moving.scene.clear_shutter();
    return image;
}

double luminance(const float* p) { return 0.2126 * double(p[0]) + 0.7152 * double(p[1]) + 0.0722 * double(p[2]); }

}  // namespace

BlurComparison compare_with_stills(Moving& moving, const StillPictures& stills)
{
    const Image picture = blurred(moving);
    BlurComparison found;
    found.pixels = std::size_t(moving.settings.width * moving.settings.height);
    std::vector<double> sum(found.pixels), squares(found.pixels), noise(found.pixels);
    Renderer renderer;
    for (int m = 0; m < stills.count; ++m) {
        const double tau = (m + 0.5) / stills.count;
        moving.pose(moving.scene, tau);
        Settings settings = moving.settings;
        settings.spp = stills.samples;
        settings.seed = std::uint64_t(m);
        settings.aovs = Aov::Variance;
        const Image still = renderer.render(moving.scene, moving.camera(tau), settings);
        const std::vector<float>& own = still.find("variance")->pixels;
        for (std::size_t i = 0; i < found.pixels; ++i) {
            const double y = luminance(&still.layers()[0].pixels[4 * i]);
            sum[i] += y;
            squares[i] += y * y;
            noise[i] += double(own[i]) / stills.count;
        }
    }
    const std::vector<float>& variance = picture.find("variance")->pixels;
    double error2_of_sum = 0;
    for (std::size_t i = 0; i < found.pixels; ++i) {
        const double mean = sum[i] / stills.count, here = luminance(&picture.layers()[0].pixels[4 * i]);
        const double of_stills = std::max(0.0, squares[i] / stills.count - mean * mean);  // mostly motion
        // Where few samples see something, those of the blurred picture may all miss it; the still pictures have more.
        const double samples = moving.settings.spp;
        const double of_blurred = std::max(double(variance[i]), (noise[i] * stills.samples + of_stills) / samples);
        const double error2 = of_blurred + of_stills / stills.count;
        found.exceeding += std::abs(here - mean) > 4 * std::sqrt(error2) + 1e-3;
        found.difference += here - mean;
        error2_of_sum += error2;
        found.blur += of_stills / double(found.pixels);
    }
    found.error = std::sqrt(error2_of_sum);
    return found;
}

}  // namespace occam::test
