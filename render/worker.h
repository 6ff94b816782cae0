// Renders the tiles of a frame, one after the other: one worker for each thread.
//
// Memory   queues of rays, within the worker's share of the memory budget.
// Threads  each worker belongs to one thread.
#pragma once

#include <chrono>
#include <span>
#include <vector>

#include "accel/frame.h"
#include "base/kept_blocks.h"
#include "render/film.h"
#include "render/frame.h"
#include "render/frame_sums.h"
#include "render/integrator.h"
#include "render/tiles.h"

namespace occam::render {

/// Renders tiles with an integrator of its own. Borrows the context and the tracer.
class Worker {
public:
    /// batch_rays   camera rays that are started together
    /// cpu_seconds  the processor time of the worker is added to it
    Worker(const FrameContext& context, accel::Tracer& tracer, double& cpu_seconds, int batch_rays,
           std::chrono::steady_clock::time_point deadline);

    /// Renders tiles until they have `target` samples a pixel. They begin with the `before` samples that `sums` holds, or
    /// with none if `sums` is null. Samples of unfinished tiles are kept in `sums`; without it they are dropped if the frame
    /// was cancelled. Returns false if it stopped before the target, because the frame was cancelled or is out of time.
    bool make(std::span<const PixelRect> tiles, int before, int target, Film& film, FrameControl& control, FrameSums* sums);

    /// Returns how many tiles fill a batch of rays with `samples` samples a pixel. If pixels may end early, the number of
    /// samples at which they do so first counts if it is smaller, and no more than four tiles are made together.
    std::size_t tiles_at_once(int samples) const noexcept;

    /// Adds the rays, and the time that tracing and shading them took.
    void count_rays_into(FrameStats& stats) const;
    /// Adds all other costs, those of the tracer with them.
    void count_into(FrameStats& stats) const;

    /// Adds what a tree has cost.
    /// exponent   that of the frame's scale: levels are counted as those of the world
    static void count_building(const accel::TraceCounters& t, int exponent, FrameStats& stats, FrameStats::Worker& worker);

private:
    bool make_samples(std::span<const PixelRect> tiles, int before, int target, Film& film, FrameControl& control,
                      FrameSums* kept);

    void load(std::span<const PixelRect> tiles, const FrameSums* kept);

    /// Counts the tiles of which no pixel goes on, and keeps the sums of all if `kept` is not null.
    /// made   samples of the pixels that go on
    /// Returns how many samples are finished, counting one pixel of each tile.
    std::size_t finish(std::span<const PixelRect> tiles, int before, int made, FrameSums* kept);

    std::uint64_t count_not_finite() const noexcept;

    /// Turns the sums of the tile into pixels.
    void develop(Film& film);

    /// Returns the next number of samples at which pixels may end: Settings::min_spp, twice as many, and so on. Where these
    /// are powers of two, their points are evenly distributed.
    int next_check(int after) const noexcept;
    bool is_check(int samples) const noexcept { return samples > 0 && samples == next_check(samples - 1); }

    /// Ends the pixels around which the error is below Settings::error (render/pixel_errors.h).
    void end_clean_pixels(std::span<const PixelRect> tiles);

    /// Traces samples [first, last) of each pixel that goes on, pixel by pixel and in their order, so that neighbouring rays
    /// stay neighbours in the batch. Returns false if the frame was cancelled meanwhile; the batch is then dropped.
    bool trace(int first, int last);
    /// Returns how many camera rays may be on their way together, so that the paths that they split into stay few.
    std::size_t most_rays() const noexcept;

    const FrameContext& context_;
    accel::Tracer& tracer_;
    double& cpu_seconds_;
    Integrator integrator_;
    int batch_rays_;
    std::chrono::steady_clock::time_point deadline_;
    double film_seconds_ = 0, visible_cells_ = 0;
    std::uint64_t samples_made_ = 0, not_finite_ = 0, tiles_ = 0;
    KeptVector<CameraSample> samples_;
    KeptVector<SampleResult> results_;
    KeptVector<Pixel> pixels_;         ///< pixels of the tiles
    KeptVector<std::uint32_t> going_;  ///< indices of those that go on, in their order
    std::vector<PixelSums> sums_;
    std::vector<MatteSums> mattes_[2];
    KeptVector<MatteShare> matte_shares_;  ///< of the batch
};

}  // namespace occam::render
