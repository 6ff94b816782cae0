#include "small_picture.h"

#include <algorithm>

#include "base/maths.h"
#include "render/display.h"

namespace occam::command {

Measured measure_small(const Settings& settings, const Camera& camera, Scene& scene, Renderer& renderer)
{
    constexpr int kWidth = 96, kSamples = 4;
    Settings small = settings;
    small.height = std::clamp(small.height * kWidth / small.width, 1, 4 * kWidth);
    small.width = kWidth;
    // A picture that is smaller still is measured without finer surfaces than its own.
    if (settings.width < kWidth)
        small.shading_rate = std::min(small.shading_rate * float(kWidth) / float(settings.width), 1024.0f);
    small.crop_x0 = small.crop_y0 = 0;
    small.crop_x1 = small.crop_y1 = 1;
    small.spp = std::min(small.spp, kSamples);
    small.aovs = {};
    small.clamp = 0;
    small.deadline_s = small.error = 0;
    small.progressive = false;
    const Image image = renderer.render(scene, camera, small);
    const FrameStats& stats = renderer.stats();
    return {render::automatic_exposure(image), stats.lights.has_default, stats.lights.has_emitters};
}

bool wants_display_clamp(const RenderArguments& a)
{
    const Settings& s = a.settings;
    return !a.clamp_given && Image::is_for_display(a.output) && s.integrator == render::IntegratorKind::Path &&
           s.view == View::Beauty;
}

float display_clamp(float stops) noexcept
{
    constexpr float kLogOfTwo = 0.69314718f;
    return kDisplayClamp * maths::exp(-stops * kLogOfTwo);
}

}  // namespace occam::command
