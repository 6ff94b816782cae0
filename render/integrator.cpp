#include "render/integrator.h"

#include <algorithm>
#include <cmath>

#include "render/views.h"

namespace occam::render {
namespace {

// Less of a ray's light than this is not followed through blended surfaces.
constexpr float kLeastShare = 1.0f / 1024;

// A pixel is the mean of its samples: each of them filters textures over its own share of the pixel alone.
float sample_width(int samples) noexcept { return 1 / std::sqrt(static_cast<float>(samples)); }

shade::ShadePoint shade_point(const accel::Ray& ray, const accel::SurfaceHit& hit, float texture_width) noexcept
{
    shade::ShadePoint p;
    p.position = hit.position;
    p.to_eye = -ray.direction;
    p.normal_geometric = hit.normal_geometric;
    p.normal_shading = hit.normal_shading;
    p.self_distance = hit.self_distance;
    for (int set = 0; set < 2; ++set) {
        p.uv[set] = hit.uv[set];
        p.uv_width[set] = hit.uv_width[set] * texture_width;
    }
    p.color = hit.color;
    p.material = hit.material;
    return p;
}

// The rest of a ray behind a hit: the interval is open at its near end, and rounding of t must not find the hit again.
accel::Ray behind(accel::Ray ray, float t) noexcept
{
    ray.t_near = t * (1 + 4 * std::numeric_limits<float>::epsilon());
    return ray;
}

}  // namespace

DirectIntegrator::DirectIntegrator(const FrameContext& context)
    : context_(context), texture_width_(sample_width(context.settings.spp))
{
}

void DirectIntegrator::begin(std::span<const CameraSample> samples, std::span<SampleResult> results)
{
    paths_.clear();
    rays_.clear();
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const CameraSample& s = samples[i];
        const Vec2f place = context_.sampler.in_pixel(s.x, s.y, s.index);
        paths_.push_back({static_cast<std::uint32_t>(i), 1});
        rays_.push_back(context_.camera.ray(s.x + double(place.x), s.y + double(place.y)));
        results[i] = {};
    }
    counters_.primary += samples.size();
}

std::size_t DirectIntegrator::shade_some(int layer, std::size_t first, std::span<const CameraSample> samples,
                                         std::span<SampleResult> results)
{
    const auto start = Clock::now();
    shadow_paths_.clear();
    shadow_rays_.clear();
    std::size_t i = first;
    for (; i < paths_.size() && shadow_rays_.size() < kShadowBatch; ++i)
        shade_hit(layer, i, samples[paths_[i].sample], results[paths_[i].sample]);
    counters_.shade_seconds += std::chrono::duration<double>(Clock::now() - start).count();
    return i;
}

void DirectIntegrator::shade_hit(int layer, std::size_t i, const CameraSample& sample, SampleResult& result)
{
    const accel::Ray& ray = rays_[i];
    const accel::SurfaceHit& hit = hits_[i];
    const float share = paths_[i].share;
    const bool is_view = context_.settings.view != View::Beauty;
    if (!hit.is_hit()) {
        if (!context_.settings.background || is_view) return;
        result.radiance += share * context_.lights.environment().radiance(ray.direction);
        result.alpha += share;
        return;
    }

    const shade::Surface surface = shade::evaluate(shade_point(ray, hit, texture_width_), context_.textures);
    const float opaque = share * surface.opacity;
    if (opaque > 0 && result.alpha == 0) {
        result.first = {static_cast<float>(context_.camera.depth(hit.position)),
                        hit.normal_shading,
                        hit.normal_geometric,
                        hit.uv[0],
                        Vec3f(hit.position),
                        static_cast<float>(hit.node.slot + 1)};
    }
    result.alpha += opaque;
    result.albedo += Vec4f(surface.base_color, 1) * opaque;
    if (is_view) {
        const float z = static_cast<float>(context_.camera.depth(hit.position));
        result.radiance += opaque * view_color(context_.settings.view, hit, z, context_.depth_near, context_.depth_far);
    } else if (surface.unlit) {
        result.radiance += opaque * surface.base_color;
    } else {
        result.radiance += opaque * surface.emission;
        if (opaque > 0) gather_light(layer, i, sample, surface, opaque);
    }

    const float rest = share - opaque;
    if (rest < kLeastShare) return;
    next_paths_.push_back({paths_[i].sample, rest});
    next_rays_.push_back(behind(ray, hit.t));
}

