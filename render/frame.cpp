#include "render/frame.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <time.h>

#include "accel/frame.h"
#include "render/film.h"
#include "render/integrator.h"
#include "render/shade_point.h"
#include "render/tiles.h"
#include "shade/material_values.h"

namespace occam::render {
namespace {

using Clock = std::chrono::steady_clock;

// Error estimates of fewer samples are unreliable.
constexpr int kLeastSamples = 16;

constexpr Aov kMattes[] = {Aov::CryptomatteObject, Aov::CryptomatteMaterial};

bool may_pass(const Scene& scene)
{
    bool found = false;
    const auto look = [&](const std::vector<MaterialId>& ids) {
        for (MaterialId id : ids)
            if (const Material* m = scene.find(id)) found |= shade::may_pass(*m);
    };
    scene.for_each_placement([&](NodeId, const Node& node, const Mat4d&) {
        look(node.materials);
        for (CageId id : node.cages)
            if (const CageSlot* slot = scene.find(id)) look(slot->cage.materials);
    });
    return found;
}

double thread_seconds()
{
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// Sets the nearest and farthest camera z of the scene's box.
void set_depth_range(FrameContext& context, const Box3d& bounds)
{
    if (bounds.is_empty()) return;
    double z_near = std::numeric_limits<double>::infinity(), z_far = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3d p(corner & 1 ? bounds.hi.x : bounds.lo.x, corner & 2 ? bounds.hi.y : bounds.lo.y,
                      corner & 4 ? bounds.hi.z : bounds.lo.z);
        const double z = std::max(0.0, context.camera.depth(p));
        z_near = std::min(z_near, z);
        z_far = std::max(z_far, z);
    }
    context.depth_near = static_cast<float>(z_near);
    context.depth_far = static_cast<float>(z_far);
}

// Renders tiles, one after the other, with its own tracer and integrator.
class Worker {
public:
    /// shared   null: the worker grows a tree of its own
    Worker(const FrameContext& context, const accel::Frame& frame, const MemoryPlan& memory, accel::SharedTree* shared,
           Clock::time_point deadline)
        : context_(context),
          tracer_(shared ? accel::Tracer(*shared) : accel::Tracer(frame, memory.tracer_bytes)),
          integrator_(context),
          batch_rays_(memory.batch_rays),
          deadline_(deadline)
    {
    }

    /// spp   samples a pixel; fewer than the picture's: what the tile shows until it is made in full
    /// False if it was stopped on the way: by the deadline, then the samples so far are kept; or cancelled, then nothing.
    bool make(const PixelRect& tile, int spp, Film& film, const FrameControl& control)
    {
        const double start_seconds = thread_seconds();
        const bool is_whole = make_samples(tile, spp, film, control);
        cpu_seconds_ += thread_seconds() - start_seconds;
        tiles_ += is_whole && spp == context_.settings.spp;
        return is_whole;
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
        count_building(t, stats, stats.workers.back());
    }

