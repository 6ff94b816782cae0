#include "render/light_probe.h"

#include <algorithm>
#include <cmath>

#include "accel/frame.h"
#include "base/luminance.h"
#include "render/hole_filter.h"
#include "render/integrator.h"

namespace occam::render {
namespace {

constexpr int kSamples = 4, kBounces = 4;
// The picture has as many columns as the first of these, or as the second if fewer samples than kLeastSubject show
// anything beside the emissive surfaces.
constexpr int kColumns[] = {32, 128};
constexpr int kLeastSubject = 64;
// A surface is lit if it is as bright as this share of its colour: what an irradiance of 0.02 makes of it.
constexpr float kLeastRadiance = 0.02f / 3.14159265f;
// It also needs this share of the picture's own brightness, because a display shows it beside the rest.
constexpr float kLeastShare = 0.05f;
// This share of what is seen, without the emissive surfaces themselves, has to be lit.
constexpr double kLeastLit = 0.25;
// So many pixels along and across are judged by the mean of their samples: rays find surfaces that emit light and are not
// sampled, such as those that move, by chance alone.
constexpr int kBlock = 4;

// Holds what a sample of the small picture shows, by luminance, or the sum of several.
struct Glimpse {
    float alpha = 0, reflected = 0, emitted = 0, color = 0;
    bool is_subject() const noexcept { return alpha > 0 && emitted <= kLeastRadiance && std::isfinite(reflected); }
};

Settings small_settings(const Settings& from, int columns)
{
    Settings s = from;
    s.width = columns;
    s.height = std::clamp(static_cast<int>(std::lround(double(columns) * from.height / from.width)), 1, 4 * columns);
    s.crop_x0 = s.crop_y0 = 0;
    s.crop_x1 = s.crop_y1 = 1;
    s.spp = kSamples;
    s.jitter = true;
    s.filter = FilterKind::Box;
    s.filter_radius = 0;
    s.integrator = IntegratorKind::Path;
    s.bounces = std::min(s.bounces, kBounces);
    s.light_samples = 1;
    s.clamp = 0;
    s.aovs = {};
    s.background = false;
    s.lod_camera.reset();
    s.shade_at = ShadeAt::Hit;
    return s;
}

std::vector<Glimpse> small_picture(const FrameInputs& in, const FrameScale& scale, const shade::FrameLights& lights,
                                   int columns)
{
    const Settings settings = small_settings(in.settings, columns);
    const CameraRays camera(scale.placed(in.camera), settings.width, settings.height, settings.spp, settings.shading_rate);
    const Sampler sampler(kSketchSeed, settings.spp, settings.jitter);
    const PixelFilter filter(settings.filter, settings.filter_radius);
    PassBudget passes(settings);
    FrameContext context{settings, camera, sampler, filter, lights, in.textures, passes};
    context.may_pass = true;
    context.moves = camera.moves() || in.scene.shutter_segments() > 0;
    context.may_start_in_body = in.scene.contents().has(Contents::Absorbing);
    context.scale = scale;
    context.shadow_batch = in.memory.shadow_batch;
    const HoleFilter holes(in.textures, !settings.back_faces);
    const lod::VertexShading shading{nullptr, 1, holes.if_needed(in.scene.contents())};
    const accel::Frame frame(in.scene, in.topologies, camera.levels(settings.shading_rate),
                             {.textures = &in.textures, .shading = shading, .scale = scale});
    accel::Tracer tracer(frame, in.memory.tracer_bytes);
    Integrator integrator(context);

    std::vector<Glimpse> glimpses;
    std::vector<CameraSample> samples;
    std::vector<SampleResult> results;
    for (int y = 0; y < settings.height; ++y) {
        samples.clear();
        for (int x = 0; x < settings.width; ++x)
            for (int s = 0; s < settings.spp; ++s) samples.push_back({x, y, s});
        results.resize(samples.size());
        integrator.run(tracer, samples, results);
        for (const SampleResult& r : results)
            glimpses.push_back({r.alpha, luminance(r.radiance) - r.emitted, r.emitted, luminance(Vec3f(r.albedo))});
    }
    return glimpses;
}

// Returns the sums of what is seen beside the emissive surfaces, for each block of pixels.
std::vector<Glimpse> blocks_of(const std::vector<Glimpse>& glimpses, int columns)
{
    const auto width = static_cast<std::size_t>(columns), across = (width + kBlock - 1) / kBlock;
    const std::size_t rows = glimpses.size() / (width * kSamples);
    std::vector<Glimpse> blocks(across * ((rows + kBlock - 1) / kBlock));
    for (std::size_t i = 0; i < glimpses.size(); ++i) {
        const Glimpse& g = glimpses[i];
        if (!g.is_subject()) continue;
        const std::size_t pixel = i / kSamples;
        Glimpse& block = blocks[pixel / width / kBlock * across + pixel % width / kBlock];
        block.alpha += g.alpha;
        block.reflected += g.reflected;
        block.color += g.color;
    }
    return blocks;
}

bool is_lit(const FrameInputs& in, const FrameScale& scale, const shade::FrameLights& lights)
{
    std::vector<Glimpse> glimpses;
    int columns_seen = 0;
    for (const int columns : kColumns) {
        columns_seen = columns;
        glimpses = small_picture(in, scale, lights, columns);
        const auto subject = std::count_if(glimpses.begin(), glimpses.end(),
                                           [](const Glimpse& g) { return g.is_subject(); });
        if (subject >= kLeastSubject) break;
    }
    // The log-average brightness of what is seen (Reinhard et al. 2002).
    double logs = 0, seen = 0;
    for (const Glimpse& g : glimpses) {
        if (!(g.alpha > 0) || !std::isfinite(g.reflected + g.emitted)) continue;
        logs += double(g.alpha * maths::log(std::max((g.reflected + g.emitted) / g.alpha, 1e-4f)));
        seen += double(g.alpha);
    }
    const float brightness = seen > 0 ? maths::exp(static_cast<float>(logs / seen)) : 0;
    const float least = std::max(kLeastRadiance, kLeastShare * std::min(brightness, 1.0f));
    double subject = 0, lit = 0;
    for (const Glimpse& block : blocks_of(glimpses, columns_seen)) {
        subject += double(block.alpha);
        if (block.reflected >= least * std::max(block.color, 0.05f * block.alpha)) lit += double(block.alpha);
    }
    return lit >= kLeastLit * subject;
}

}  // namespace

shade::FrameLights lights_of(const FrameInputs& in, const FrameScale& scale)
{
    const Settings& s = in.settings;
    const Camera camera = scale.placed(in.camera);
    const auto make = [&](shade::Sky sky, std::optional<bool> gets_default) {
        shade::FrameLights made(in.scene, camera, in.textures, {sky, s.sky_strength, gets_default}, scale, &in.lights);
        if (!s.back_faces) made.hide_backs();
        return made;
    };
    shade::FrameLights lights = make(s.sky, s.default_light);
    const bool is_known = s.default_light || s.sky == shade::Sky::Off || !lights.relies_on_emitters();
    if (is_known || s.integrator == IntegratorKind::Ao || s.view != View::Beauty) return lights;
    if (s.sky == shade::Sky::Auto ? is_lit(in, scale, lights) : is_lit(in, scale, make(shade::Sky::Off, false)))
        return lights;
    return make(s.sky, true);
}

}  // namespace occam::render
