#include "idle_options.h"

#include <stdexcept>

#include "render/picture_formats.h"

namespace occam::command {
namespace {

using Given = std::set<std::string>;

bool is_sky_or_none(const RenderArguments& a, const Given& given)
{
    return given.contains("--environment") && a.environment.empty();
}

bool is_debug_view(const RenderArguments& a, const Given&) { return a.settings.view != render::View::Beauty; }

bool is_ao(const RenderArguments& a, const Given&) { return a.settings.integrator == IntegratorKind::Ao; }

bool has_no_jitter(const RenderArguments& a, const Given&) { return !a.settings.jitter; }

// Of commands that make no picture: what is strict concerns files alone there, and moments of scenes that do not move.
bool has_nothing_strict(const RenderArguments& a, const Given&)
{
    return a.scene.empty() && a.output.empty() && !a.replay && !a.time && !a.frame;
}

// Of `occam render`. What is set for a picture may stay in the command, and what is set for its file may if the file does.
bool is_one_sample(const RenderArguments& a, const Given&) { return a.replay.has_value(); }
bool is_one_sample_without_file(const RenderArguments& a, const Given&) { return a.replay && a.output.empty(); }

// Of `occam verify`: render has none of the options that this concerns.
bool is_one_ray(const RenderArguments&, const Given& given) { return given.contains("--replay"); }

constexpr char kHoldsLight[] = "EXR and HDR files hold the light as it is; it is for PNG, JPEG and TIFF",
               kNoLight[] = "a debug view shows no light", kAo[] = "--integrator ao does not follow light",
               kAllSides[] = "--integrator ao has equal light from all sides",
               kOneRay[] = "--replay traces one ray, and prints its steps",
               kOneSample[] = "--replay traces one sample, and makes no picture",
               kInTheMiddle[] = "with --jitter off all samples lie in the middle of their pixels";

// Where the name of the picture has no format, that is what is wrong.
bool has_no_layers(const RenderArguments& a, const Given&)
{
    const render::PictureFormat* format = render::picture_format_of(a.output);
    return format && !format->holds_layers;
}

bool is_scene_linear(const RenderArguments& a, const Given&)
{
    const render::PictureFormat* format = render::picture_format_of(a.output);
    return format && !format->is_for_display;
}

struct Rule {
    const char* option;
    bool (*is_idle)(const RenderArguments&, const Given&);
    const char* why;
};

constexpr Rule kRules[] = {
    {"--quality",
     [](const RenderArguments&, const Given& given) { return given.contains("--spp") && given.contains("--shading-rate"); },
     "--spp and --shading-rate are all that it sets"},
    {"--progress", [](const RenderArguments& a, const Given&) { return a.quiet; }, "--quiet shows no progress"},
    {"--stats", is_one_sample, kOneSample},
    {"--checkpoint", is_one_sample, kOneSample},
    {"--resume", is_one_sample, kOneSample},
    {"--deadline", is_one_sample, kOneSample},
    {"--aov", is_one_sample_without_file, kOneSample},
    {"--exr", is_one_sample_without_file, kOneSample},
    {"--exposure", is_one_sample_without_file, kOneSample},
    {"--tonemap", is_one_sample_without_file, kOneSample},
    {"--filter", has_no_jitter, kInTheMiddle},
    {"--filter-radius", has_no_jitter, kInTheMiddle},
    {"--aov", has_no_layers, "only EXR files hold layers"},
    {"--exr", has_no_layers, "the picture is no EXR file"},
    {"--exposure", is_scene_linear, kHoldsLight},
    {"--tonemap", is_scene_linear, kHoldsLight},
    {"--exposure", is_debug_view, kNoLight},
    {"--tonemap", is_debug_view, kNoLight},
    {"--integrator", is_debug_view, kNoLight},
    {"--bounces", is_debug_view, kNoLight},
    {"--clamp", is_debug_view, kNoLight},
    {"--light-samples", is_debug_view, kNoLight},
    {"--background", is_debug_view, kNoLight},
    {"--environment", is_debug_view, kNoLight},
    {"--environment-strength", is_debug_view, kNoLight},
    {"--environment-rotation", is_debug_view, kNoLight},
    {"--ao-distance", [](const RenderArguments& a, const Given&) { return a.settings.integrator != IntegratorKind::Ao; },
     "only --integrator ao looks for it"},
    {"--fps",
     [](const RenderArguments& a, const Given& given) {
         return !a.frame && !given.contains("--frames") && !given.contains("--shutter");
     },
     "it is the length of a frame, for --frame and --shutter"},
    {"--shutter",
     [](const RenderArguments& a, const Given& given) {
         return a.clip.empty() && !a.time && !a.frame && !given.contains("--frames");
     },
     "nothing moves without --frame, --time or --clip"},
    {"--shutter-segments", [](const RenderArguments& a, const Given&) { return !a.settings.shutter.is_open(); },
     "nothing moves while the shutter is open for one moment"},
    {"--lod",
     [](const RenderArguments& a, const Given& given) {
         return a.settings.lod == render::Lod::Frozen && is_debug_view(a, given);
     },
     "frozen is about secondary rays, and a debug view has none"},
    {"--bounces", is_ao, kAo},
    {"--clamp", is_ao, kAo},
    {"--environment", is_ao, kAllSides},
    {"--environment-strength", is_ao, kAllSides},
    {"--environment-rotation", is_ao, kAllSides},
    {"--error",
     [](const RenderArguments& a, const Given&) { return a.settings.error > 0 && a.settings.spp <= a.settings.min_spp; },
     "pixels end at --min-spp samples (16 unless given) at the earliest, so --spp has to be above it"},
    {"--min-spp", [](const RenderArguments& a, const Given&) { return !(a.settings.error > 0); },
     "only --error above 0 ends pixels early"},
    {"--environment-strength",
     [](const RenderArguments& a, const Given& given) {
         return is_sky_or_none(a, given) && a.settings.sky == shade::Sky::Off;
     },
     "--environment none has no light"},
    {"--environment-rotation", is_sky_or_none, "only an image can be turned"},
    {"--subdivide", [](const RenderArguments& a, const Given&) { return a.scene.empty(); }, "the built-in scene is no file"},
    {"--rays", is_one_ray, kOneRay},
    {"--json", is_one_ray, kOneRay},
    {"--variant", [](const RenderArguments& a, const Given&) { return a.scene.empty(); }, "the built-in scene is no file"},
    {"--strict", has_nothing_strict, "the built-in scene is no file"},
};

}  // namespace

void refuse_idle(const RenderArguments& a, const Given& given)
{
    for (const Rule& rule : kRules)
        if (given.contains(rule.option) && rule.is_idle(a, given))
            throw std::invalid_argument(std::string(rule.option) + " would do nothing: " + rule.why);
}

void refuse_idle(const CompareArguments& a, const Given& given)
{
    if (given.contains("--layer") && !a.has_limit() && a.heat.empty())
        throw std::invalid_argument(
            "--layer would do nothing: without a limit (--max-rmse and others) or --heat all layers are measured");
}

void refuse_idle(const SceneArguments& a, const Given& given)
{
    RenderArguments like;
    static_cast<SceneArguments&>(like) = a;
    refuse_idle(like, given);
}

}  // namespace occam::command