void DirectIntegrator::gather_light(int layer, std::size_t i, const CameraSample& sample, const shade::Surface& surface,
                                    float share)
{
    const auto& lights = context_.lights.lights();
    const int light_count = static_cast<int>(lights.size());
    const int slots = std::min(light_count, kMaxLightsPerHit);
    const auto per_hit = static_cast<std::uint32_t>(context_.settings.light_samples);
    const std::uint32_t count = per_hit * static_cast<std::uint32_t>(context_.sampler.samples());
    const float each = share / static_cast<float>(per_hit);

    const auto numbers = [&](int slot, std::uint32_t n) {
        const std::uint32_t index = static_cast<std::uint32_t>(sample.index) * per_hit + n;
        const Dimension d = Dimension::light(layer, slot);
        return shade::LightNumbers{context_.sampler.square(sample.x, sample.y, index, count, d),
                                   context_.sampler.interval(sample.x, sample.y, index, count, d.next(2))};
    };
    for (int slot = 0; slot < slots; ++slot)
        for (std::uint32_t n = 0; n < per_hit; ++n) {
            const shade::LightNumbers u = numbers(slot, n);
            int light = slot;
            if (light_count > slots) {
                const float at = (static_cast<float>(slot) + u.choice) / static_cast<float>(slots);
                light = std::min(static_cast<int>(at * static_cast<float>(light_count)), light_count - 1);
            }
            const float weight = each * static_cast<float>(light_count) / static_cast<float>(slots);
            wait_for_shadow(i, shade::sample_light(surface, lights[std::size_t(light)], u), weight);
        }
    if (context_.lights.environment().is_black()) return;
    for (std::uint32_t n = 0; n < per_hit; ++n)
        wait_for_shadow(i, shade::sample_environment(surface, context_.lights.environment(), numbers(slots, n)), each);
}

void DirectIntegrator::wait_for_shadow(std::size_t i, const shade::ShadowTest& test, float share)
{
    if (!(test.radiance.x > 0 || test.radiance.y > 0 || test.radiance.z > 0)) return;
    accel::Ray ray;
    ray.origin = test.origin;
    ray.direction = test.direction;
    ray.t_far = test.t_far;
    // As wide as the beam that sees the point, and growing at least as fast.
    const lod::Footprint& beam = rays_[i].footprint;
    ray.footprint = {beam.at(hits_[i].t), beam.b};
    shadow_rays_.push_back(ray);
    shadow_paths_.push_back({paths_[i].sample, test.radiance * share, 1});
}

void DirectIntegrator::extend()
{
    paths_.swap(next_paths_);
    rays_.swap(next_rays_);
    next_paths_.clear();
    next_rays_.clear();
}

void DirectIntegrator::collect_blocked()
{
    blocked_.clear();
    blocked_rays_.clear();
    for (std::size_t i = 0; i < shadow_paths_.size(); ++i) {
        if (!occluded_[i]) continue;
        if (!context_.has_blending) {
            shadow_paths_[i].passed = 0;
            continue;
        }
        blocked_.push_back(static_cast<std::uint32_t>(i));
        blocked_rays_.push_back(shadow_rays_[i]);
    }
}

void DirectIntegrator::pass_blocked()
{
    std::size_t kept = 0;
    for (std::size_t i = 0; i < blocked_.size(); ++i) {
        const accel::SurfaceHit& hit = blocked_hits_[i];
        if (!hit.is_hit()) continue;
        float& passed = shadow_paths_[blocked_[i]].passed;
        passed *= 1 - shade::evaluate(shade_point(blocked_rays_[i], hit, texture_width_), context_.textures).opacity;
        if (passed < kLeastShare) {
            passed = 0;
            continue;
        }
        blocked_rays_[kept] = behind(blocked_rays_[i], hit.t);
        blocked_[kept++] = blocked_[i];
    }
    blocked_.resize(kept);
    blocked_rays_.resize(kept);
}

void DirectIntegrator::add_light(std::span<SampleResult> results)
{
    // What is still on its way after the last layer counts as blocked.
    for (const std::uint32_t i : blocked_) shadow_paths_[i].passed = 0;
    for (const ShadowPath& p : shadow_paths_) results[p.sample].radiance += p.radiance * p.passed;
}

}  // namespace occam::render
