// The integrator turns camera samples into radiance, as a wavefront over the samples of a tile: all rays of a batch are
// traced, then all hits are shaded, then all paths are extended.
//
// direct   light that comes straight from lights, seen also in mirrors and through clear glass
// path     light of any number of bounces up to a limit; Russian roulette ends paths of little throughput
// ao       the share of a white sky that each point sees, also through what lets light pass straight on
//
// A surface that blends, masks, is clear glass or bounds a body that does not bend light transmits it, and the ray is shot
// again from there, in order of t.
// Camera rays split in two at it, up to kMaxSplits times; from then on they continue along one of the two at random, as
// scattered rays always do. The number of surfaces that a ray passes is not limited, and few rays of a sample are on
// their way at once. The sums of a sample are made in an order that depends on the sample alone, so neither the size of a
// batch nor the memory budget of a tracer can change them.
//
// Threads  one integrator per worker; the context is shared and const.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <new>
#include <span>

#include "accel/tracer.h"
#include "base/kept_blocks.h"
#include "base/stopwatch.h"
#include "render/body_absorption.h"
#include "render/camera_rays.h"
#include "render/cryptomatte.h"
#include "render/eye_body.h"
#include "render/film.h"
#include "render/frame_context.h"
#include "render/path.h"
#include "render/sampler.h"
#include "render/settings.h"
#include "render/shadow_queue.h"
#include "shade/direct.h"
#include "shade/light_lanes.h"

namespace occam::render {

struct CameraSample {
    int x = 0, y = 0;  ///< pixel of the whole frame
    int index = 0;     ///< index among the samples of the pixel
};

struct IntegratorCounters {
    RayCounters rays;
    double trace_seconds = 0, shade_seconds = 0;
    /// The area of the surface that a pixel covers where a camera ray hits, in squares of the shading rate, summed over
    /// samples.
    double visible_cells = 0;
    std::uint64_t hits_looked_up = 0;  ///< hits that were shaded without values of phase one
};

/// The number of lights outside the tree that are sampled at a hit. Of more, all of which are suns, one is chosen from each
/// sixteenth of the list.
inline constexpr int kMaxLightsPerHit = static_cast<int>(shade::PlacedLights::kMostWithoutTree);
/// The largest number of lights that are drawn from the tree for each light sample of a hit: where the camera sees it, and
/// later.
inline constexpr int kTreeDraws = shade::LightTree::kMostDraws, kLaterTreeDraws = 4;
/// The random numbers for a light of the tree have a slot of their own from this one on, whatever draw it comes from: so
/// those of a pixel's samples are spread evenly.
inline constexpr int kFirstTreeSlot = 64;
/// The GGX width up to which `direct` follows a lobe as a mirror; wider lobes show lights alone.
inline constexpr float kMirrorAlpha = 0.01f;
/// `direct` follows mirrors for certain that a ray comes to after fewer transparent surfaces than this. Behind more, as in a
/// stack of panes, each of which mirrors all others, paths end by chance.
inline constexpr int kPassedForSure = 4;

/// A camera ray that has been split this many times continues along one way at random.
inline constexpr int kMaxSplits = 32;

/// Returns the chance with which a surface is lit that adds `share` to what a ray sees which has passed `passed` surfaces
/// before: 1 for an eighth and more at the first surfaces. The shares along a ray add up to 1 at most, so few of thousands
/// of faint surfaces are lit, and each of these stands for many.
inline float lighting_chance(float share, int passed) noexcept
{
    constexpr int kMostLit = 8;  // surfaces that are to be expected to be lit
    return std::min(share * static_cast<float>(std::clamp(2 * kMostLit - passed, 1, kMostLit)), 1.0f);
}

class Integrator {
public:
    explicit Integrator(const FrameContext& context);

