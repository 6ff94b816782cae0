// Renders a sequence, one frame after the other in one process, so that textures and topology are made once.
//
// A frame is either complete or absent: pictures appear under their names when they are finished (Image::write). So a run
// that was killed can be started again with the same arguments, and continues with the first frame that is missing.
#include <set>

#include "arguments.h"
#include "base/printable.h"
#include "base/stopwatch.h"
#include "framing.h"
#include "interrupt.h"
#include "io/output_file.h"
#include "progress.h"
#include "recipe.h"
#include "small_picture.h"

namespace occam::command {
namespace {

namespace fs = std::filesystem;

// Collects the statistics of frames in a JSON list, each with the number of its frame.
class SequenceStats {
public:
    void add(int frame, const FrameStats& stats)
    {
        const std::string object = render::to_json(stats);
        text_ += (text_.empty() ? "[\n{\"frame\": " : ",\n{\"frame\": ") + std::to_string(frame) + "," +
                 object.substr(object.find('{') + 1);
    }
    bool is_empty() const { return text_.empty(); }
    std::string text() const { return text_.empty() ? "[]\n" : text_ + "]\n"; }

private:
    std::string text_;
};

// Holds what is chosen once for a whole sequence, so that it does not flicker.
struct Chosen {
    float exposure = 0;                 ///< the mean of what the measured frames ask for
    std::optional<bool> default_light;  ///< what most of them ask for; none: the scene has no emissive surfaces
};

// Measures small pictures of the first, the middle and the last frame. The choice depends on the list of frames alone, so
// all shards find the same one.
Chosen measure(const AnimateArguments& a, Framing& framing, Scene& scene, Renderer& renderer)
{
    Chosen chosen;
    if (a.settings.view != View::Beauty) return chosen;
    constexpr int kFrames = 3;
    const std::size_t last = a.frames.size() - 1;
    while (true) {
        int with_default = 0;
        bool has_emitters = false;
        chosen.exposure = 0;
        for (const std::size_t at : {std::size_t(0), last / 2, last}) {
            framing.pose(a.frames[at]);
            const Camera camera = framing.camera();
            Settings settings = framing.settings(camera);
            settings.default_light = chosen.default_light;
            const Measured found = measure_small(settings, camera, scene, renderer);
            chosen.exposure += found.exposure / kFrames;
            with_default += found.has_default;
            has_emitters |= found.has_emitters;
        }
        if (!has_emitters || chosen.default_light) return chosen;
        chosen.default_light = 2 * with_default > kFrames;
        if (with_default % kFrames == 0) return chosen;  // All agree, so the exposure is that of the choice.
    }
}

// Returns those of `warnings` that are not known yet, and adds them to the known ones.
std::vector<std::string> new_ones(const std::vector<std::string>& warnings, std::set<std::string>& known)
{
    std::vector<std::string> fresh;
    for (const std::string& line : warnings)
        if (known.insert(line).second) fresh.push_back(line);
    return fresh;
}

// Knows what a sequence is made from, and which of its frames exist already.
class Sequence {
public:
    Sequence(const AnimateArguments& arguments, Scene& scene, Renderer& renderer)
        : arguments_(arguments),
          write_(arguments.write),
          framing_(scene, arguments),
          stamp_(scene_stamp(scene, arguments, renderer))
    {
        framing_.fit_clip();
        const bool needs_exposure = !write_.exposure_ev && Image::is_for_display(arguments.output);
        is_exposure_measured_ = needs_exposure;
        if (needs_exposure || scene.contents().has(Contents::Emitters)) {
            const Chosen chosen = measure(arguments, framing_, scene, renderer);
            default_light_ = chosen.default_light;
            if (needs_exposure) write_.exposure_ev = chosen.exposure;
        }
        if (wants_display_clamp(arguments)) clamp_ = display_clamp(write_.exposure_ev.value_or(0));
    }
    Framing& framing() { return framing_; }
    /// Returns the settings of all frames, with the default light and the limit of scattered light of the sequence.
    Settings settings(const Camera& camera) const
    {
        Settings settings = framing_.settings(camera);
        settings.default_light = default_light_;
        if (clamp_) settings.clamp = *clamp_;
        return settings;
    }
    /// Returns the options of all frames, with the exposure of the sequence.
    const WriteOptions& write_options() const { return write_; }

