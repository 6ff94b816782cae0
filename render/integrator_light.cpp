// What an integrator does at a hit: shadow rays to lights, and rays that follow the surface's lobes.
#include <algorithm>
#include <cmath>

#include "render/integrator.h"
#include "shade/footprints.h"

namespace occam::render {
namespace {

using accel::RayKind;
using Use = Dimension::Use;

std::uint8_t kind_of(shade::Lobe lobe) noexcept
{
    switch (lobe) {
        case shade::Lobe::Diffuse: return RayKind::Diffuse;
        case shade::Lobe::Layer:
        case shade::Lobe::Coat: return RayKind::Reflection;
        case shade::Lobe::Transmission: return RayKind::Transmission;
    }
    return RayKind::All;
}

std::uint32_t scattered_key(std::uint32_t key, std::uint32_t n) noexcept
{
    return static_cast<std::uint32_t>(mix_bits((std::uint64_t(key) << 16) + 0x8000u + n) >> 32);
}

bool is_black(Vec3f c) noexcept { return !(c.x > 0 || c.y > 0 || c.z > 0); }

}  // namespace

// Later surfaces of a path are lit by one sample of each light, whatever was asked for.
int Integrator::light_samples_at(const Path& path) const noexcept
{
    return path.is_camera() ? context_.settings.light_samples : 1;
}

shade::Tries Integrator::tries_of(float light_tries, float scatter_tries, bool is_placed) const noexcept
{
    return {light_tries * (is_placed ? placed_tries_ : 1.0f), scatter_tries};
}

Vec2f Integrator::square(const Vertex& v, Dimension d, int n, int of) const noexcept
{
    const auto index = static_cast<std::uint32_t>(v.sample.index * of + n);
    return context_.sampler.square(v.sample.x, v.sample.y, index, d);
}

float Integrator::interval(const Vertex& v, Dimension d, int n, int of) const noexcept
{
    const auto index = static_cast<std::uint32_t>(v.sample.index * of + n);
    return context_.sampler.interval(v.sample.x, v.sample.y, index, d);
}

void Integrator::gather_light(const Vertex& v)
{
    const auto& lights = context_.lights.lights();
    const int light_count = static_cast<int>(lights.size());
    const int slots = std::min(light_count, kMaxLightsPerHit);
    const int per_hit = light_samples_at(v.path);
    const int scatter_tries = context_.settings.integrator == IntegratorKind::Direct || v.path.bounces >= context_.settings.bounces
                                  ? per_hit
                                  : 1;
    const Vec3f each = v.share / static_cast<float>(per_hit);
    // A light of its own has no choice to make.
    const auto numbers = [&](int slot, int n, bool is_choice) {
        const auto s = static_cast<std::uint32_t>(slot);
        shade::LightNumbers u{square(v, Dimension::at(v.path.key, Use::Light, s), n, per_hit)};
        if (is_choice) u.choice = interval(v, Dimension::at(v.path.key, Use::LightChoice, s), n, per_hit);
        return u;
    };
    const auto tries = [&](bool is_placed, bool is_left_to_samples = false) {
        return tries_of(float(per_hit), is_left_to_samples ? 0.0f : float(scatter_tries), is_placed);
    };
    for (int slot = 0; slot < slots; ++slot)
        for (int n = 0; n < per_hit; ++n) {
            const shade::LightNumbers u = numbers(slot, n, light_count > slots);
            int light = slot;
            if (light_count > slots) {
                const float at = (static_cast<float>(slot) + u.choice) / static_cast<float>(slots);
                light = std::min(static_cast<int>(at * static_cast<float>(light_count)), light_count - 1);
            }
            const shade::WorldLight& placed = lights[std::size_t(light)];
            if ((placed.groups & v.hit.lit_by) == 0) continue;
            const bool is_left = shade::FrameLights::is_left_to_samples(placed, v.start, v.peak);
            test(v, shade::test_light(v.surface, placed, u, tries(true, is_left)), each / placed_tries_, per_hit);
        }
    for (int n = 0; n < per_hit; ++n) {
        if (!context_.lights.meshes().is_empty())
            test(v, shade::test_meshes(v.surface, context_.lights.meshes(), numbers(slots, n, true), tries(false)), each, per_hit);
        if (context_.lights.environment().has_density())
            test(v, shade::test_environment(v.surface, context_.lights.environment(), numbers(slots + 1, n, false), tries(false)), each,
                 per_hit);
    }
}

void Integrator::test(const Vertex& v, const shade::ShadowTest& test, Vec3f share, int samples)
{
    if (is_black(test.radiance)) return;
    accel::Ray ray;
    ray.origin = test.origin;
    ray.direction = test.direction;
    ray.t_far = test.t_far;
    ray.kinds = RayKind::Shadow;
    ray.footprint = shade::light_beam(v.ray.footprint.at(v.hit.t), test.t_far, test.density, samples * context_.settings.spp);
    shadows_.add(v.path.sample, ray, test.radiance * share);
}

void Integrator::gather_sky(const Vertex& v)
{
    const int samples = light_samples_at(v.path);
    const shade::Axes axes(v.surface.normal);
    const float reach = context_.settings.ao_distance > 0 ? context_.settings.ao_distance : std::numeric_limits<float>::infinity();
    for (int n = 0; n < samples; ++n) {
        accel::Ray ray;
        ray.direction = axes.to_world(shade::cosine_direction(square(v, Dimension::at(v.path.key, Use::Scatter), n, samples)));
        if (!(glm::dot(ray.direction, v.surface.normal_geometric) > 0)) continue;
        ray.origin = v.surface.start(ray.direction);
        ray.t_far = reach;
        ray.kinds = RayKind::Shadow;
        const float density = glm::dot(ray.direction, v.surface.normal) / shade::kPi;
        ray.footprint = shade::scattered_beam({v.ray.footprint.at(v.hit.t), 0}, density, samples * context_.settings.spp);
        shadows_.add(v.path.sample, ray, v.share / static_cast<float>(samples));
    }
}

accel::Ray Integrator::scattered_ray(const Vertex& v, const shade::ScatterSample& s, int samples) const noexcept
{
    accel::Ray ray;
    ray.origin = v.surface.start(s.direction);
    ray.direction = s.direction;
    ray.kinds = kind_of(s.lobe);
    const shade::Beam beam{v.ray.footprint.at(v.hit.t), v.ray.footprint.b};
    const float cosine = std::max(glm::dot(v.surface.normal, v.surface.to_eye), 0.0f);
    lod::Footprint smooth{beam.width, 0};
    if (s.lobe == shade::Lobe::Transmission) {
        smooth.b = std::max(beam.spread, 0.0f);
        if (v.surface.is_solid)
            smooth = shade::bent_beam(beam, v.hit.curvature, cosine, std::fabs(glm::dot(v.surface.normal, s.direction)), v.surface.eta);
    } else if (s.lobe != shade::Lobe::Diffuse) {
        smooth = shade::mirrored_beam(beam, v.hit.curvature, cosine);
    }
    ray.footprint = shade::followable(shade::scattered_beam(smooth, s.density, samples * context_.settings.spp), context_.settings.shading_rate);
    return ray;
}

bool Integrator::needs_scattering(const Vertex& v) const noexcept
{
    const bool is_direct = context_.settings.integrator == IntegratorKind::Direct;
    const bool goes_on = v.path.bounces < context_.settings.bounces && !(is_direct && shade::narrowest_lobe(v.surface) > kMirrorAlpha);
    return goes_on || !context_.lights.leaves_all_to_samples(v.start, v.peak, v.hit.lit_by);
}

void Integrator::scatter_on(const Vertex& v, float chance)
{
    const Settings& settings = context_.settings;
    const bool is_last = v.path.bounces >= settings.bounces;
    const bool is_direct = settings.integrator == IntegratorKind::Direct;
    const int light_tries = light_samples_at(v.path);
    const int samples = is_direct || is_last ? light_tries : 1;
    for (int n = 0; n < samples; ++n) {
        const float lobe = interval(v, Dimension::at(v.path.key, Use::Lobe), n, samples);
        const shade::ScatterSample s =
            shade::sample_scatter(v.surface, lobe, square(v, Dimension::at(v.path.key, Use::Scatter), n, samples));
        if (is_black(s.weight)) continue;

        Path next = v.path;
        next.throughput = v.share * s.weight / (static_cast<float>(samples) * chance);
        next.coverage = 0;
        next.key = scattered_key(v.path.key, static_cast<std::uint32_t>(n));
        next.density = s.density;
        next.peak = v.peak;
        next.lit_by = v.hit.lit_by;
        next.light_tries = static_cast<float>(light_tries);
        next.scatter_tries = static_cast<float>(samples);
        next.is_before_focus = false;
        ++next.bounces;
        if (s.lobe == shade::Lobe::Transmission && v.surface.is_solid)
            next.absorption = v.hit.back_side ? Vec3f(0) : v.surface.absorption_inside;
        const accel::Ray ray = scattered_ray(v, s, samples);

        if (is_last || (is_direct && s.alpha > kMirrorAlpha)) {
            look_for_light(next, ray);
            continue;
        }
        if (!is_direct && next.bounces > kCertainBounces) {
            const float worth = std::max({next.throughput.x, next.throughput.y, next.throughput.z});
            const float survival = std::clamp(worth, 0.05f, 0.95f);
            if (interval(v, Dimension::at(v.path.key, Use::Survival), 0, 1) >= survival) continue;
            next.throughput /= survival;
        }
        push(next, ray);
    }
}

void Integrator::look_for_light(const Path& next, const accel::Ray& ray)
{
    if (context_.lights.meshes().any_emitter()) {
        Path probe = next;
        probe.is_probe = true;
        push(probe, ray);
        return;
    }
    // Lights without a surface and the sky need no hit: something is in the way or not.
    const shade::Tries placed = tries_of(next.light_tries, next.scatter_tries, true);
    const auto add = [&](float t_far, Vec3f radiance) {
        accel::Ray shadow = ray;
        shadow.kinds = RayKind::Shadow;
        shadow.t_far = t_far;
        shadows_.add(next.sample, shadow, next.throughput * radiance);
    };
    const float infinity = std::numeric_limits<float>::infinity();
    context_.lights.for_crossings(ray.origin, ray.direction, infinity, next.peak,
                                  [&](const shade::WorldLight& light, const shade::LightCrossing& c) {
                                      if ((light.groups & next.lit_by) == 0) return;
                                      add(c.distance, c.radiance * placed.of_scatter(next.density, c.density));
                                  });
    const shade::Environment& sky = context_.lights.environment();
    if (sky.is_black()) return;
    const shade::Tries tries = tries_of(next.light_tries, next.scatter_tries, false);
    add(infinity, sky.radiance(ray.direction) * tries.of_scatter(next.density, sky.density(ray.direction)));
}

}  // namespace occam::render