    /// Runs a batch, where results.size() == samples.size(). Tracer is accel::Tracer, or what a test puts in its place.
    template <class Tracer>
    void run(Tracer& tracer, std::span<const CameraSample> samples, std::span<SampleResult> results)
    {
        begin(samples, results);
        if (seeks_eye_body_) find_eye_body(tracer);
        for (; !paths_.empty(); extend()) {
            for (std::size_t first = 0, end = 0; first < paths_.size(); first = end) {
                hits_of_each_ = hits_at_once(paths_[first]);
                end = end_of_chunk(first);
                first_of_chunk_ = first;
                trace([&] { find_hits(tracer, std::span(rays_).subspan(first, end - first)); });
                for (std::size_t done = first; done < end;) {
                    done = shade_some(done, end, samples, results);
                    std::uint64_t shot = 0;
                    trace([&] { shot = shadows_.trace(tracer, lit_, luck_); });
                    (context_.settings.integrator == IntegratorKind::Ao ? counters_.rays.ao : counters_.rays.shadow) += shot;
                }
            }
        }
        for (std::size_t i = 0; i < results.size(); ++i) results[i].radiance += lit_[i];
    }

    /// Returns the matte shares of the batch that was run last, if the settings have a layer of Cryptomatte: the surfaces
    /// of each sample from front to back.
    std::span<const MatteShare> mattes() const noexcept { return mattes_; }
    /// Returns how many paths the hit of a camera ray may be split into: the directions in which it is scattered no further,
    /// each of which may hit a surface that emits light.
    int paths_of_a_camera_ray() const noexcept;

    const IntegratorCounters& counters() const noexcept { return counters_; }

private:
    using Use = Dimension::Use;

    /// Describes a hit that is being shaded.
    struct Vertex {
        const Path& path;
        const accel::Ray& ray;
        const accel::SurfaceHit& hit;
        const CameraSample& sample;
        const shade::Surface& surface;
        Vec3f share;      ///< share of the light leaving the surface that reaches the pixel
        Vec3f lit_share;  ///< the same for light that is gathered, which stands for surfaces that are not lit, too
        float limit;      ///< of the light that is gathered
        float occlusion;  ///< share of the ambient light at the surface that its occlusion map leaves
        /// shade::peak_density(), set where light is gathered. It decides which lights are left to their own samples here
        /// (shade/direct.h).
        float peak = 0;
        Vec3d start = surface.front_start();
        shade::Receiver receiver{};             ///< filled if there is a tree of lights
        float width = ray.footprint.at(hit.t);  ///< width of the beam
        /// The surface with its lobes; not null where light is gathered.
        const shade::SurfaceForEye* for_eye = nullptr;
        /// Returns the index of the sample's first number in a dimension that has `of` numbers for each sample.
        std::uint32_t first_of(int of) const noexcept { return static_cast<std::uint32_t>(sample.index * of); }
    };

