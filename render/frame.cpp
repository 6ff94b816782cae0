#include "render/frame.h"

#include "base/cancellation.h"
#include "base/error_without_file.h"
#include "base/machine_memory.h"
#include "base/stopwatch.h"
#include "render/crew.h"
#include "render/exposure_sketch.h"
#include "render/film.h"
#include "render/frame_setup.h"
#include "render/frame_sums.h"
#include "render/tiles.h"
#include "scenegraph/content_hash.h"

namespace occam::render {
namespace {

// The memory is touched as soon as it is taken, so a picture that does not fit would stop the machine.
void refuse_beyond_machine(std::size_t bytes, const std::string& picture, const std::string& purpose)
{
    if (const std::size_t most = machine_memory_bytes() / 4 * 3; most > 0 && bytes > most)
        throw error_without_file(picture + " takes " + std::to_string(bytes >> 20) + " MB for " + purpose +
                                     ", and three quarters of the machine's memory are " + std::to_string(most >> 20) +
                                     " MB",
                                 "size", Error::Kind::Output);
}

// A frame that is stopped copies its sums to the checkpoint.
void refuse_if_too_large(const FrameInputs& in)
{
    refuse_beyond_machine(FrameSums::bytes_for(in.settings) * (in.keeps_checkpoint ? 2 : 1),
                          "a picture of this size that is made in rounds", "the sums of its pixels");
}

// Returns the sums of a frame that is made in rounds, or null for a frame that is made tile by tile. A frame is made in
// rounds if the settings ask for it, or if it has a deadline or a checkpoint. Its sums are taken beyond the memory budget,
// as its layers are: whoever asks for them would lose the frame without them.
std::unique_ptr<FrameSums> sums_of(const FrameInputs& in)
{
    const bool has_deadline = in.deadline != Clock::time_point::max();
    if (!in.settings.progressive && !has_deadline && in.checkpoint.empty()) return nullptr;
    refuse_if_too_large(in);
    return std::make_unique<FrameSums>(in.settings, in.camera);
}

// Returns a hash of what the picture shows, and of how much smaller textures are than their images: other budgets of
// textures may make another picture. The slots of nodes count where the picture shows them.
std::uint64_t scene_hash(const FrameInputs& in)
{
    const bool shows_slots = in.settings.has(Aov::Id) || in.settings.view == View::Face;
    return (shows_slots ? content_and_slots_hash(in.scene) : content_hash(in.scene)) ^ in.textures.halvings_hash();
}

// Develops what an earlier run has made, and sets the counts of samples in the picture to its own. Returns the number of
// its samples, counting one pixel of each tile.
std::size_t develop_all(const FrameSums& sums, const std::vector<PixelRect>& tiles, const Settings& settings, Film& film,
                        FrameStats::Image& counts)
{
    counts.samples = counts.samples_not_finite = 0;
    std::size_t done = 0;
    std::vector<PixelSums> pixels;
    std::vector<MatteSums> mattes[2];
    for (const PixelRect& tile : tiles) {
        const FrameSums::Tile state = sums.tile(tile);
        done += static_cast<std::size_t>(state.is_done ? settings.spp : state.samples);
        if (state.samples == 0) continue;
        pixels.clear(), mattes[0].clear(), mattes[1].clear();
        sums.load(tile, pixels, mattes);
        const std::vector<Pixel> places = pixels_of(tile);
        for (std::size_t i = 0; i < places.size(); ++i) {
            film.store(places[i].x, places[i].y, pixels[i]);
            counts.samples += static_cast<std::uint64_t>(pixels[i].count());
            counts.samples_not_finite += static_cast<std::uint64_t>(pixels[i].not_finite());
            for (int k : {0, 1})
                if (settings.has(kMattes[k]))
                    film.store(places[i].x, places[i].y, kMattes[k], mattes[k][i], pixels[i].weight());
        }
    }
    return done;
}

FrameResult make_frame(const FrameInputs& in, FrameControl& control, FrameStats& stats)
{
    check_layers(in.scene);  // before its lights are gathered, which takes long in a scene that is refused
    FrameSetup setup(in);
    stats.lights = {setup.lights.has_default(), setup.lights.meshes().any_emitter()};
    stats.tree = setup.frame.tree();

    const std::unique_ptr<FrameSums> sums = sums_of(in);  // first, since it may be too large
    Film film(in.settings);
    stats.memory.film_bytes = Film::bytes_for(in.settings);
    stats.memory.floor_bytes = in.memory.floor_bytes;
    stats.memory.queue_bytes = in.memory.queue_bytes * static_cast<std::size_t>(in.resources.threads);
    FrameTracers tracers(setup.frame, in);
    const std::vector<PixelRect> tiles = make_tiles(crop_pixels(in.settings));
    std::size_t done_before = 0;
    if (sums) {
        stats.memory.film_bytes += FrameSums::bytes_for(in.settings);
        if (!in.checkpoint.empty()) {
            sums->restore(in.checkpoint, scene_hash(in));
            done_before = develop_all(*sums, tiles, in.settings, film, stats.image);
        }
    }
    const auto sketch_start = Clock::now();
    set_limit_as_shown(in, setup, tracers, control, stats);
    const bool has_deadline = in.deadline != Clock::time_point::max();
    const auto deadline = has_deadline ? in.deadline + (Clock::now() - sketch_start) : in.deadline;
    Crew crew(setup.context, tracers, in, deadline);
    control.start_samples(tiles.size() * static_cast<std::size_t>(in.settings.spp), done_before);
    // The rounds take 1, 1, 2, 4, 8, ... samples, so that each doubles the number of samples of all pixels.
    const auto goes_on = [&] { return !control.is_cancelled() && !in.textures.has_failed() && Clock::now() < deadline; };
    for (int target = sums ? 1 : in.settings.spp; goes_on(); target *= 2) {
        crew.make(tiles, std::min(target, in.settings.spp), film, control, sums.get());
        if (target >= in.settings.spp) break;
    }
    crew.count_into(stats);
    stats.complete = control.is_whole();
    stats.image.least_samples = stats.complete ? in.settings.spp : sums ? sums->least_samples() : 0;
    FrameResult result{std::move(film).take(), {}, setup.context.clamp};
    // A frame that fails is not worth going on from before it has a sample.
    const bool is_worth_it = !in.textures.has_failed() || control.progress().fraction > 0;
    if (sums && !stats.complete && in.keeps_checkpoint && is_worth_it) result.checkpoint = sums->checkpoint(scene_hash(in));
    return result;
}

// Returns a frame that was cancelled before its workers began: what an earlier run has made of it.
FrameResult frame_so_far(const FrameInputs& in, FrameControl& control, FrameStats& stats)
{
    Film film(in.settings);
    if (!in.checkpoint.empty()) {
        FrameSums sums(in.settings, in.camera);
        sums.restore(in.checkpoint, scene_hash(in));
        const std::vector<PixelRect> tiles = make_tiles(crop_pixels(in.settings));
        const std::size_t done = develop_all(sums, tiles, in.settings, film, stats.image);
        control.start_samples(tiles.size() * static_cast<std::size_t>(in.settings.spp), done);
        stats.image.least_samples = sums.least_samples();
    }
    stats.complete = false;
    return {std::move(film).take(), std::string(in.checkpoint), in.settings.clamp};
}

}  // namespace

FrameResult render_frame(const FrameInputs& in, FrameControl& control, FrameStats& stats)
{
    refuse_beyond_machine(Film::bytes_for(in.settings), "a picture of this size", "its layers");
    const CancelScope scope(control);
    try {
        return make_frame(in, control, stats);
    } catch (const Cancelled&) {
        return frame_so_far(in, control, stats);  // workers end by themselves
    }
}

}  // namespace occam::render
