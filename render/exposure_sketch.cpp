#include "render/exposure_sketch.h"

#include <algorithm>

#include "base/maths.h"
#include "render/display.h"

namespace occam::render {
namespace {

Settings sketch_settings(const Settings& from)
{
    constexpr int kMostColumns = 96, kSamples = 4;
    Settings s = from;
    s.width = std::min(from.width, kMostColumns);
    s.height = static_cast<int>(
        std::clamp(std::int64_t(from.height) * s.width / from.width, std::int64_t(1), std::int64_t(4 * kMostColumns)));
    s.crop_x0 = s.crop_y0 = 0;
    s.crop_x1 = s.crop_y1 = 1;
    s.spp = std::min(from.spp, kSamples);
    s.aovs = {};
    s.error = 0;
    return s;
}

float exposure_of_sketch(const FrameInputs& in, const FrameSetup& setup, FrameTracers& tracers, FrameControl& control,
                         FrameStats& stats)
{
    const Settings settings = sketch_settings(in.settings);
    const CameraRays camera = camera_of(settings, setup.scale, in.camera);
    const Sampler sampler(kSketchSeed, settings.spp, settings.jitter);
    PassBudget passes(settings);
    FrameContext context{settings, camera, sampler, setup.filter, setup.lights, in.textures, passes};
    context.may_pass = setup.context.may_pass;
    context.moves = setup.context.moves;
    context.may_start_in_body = setup.context.may_start_in_body;
    context.scene = setup.context.scene;
    context.scale = setup.scale;
    context.shadow_batch = setup.context.shadow_batch;
    context.clamp = 0;

    Film film(settings);
    Crew crew(context, tracers, in, std::chrono::steady_clock::time_point::max());
    crew.make(make_tiles(crop_pixels(settings)), settings.spp, film, control, nullptr);
    crew.count_rays_into(stats);
    return automatic_exposure(std::move(film).take());
}

}  // namespace

void set_limit_as_shown(const FrameInputs& in, FrameSetup& setup, FrameTracers& tracers, FrameControl& control,
                        FrameStats& stats)
{
    const Settings& s = in.settings;
    const bool is_limited = s.clamp > 0 && s.view == View::Beauty && s.integrator != IntegratorKind::Ao;
    if (s.clamp_as_shown && is_limited)
        setup.context.clamp = s.clamp * maths::exp2(-exposure_of_sketch(in, setup, tracers, control, stats));
}

}  // namespace occam::render