    void begin(std::span<const CameraSample> samples, std::span<SampleResult> results);
    /// Finds the bodies in which the rays of the samples start.
    template <class Tracer>
    void find_eye_body(Tracer& tracer)
    {
        trace([&] { counters_.rays.primary += eye_body_.find(tracer, rays_, paths_); });
        log_eye_body();
    }
    void log_eye_body() const;
    /// Sets the offsets and weights of samples by the filter.
    void place(std::span<const CameraSample> samples, std::span<SampleResult> results) const;
    /// Returns how many hits of the path's ray are found at once: more for one that has passed many surfaces, so that the
    /// work grows with the number of the surfaces and not with its square. Costs are known of single hits alone.
    int hits_at_once(const Path& path) const noexcept
    {
        return path.passed < 4 || shows_cost_ ? 1 : path.passed < 24 ? 16 : accel::kMostNearest;
    }
    /// Returns one past the last path from `first` on whose hits are found together; all of them find hits_of_each_ hits.
    std::size_t end_of_chunk(std::size_t first) const noexcept;
    template <class Tracer>
    void find_hits(Tracer& tracer, std::span<const accel::Ray> rays)
    {
        const std::size_t count = rays.size() * static_cast<std::size_t>(hits_of_each_);
        if (hits_.size() < count) hits_.resize(count);
        const std::span<accel::SurfaceHit> hits = std::span(hits_).first(count);
        hit_counts_.resize(rays.size());
        if (shows_cost_) costs_.assign(rays.size(), {});
        if (hits_of_each_ > 1) return tracer.nearest(rays, hits_of_each_, hits, hit_counts_);
        if (!find_costs(tracer, rays, hits)) tracer.closest(rays, hits);
        for (std::size_t i = 0; i < rays.size(); ++i) hit_counts_[i] = {hits[i].is_hit(), !hits[i].is_hit()};
    }
    /// Finds the hits of rays whose cost is shown, one by one. Returns false if no cost is shown, or if the tracer knows
    /// none.
    template <class Tracer>
    bool find_costs(Tracer& tracer, std::span<const accel::Ray> rays, std::span<accel::SurfaceHit> hits)
    {
        if constexpr (!requires { tracer.observe(rays[0], hits[0]); }) return false;
        else {
            if (!shows_cost_) return false;
            for (std::size_t i = 0; i < rays.size(); ++i) costs_[i] = tracer.observe(rays[i], hits[i]);
            return true;
        }
    }
    /// Shades the hits of paths [first, end) until enough shadow rays wait, and returns the first path that is not shaded
    /// yet.
    std::size_t shade_some(std::size_t first, std::size_t end, std::span<const CameraSample> samples,
                           std::span<SampleResult> results);
    /// Returns true if the path goes straight on. Then paths_[i] and rays_[i] are what continues.
    bool shade_hit(std::size_t i, const accel::SurfaceHit& hit, const CameraSample& sample, SampleResult& result);
    void set_receiver(Vertex& v) const noexcept;
    void count_cells(const accel::Ray& ray, const accel::SurfaceHit& hit);
    void shade_miss(std::size_t i, SampleResult& result);
    Vec3f left_by_body(Vec3f absorption, float length) const noexcept
    {
        return render::left_by_body(absorption, length, context_.scale);
    }
    /// Returns the absorption coefficient that holds along a ray which leaves the surface in that direction.
    static Vec3f absorption_along(const Vertex& v, Vec3f direction) noexcept
    {
        return glm::dot(v.surface.normal_geometric, direction) > 0
                   ? v.path.absorption
                   : v.surface.absorption_behind(v.hit.back_side, v.path.absorption);
    }
    /// Adds the lights without a surface that a scattered ray crosses before `t_far`.
    void cross_lights(const Path& path, const accel::Ray& ray, float t_far, SampleResult& result) const;
    void add_emission(const Path& path, const accel::SurfaceHit& hit, const shade::Surface& surface, Vec3f share,
                      SampleResult& result) const;
    /// Returns the limit (light_limit.h) of light that `scatterings` surfaces scattered; `stands_for` is as Path has it.
    float limit(int scatterings, float stands_for) const noexcept
    {
        const bool is_limited = context_.clamp > 0 && scatterings >= 2;
        return is_limited ? context_.clamp * stands_for : std::numeric_limits<float>::infinity();
    }
    float limit(const Path& path) const noexcept { return limit(path.bounces, path.stands_for); }
    void record_first(const accel::Ray& ray, const accel::SurfaceHit& hit, const shade::Surface& surface, float occlusion,
                      float covered, SampleResult& result) const;
    Vec2f motion_of(const accel::Ray& ray, const accel::SurfaceHit& hit) const;
    void record_matte(const accel::SurfaceHit& hit, std::uint32_t sample, float covered);

