#include "render/worker.h"

#include <time.h>

#include <algorithm>

#include "base/cancellation.h"
#include "base/stopwatch.h"
#include "render/pixel_errors.h"

namespace occam::render {
namespace {

// Tiles that are made together from their first to their last sample cannot be shared by workers.
constexpr int kMostTilesThatEndEarly = 4;

double thread_seconds()
{
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace

Worker::Worker(const FrameContext& context, accel::Tracer& tracer, double& cpu_seconds, int batch_rays,
               Clock::time_point deadline)
    : context_(context),
      tracer_(tracer),
      cpu_seconds_(cpu_seconds),
      integrator_(context),
      batch_rays_(batch_rays),
      deadline_(deadline)
{
}

bool Worker::make(std::span<const PixelRect> tiles, int before, int target, Film& film, FrameControl& control,
                  FrameSums* sums)
{
    const CancelScope scope(control);
    const double start_seconds = thread_seconds();
    const bool is_whole = make_samples(tiles, before, target, film, control, sums);
    cpu_seconds_ += thread_seconds() - start_seconds;
    return is_whole;
}

std::size_t Worker::tiles_at_once(int samples) const noexcept
{
    const bool may_end_early = context_.settings.error > 0;
    const int next = std::min(samples, next_check(0));
    const int tiles = std::max(1, batch_rays_ / (next * kTileSide * kTileSide));
    return static_cast<std::size_t>(may_end_early ? std::min(tiles, kMostTilesThatEndEarly) : tiles);
}

void Worker::count_rays_into(FrameStats& stats) const
{
    const IntegratorCounters& c = integrator_.counters();
    stats.rays.primary += c.rays.primary;
    stats.rays.shadow += c.rays.shadow;
    stats.rays.ao += c.rays.ao;
    stats.rays.glossy += c.rays.glossy;
    stats.rays.diffuse += c.rays.diffuse;
    stats.seconds.trace += c.trace_seconds;
    stats.seconds.shade += c.shade_seconds;
}

void Worker::count_into(FrameStats& stats) const
{
    const accel::TraceCounters t = tracer_.counters();
    stats.image.samples += samples_made_;
    stats.image.samples_not_finite += not_finite_;
    stats.seconds.film += film_seconds_;
    stats.built.by_camera_rays += t.diced_for_camera;
    stats.built.by_shadow_rays += t.diced_for_occlusion;
    stats.built.visible_cells += visible_cells_;
    stats.built.hits_looked_up += integrator_.counters().hits_looked_up;
    stats.workers.push_back({.cpu_seconds = cpu_seconds_, .tiles = tiles_});
    count_building(t, context_.scale.exponent(), stats, stats.workers.back());
}

void Worker::count_building(const accel::TraceCounters& t, int exponent, FrameStats& stats, FrameStats::Worker& worker)
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

bool Worker::make_samples(std::span<const PixelRect> tiles, int before, int target, Film& film, FrameControl& control,
                          FrameSums* kept)
{
    const int spp = context_.settings.spp;
    load(tiles, kept);
    if (is_check(before)) end_clean_pixels(tiles);  // as they did when their last samples were made
    const std::uint64_t not_finite = count_not_finite(), samples_before = samples_made_;
    const double cells = integrator_.counters().visible_cells;
    FrameControl::Unfinished unfinished(control);
    int made = before;
    bool is_stopped = false;
    while (made < target && !going_.empty()) {
        is_stopped = control.is_cancelled() || context_.textures.has_failed() || Clock::now() >= deadline_;
        if (is_stopped) break;
        const int step = std::clamp(batch_rays_ / static_cast<int>(going_.size()), 1, spp);
        const int last = std::min({made + step, next_check(made), target});
        is_stopped = !trace(made, last);
        if (is_stopped) break;
        unfinished.add(tiles.size() * static_cast<std::size_t>(last - made));
        made = last;
        if (made == spp) going_.clear();
        else if (is_check(made)) end_clean_pixels(tiles);
    }
    // What was made since a texture proved unreadable may show what stands in for it.
    if (made == before || context_.textures.has_failed() || (!kept && control.is_cancelled())) return false;
    const std::uint64_t samples = kept ? pixels_.size() * std::uint64_t(spp) : samples_made_ - samples_before;
    visible_cells_ += (integrator_.counters().visible_cells - cells) * double(pixels_.size()) / double(samples);
    not_finite_ += count_not_finite() - not_finite;
    const std::size_t finished = finish(tiles, before, made, kept);
    develop(film);
    if (kept || going_.empty()) control.finish_samples(finished);
    return !is_stopped;
}

void Worker::load(std::span<const PixelRect> tiles, const FrameSums* kept)
{
    pixels_.clear();
    sums_.clear();
    going_.clear();
    for (std::vector<MatteSums>& mattes : mattes_) mattes.clear();
    for (const PixelRect& tile : tiles) {
        const std::vector<Pixel> pixels = pixels_of(tile);
        pixels_.insert(pixels_.end(), pixels.begin(), pixels.end());
        if (kept) kept->load(tile, sums_, mattes_);
        else sums_.resize(pixels_.size());
        for (std::size_t i = pixels_.size() - pixels.size(); i < pixels_.size(); ++i)
            if (!kept || sums_[i].count() == kept->tile(tile).samples) going_.push_back(static_cast<std::uint32_t>(i));
    }
    if (kept) return;
    for (int k : {0, 1})
        if (context_.settings.has(kMattes[k])) mattes_[k].assign(pixels_.size(), {});
}

std::size_t Worker::finish(std::span<const PixelRect> tiles, int before, int made, FrameSums* kept)
{
    std::size_t first = 0, finished = 0;
    for (const PixelRect& tile : tiles) {
        const std::size_t end = first + static_cast<std::size_t>(tile.width() * tile.height());
        const auto next = std::lower_bound(going_.begin(), going_.end(), first);
        const bool is_done = next == going_.end() || *next >= end;
        tiles_ += is_done;
        finished += static_cast<std::size_t>((is_done ? context_.settings.spp : made) - before);
        if (kept) kept->store(tile, {made, is_done}, sums_, mattes_, first);
        first = end;
    }
    return finished;
}

std::uint64_t Worker::count_not_finite() const noexcept
{
    std::uint64_t count = 0;
    for (const PixelSums& pixel : sums_) count += static_cast<std::uint64_t>(pixel.not_finite());
    return count;
}

void Worker::develop(Film& film)
{
    const Stopwatch watch(film_seconds_);
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
        const auto [x, y] = pixels_[i];
        film.store(x, y, sums_[i]);
        for (int k : {0, 1})
            if (context_.settings.has(kMattes[k])) film.store(x, y, kMattes[k], mattes_[k][i], sums_[i].weight());
    }
}

int Worker::next_check(int after) const noexcept
{
    if (!(context_.settings.error > 0)) return context_.settings.spp;
    int count = context_.settings.min_spp;
    while (count <= after) count *= 2;
    return count;
}

void Worker::end_clean_pixels(std::span<const PixelRect> tiles)
{
    std::vector<float> errors(pixels_.size());
    std::size_t first = 0;
    for (const PixelRect& tile : tiles) {
        const auto count = static_cast<std::size_t>(tile.width() * tile.height());
        errors_around(tile, std::span(pixels_).subspan(first, count), std::span(sums_).subspan(first, count),
                      std::span(errors).subspan(first, count));
        first += count;
    }
    std::erase_if(going_, [&](std::uint32_t i) { return errors[i] < context_.settings.error; });
}

std::size_t Worker::most_rays() const noexcept
{
    constexpr int kLeast = 16;
    return static_cast<std::size_t>(std::max(kLeast, batch_rays_ / integrator_.paths_of_a_camera_ray()));
}

bool Worker::trace(int first, int last)
{
    samples_.clear();
    for (const std::uint32_t i : going_)
        for (int s = first; s < last; ++s) samples_.push_back({pixels_[i].x, pixels_[i].y, s});
    results_.resize(samples_.size());
    const auto per_pixel = static_cast<std::size_t>(last - first);
    const std::size_t most = most_rays();
    matte_shares_.clear();
    for (std::size_t begin = 0; begin < samples_.size(); begin += most) {
        const std::size_t count = std::min(most, samples_.size() - begin);
        try {
            integrator_.run(tracer_, std::span(samples_).subspan(begin, count), std::span(results_).subspan(begin, count));
        } catch (const Cancelled&) {
            return false;
        }
        for (MatteShare share : integrator_.mattes()) {
            share.sample += static_cast<std::uint32_t>(begin);
            matte_shares_.push_back(share);
        }
    }
    const Stopwatch watch(film_seconds_);
    for (std::size_t i = 0; i < samples_.size(); ++i) sums_[going_[i / per_pixel]].add(results_[i]);
    // They came in the order in which they were shaded, which depends on the size of the batch: first the first surfaces of
    // many samples, and then the second ones.
    std::ranges::stable_sort(matte_shares_, {}, &MatteShare::sample);
    for (const MatteShare& share : matte_shares_) {
        const double covers = double(share.coverage) * double(results_[share.sample].weight);
        for (int k : {0, 1})
            if (context_.settings.has(kMattes[k]))
                mattes_[k][going_[share.sample / per_pixel]].add(k ? share.material : share.object, covers);
    }
    samples_made_ += samples_.size();
    return true;
}

}  // namespace occam::render
