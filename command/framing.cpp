#include "framing.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>

#include "base/error_without_file.h"
#include "base/number_in.h"
#include "base/printable.h"
#include "base/stopwatch.h"
#include "io/input_file.h"
#include "io/output_file.h"
#include "io/picture_codec.h"
#include "render/picture_formats.h"
#include "values.h"

namespace occam::command {
namespace {

using namespace std::chrono_literals;

constexpr float kRadians = 3.14159265f / 180;
constexpr int kClipSteps = 48;  // poses at which a clip is measured; the margin of CameraFit covers what lies between them

std::string list_of(const std::vector<std::string>& names)
{
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
    return text.empty() ? "it has none" : "it has " + text;
}

// Returns all clips, one by its name or else its number, or those that the file means to play together.
std::vector<ClipId> choose_clips(const Scene& scene, const RenderArguments& a)
{
    const std::vector<ClipId>& clips = scene.clips();
    if (a.clip.empty()) return scene.clips_together();
    if (a.clip == "all" && !clips.empty()) return clips;
    if (const ClipId named = scene.find_clip(a.clip)) return {named};
    if (const auto index = number_in<std::size_t>(a.clip); index && *index < clips.size()) return {clips[*index]};
    std::vector<std::string> names;
    for (const ClipId id : clips)
        names.push_back(scene.clip(id).name.empty() ? std::to_string(names.size()) : scene.clip(id).name);
    throw Error(name_of_scene(a), "has no clip of that name or number; " + list_of(names), a.clip);
}

// What is no regular file, such as a pipe, would be read for ever.
void require_readable(const std::filesystem::path& file, const std::string& option = {})
{
    if (const std::string why = why_unreadable(file); !why.empty()) throw Error(file.string(), why, option);
}

// Returns whether the scene has an environment then, whatever its factor is.
bool set_environment(Scene& scene, const RenderArguments& a)
{
    if (!a.has_environment) scene.environment = {};
    if (!a.environment.empty()) {
        require_readable(a.environment, "--environment");
        Texture image;
        image.name = a.environment.string();
        image.path = a.environment;
        scene.environment = {Vec3f(1), scene.add(std::move(image)), 0};
    }
    const bool has_environment = scene.environment.radiance != Vec3f(0);
    scene.environment.radiance *= a.environment_strength;
    scene.environment.rotation += a.environment_rotation_deg * kRadians;
    return has_environment;
}

// Statistics may have any name, so a slip of the hand may name a file of the scene, or what another program has written.
// Only an empty file is replaced, and one that begins as older statistics do: a JSON object whose first key is "scene", with
// an object, or a list of objects whose first key is "frame", with a number. Of glTF files "scene" is a number.
void require_older_statistics(const std::filesystem::path& file)
{
    std::error_code error;
    if (is_written_directly(file) || !std::filesystem::is_regular_file(file, error)) return;
    require_readable(file, "--stats");
    constexpr std::string_view kOfFrame = R"({"scene":{)", kOfSequence = R"([{"frame":)";
    std::ifstream stream(file, std::ios::binary);
    std::string head;  // without blanks
    for (char c = 0; head.size() <= kOfSequence.size() && stream >> c;) head += c;
    const bool is_list = head.starts_with(kOfSequence) && head.find_first_of("0123456789", kOfSequence.size()) != head.npos;
    if (!head.empty() && head != "[]" && !is_list && !head.starts_with(kOfFrame))
        throw Error(file.string(), "is there already and holds no statistics, so it is not replaced", "--stats");
}

/// Throws Error if the statistics would be written over one of these files of pictures, which are in one folder.
void refuse_statistics_among(std::span<const std::filesystem::path> pictures, const RenderArguments& a)
{
    if (a.stats.empty()) return;
    const auto place_of = [](const std::filesystem::path& file) {
        std::error_code error;
        const std::filesystem::path place = std::filesystem::weakly_canonical(file, error);
        return error ? file : place;
    };
    const auto folder_of = [&](const std::filesystem::path& file) {
        return place_of(file.has_parent_path() ? file.parent_path() : std::filesystem::path("."));
    };
    const std::filesystem::path folder = folder_of(pictures.front()), stats = place_of(a.stats);
    const std::filesystem::path named = folder_of(a.stats) / std::filesystem::path(a.stats).filename();
    for (const std::filesystem::path& picture : pictures)
        if (const auto name = folder / picture.filename(); name == stats || name == named)
            throw error_without_file("the statistics and the picture, or its checkpoint, cannot be written to one file",
                                     "--stats");
}

}  // namespace

Framing::Framing(Scene& scene, const RenderArguments& arguments)
    : scene_(scene),
      arguments_(arguments),
      clips_(choose_clips(scene, arguments)),
      fit_(arguments.view_from.value_or(ViewFrom::ThreeQuarter), up(),
           arguments.fov_deg > 0 ? arguments.fov_deg * kRadians : CameraLens().fov,
           float(arguments.settings.width) / float(arguments.settings.height)),
      has_environment_(set_environment(scene, arguments))
{
    if (arguments.environment_rotation_deg != 0 && !scene.environment.image)
        note_idle("no image is around the scene, so --environment-rotation changes nothing");
    if (arguments.time || arguments.frame) note_stillness("--time and --frame change nothing");
}

void Framing::note_stillness(const std::string& consequence)
{
    if (clips_.empty()) note_idle("nothing in the scene is animated, so " + consequence);
}

void Framing::note_idle(std::string warning)
{
    if (arguments_.load.strict) throw Error(name_of_scene(arguments_), warning);
    scene_.warnings.push_back(std::move(warning));
}

void Framing::note_idle_strength(FrameStats& stats) const
{
    const RenderArguments& a = arguments_;
    if (a.environment_strength == 1 || has_environment_) return;
    if (stats.lights.has_default || a.settings.sky == shade::Sky::On) return;
    stats.warnings.push_back("neither an image nor daylight is around the scene, so --environment-strength changes nothing");
    stats.scene.warnings = stats.warnings.size();
}

bool Framing::is_fitted() const
{
    const RenderArguments& a = arguments_;
    if (a.look_at || !a.camera.empty()) return false;
    return a.view_from || a.up || !scene_.camera();
}

Vec3d Framing::up() const
{
    if (arguments_.up) return *arguments_.up;
    const SceneFormat* format = scene_format_of(arguments_.scene);
    return axis_of(format ? format->up : "y");
}

void Framing::fit_pose()
{
    scene_.refit();
    extent_.visit_points(scene_, [&](Vec3d point) { fit_.add(point); });
}

void Framing::fit_clip()
{
    if (!is_fitted()) return;
    is_clip_fitted_ = true;
    if (clips_.empty()) return fit_pose();
    TimeRange range = time_range(scene_.clip(clips_.front()));
    for (const ClipId id : clips_) {
        const TimeRange of_clip = time_range(scene_.clip(id));
        range = {std::min(range.first, of_clip.first), std::max(range.last, of_clip.last)};
    }
    const int steps = range.last > range.first ? kClipSteps : 0;
    for (int i = 0; i <= steps; ++i) {
        pose_at(range.first + (range.last - range.first) * i / std::max(steps, 1));
        fit_pose();
    }
}

void Framing::pose_at(double seconds)
{
    std::vector<ClipAt> at;
    for (const ClipId id : clips_) at.push_back({id, seconds});
    scene_.pose(at);
}

std::optional<double> Framing::moment(std::optional<int> frame) const
{
    const RenderArguments& a = arguments_;
    if (!frame) frame = a.frame;
    if (clips_.empty() || (!frame && !a.time && a.clip.empty())) return std::nullopt;
    return a.time ? *a.time : double(frame.value_or(0)) / a.fps;
}

void Framing::pose(std::optional<int> frame)
{
    if (moment(frame)) pose_in_shutter(frame, 0.5);
}

void Framing::pose_in_shutter(std::optional<int> frame, double tau)
{
    const Shutter& shutter = arguments_.settings.shutter;
    pose_at(*moment(frame) + (shutter.open + tau * shutter.length()) / arguments_.fps);
}

std::optional<float> Framing::exposure_seconds() const
{
    const Shutter& shutter = arguments_.settings.shutter;
    if (!shutter.is_open()) return std::nullopt;
    return static_cast<float>(shutter.length() / arguments_.fps);
}

Camera Framing::open_shutter(const Camera& camera, std::optional<int> frame)
{
    const Shutter& shutter = arguments_.settings.shutter;
    if (shutter == Shutter{}) return camera;
    if (!moment(frame)) throw Error(name_of_scene(arguments_), "has no animation that a shutter could blur", "--shutter");
    if (!shutter.is_open()) return camera;
    const int height = settings(camera).height;
    return record_shutter(
        scene_, [&](double tau) { pose_in_shutter(frame, tau); }, [&] { return this->camera(); }, height,
        arguments_.shutter_segments);
}

Camera Framing::camera_named(const std::string& name) const
{
    if (const auto found = scene_.camera(name)) return *found;
    throw Error(name_of_scene(arguments_), "has no camera of that name; " + list_of(scene_.camera_names()), name);
}

Camera Framing::camera()
{
    const RenderArguments& a = arguments_;
    Camera camera;
    if (a.look_at) {
        if (a.look_at->eye == a.look_at->target) throw error_without_file("eye and target are the same point", "--look-at");
        if (is_along(a.look_at->target - a.look_at->eye, up()))
            throw error_without_file("up is parallel to the view", "--up");
        camera = Camera::look_at(a.look_at->eye, a.look_at->target, up(), CameraLens{}.fov);
    } else if (!a.camera.empty()) {
        camera = camera_named(a.camera);
    } else if (is_fitted()) {
        if (!is_clip_fitted_) {
            fit_.clear();
            fit_pose();
        }
        camera = fit_.camera();
    } else {
        camera = *scene_.camera();
    }
    if (a.fov_deg > 0) {
        if (camera.lens.orthographic)
            throw Error(name_of_scene(a), "has an orthographic camera, which has no angle of view", "--fov");
        camera.lens.fov = a.fov_deg * kRadians;
    }
    if (a.lens_radius > 0) {
        camera.lens.radius = a.lens_radius;
        camera.lens.focus = a.focus;
        camera.lens.blades = a.blades;
    }
    return camera;
}

Settings Framing::settings(const Camera& camera) const
{
    Settings settings = arguments_.settings;
    settings.strict = arguments_.load.strict;
    if (const std::string& name = arguments_.lod_camera; !name.empty()) settings.lod_camera = camera_named(name);
    const float aspect = camera.lens.aspect;
    if (!arguments_.size_given && aspect > 0)
        settings.height = static_cast<int>(
            std::clamp(std::round(float(settings.width) / aspect), 1.0f, float(render::kMaxSide)));
    render::check(settings);
    if (const render::PixelRect pixels = render::crop_pixels(settings); !arguments_.output.empty() && !arguments_.replay)
        render::check_sides(arguments_.output, pixels.width(), pixels.height());
    return settings;
}

Ending wait_for(Job& job, ProgressDisplay& display, HeldInterrupts& held, bool keeps_part, std::size_t done, std::size_t all)
{
    constexpr auto kPatience = 800ms;
    std::optional<Clock::time_point> cancelled;
    while (!job.wait_for(50ms)) {
        Progress progress = job.progress();
        if (is_interrupted()) {
            if (keeps_part && progress.fraction > 0) held.allow_time();
            if (!cancelled) {
                job.cancel();
                display.announce(keeps_part
                                     ? "stopping: what is finished is written; another signal ends the process at once"
                                     : "stopping");
                cancelled = Clock::now();
            }
            // If a part of the picture is done, it is worth waiting for; otherwise the process waits no longer than a
            // person does.
            if (!keeps_part || (progress.fraction <= 0 && Clock::now() - *cancelled > kPatience)) return Ending::Abandoned;
        }
        // The remaining time of a sequence is estimated from its frames so far.
        if (progress.seconds_left >= 0 && progress.fraction > 0) {
            const double frame_seconds = progress.seconds_left / std::max(1 - progress.fraction, 1e-6);
            progress.seconds_left += frame_seconds * double(all - done - 1);
        }
        progress.fraction = (double(done) + progress.fraction) / double(all);
        display.show(progress);
    }
    if (!is_interrupted()) return Ending::Whole;
    held.allow_time();
    return Ending::Interrupted;
}

void write_stats(const RenderArguments& a, HeldInterrupts& held, const std::function<std::string()>& json)
{
    if (a.stats.empty()) return;
    if (is_written_directly(a.stats)) held.limit();
    else held.allow_time();
    write_whole(a.stats, json());
}

void check_outputs(const RenderArguments& a, std::span<const std::filesystem::path> pictures,
                   std::span<const std::filesystem::path> all)
{
    std::vector<std::filesystem::path> outputs(pictures.begin(), pictures.end());
    if (!a.stats.empty()) outputs.push_back(a.stats);
    remove_unfinished(outputs);
    const std::filesystem::path& any = pictures.empty() ? all.front() : pictures.front();
    const bool needs_codec = render::required_picture_format(any).needs_codec;
    check_folder(any);
    if (needs_codec) check_picture_codec();
    for (const std::filesystem::path& picture : pictures)
        if (std::error_code error;
            std::filesystem::exists(picture, error) && !std::filesystem::is_regular_file(picture, error))
            throw Error(picture.string(), "is there already and is not a file", {}, Error::Kind::Output);
    if (!a.stats.empty()) {
        if (a.progress == ProgressStyle::OpenJd && !a.quiet && is_standard_output(a.stats))
            throw error_without_file("statistics on standard output would be among the lines of --progress openjd",
                                     "--stats");
        check_whole(a.stats);
        require_older_statistics(a.stats);
    }
    const std::filesystem::path inputs[] = {a.scene, a.has_environment ? a.environment : std::filesystem::path()};
    refuse_inputs(outputs, inputs);
    refuse_statistics_among(all, a);
}

void check_inputs(const RenderArguments& a)
{
    if (!a.scene.empty()) required_scene_format(a.scene);
    if (!a.environment.empty()) require_readable(a.environment, "--environment");
}

Scene open_scene(const RenderArguments& a, std::span<const std::filesystem::path> pictures)
{
    check_inputs(a);  // before the scene is read, which may take long
    Scene scene = open_scene(a);
    std::vector<std::filesystem::path> outputs(pictures.begin(), pictures.end());
    if (!a.stats.empty()) outputs.push_back(a.stats);
    refuse_inputs(outputs, scene.files);
    return scene;
}

void print_notes(const Scene& scene)
{
    for (const std::string& note : scene.notes) std::fprintf(stderr, "occam: %s\n", printable_line(note).c_str());
}

void print_warnings(const std::vector<std::string>& warnings, bool all)
{
    constexpr std::size_t kShown = 5;
    const std::size_t shown = all ? warnings.size() : std::min(warnings.size(), kShown);
    for (std::size_t i = 0; i < shown; ++i)
        std::fprintf(stderr, "occam: warning: %s\n", printable_line(warnings[i]).c_str());
    if (shown < warnings.size()) std::fprintf(stderr, "occam: %zu more warnings; -v shows all\n", warnings.size() - shown);
}

void add_seconds(FrameStats& stats, double load, double edit, double write)
{
    stats.seconds.load = load;
    stats.seconds.edit = edit;
    stats.seconds.write = write;
    stats.seconds.total += load + edit + write;
}

void print_light(const FrameStats& stats)
{
    if (!stats.lights.has_default || !stats.lights.has_emitters) return;
    std::fprintf(stderr,
                 "occam: the glowing surfaces do not light what is seen, so daylight and a lamp are added "
                 "(--environment none leaves them out)\n");
}

void print_figures(const FrameStats& stats)
{
    const bool may_be_fewer = stats.image.least_samples < stats.image.spp || stats.settings.error > 0;
    const char* const at_most = may_be_fewer ? "at most " : "";
    std::fprintf(stderr, "occam: %dx%d, %s%d samples a pixel, %.2f s, %.2f million rays a second, checksum %016llx\n",
                 stats.image.width, stats.image.height, at_most, stats.image.spp, stats.seconds.total,
                 stats.rays.per_second * 1e-6, static_cast<unsigned long long>(stats.image.checksum));
}

}  // namespace occam::command