    std::string note(int frame, const Settings& settings, const Camera& camera) const
    {
        return recipe_note(stamp_, {arguments_, write_, settings, camera, framing_.moment(frame)});
    }

    /// Returns the frames that have to be made. A file that is not a whole picture is made again, with a warning, and stays
    /// until then. Throws Error for a whole picture that was made with other settings or from another scene or says
    /// nothing of them, and for a file that cannot be read or has to be replaced and cannot be.
    std::vector<int> missing(const std::vector<int>& frames)
    {
        std::vector<int> todo;
        for (const int frame : frames) {
            const fs::path file = arguments_.pattern.file(frame);
            if (std::error_code ignored; arguments_.overwrite || !fs::exists(file, ignored)) {
                check_replaceable(file);
                todo.push_back(frame);
                continue;
            }
            framing_.pose(frame);
            const Camera camera = framing_.camera();
            const Settings settings = this->settings(camera);
            const FoundPicture found = look_for(file, settings, note(frame, settings, camera));
            if (found.state != FoundPicture::State::Same && found.state != FoundPicture::State::Broken) refuse(file, found);
            if (found.state == FoundPicture::State::Broken) {
                check_replaceable(file);
                std::fprintf(stderr, "occam: warning: %s; it is made again\n", found.why.c_str());
                made_again_.insert(frame);
            }
            if (found.state != FoundPicture::State::Same) todo.push_back(frame);
        }
        return todo;
    }
    /// Returns whether another process has made a missing frame in the meantime. Throws Error if it did so with other
    /// settings or from another scene.
    bool is_made_by_now(int frame, const Settings& settings, const Camera& camera) const
    {
        using State = FoundPicture::State;
        if (arguments_.overwrite || made_again_.contains(frame)) return false;
        const fs::path file = arguments_.pattern.file(frame);
        const FoundPicture found = look_for(file, settings, note(frame, settings, camera));
        if (found.state != State::Missing && found.state != State::Same && found.state != State::Broken) refuse(file, found);
        return found.state == State::Same;
    }

private:
    [[noreturn]] void refuse(const fs::path& file, const FoundPicture& found) const
    {
        const bool may_be_exposure = is_exposure_measured_ && found.state == FoundPicture::State::OtherRecipe;
        throw Error(file.string(),
                    "is there already, and " + found.why +
                        (may_be_exposure ? ", or with the exposure that another list of frames asks for (--exposure)" : "") +
                        "; --overwrite makes it again");
    }

