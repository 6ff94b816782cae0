#include "idle_options.h"

#include <stdexcept>

namespace occam::command {
namespace {

using Given = std::set<std::string>;

bool is_sky_or_none(const RenderArguments& a, const Given& given)
{
    return given.contains("--environment") && a.environment.empty();
}

bool is_debug_view(const RenderArguments& a, const Given&) { return a.settings.view != render::View::Beauty; }

constexpr char kHoldsLight[] = "EXR and HDR files hold the light as it is; it is for PNG, JPEG and TIFF",
               kNoLight[] = "a debug view shows no light";

struct Rule {
    const char* option;
    bool (*is_idle)(const RenderArguments&, const Given&);
    const char* why;
};

constexpr Rule kRules[] = {
    {"--aov", [](const RenderArguments& a, const Given&) { return !Image::has_layers(a.output); },
     "only EXR files hold layers"},
    {"--exr", [](const RenderArguments& a, const Given&) { return !Image::has_layers(a.output); },
     "the picture is no EXR file"},
    {"--exposure", [](const RenderArguments& a, const Given&) { return !Image::is_for_display(a.output); }, kHoldsLight},
    {"--tonemap", [](const RenderArguments& a, const Given&) { return !Image::is_for_display(a.output); }, kHoldsLight},
    {"--exposure", is_debug_view, kNoLight},
    {"--tonemap", is_debug_view, kNoLight},
    {"--ao-distance", [](const RenderArguments& a, const Given&) { return a.settings.integrator != IntegratorKind::Ao; },
     "only --integrator ao looks for it"},
    {"--fps",
     [](const RenderArguments&, const Given& given) {
         return !given.contains("--frame") && !given.contains("--frames") && !given.contains("--shutter");
     },
     "it is the length of a frame, for --frame and --shutter"},
    {"--shutter",
     [](const RenderArguments& a, const Given& given) {
         return a.clip.empty() && !a.time && !a.frame && !given.contains("--frames");
     },
     "nothing moves without --frame, --time or --clip"},
    {"--bounces", [](const RenderArguments& a, const Given&) { return a.settings.integrator == IntegratorKind::Ao; },
     "--integrator ao does not follow light"},
    {"--clamp", [](const RenderArguments& a, const Given&) { return a.settings.integrator == IntegratorKind::Ao; },
     "--integrator ao does not follow light"},
    {"--error", [](const RenderArguments& a, const Given&) { return a.settings.spp <= a.settings.min_spp; },
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
    {"--variant", [](const RenderArguments& a, const Given&) { return a.scene.empty(); }, "the built-in scene is no file"},
};

}  // namespace

void refuse_idle(const RenderArguments& a, const Given& given)
{
    for (const Rule& rule : kRules)
        if (given.contains(rule.option) && rule.is_idle(a, given))
            throw std::invalid_argument(std::string(rule.option) + " would do nothing: " + rule.why);
}

}  // namespace occam::command
