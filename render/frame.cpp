#include "render/frame.h"

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <optional>
#include <span>

#include "base/cancellation.h"
#include "render/film.h"
#include "render/frame_setup.h"
#include "render/frame_sums.h"
#include "render/tiles.h"
#include "render/worker.h"

namespace occam::render {
namespace {

// TBB counts the processors when their number is first needed. If an allocation fails in that, every later call waits for
// ever for the count to end. So they are counted while this library is loaded.
const int kProcessors = tbb::info::default_concurrency();

using Clock = std::chrono::steady_clock;

// Holds the workers of a frame, and the trees that groups of them share.
class Crew {
public:
    Crew(const FrameContext& context, const accel::Frame& frame, const FrameInputs& in)
        : context_(context), frame_(frame), in_(in), workers_(static_cast<std::size_t>(in.resources.threads))
    {
        const auto group = static_cast<std::size_t>(in.resources.workers_a_tree);
        for (std::size_t first = 0; group > 1 && first < workers_.size(); first += group)
            trees_.push_back(std::make_unique<accel::SharedTree>(
                frame, in.memory.tracer_bytes * std::min(group, workers_.size() - first)));
    }

    /// Renders all tiles until they have `target` samples a pixel, as far as time allows.
    void make(const std::vector<PixelRect>& all, int target, Film& film, FrameControl& control, FrameSums* sums)
    {
        const int threads = in_.resources.threads;
        TileQueue tiles(all, threads);
        const auto render_tiles = [&](int index) {
            auto tile = tiles.next(index);
            if (!tile) return;  // other workers have taken all tiles
            std::unique_ptr<Worker>& worker = workers_[static_cast<std::size_t>(index)];
            if (!worker) worker = std::make_unique<Worker>(context_, frame_, in_.memory, tree_of(index), in_.deadline);
            // Tiles with equally many samples are made together, so that a round of few samples still fills the batches.
            std::vector<PixelRect> group;
            int before = 0;
            const auto flush = [&] {
                const bool goes_on = group.empty() || worker->make(group, before, target, film, control, sums);
                group.clear();
                return goes_on;
            };
            for (; tile; tile = tiles.next(index)) {
                const FrameSums::Tile state = sums ? sums->tile(*tile) : FrameSums::Tile{};
                if (state.is_done || state.samples >= target) continue;
                if (state.samples != before && !flush()) return;
                before = state.samples;
                group.push_back(*tile);
                if (group.size() >= worker->tiles_at_once(target - before) && !flush()) return;
            }
            flush();
        };
        // An error of one worker ends the frame, so the others stop where they are. They may not hide it by their own end.
        const auto work = [&](int index) {
            try {
                render_tiles(index);
            } catch (const Cancelled&) {
            } catch (...) {
                control.cancel();
                throw;
            }
        };
        // An arena alone cannot have more threads than there are processors.
        std::optional<tbb::global_control> allow;
        if (threads > kProcessors)
            allow.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
        tbb::task_arena arena(threads);
        arena.execute([&] { tbb::parallel_for(0, threads, work, tbb::simple_partitioner()); });
    }

    void count_into(FrameStats& stats) const
    {
        const auto group = static_cast<std::size_t>(in_.resources.workers_a_tree);
        for (std::size_t first = 0; first < workers_.size(); first += group) {
            const std::size_t known = stats.workers.size();
            for (std::size_t i = first; i < std::min(first + group, workers_.size()); ++i)
                if (workers_[i]) workers_[i]->count_into(stats);
            if (!trees_.empty() && stats.workers.size() > known)
                Worker::count_building(trees_[first / group]->counters(), context_.scale.exponent(), stats,
                                       stats.workers[known]);
        }
        stats.seconds.trace = std::max(
            0.0, stats.seconds.trace - stats.seconds.build - stats.seconds.tessellate - stats.seconds.phase_one);
    }

private:
    accel::SharedTree* tree_of(int worker) const
    {
        return trees_.empty() ? nullptr : trees_[static_cast<std::size_t>(worker / in_.resources.workers_a_tree)].get();
    }

    const FrameContext& context_;
    const accel::Frame& frame_;
    const FrameInputs& in_;
    std::vector<std::unique_ptr<accel::SharedTree>> trees_;
    std::vector<std::unique_ptr<Worker>> workers_;  ///< made when they first find a tile
};

// Returns the sums of a frame that is made in rounds, or null for a frame that is made tile by tile. A frame with a deadline
// or a checkpoint is always made in rounds. Any other one is if the settings ask for it and its sums fit in the memory
// budget.
std::unique_ptr<FrameSums> sums_of(const FrameInputs& in)
{
    const bool has_to = in.deadline != Clock::time_point::max() || !in.checkpoint.empty();
    const bool is_wanted = in.settings.progressive && FrameSums::bytes_for(in.settings) <= in.resources.memory_bytes;
    if (!has_to && !is_wanted) return nullptr;
    return std::make_unique<FrameSums>(in.settings, in.camera);
}

// Develops what an earlier run has made. Returns the number of its samples, counting one pixel of each tile.
std::size_t develop_all(const FrameSums& sums, const std::vector<PixelRect>& tiles, const Settings& settings, Film& film)
{
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
    const FrameSetup setup(in);
    stats.lights = {setup.lights.has_default(), setup.lights.meshes().any_emitter()};
    stats.tree = setup.frame.tree();

    Film film(in.settings);
    stats.memory.film_bytes = film.bytes();
    stats.memory.floor_bytes = in.memory.floor_bytes;
    stats.memory.queue_bytes = in.memory.queue_bytes * static_cast<std::size_t>(in.resources.threads);
    Crew crew(setup.context, setup.frame, in);
    const std::vector<PixelRect> tiles = make_tiles(crop_pixels(in.settings));
    const std::unique_ptr<FrameSums> sums = sums_of(in);
    std::size_t done_before = 0;
    if (sums) {
        stats.memory.film_bytes += FrameSums::bytes_for(in.settings);
        if (!in.checkpoint.empty()) {
            sums->restore(in.checkpoint);
            done_before = develop_all(*sums, tiles, in.settings, film);
        }
    }
    control.start_samples(tiles.size() * static_cast<std::size_t>(in.settings.spp), done_before);
    // The rounds take 1, 1, 2, 4, 8, ... samples, so that each doubles the number of samples of all pixels.
    for (int target = sums ? 1 : in.settings.spp; !control.is_cancelled() && Clock::now() < in.deadline; target *= 2) {
        crew.make(tiles, std::min(target, in.settings.spp), film, control, sums.get());
        if (target >= in.settings.spp) break;
    }
    crew.count_into(stats);
    stats.complete = control.is_whole();
    stats.image.least_samples = stats.complete ? in.settings.spp : sums ? sums->least_samples() : 0;
    FrameResult result{std::move(film).take(), {}};
    if (sums && !stats.complete) result.checkpoint = sums->checkpoint();
    return result;
}

}  // namespace

FrameResult render_frame(const FrameInputs& in, FrameControl& control, FrameStats& stats)
{
    const CancelScope scope(control);
    try {
        return make_frame(in, control, stats);
    } catch (const Cancelled&) {
        // Workers end by themselves: it was cancelled before the first of them began.
        stats.complete = false;
        return {Film(in.settings).take(), std::string(in.checkpoint)};
    }
}

}  // namespace occam::render
