#include "render/worker.h"

#include <time.h>

#include <algorithm>

#include "base/cancellation.h"
#include "base/stopwatch.h"

namespace occam::render {
namespace {

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
    if (context_.settings.error > 0) return 1;
    return static_cast<std::size_t>(std::max(1, batch_rays_ / (samples * kTileSide * kTileSide)));
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
    if (kept || is_done) control.finish_samples(tiles.size() * static_cast<std::size_t>((is_done ? spp : made) - before));
    return !is_stopped;
}

void Worker::load(std::span<const PixelRect> tiles, const FrameSums* kept)
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

void Worker::keep(std::span<const PixelRect> tiles, FrameSums::Tile state, FrameSums& kept) const
{
    std::size_t first = 0;
    for (const PixelRect& tile : tiles) {
        kept.store(tile, state, sums_, mattes_, first);
        first += static_cast<std::size_t>(tile.width() * tile.height());
    }
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
    int count = kLeastErrorSamples;
    while (count <= after) count *= 2;
    return count;
}

bool Worker::is_good_enough() const noexcept
{
    if (!(context_.settings.error > 0)) return false;
    double sum = 0;
    for (const PixelSums& pixel : sums_) sum += double(pixel.relative_error()) * double(pixel.relative_error());
    const double most = double(context_.settings.error);
    return sum <= most * most * double(sums_.size());
}

bool Worker::trace(int first, int last)
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
    const Stopwatch watch(film_seconds_);
    const auto per_pixel = static_cast<std::size_t>(last - first);
    for (std::size_t i = 0; i < samples_.size(); ++i) sums_[i / per_pixel].add(results_[i]);
    for (const MatteShare& share : integrator_.mattes()) {
        const double covers = double(share.coverage) * double(results_[share.sample].weight);
        for (int k : {0, 1})
            if (context_.settings.has(kMattes[k]))
                mattes_[k][share.sample / per_pixel].add(k ? share.material : share.object, covers);
    }
    samples_made_ += samples_.size();
    return true;
}

}  // namespace occam::render
