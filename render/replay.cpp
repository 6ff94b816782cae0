#include "render/replay.h"

#include <ostream>

#include "base/error_without_file.h"
#include "render/exposure_sketch.h"
#include "render/path_log.h"

namespace occam::render {
namespace {

// Stands in for the tracer of an integrator: traces each ray alone, and writes what it does.
class ReplayTracer {
public:
    ReplayTracer(accel::Tracer& tracer, PathLog& log) : tracer_(tracer), log_(log) {}

    void closest(std::span<const accel::Ray> rays, std::span<accel::SurfaceHit> hits)
    {
        for (std::size_t i = 0; i < rays.size(); ++i) trace(rays[i], hits[i]);
    }
    accel::RayCost observe(const accel::Ray& ray, accel::SurfaceHit& hit) { return trace(ray, hit); }
    // Several hits of a ray are found as the frame finds them. The first of them is written as that of a ray of its own.
    void nearest(std::span<const accel::Ray> rays, int most, std::span<accel::SurfaceHit> hits,
                 std::span<accel::HitCount> counts)
    {
        tracer_.nearest(rays, most, hits, counts);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            accel::SurfaceHit first;
            trace(rays[i], first);
            for (int k = 1; k < counts[i].count; ++k) log_.found(hits[i * static_cast<std::size_t>(most) + std::size_t(k)]);
        }
    }
    void occluded(std::span<const accel::Ray> rays, std::span<std::uint8_t> occluded)
    {
        for (std::size_t i = 0; i < rays.size(); ++i) {
            accel::SurfaceHit hit;
            trace(rays[i], hit);
            occluded[i] = hit.is_hit();
        }
    }

private:
    accel::RayCost trace(const accel::Ray& ray, accel::SurfaceHit& hit)
    {
        log_.ray(ray);
        const accel::RayCost cost = tracer_.observe(ray, hit, &log_.out());
        log_.found(hit);
        log_.cost(cost);
        return cost;
    }

    accel::Tracer& tracer_;
    PathLog& log_;
};

void check(const CameraSample& sample, const Settings& settings)
{
    const PixelRect rect = crop_pixels(settings);
    if (sample.x < rect.x0 || sample.x >= rect.x1 || sample.y < rect.y0 || sample.y >= rect.y1)
        throw error_without_file("pixel " + std::to_string(sample.x) + "," + std::to_string(sample.y) +
                                     " lies outside of the picture, which has columns " + std::to_string(rect.x0) + " to " +
                                     std::to_string(rect.x1 - 1) + " and rows " + std::to_string(rect.y0) + " to " +
                                     std::to_string(rect.y1 - 1),
                                 "replay");
    if (sample.index < 0 || sample.index >= settings.spp)
        throw error_without_file("a pixel has samples 0 to " + std::to_string(settings.spp - 1) + ", but no sample " +
                                     std::to_string(sample.index),
                                 "replay");
}

}  // namespace

SampleResult replay_sample(const FrameInputs& in, const CameraSample& sample, std::ostream& out)
{
    check(sample, in.settings);
    FrameSetup setup(in);
    {
        FrameTracers tracers(setup.frame, in);
        FrameControl control;
        FrameStats stats;
        set_limit_as_shown(in, setup, tracers, control, stats);
    }
    PathLog log(out, in.scene, setup.scale);
    setup.context.log = &log;
    accel::Tracer tracer(setup.frame, in.memory.tracer_bytes);  // of its own, so that the text is the same every time
    ReplayTracer replay(tracer, log);
    Integrator integrator(setup.context);
    out << "sample " << sample.index << " of pixel " << sample.x << ',' << sample.y << '\n';
    SampleResult result;
    integrator.run(replay, {&sample, 1}, {&result, 1});
    out << "colour " << result.radiance << ", alpha " << result.alpha << '\n';
    return result;
}

}  // namespace occam::render