    const AnimateArguments& arguments_;
    WriteOptions write_;
    bool is_exposure_measured_ = false;
    Framing framing_;
    std::uint64_t stamp_;  ///< of the scene as it is framed
    std::optional<bool> default_light_;
    std::optional<float> clamp_;
    std::set<int> made_again_;
};

std::vector<fs::path> files_of(const FramePattern& pattern, const std::vector<int>& frames)
{
    std::vector<fs::path> files;
    for (const int frame : frames) files.push_back(pattern.file(frame));
    return files;
}

/// Returns how many frames are there, and says so.
std::size_t count_what_is_there(std::size_t missing, std::size_t all, ProgressDisplay& display)
{
    const std::size_t done = all - missing;
    if (done > 0)
        display.say(std::to_string(done) + " of " + std::to_string(all) + " frames are there, whole and of these settings" +
                    (done == all ? ": nothing to do" : ""));
    return done;
}

// Says which part of the sequence is made where the variables of a batch system decide it, of which a person may not know.
void say_part(const AnimateArguments& a)
{
    if (a.is_slurms_shard_unclear)
        std::fprintf(
            stderr,
            "occam: Slurm's array variables do not say which part of the sequence is this task's (SLURM_ARRAY_TASK_ID; a "
            "list of tasks must have even steps), so all of it is made; --shard K/N chooses a part\n");
    if (!a.is_slurms_shard || a.shard.count == 1) return;
    std::fprintf(stderr,
                 "occam: part %d of %d of the sequence is made, since Slurm's array variables say so (SLURM_ARRAY_TASK_ID); "
                 "--shard 1/1 makes all of it\n",
                 a.shard.index, a.shard.count);
}

// What the frames of a sequence are made with.
struct SequenceParts {
    const AnimateArguments& arguments;
    ProgressDisplay& display;
    Scene& scene;
    Renderer& renderer;
    Sequence& sequence;
    HeldInterrupts& held;
    std::size_t frame_count;
    double load_seconds;  // they count for the first frame
};

// Makes the frames that are missing, when `done` others are there, until one is interrupted. Adds their statistics to `all`.
void make_frames(SequenceParts parts, const std::vector<int>& missing, std::size_t done, SequenceStats& all)
{
    auto& [a, display, scene, renderer, sequence, held, frame_count, load_seconds] = parts;
    Framing& framing = sequence.framing();
    std::set<std::string> known_warnings;  // warnings of the frames so far; each is printed once
    for (const int frame : missing) {
        if (is_interrupted()) return;
        const fs::path file = a.pattern.file(frame);
        const auto edit_start = Clock::now();
        framing.pose(frame);
        const Camera camera = framing.open_shutter(framing.camera(), frame);
        const double edit_seconds = seconds_since(edit_start);
        const Settings settings = sequence.settings(camera);
        if (sequence.is_made_by_now(frame, settings, camera)) {
            ++done;
            continue;
        }
        display.set_subject("frame " + std::to_string(frame) + " (" + std::to_string(done + 1) + " of " +
                            std::to_string(frame_count) + ")");
        Job job = renderer.start(scene, camera, settings);
        // An interrupted frame is not written, since a frame is either complete or absent.
        if (wait_for(job, display, held, false, done, frame_count) != Ending::Whole) {
            display.end();
            write_stats(a, held, [&all] { return all.text(); });
            end_interrupted();
        }
        FrameStats stats = job.stats();
        framing.note_idle_strength(stats);
        const auto write_start = Clock::now();
        WriteOptions write = sequence.write_options();
        write.exposure_seconds = framing.exposure_seconds();
        write.note = note_in_file(sequence.note(frame, settings, camera), stats.complete);
        held.allow_time();
        job.image().write(file, write);
        held.limit();
        add_seconds(stats, load_seconds, edit_seconds, seconds_since(write_start));
        load_seconds = 0;
        if (!a.stats.empty()) all.add(frame, stats);
        ++done;
        display.finish_part(done, frame_count, file.string());
        display.end();
        if (frame == missing.front()) print_light(stats);
        print_warnings(new_ones(stats.warnings, known_warnings), a.verbose);
        if (a.verbose) print_figures(stats);
    }
}

// Ends a part of a sequence that has fewer frames than parts. The scene is not read, which may take long.
void end_part_without_frames(const AnimateArguments& a, ProgressDisplay& display)
{
    check_inputs(a);
    display.announce("part " + std::to_string(a.shard.index) + " of " + std::to_string(a.shard.count) +
                     " of the sequence has no frames: nothing to do");
    HeldInterrupts held;
    write_stats(a, held, [] { return SequenceStats().text(); });
}

int run_sequence(const AnimateArguments& a, ProgressDisplay& display)
{
    const std::vector<int> frames = a.shard.of(a.frames);
    check_outputs(a, files_of(a.pattern, frames), files_of(a.pattern, a.frames));
    say_part(a);
    if (frames.empty()) {
        end_part_without_frames(a, display);
        return 0;
    }

    display.say("reading " + name_of_scene(a));
    const auto load_start = Clock::now();
    Scene scene = open_scene(a, files_of(a.pattern, frames));
    const double load_seconds = seconds_since(load_start);
    display.end();
    print_notes(scene);
    Renderer renderer(a.resources);
    Sequence sequence(a, scene, renderer);
    sequence.framing().note_stillness("all frames are alike");
    const std::vector<int> missing = sequence.missing(frames);
    const std::size_t done = count_what_is_there(missing.size(), frames.size(), display);

    SequenceStats all;
    HeldInterrupts held;
    try {
        make_frames({a, display, scene, renderer, sequence, held, frames.size(), load_seconds}, missing, done, all);
    } catch (...) {
        // The frames that are finished have their statistics, and what ended the run is what is reported.
        try {
            if (!all.is_empty()) write_stats(a, held, [&all] { return all.text(); });
        } catch (const std::exception& error) {
            std::fprintf(stderr, "occam: %s\n", printable_line(error.what()).c_str());
        }
        throw;
    }
    display.end();
    write_stats(a, held, [&all] { return all.text(); });
    return is_interrupted() ? kInterruptedExit : 0;
}

}  // namespace

int run(const AnimateArguments& a) { return run_with_display(a, run_sequence); }

}  // namespace occam::command
