#include "render/frame.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <mutex>

#include "accel/frame.h"
#include "render/film.h"
#include "render/integrator.h"
#include "render/shade_point.h"
#include "render/tiles.h"
#include "shade/material_values.h"

namespace occam::render {
namespace {

using Clock = std::chrono::steady_clock;

// Rays that start together: enough for a tracer's packets and streams, few enough that a cancelled frame stops soon.
constexpr int kBatchRays = 4096;

// Error estimates of fewer samples say little.
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

// Nearest and farthest camera z of the scene's box.
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

// Makes tiles, one after the other, with what it owns.
class Worker {
public:
    Worker(const FrameContext& context, const accel::Frame& frame, std::size_t budget_bytes, Clock::time_point deadline)
        : context_(context), tracer_(frame, budget_bytes), integrator_(context), deadline_(deadline)
    {
    }

    /// False if it was stopped on the way: then nothing of the tile is kept.
    bool make(const PixelRect& tile, Film& film, const FrameControl& control)
    {
        const int pixels = tile.width() * tile.height();
        const int spp = context_.settings.spp;
        const int step = std::clamp(kBatchRays / pixels, 1, spp);
        sums_.assign(static_cast<std::size_t>(pixels), {});
        for (int k : {0, 1})
            if (context_.settings.has(kMattes[k])) mattes_[k].assign(static_cast<std::size_t>(pixels), {});
        const double cells = integrator_.counters().visible_cells;
        int first = 0;
        while (first < spp) {
            if (control.is_cancelled() || Clock::now() >= deadline_) return false;
            const int last = std::min({first + step, next_check(first), spp});
            trace(tile, first, last);
            first = last;
            if (last == next_check(last - 1) && is_good_enough()) break;
        }
        visible_cells_ += (integrator_.counters().visible_cells - cells) / first;
        const auto start = Clock::now();
        std::size_t i = 0;
        for (int y = tile.y0; y < tile.y1; ++y)
            for (int x = tile.x0; x < tile.x1; ++x) {
                not_finite_ += static_cast<std::uint64_t>(sums_[i].not_finite());
                film.store(x, y, sums_[i]);
                for (int k : {0, 1})
                    if (context_.settings.has(kMattes[k])) film.store(x, y, kMattes[k], mattes_[k][i], sums_[i].weight());
                ++i;
            }
        film_seconds_ += std::chrono::duration<double>(Clock::now() - start).count();
        return true;
    }

    void count_into(FrameStats& stats) const
    {
        const accel::TraceCounters& t = tracer_.counters();
        const IntegratorCounters& c = integrator_.counters();
        stats.rays.primary += c.rays.primary;
        stats.rays.shadow += c.rays.shadow;
        stats.rays.ao += c.rays.ao;
        stats.rays.glossy += c.rays.glossy;
        stats.rays.diffuse += c.rays.diffuse;
        stats.image.samples += samples_made_;
        stats.image.samples_not_finite += not_finite_;
        for (int l = 0; l < accel::TraceCounters::kLevels; ++l)
            if (t.micropolygons_of_level[l] > 0) stats.built.by_level[accel::TraceCounters::kFinestLevel + l] += t.micropolygons_of_level[l];
        stats.seconds.build += t.build_seconds;
        stats.seconds.tessellate += t.dice_seconds;
        stats.seconds.deform += t.deform.seconds;
        stats.seconds.trace += std::max(0.0, c.trace_seconds - t.build_seconds - t.dice_seconds - t.shade_seconds);
        stats.seconds.shade += c.shade_seconds + t.shade_seconds;
        stats.seconds.phase_one += t.shade_seconds;
        stats.seconds.film += film_seconds_;
        stats.built.kd_nodes += t.kd_nodes;
        stats.built.grids += t.grids;
        stats.built.micropolygons += t.micropolygons;
        stats.built.by_camera_rays += t.diced_for_camera;
        stats.built.by_shadow_rays += t.diced_for_occlusion;
        stats.built.visible_cells += visible_cells_;
        stats.built.faces_touched += t.faces_touched;
        stats.built.vertices_deformed += t.deform.vertices;
        stats.built.vertices_shaded += t.vertices_shaded;
        stats.built.vertices_looked_up += t.vertices_looked_up;
        stats.built.hits_looked_up += c.hits_looked_up;
        stats.memory.arena_peak_bytes += t.peak_bytes;
        stats.memory.flushes += t.flushes;
    }

private:
    // Samples a pixel at which its tile may end: powers of two. The points of so many are evenly laid out.
    int next_check(int after) const noexcept
    {
        if (!(context_.settings.error > 0)) return context_.settings.spp;
        int count = kLeastSamples;
        while (count <= after) count *= 2;
        return count;
    }

    // The root of the mean square over the tile: of a pixel alone, luck would decide.
    bool is_good_enough() const noexcept
    {
        if (!(context_.settings.error > 0)) return false;
        double sum = 0;
        for (const PixelSums& pixel : sums_) sum += double(pixel.relative_error()) * double(pixel.relative_error());
        const double most = double(context_.settings.error);
        return sum <= most * most * double(sums_.size());
    }

    // Pixel by pixel, a pixel's samples in order: neighbouring rays stay neighbours in the batch.
    void trace(const PixelRect& tile, int first, int last)
    {
        samples_.clear();
        for (int y = tile.y0; y < tile.y1; ++y)
            for (int x = tile.x0; x < tile.x1; ++x)
                for (int s = first; s < last; ++s) samples_.push_back({x, y, s});
        results_.resize(samples_.size());
        integrator_.run(tracer_, samples_, results_);

        const auto start = Clock::now();
        const auto per_pixel = static_cast<std::size_t>(last - first);
        for (std::size_t i = 0; i < samples_.size(); ++i) sums_[i / per_pixel].add(results_[i]);
        for (const MatteShare& share : integrator_.mattes()) {
            const double covers = double(share.coverage) * double(results_[share.sample].weight);
            for (int k : {0, 1})
                if (context_.settings.has(kMattes[k])) mattes_[k][share.sample / per_pixel].add(k ? share.material : share.object, covers);
        }
        samples_made_ += samples_.size();
        film_seconds_ += std::chrono::duration<double>(Clock::now() - start).count();
    }

    const FrameContext& context_;
    accel::Tracer tracer_;
    Integrator integrator_;
    Clock::time_point deadline_;
    double film_seconds_ = 0, visible_cells_ = 0;
    std::uint64_t samples_made_ = 0, not_finite_ = 0;
    std::vector<CameraSample> samples_;
    std::vector<SampleResult> results_;
    std::vector<PixelSums> sums_;
    std::vector<MatteSums> mattes_[2];
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

    Film film(in.settings);
    const int threads = in.resources.threads;
    TileQueue tiles(make_tiles(crop_pixels(in.settings)), threads);
    std::mutex stats_mutex;
    const auto work = [&](int index) {
        auto tile = tiles.next(index);
        if (!tile) return;  // another took all of it already
        Worker worker(context, frame, in.resources.memory_bytes / static_cast<std::size_t>(threads), in.deadline);
        for (; tile && worker.make(*tile, film, control); tile = tiles.next(index)) control.finish_tile();
        const std::lock_guard lock(stats_mutex);
        worker.count_into(stats);
    };

    control.start_tiles(tiles.size());
    const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    tbb::task_arena arena(threads);
    arena.execute([&] { tbb::parallel_for(0, threads, work, tbb::simple_partitioner()); });

    stats.complete = control.tiles_done() == tiles.size();
    return std::move(film).take();
}

}  // namespace occam::render
