// The workers that make a frame, and the trees in which they trace.
//
// Borrows   everything in FrameInputs.
// Threads   Crew::make() starts the workers and waits for them; each has a tracer of its own.
#pragma once

#include <memory>
#include <vector>

#include "accel/frame.h"
#include "accel/tracer.h"
#include "render/worker.h"

namespace occam::render {

/// Holds the tracers of a frame, one for each worker, and the trees that groups of workers share. They are made when they
/// are first asked for, and serve several crews, one after the other.
class FrameTracers {
public:
    FrameTracers(const accel::Frame& frame, const FrameInputs& in);

    /// Returns the tracer of a worker. No two threads may ask for the same.
    accel::Tracer& of(int worker);
    bool has(int worker) const noexcept { return tracers_[static_cast<std::size_t>(worker)] != nullptr; }
    /// Returns the tree that the worker shares with others, or null if it has one of its own.
    accel::SharedTree* tree_of(int worker) const noexcept;
    /// Returns the processor time that a worker has spent, in all crews.
    double& cpu_seconds_of(int worker) noexcept { return cpu_seconds_[static_cast<std::size_t>(worker)]; }

private:
    const accel::Frame& frame_;
    const FrameInputs& in_;
    std::vector<std::unique_ptr<accel::SharedTree>> trees_;
    std::vector<std::unique_ptr<accel::Tracer>> tracers_;
    std::vector<double> cpu_seconds_;
};

/// Holds the workers of a picture: of the frame's own, or of a small one that is made before it in the same trees.
class Crew {
public:
    Crew(const FrameContext& context, FrameTracers& tracers, const FrameInputs& in,
         std::chrono::steady_clock::time_point deadline);

    /// Renders all tiles until they have `target` samples a pixel, as far as time allows.
    void make(const std::vector<PixelRect>& all, int target, Film& film, FrameControl& control, FrameSums* sums);

    /// Adds the rays of the workers and the time that they took, with what their trees have cost in it.
    void count_rays_into(FrameStats& stats) const;
    /// Adds all that the workers and their trees have cost.
    void count_into(FrameStats& stats);

private:
    Worker& worker_of(int index);
    void make_tiles_of(int index, TileQueue& tiles, int target, Film& film, FrameControl& control, FrameSums* sums);

    const FrameContext& context_;
    FrameTracers& tracers_;
    const FrameInputs& in_;
    std::chrono::steady_clock::time_point deadline_;
    std::vector<std::unique_ptr<Worker>> workers_;  ///< made when they first find a tile
};

}  // namespace occam::render