    /// What a tree has cost.
    static void count_building(const accel::TraceCounters& t, FrameStats& stats, FrameStats::Worker& worker)
    {
        for (int l = 0; l < accel::TraceCounters::kLevels; ++l)
            if (t.micropolygons_of_level[l] > 0)
                stats.built.by_level[accel::TraceCounters::kFinestLevel + l] += t.micropolygons_of_level[l];
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
    bool make_samples(const PixelRect& tile, int spp, Film& film, const FrameControl& control)
    {
        pixels_ = pixels_of(tile);
        const auto pixels = static_cast<int>(pixels_.size());
        const int step = std::clamp(batch_rays_ / pixels, 1, spp);
        bool is_late = false;
        sums_.assign(static_cast<std::size_t>(pixels), {});
        for (int k : {0, 1})
            if (context_.settings.has(kMattes[k])) mattes_[k].assign(static_cast<std::size_t>(pixels), {});
        const double cells = integrator_.counters().visible_cells;
        int first = 0;
        while (first < spp) {
            if (control.is_cancelled()) return false;
            is_late = Clock::now() >= deadline_;
            if (is_late && first == 0) return false;
            if (is_late) break;
            const int last = std::min({first + step, next_check(first), spp});
            trace(first, last);
            first = last;
            if (last == next_check(last - 1) && is_good_enough()) break;
        }
        if (spp == context_.settings.spp) visible_cells_ += (integrator_.counters().visible_cells - cells) / first;
        const auto start = Clock::now();
        for (std::size_t i = 0; i < pixels_.size(); ++i) {
            const auto [x, y] = pixels_[i];
            not_finite_ += static_cast<std::uint64_t>(sums_[i].not_finite());
            film.store(x, y, sums_[i]);
            for (int k : {0, 1})
                if (context_.settings.has(kMattes[k])) film.store(x, y, kMattes[k], mattes_[k][i], sums_[i].weight());
        }
        film_seconds_ += std::chrono::duration<double>(Clock::now() - start).count();
        return !is_late;
    }

    // Returns the next number of samples per pixel at which the tile may end. These are powers of two, because their
    // points are evenly distributed.
    int next_check(int after) const noexcept
    {
        if (!(context_.settings.error > 0)) return context_.settings.spp;
        int count = kLeastSamples;
        while (count <= after) count *= 2;
        return count;
    }

    // Tests the root mean square over the tile: for a single pixel, chance would decide.
    bool is_good_enough() const noexcept
    {
        if (!(context_.settings.error > 0)) return false;
        double sum = 0;
        for (const PixelSums& pixel : sums_) sum += double(pixel.relative_error()) * double(pixel.relative_error());
        const double most = double(context_.settings.error);
        return sum <= most * most * double(sums_.size());
    }

    // Pixel by pixel, a pixel's samples in order: neighbouring rays stay neighbours in the batch.
    void trace(int first, int last)
    {
        samples_.clear();
        for (const auto [x, y] : pixels_)
            for (int s = first; s < last; ++s) samples_.push_back({x, y, s});
        results_.resize(samples_.size());
        integrator_.run(tracer_, samples_, results_);

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
    std::vector<Pixel> pixels_;  ///< of the tile
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

    template <class Finished>
    void make(const std::vector<PixelRect>& all, int spp, Film& film, const FrameControl& control, Finished&& finished)
    {
        const int threads = in_.resources.threads;
        TileQueue tiles(all, threads);
        const auto work = [&](int index) {
            auto tile = tiles.next(index);
            if (!tile) return;  // another took all of it already
            std::unique_ptr<Worker>& worker = workers_[static_cast<std::size_t>(index)];
            if (!worker) worker = std::make_unique<Worker>(context_, frame_, in_.memory, tree_of(index), in_.deadline);
            for (; tile && worker->make(*tile, spp, film, control); tile = tiles.next(index)) finished();
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
                Worker::count_building(trees_[first / group]->counters(), stats, stats.workers[known]);
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

}  // namespace

Image render_frame(const FrameInputs& in, FrameControl& control, FrameStats& stats)
{
    CameraRays camera(in.camera, in.settings.width, in.settings.height, in.settings.spp);
    lod::LevelSettings levels = camera.levels(in.settings.shading_rate);
    if (in.settings.lod_camera) {
        const CameraRays other(*in.settings.lod_camera, in.settings.width, in.settings.height);
        camera.take_footprints_of(other);
        levels = other.levels(in.settings.shading_rate);
    }
    const PixelFilter filter(in.settings.filter, in.settings.filter_radius);
    const Sampler sampler(in.settings.seed, in.settings.spp, in.settings.jitter);
    const shade::FrameLights lights(in.scene, in.camera, in.textures, in.settings.sky, in.settings.sky_strength);
    FrameContext context{in.settings, camera, sampler, filter, lights, in.textures, may_pass(in.scene)};
    context.scene = &in.scene;
    set_depth_range(context, in.scene_bounds);
    constexpr lod::LevelMode kModes[] = {lod::LevelMode::PerRay, lod::LevelMode::PerInstance, lod::LevelMode::Frozen};
    levels.mode = kModes[static_cast<int>(in.settings.lod)];
    const shade::PhaseOne phase_one(in.textures);
    lod::VertexShading shading{nullptr, sample_width(in.settings.spp)};
    if (in.settings.shade_at == ShadeAt::Vertex) shading.shader = &phase_one;
    const accel::Frame frame(in.scene, in.topologies, levels, &in.textures, shading);

    context.shadow_batch = in.memory.shadow_batch;

    Film film(in.settings);
    stats.memory.film_bytes = film.bytes();
    stats.memory.floor_bytes = in.memory.floor_bytes;
    stats.memory.queue_bytes = in.memory.queue_bytes * static_cast<std::size_t>(in.resources.threads);
    Crew crew(context, frame, in);
    const std::vector<PixelRect> tiles = make_tiles(crop_pixels(in.settings));
    control.start_tiles(tiles.size());
    // What runs out of time shows a sample of each pixel first of all.
    if (in.deadline != Clock::time_point::max() && in.settings.spp > 1) crew.make(tiles, 1, film, control, [] {});
    crew.make(tiles, in.settings.spp, film, control, [&] { control.finish_tile(); });
    crew.count_into(stats);
    stats.complete = control.tiles_done() == tiles.size();
    return std::move(film).take();
}

}  // namespace occam::render
