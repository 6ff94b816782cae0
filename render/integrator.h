// From camera samples to what they bring back: a wavefront over the samples of a tile. Shoot all, shade all, extend all.
//
// Direct light only. A surface that blends lets the rest of the ray through, and the ray is shot again from there, in order
// of t. A sample's sums are made in an order that depends on the sample alone: layer by layer, light by light; so neither
// the size of a batch nor the budget of a tracer can change them.
//
// Threads  one integrator a worker; the context is shared and const.
#pragma once

#include <chrono>
#include <span>
#include <vector>

#include "accel/tracer.h"
#include "render/camera_rays.h"
#include "render/film.h"
#include "render/sampler.h"
#include "render/settings.h"
#include "shade/direct.h"

namespace occam::render {

/// What all workers read.
struct FrameContext {
    const Settings& settings;
    const CameraRays& camera;
    const Sampler& sampler;
    const shade::FrameLights& lights;
    const TextureStore& textures;
    bool has_blending = false;            ///< some material of the scene lets light through
    float depth_near = 0, depth_far = 1;  ///< camera z of the scene, for View::Depth
};

struct CameraSample {
    int x = 0, y = 0;  ///< pixel of the whole frame
    int index = 0;     ///< of the pixel's samples
};

struct IntegratorCounters {
    std::uint64_t primary = 0, shadow = 0;
    double trace_seconds = 0, shade_seconds = 0;
};

/// Surfaces that a ray may pass through before the rest of its light is dropped.
inline constexpr int kMaxBlendLayers = 32;
/// Lights tried at a hit. A scene with more has them sampled, one from each sixteenth of the list.
inline constexpr int kMaxLightsPerHit = 16;
/// Shadow rays that may wait before they are traced: bounds the memory of a batch.
inline constexpr std::size_t kShadowBatch = 16384;

class DirectIntegrator {
public:
    explicit DirectIntegrator(const FrameContext& context);

    /// results.size() == samples.size(). Tracer is accel::Tracer, or what a test puts in its place.
    template <class Tracer>
    void run(Tracer& tracer, std::span<const CameraSample> samples, std::span<SampleResult> results)
    {
        begin(samples, results);
        for (int layer = 0; layer < kMaxBlendLayers && !paths_.empty(); ++layer) {
            hits_.assign(rays_.size(), {});
            trace([&] { tracer.closest(rays_, hits_); });
            for (std::size_t done = 0; done < paths_.size();) {
                done = shade_some(layer, done, samples, results);
                trace_shadows(tracer, results);
            }
            extend();
        }
    }

    const IntegratorCounters& counters() const noexcept { return counters_; }

private:
    using Clock = std::chrono::steady_clock;

    /// A sample that is still on its way, and the share of its light that is not yet accounted for.
    struct Path {
        std::uint32_t sample;
        float share;
    };
    struct ShadowPath {
        std::uint32_t sample;
        Vec3f radiance;  ///< if nothing is in the way
        float passed;    ///< share that gets through, once it is known
    };

    void begin(std::span<const CameraSample> samples, std::span<SampleResult> results);
    /// Shades hits from `first` on until enough shadow rays wait; returns the first that is not shaded yet.
    std::size_t shade_some(int layer, std::size_t first, std::span<const CameraSample> samples,
                           std::span<SampleResult> results);
    void shade_hit(int layer, std::size_t i, const CameraSample& sample, SampleResult& result);
    void gather_light(int layer, std::size_t i, const CameraSample& sample, const shade::Surface& surface, float share);
    void wait_for_shadow(std::size_t i, const shade::ShadowTest& test, float share);
    void extend();
    /// Of the shadow rays that met something, those that may pass it: their hits are to be found.
    void collect_blocked();
    void pass_blocked();
    void add_light(std::span<SampleResult> results);

    template <class Call>
    void trace(Call&& call)
    {
        const auto start = Clock::now();
        call();
        counters_.trace_seconds += std::chrono::duration<double>(Clock::now() - start).count();
    }

    template <class Tracer>
    void trace_shadows(Tracer& tracer, std::span<SampleResult> results)
    {
        counters_.shadow += shadow_rays_.size();
        occluded_.assign(shadow_rays_.size(), 0);
        trace([&] { tracer.occluded(shadow_rays_, occluded_); });
        collect_blocked();
        for (int layer = 0; layer < kMaxBlendLayers && !blocked_rays_.empty(); ++layer) {
            counters_.shadow += blocked_rays_.size();
            blocked_hits_.assign(blocked_rays_.size(), {});
            trace([&] { tracer.closest(blocked_rays_, blocked_hits_); });
            pass_blocked();
        }
        add_light(results);
    }

    const FrameContext& context_;
    float texture_width_;  ///< of a sample, in pixels
    IntegratorCounters counters_;

    // Parallel arrays, kept from batch to batch for their memory.
    std::vector<Path> paths_, next_paths_;
    std::vector<accel::Ray> rays_, next_rays_;
    std::vector<accel::SurfaceHit> hits_;
    std::vector<ShadowPath> shadow_paths_;
    std::vector<accel::Ray> shadow_rays_;
    std::vector<std::uint8_t> occluded_;
    std::vector<std::uint32_t> blocked_;  ///< indices into shadow_paths_
    std::vector<accel::Ray> blocked_rays_;
    std::vector<accel::SurfaceHit> blocked_hits_;
};

}  // namespace occam::render