    /// Holds the chances with which a ray continues straight on and scattered, and with which the surface is lit. What has a
    /// chance of 0 is not done.
    struct Chances {
        float pass, scatter, light;
    };
    Chances chances(const Vertex& v) const
    {
        const bool passes = v.surface.transmittance != Vec3f(0),
                   scatters = v.surface.opacity > 0 && !v.path.is_probe && !v.surface.only_passes();
        if (passes && scatters) return chances_of_both(v);
        return {passes ? 1.0f : 0.0f, scatters ? 1.0f : 0.0f, 1};
    }
    /// Returns the chances at a surface that passes light and scatters it.
    Chances chances_of_both(const Vertex& v) const;
    /// Gathers light at a surface and follows the lobes of the surface, with these chances.
    void gather_and_scatter(Vertex& v, const Chances& chance);
    /// Returns whether the same may be done later for several surfaces side by side.
    bool may_wait(const Vertex& v, const Chances& chance) const noexcept;
    /// Does it now or lets the surface, which is in the first free slot, wait until there are as many as lanes.
    void shade_or_wait(Vertex& v, const Chances& chance);
    /// Does gather_and_scatter() for all surfaces that wait: with the same bits, and in the order in which they came.
    void shade_waiting();
    /// Adds samples of all lights to tests_, for all surfaces that wait.
    void gather_in_lanes(const shade::SurfaceLanes& surfaces, int count);
    void gather_placed_in_lanes(const shade::SurfaceLanes& surfaces, int count);
    void add_tests(const shade::SurfaceLanes& surfaces, const shade::LightSampleLanes& sample, vfloat scatter_count);
    void draw_for_waiting(int count);
    std::uint32_t light_slots_to_draw() const noexcept;
    /// Returns the slot of Use::Light that belongs to the environment, which is the last one.
    int environment_slot() const noexcept;
    Vec2f light_square(const Vertex& v, int slot) const noexcept;
    void gather_light(const Vertex& v);
    void gather_sky(const Vertex& v);
    /// Returns false if a scattered direction can contribute nothing that gather_light() has not contributed.
    bool needs_scattering(const Vertex& v) const noexcept;
    void scatter_on(const Vertex& v, float chance);
    /// Says which direction this is among those that are scattered on one surface.
    struct ScatterNumber {
        int n, samples;
        float chance;  ///< with which the ray is scattered at all
    };
    /// Follows a scattered direction whose weight is not black.
    /// sky   the light of the environment from there, if it is known already
    void follow(const Vertex& v, const shade::ScatterSample& s, const ScatterNumber& number,
                const shade::Environment::Light* sky = nullptr);
    /// Adds the lights without a surface along a scattered direction that is followed no further.
    void look_for_light(const Path& next, const accel::Ray& ray, const shade::Environment::Light* known_sky);
    void gather_placed(const Vertex& v, int slots);
    void gather_from_tree(const Vertex& v, int first_slot);
    /// What is to be known of the samples that are drawn of one light.
    struct PlacedSamples {
        Vec3f share;     ///< what each counts for
        float expected;  ///< samples of the light that were to be expected at the hit
    };
    /// Adds samples of a placed light. Calls draw(sample) to draw them: sample(square) adds one.
    template <class Draw>
    void gather_light(const Vertex& v, const shade::WorldLight& light, const PlacedSamples& samples, Draw&& draw);
    void test(const Vertex& v, const shade::ShadowTest& test, Vec3f share, int samples);
    /// Shoots a shadow ray.
    /// light    what it brings if nothing is in its way
    /// spread   of its footprint
    OCCAM_ALWAYS_INLINE void shoot(const Vertex& v, const shade::ShadowTest& test, Vec3f light, float spread)
    {
        accel::Ray& ray = shadows_.add(v.path.sample, light, v.limit);
        ray.origin = test.origin;
        ray.direction = test.direction;
        ray.t_far = test.t_far;
        ray.kinds = test.kinds;
        ray.start_level = v.hit.start_level;
        ray.time = v.ray.time;
        ray.footprint = {v.width, spread};
    }
    /// Describes what continues straight on behind a surface.
    struct Passing {
        Vec3f light;       ///< transmittance for light that comes from there
        float coverage;    ///< share of the pixel that no surface up to here covers
        float chance;      ///< the chance that the ray continues at all
        Vec3f absorption;  ///< coefficient that holds behind the surface
    };
    /// Replaces path i, which has come to t, by what continues behind. Returns false if it ends by chance.
    bool pass_straight(std::size_t i, const Path& path, float t, const Passing& passing, const CameraSample& sample);
    void push(const Path& path, const accel::Ray& ray);
    void drop_last() noexcept
    {
        next_paths_.pop_back();
        next_rays_.pop_back();
    }
    void extend();
    /// Sorts the paths by the number of hits that are found at once, so that those of one number stand together.
    void group_by_hits();
    int light_samples_at(const Path& path) const noexcept;
    int scatter_samples_at(const Path& path) const noexcept;
    int tree_draws_at(const Path& path) const noexcept { return path.is_camera() ? kTreeDraws : kLaterTreeDraws; }
    Sequence numbers(const Vertex& v, Dimension::Use use, int slot = 0) const noexcept;
    accel::Ray scattered_ray(const Vertex& v, const shade::ScatterSample& s, int samples) const noexcept;

