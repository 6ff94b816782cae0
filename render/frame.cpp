#include "render/frame.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <time.h>

#include <span>

#include "base/cancellation.h"
#include "render/film.h"
#include "render/frame_setup.h"
#include "render/frame_sums.h"
#include "render/tiles.h"

namespace occam::render {
namespace {

using Clock = std::chrono::steady_clock;

constexpr Aov kMattes[] = {Aov::CryptomatteObject, Aov::CryptomatteMaterial};

double thread_seconds()
{
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// Renders tiles, one after the other, with its own tracer and integrator.
class Worker {
public:
    /// shared   if null, the worker grows a tree of its own
    Worker(const FrameContext& context, const accel::Frame& frame, const MemoryPlan& memory, accel::SharedTree* shared,
           Clock::time_point deadline)
        : context_(context),
          tracer_(shared ? accel::Tracer(*shared) : accel::Tracer(frame, memory.tracer_bytes)),
          integrator_(context),
          batch_rays_(memory.batch_rays),
          deadline_(deadline)
    {
    }

    /// Renders tiles until they have `target` samples a pixel. They begin with the `before` samples that `sums` holds, or
    /// with none if `sums` is null. Samples of unfinished tiles are kept in `sums`; without it they are dropped if the frame
    /// was cancelled. Returns false if it stopped before the target, because the frame was cancelled or is out of time.
    bool make(std::span<const PixelRect> tiles, int before, int target, Film& film, FrameControl& control, FrameSums* sums)
    {
        const CancelScope scope(control);
        const double start_seconds = thread_seconds();
        const bool is_whole = make_samples(tiles, before, target, film, control, sums);
        cpu_seconds_ += thread_seconds() - start_seconds;
        return is_whole;
    }

    /// Returns how many tiles fill a batch of rays with `samples` samples a pixel. If tiles end by their error, it is one.
    std::size_t tiles_at_once(int samples) const noexcept
    {
        if (context_.settings.error > 0) return 1;
        return static_cast<std::size_t>(std::max(1, batch_rays_ / (samples * kTileSide * kTileSide)));
    }

    void count_into(FrameStats& stats) const
    {
        const accel::TraceCounters t = tracer_.counters();
        const IntegratorCounters& c = integrator_.counters();
        stats.rays.primary += c.rays.primary;
        stats.rays.shadow += c.rays.shadow;
        stats.rays.ao += c.rays.ao;
        stats.rays.glossy += c.rays.glossy;
        stats.rays.diffuse += c.rays.diffuse;
        stats.image.samples += samples_made_;
        stats.image.samples_not_finite += not_finite_;
        stats.seconds.trace += c.trace_seconds;
        stats.seconds.shade += c.shade_seconds;
        stats.seconds.film += film_seconds_;
        stats.built.by_camera_rays += t.diced_for_camera;
        stats.built.by_shadow_rays += t.diced_for_occlusion;
        stats.built.visible_cells += visible_cells_;
        stats.built.hits_looked_up += c.hits_looked_up;
        stats.workers.push_back({.cpu_seconds = cpu_seconds_, .tiles = tiles_});
        count_building(t, context_.scale.exponent(), stats, stats.workers.back());
    }

    /// Adds what a tree has cost.
    /// exponent   that of the frame's scale: levels are counted as those of the world
    static void count_building(const accel::TraceCounters& t, int exponent, FrameStats& stats, FrameStats::Worker& worker)
    {
        for (int l = 0; l < accel::TraceCounters::kLevels; ++l)
            if (t.micropolygons_of_level[l] > 0)
                stats.built.by_level[accel::TraceCounters::kFinestLevel + l + exponent] += t.micropolygons_of_level[l];
        stats.seconds.build += t.build_seconds;
        stats.seconds.tessellate += t.dice_seconds;
        stats.seconds.shade += t.shade_seconds;
        stats.seconds.phase_one += t.shade_seconds;
        stats.seconds.deform += t.deform.seconds;
        stats.built.kd_nodes += t.kd_nodes;
        stats.built.grids += t.grids;
        stats.built.micropolygons += t.micropolygons;
        stats.built.faces_touched += t.faces_touched;
        stats.built.vertices_deformed += t.deform.vertices;
        stats.built.vertices_shaded += t.vertices_shaded;
        stats.built.vertices_looked_up += t.vertices_looked_up;
        stats.memory.arena_peak_bytes += t.peak_bytes;
        stats.memory.flushes += t.flushes;
        worker.build_seconds += t.build_seconds + t.dice_seconds;
        worker.kd_nodes += t.kd_nodes;
        worker.grids += t.grids;
        worker.micropolygons += t.micropolygons;
        worker.arena_peak_bytes += t.peak_bytes;
    }

private:
    bool make_samples(std::span<const PixelRect> tiles, int before, int target, Film& film, FrameControl& control,
                      FrameSums* kept)
    {
        const int spp = context_.settings.spp;
        load(tiles, kept);
        const int step = std::clamp(batch_rays_ / static_cast<int>(pixels_.size()), 1, spp);
        const std::uint64_t not_finite = count_not_finite();
        const double cells = integrator_.counters().visible_cells;
        int made = before;
        bool is_done = false, is_stopped = false;
        while (made < target && !is_done) {
            is_stopped = control.is_cancelled() || Clock::now() >= deadline_;
            if (is_stopped) break;
            const int last = std::min({made + step, next_check(made), target});
            is_stopped = !trace(made, last);
            if (is_stopped) break;
            made = last;
            is_done = made == spp || (made == next_check(made - 1) && is_good_enough());
        }
        if (made == before || (!kept && control.is_cancelled())) return false;
        visible_cells_ += (integrator_.counters().visible_cells - cells) / (kept ? spp : made);
        not_finite_ += count_not_finite() - not_finite;
        tiles_ += is_done ? tiles.size() : 0;
        if (kept) keep(tiles, {made, is_done}, *kept);
        develop(film);
        if (kept || is_done)
            control.finish_samples(tiles.size() * static_cast<std::size_t>((is_done ? spp : made) - before));
        return !is_stopped;
    }

    void load(std::span<const PixelRect> tiles, const FrameSums* kept)
    {
        pixels_.clear();
        sums_.clear();
        for (std::vector<MatteSums>& mattes : mattes_) mattes.clear();
        for (const PixelRect& tile : tiles) {
            const std::vector<Pixel> pixels = pixels_of(tile);
            pixels_.insert(pixels_.end(), pixels.begin(), pixels.end());
            if (kept) kept->load(tile, sums_, mattes_);
        }
        if (kept) return;
        sums_.assign(pixels_.size(), {});
        for (int k : {0, 1})
            if (context_.settings.has(kMattes[k])) mattes_[k].assign(pixels_.size(), {});
    }

    void keep(std::span<const PixelRect> tiles, FrameSums::Tile state, FrameSums& kept) const
    {
        std::size_t first = 0;
        for (const PixelRect& tile : tiles) {
            kept.store(tile, state, sums_, mattes_, first);
            first += static_cast<std::size_t>(tile.width() * tile.height());
        }
    }

    std::uint64_t count_not_finite() const noexcept
    {
        std::uint64_t count = 0;
        for (const PixelSums& pixel : sums_) count += static_cast<std::uint64_t>(pixel.not_finite());
        return count;
    }

    // Turns the sums of the tile into pixels.
    void develop(Film& film)
    {
        const auto start = Clock::now();
        for (std::size_t i = 0; i < pixels_.size(); ++i) {
            const auto [x, y] = pixels_[i];
            film.store(x, y, sums_[i]);
            for (int k : {0, 1})
                if (context_.settings.has(kMattes[k])) film.store(x, y, kMattes[k], mattes_[k][i], sums_[i].weight());
        }
        film_seconds_ += std::chrono::duration<double>(Clock::now() - start).count();
    }

    // Returns the next number of samples per pixel at which the tile may end. These are powers of two, because their
    // points are evenly distributed.
    int next_check(int after) const noexcept
    {
        if (!(context_.settings.error > 0)) return context_.settings.spp;
        int count = kLeastErrorSamples;
        while (count <= after) count *= 2;
        return count;
    }

    // Tests the root mean square over the tile, since chance would decide for a single pixel.
    bool is_good_enough() const noexcept
    {
        if (!(context_.settings.error > 0)) return false;
        double sum = 0;
        for (const PixelSums& pixel : sums_) sum += double(pixel.relative_error()) * double(pixel.relative_error());
        const double most = double(context_.settings.error);
        return sum <= most * most * double(sums_.size());
    }

    // Traces samples [first, last) of each pixel, pixel by pixel and in their order, so that neighbouring rays stay
    // neighbours in the batch. Returns false if the frame was cancelled meanwhile; the batch is then dropped.
    bool trace(int first, int last)
    {
        samples_.clear();
        for (const auto [x, y] : pixels_)
            for (int s = first; s < last; ++s) samples_.push_back({x, y, s});
        results_.resize(samples_.size());
        try {
            integrator_.run(tracer_, samples_, results_);
        } catch (const Cancelled&) {
            return false;
        }
        const auto start = Clock::now();
        const auto per_pixel = static_cast<std::size_t>(last - first);
        for (std::size_t i = 0; i < samples_.size(); ++i) sums_[i / per_pixel].add(results_[i]);
        for (const MatteShare& share : integrator_.mattes()) {
            const double covers = double(share.coverage) * double(results_[share.sample].weight);
            for (int k : {0, 1})
                if (context_.settings.has(kMattes[k]))
                    mattes_[k][share.sample / per_pixel].add(k ? share.material : share.object, covers);
        }
        samples_made_ += samples_.size();
        film_seconds_ += std::chrono::duration<double>(Clock::now() - start).count();
        return true;
    }

    const FrameContext& context_;
    accel::Tracer tracer_;
    Integrator integrator_;
    int batch_rays_;
    Clock::time_point deadline_;
    double film_seconds_ = 0, visible_cells_ = 0, cpu_seconds_ = 0;
    std::uint64_t samples_made_ = 0, not_finite_ = 0, tiles_ = 0;
    std::vector<CameraSample> samples_;
    std::vector<SampleResult> results_;
    std::vector<Pixel> pixels_;  ///< pixels of the tile
    std::vector<PixelSums> sums_;
    std::vector<MatteSums> mattes_[2];
};

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
        const auto work = [&](int index) {
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
        const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
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
