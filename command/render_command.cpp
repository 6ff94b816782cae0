#include <algorithm>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string_view>

#include "arguments.h"
#include "base/printable.h"
#include "base/stopwatch.h"
#include "framing.h"
#include "interrupt.h"
#include "io/input_file.h"
#include "io/output_file.h"
#include "progress.h"
#include "recipe.h"
#include "render/frame_sums.h"
#include "small_picture.h"

namespace occam::command {
namespace {

std::filesystem::path checkpoint_of(const std::filesystem::path& picture)
{
    std::filesystem::path file = picture;
    return file += ".checkpoint";
}

// The file beside a picture from which the picture can be continued. Its first line is the note of the picture, and the
// engine's checkpoint follows. A file of that name that begins otherwise belongs to somebody else and stays as it is.
class CheckpointFile {
public:
    /// Throws Error if a checkpoint may be left and cannot be written.
    explicit CheckpointFile(const RenderArguments& a) : arguments_(a), file_(checkpoint_of(a.output))
    {
        if (a.replay) return;
        remove_unfinished(std::span(&file_, 1));
        if (!a.keeps_checkpoint()) return;
        check_output(file_);  // before minutes of work
        refuse_foreign();
    }

    /// Returns the checkpoint from which the picture continues; empty if it starts anew. Throws Error for the checkpoint of
    /// another picture, or if the picture starts anew, says that it stays.
    std::string read(const std::string& note, ProgressDisplay& display) const
    {
        if (!arguments_.resume && is_of_another(note))
            display.announce(file_.string() + " is that of another picture and stays" +
                             (arguments_.keeps_checkpoint() ? ", so this one leaves none" : ""));
        if (!arguments_.resume || !is_there()) return {};
        if (const std::string why = why_unreadable(file_); !why.empty()) throw Error(file_.string(), why);
        std::ifstream in(file_, std::ios::binary);
        std::string first;
        std::getline(in, first);
        if (first != note) throw Error(file_.string(), "belongs to other settings or another scene" + std::string(kAnew));
        return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    }

    /// Returns the figures of the frame when it is done. Throws Error: that of the frame, beside a checkpoint if a texture
    /// failed it, or if the engine refuses the checkpoint, one that names the file.
    FrameStats stats_of(const std::string& note, const Job& job) const
    try {
        return job.stats();
    } catch (const Error& error) {
        const std::string_view what = error.what();
        if (!what.starts_with(render::kTheCheckpoint)) {
            keep_of_failed(note, job);
            throw;
        }
        throw Error(file_.string(), std::string(what.substr(render::kTheCheckpoint.size())) + kAnew);
    }

    /// Writes the checkpoint of an unfinished picture, and removes that of a finished one. Returns true if it was written.
    bool write(const std::string& note, const Job& job) const
    {
        std::error_code ignored;
        if (job.stats().complete && note_there() == note) std::filesystem::remove(file_, ignored);
        return keep(note, job.checkpoint());
    }

private:
    static constexpr char kAnew[] = "; without --resume the picture is made anew";

    bool keep(const std::string& note, const std::string& checkpoint) const
    {
        if (checkpoint.empty() || !arguments_.keeps_checkpoint()) return false;
        refuse_foreign();
        if (is_of_another(note)) return false;
        OutputFile out(file_);
        out.append(note + "\n");
        out.append(checkpoint);
        out.publish();
        return true;
    }
    // Keeps what a frame had made before a texture failed it. That is the error to tell, whatever happens here.
    void keep_of_failed(const std::string& note, const Job& job) const
    {
        std::string checkpoint;
        try {
            checkpoint = job.checkpoint();
        } catch (const Error&) {
            return;  // the frame had made nothing, and this is its error again
        }
        try {
            if (keep(note, checkpoint))
                std::fprintf(stderr, "occam: %s holds what was made until then (--resume)\n",
                             printable_line(file_.string()).c_str());
        } catch (const std::exception& error) {
            std::fprintf(stderr, "occam: warning: %s\n", printable_line(error.what()).c_str());
        }
    }

    bool is_there() const
    {
        std::error_code ignored;
        return std::filesystem::exists(file_, ignored);
    }
    // Returns the note of the picture whose checkpoint the file is; empty if it is none. Where there is no file, nothing is
    // allocated: the picture is there already when this is asked for the last time.
    std::string note_there() const
    {
        constexpr std::size_t kLongestNote = 256;
        if (!is_there() || !why_unreadable(file_).empty()) return {};
        std::string head(kLongestNote, '\0');
        std::ifstream in(file_, std::ios::binary);
        in.read(head.data(), static_cast<std::streamsize>(head.size()));
        head.resize(static_cast<std::size_t>(in.gcount()));
        head.resize(std::min(head.find('\n'), head.size()));
        return is_recipe_note(head) ? head : std::string();
    }
    // Returns whether the checkpoint of another picture is there, which is neither removed nor replaced.
    bool is_of_another(const std::string& note) const
    {
        const std::string there = note_there();
        return !there.empty() && there != note;
    }
    void refuse_foreign() const
    {
        if (!is_there()) return;
        if (const std::string why = why_unreadable(file_); !why.empty()) throw Error(file_.string(), why);
        if (note_there().empty())
            throw Error(file_.string(), "is there already and is no checkpoint, so it is not replaced", "--checkpoint");
    }