    template <class Call>
    void trace(Call&& call)
    {
        const Stopwatch watch(counters_.trace_seconds);
        call();
    }

    const FrameContext& context_;
    float texture_width_;  ///< width of the texture filter of one sample, in pixels
    bool has_mattes_;
    bool shows_cost_;       ///< the view shows what rays cost
    bool wants_occlusion_;  ///< occlusion maps are looked up, for `ao` or for the layer
    IntegratorCounters counters_;
    std::uint64_t passed_ = 0;  ///< the number of surfaces that paths have passed since the budget was asked

    // These are parallel arrays, kept from batch to batch for their memory.
    KeptVector<Path> paths_, next_paths_;
    KeptVector<accel::Ray> rays_, next_rays_;
    KeptVector<accel::SurfaceHit> hits_;      ///< hits_of_each_ of each path of the chunk that is being shaded
    KeptVector<accel::HitCount> hit_counts_;  ///< one for each path of the chunk
    KeptVector<accel::RayCost> costs_;        ///< the same, if the view shows them
    std::size_t first_of_chunk_ = 0;
    int hits_of_each_ = 1;
    KeptVector<MatteShare> mattes_;
    KeptVector<Vec3f> lit_;   ///< radiance from shadow rays, one sum per sample
    KeptVector<float> luck_;  ///< the number for each sample that ShadowQueue::trace() needs
    ShadowQueue shadows_;
    EyeBody eye_body_;
    bool seeks_eye_body_;  ///< the picture shows what the body takes in which the eye may be
    shade::PlainSurfaces plain_surfaces_;

    /// Keeps what a surface needs that waits to be shaded with others.
    struct Waiting {
        Path path;
        shade::Surface surface;
        alignas(Vertex) std::byte vertex[sizeof(Vertex)];

        Vertex& at() noexcept { return *std::launder(reinterpret_cast<Vertex*>(vertex)); }
        const Vertex& at() const noexcept { return *std::launder(reinterpret_cast<const Vertex*>(vertex)); }
    };
    bool waits_;  ///< surfaces may wait
    int waiting_count_ = 0;
    std::array<Waiting, kLanes> waiting_;  ///< the first free one, if any, holds the surface that is looked at
    /// Holds what a sample of a light contributes to the surfaces that waited, and the spreads of the rays to it.
    struct LightTests {
        shade::LaneRows directions, radiances;  ///< with the distances and the densities
        shade::LaneFloats spread;
        unsigned not_black = 0;                  ///< bits of the surfaces to which it contributes
        std::array<std::uint8_t, kLanes> kinds;  ///< of the rays
    };
    KeptVector<LightTests> tests_;
    shade::LaneFloats widths_;  ///< of the beams that have come to them
    Vertex& waiting(int k) noexcept { return waiting_[static_cast<std::size_t>(k)].at(); }
    const Vertex& waiting(int k) const noexcept { return waiting_[static_cast<std::size_t>(k)].at(); }
    SurfacesToDraw surfaces_to_draw_;  ///< those that wait
    SurfaceNumbers drawn_;             ///< for them
};

}  // namespace occam::render
