#include "render/crew.h"

#include <algorithm>

#include "base/cancellation.h"
#include "base/threads.h"

namespace occam::render {

FrameTracers::FrameTracers(const accel::Frame& frame, const FrameInputs& in)
    : frame_(frame), in_(in), tracers_(static_cast<std::size_t>(in.resources.threads)), cpu_seconds_(tracers_.size())
{
    const auto group = static_cast<std::size_t>(in.resources.workers_a_tree);
    for (std::size_t first = 0; group > 1 && first < tracers_.size(); first += group)
        trees_.push_back(
            std::make_unique<accel::SharedTree>(frame, in.memory.tracer_bytes * std::min(group, tracers_.size() - first)));
}

accel::Tracer& FrameTracers::of(int worker)
{
    std::unique_ptr<accel::Tracer>& tracer = tracers_[static_cast<std::size_t>(worker)];
    if (tracer) return *tracer;
    if (accel::SharedTree* const tree = tree_of(worker)) tracer = std::make_unique<accel::Tracer>(*tree);
    else tracer = std::make_unique<accel::Tracer>(frame_, in_.memory.tracer_bytes);
    return *tracer;
}

accel::SharedTree* FrameTracers::tree_of(int worker) const noexcept
{
    return trees_.empty() ? nullptr : trees_[static_cast<std::size_t>(worker / in_.resources.workers_a_tree)].get();
}

Crew::Crew(const FrameContext& context, FrameTracers& tracers, const FrameInputs& in,
           std::chrono::steady_clock::time_point deadline)
    : context_(context),
      tracers_(tracers),
      in_(in),
      deadline_(deadline),
      workers_(static_cast<std::size_t>(in.resources.threads))
{
}

Worker& Crew::worker_of(int index)
{
    std::unique_ptr<Worker>& worker = workers_[static_cast<std::size_t>(index)];
    if (!worker)
        worker = std::make_unique<Worker>(context_, tracers_.of(index), tracers_.cpu_seconds_of(index),
                                          in_.memory.batch_rays, deadline_);
    return *worker;
}

void Crew::make_tiles_of(int index, TileQueue& tiles, int target, Film& film, FrameControl& control, FrameSums* sums)
{
    auto tile = tiles.next(index);
    if (!tile) return;  // other workers have taken all tiles
    Worker& worker = worker_of(index);
    // Tiles with equally many samples are made together, so that a round of few samples still fills the batches.
    std::vector<PixelRect> group;
    int before = 0;
    const auto flush = [&] {
        const bool goes_on = group.empty() || worker.make(group, before, target, film, control, sums);
        group.clear();
        return goes_on;
    };
    for (; tile; tile = tiles.next(index)) {
        const FrameSums::Tile state = sums ? sums->tile(*tile) : FrameSums::Tile{};
        if (state.is_done || state.samples >= target) continue;
        if (state.samples != before && !flush()) return;
        before = state.samples;
        group.push_back(*tile);
        if (group.size() >= worker.tiles_at_once(target - before) && !flush()) return;
    }
    flush();
}

void Crew::make(const std::vector<PixelRect>& all, int target, Film& film, FrameControl& control, FrameSums* sums)
{
    const int threads = in_.resources.threads;
    TileQueue tiles(all, threads);
    // An error of one worker ends the frame, so the others stop where they are. They may not hide it by their own end.
    run_in_threads(threads, [&](int index) {
        try {
            make_tiles_of(index, tiles, target, film, control, sums);
        } catch (const Cancelled&) {
        } catch (...) {
            control.cancel();
            throw;
        }
    });
}

void Crew::count_rays_into(FrameStats& stats) const
{
    for (const std::unique_ptr<Worker>& worker : workers_)
        if (worker) worker->count_rays_into(stats);
}

void Crew::count_into(FrameStats& stats)
{
    count_rays_into(stats);
    const accel::SharedTree* counted = nullptr;
    for (int i = 0; i < in_.resources.threads; ++i) {
        if (!tracers_.has(i)) continue;
        worker_of(i).count_into(stats);
        const accel::SharedTree* tree = tracers_.tree_of(i);
        if (tree && tree != counted)
            Worker::count_building(tree->counters(), context_.scale.exponent(), stats, stats.workers.back());
        counted = tree;
    }
    stats.seconds.trace = std::max(
        0.0, stats.seconds.trace - stats.seconds.build - stats.seconds.tessellate - stats.seconds.phase_one);
}

}  // namespace occam::render