    const RenderArguments& arguments_;
    std::filesystem::path file_;
};

// Writes and prints what is known of a frame that was made, which is not worth waiting for as its picture is.
void report(const RenderArguments& a, const FrameStats& stats, HeldInterrupts& held)
{
    write_stats(a, held, [&stats] { return render::to_json(stats); });
    held.limit();
    print_light(stats);
    print_warnings(stats.warnings, a.verbose);
    if (a.verbose) print_figures(stats);
}

// Returns the settings with the limit of scattered light that the format of the picture asks for.
Settings settings_of(const RenderArguments& a, Settings settings)
{
    if (!wants_display_clamp(a)) return settings;
    settings.clamp = display_clamp(a.write.exposure_ev.value_or(0));
    settings.clamp_as_shown = !a.write.exposure_ev;
    return settings;
}

// Returns whether nothing is in the picture yet, so that there is nothing to keep of a frame that was stopped.
bool is_empty(const Image& image)
{
    const std::vector<float>& pixels = image.layers().front().pixels;
    return std::all_of(pixels.begin(), pixels.end(), [](float value) { return value == 0; });
}

[[noreturn]] void end_without_picture(ProgressDisplay& display)
{
    display.end();
    end_interrupted();
}

int run_frame(const RenderArguments& a, ProgressDisplay& display)
{
    const std::filesystem::path files[] = {a.output, checkpoint_of(a.output)};
    if (!a.replay) {
        check_outputs(a, {&a.output, 1}, files);
        check_replaceable(a.output);
    }
    const CheckpointFile checkpoint_file(a);

    display.say("reading " + name_of_scene(a));
    const auto load_start = Clock::now();
    Scene scene = open_scene(a, {&a.output, a.replay ? 0u : 1u});
    const double load_seconds = seconds_since(load_start);
    display.end();
    print_notes(scene);

    const auto edit_start = Clock::now();
    Renderer renderer(a.resources);
    Framing framing(scene, a);
    const std::uint64_t stamp = scene_stamp(scene, a, renderer);
    if (a.frame || a.time || !a.clip.empty()) framing.fit_clip();  // the camera is that of a sequence
    framing.pose();
    const Camera camera = framing.open_shutter(framing.camera());
    Settings settings = settings_of(a, framing.settings(camera));
    if (a.replay) {
        print_warnings(scene.warnings, a.verbose);
        renderer.replay(scene, camera, settings, *a.replay, std::cout);
        return 0;
    }
    settings.progressive = a.keeps_checkpoint() || a.resume;
    WriteOptions write = a.write;
    write.exposure_seconds = framing.exposure_seconds();
    const std::string note = recipe_note(stamp, {a, a.write, settings, camera, framing.moment()});
    std::string checkpoint = checkpoint_file.read(note, display);
    if (a.resume) display.say(checkpoint.empty() ? "there is no checkpoint: starting anew" : "going on from the checkpoint");
    const double edit_seconds = seconds_since(edit_start);

    Job job = renderer.start(scene, camera, settings, std::move(checkpoint));
    HeldInterrupts held;
    const Ending ending = wait_for(job, display, held, true);
    if (ending == Ending::Abandoned) end_without_picture(display);
    FrameStats stats = checkpoint_file.stats_of(note, job);
    if (ending == Ending::Interrupted && is_empty(job.image())) end_without_picture(display);
    framing.note_idle_strength(stats);

    display.say("writing " + a.output.string());
    const auto write_start = Clock::now();
    write.note = note_in_file(note, stats.complete);
    held.allow_time();
    job.image().write(a.output, write);
    const bool can_go_on = checkpoint_file.write(note, job);
    held.limit();
    add_seconds(stats, load_seconds, edit_seconds, seconds_since(write_start));
    if (can_go_on)
        display.say("stopped at " + std::to_string(stats.image.least_samples) + " of " + std::to_string(settings.spp) +
                    " samples a pixel; --resume goes on");
    display.end();

    report(a, stats, held);
    return ending == Ending::Interrupted ? kInterruptedExit : 0;
}

}  // namespace

int run(const RenderArguments& a) { return run_with_display(a, run_frame); }

}  // namespace occam::command
