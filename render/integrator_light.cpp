// The work of an integrator at a hit: shadow rays to lights, and rays that follow the lobes of the surface.
#include <algorithm>
#include <cmath>

#include "base/prefetch.h"
#include "render/integrator.h"
#include "render/light_limit.h"
#include "render/path_log.h"
#include "shade/footprints.h"

namespace occam::render {
namespace {

using accel::RayKind;

std::uint8_t kind_of(shade::Lobe lobe) noexcept
{
    switch (lobe) {
        case shade::Lobe::Diffuse:
            return RayKind::Diffuse;
        case shade::Lobe::Layer:
        case shade::Lobe::Coat:
            return RayKind::Reflection;
        case shade::Lobe::Transmission:
            return RayKind::Transmission;
    }
    return RayKind::All;
}

std::uint32_t scattered_key(std::uint32_t key, std::uint32_t n) noexcept
{
    return static_cast<std::uint32_t>(mix_bits((std::uint64_t(key) << 16) + 0x8000u + n) >> 32);
}

bool is_black(Vec3f c) noexcept { return !(c.x > 0 || c.y > 0 || c.z > 0); }

// Returns the chance with which a scattered path goes on (Russian roulette): 1 as long as its throughput is at least
// kCertainThroughput, and in proportion to it below. Paths are ended late: in a room that is lit through its windows, those
// of many bounces bring as much light as those of few, and each that goes on for others that were ended adds noise.
float survival_of(Vec3f throughput) noexcept
{
    constexpr float kCertainThroughput = 0.25f, kLeastSurvival = 0.05f;
    const float worth = std::max({throughput.x, throughput.y, throughput.z});
    return std::clamp(worth / kCertainThroughput, kLeastSurvival, 1.0f);
}

// Asks for all cache lines of an object.
template <class T>
void prefetch_object(const T& object) noexcept
{
    constexpr std::size_t kLine = 64;
    for (std::size_t at = 0; at < sizeof(T); at += kLine) prefetch(reinterpret_cast<const char*>(&object) + at);
}

// Calls sample(square) for `count` points of a sequence, which are computed in blocks.
template <class Sample>
void for_squares(const Sequence& squares, std::uint32_t first, int count, Sample&& sample)
{
    for (int n = 0; n < count; n += Sequence::kBlock) {
        float x[Sequence::kBlock], y[Sequence::kBlock];
        squares.squares(first + static_cast<std::uint32_t>(n), x, y);
        for (int i = 0; i < std::min(count - n, Sequence::kBlock); ++i) sample(Vec2f(x[i], y[i]));
    }
}

}  // namespace

// Returns the number of samples of each light. Later surfaces of a path take one, whatever the settings ask for.
int Integrator::light_samples_at(const Path& path) const noexcept
{
    return path.is_camera() ? context_.settings.light_samples : 1;
}

// A path that is scattered no further draws as many directions as a light has samples; any other path draws one.
int Integrator::scatter_samples_at(const Path& path) const noexcept
{
    const bool goes_on = context_.settings.integrator != IntegratorKind::Direct && path.bounces < context_.settings.bounces;
    return goes_on ? 1 : light_samples_at(path);
}

int Integrator::paths_of_a_camera_ray() const noexcept
{
    return context_.lights.meshes().any_emitter() ? scatter_samples_at(Path()) : 1;
}

void Integrator::test(const Vertex& v, const shade::ShadowTest& test, Vec3f share, int samples)
{
    if (is_black(test.radiance)) return;
    const Vec3f absorption = absorption_along(v, test.direction), left = left_by_body(absorption, test.t_far);
    const Vec3f light = test.radiance * share * left;
    if (context_.log) context_.log->light_sample(test.direction, test.t_far, limited(light, v.limit));
    const auto of_pixel = static_cast<float>(samples * context_.settings.spp);
    shoot(v, test, light, shade::light_spread(v.width, test.t_far, test.density, of_pixel));
    if (absorption != Vec3f(0)) shadows_.starts_in_body(absorption, test.radiance * share);
}

void Integrator::gather_and_scatter(Vertex& v, const Chances& chance)
{
    const shade::SurfaceForEye for_eye(v.surface);
    v.for_eye = &for_eye;
    v.peak = shade::peak_density(v.surface);
    if (chance.light > 0) gather_light(v);
    if (chance.scatter > 0 && needs_scattering(v)) scatter_on(v, chance.scatter);
    v.for_eye = nullptr;
}

void Integrator::gather_light(const Vertex& v)
{
    int slots = std::min(static_cast<int>(context_.lights.lights_outside_tree()), kMaxLightsPerHit);
    gather_placed(v, slots);
    if (!context_.lights.tree().is_empty()) {
        gather_from_tree(v, slots);
        ++slots;
    }
    const int per_hit = light_samples_at(v.path);
    const Vec3f each = v.lit_share / static_cast<float>(per_hit);
    const shade::SampleCounts counts{float(per_hit), float(scatter_samples_at(v.path))};
    if (!context_.lights.meshes().is_empty()) {
        const Sequence choices = numbers(v, Use::LightChoice, slots);
        const shade::Receiver everything = v.receiver.of_all_groups();
        for (int n = 0; n < per_hit; ++n) {
            const std::uint32_t index = v.first_of(per_hit) + static_cast<std::uint32_t>(n);
            const Vec2f square = per_hit > 1 ? numbers(v, Use::Light, slots).square(index) : light_square(v, slots);
            const shade::LightNumbers u{square, choices.interval(index)};
            test(v, shade::test_meshes(*v.for_eye, context_.lights.meshes(), everything, u, counts), each, per_hit);
        }
    }
    if (context_.lights.environment().has_density()) {
        const auto sample = [&](Vec2f square) {
            test(v, shade::test_environment(*v.for_eye, context_.lights.environment(), {square}, counts), each, per_hit);
        };
        if (per_hit > 1) for_squares(numbers(v, Use::Light, environment_slot()), v.first_of(per_hit), per_hit, sample);
        else sample(light_square(v, environment_slot()));
    }
}

// Adds samples of the placed lights outside the tree: of all, or of one in each of as many parts of the list as there are
// slots.
void Integrator::gather_placed(const Vertex& v, int slots)
{
    const auto& lights = context_.lights.lights();
    const int light_count = static_cast<int>(context_.lights.lights_outside_tree());
    const int per_hit = light_samples_at(v.path);
    const float chance = light_count > slots ? static_cast<float>(slots) / static_cast<float>(light_count) : 1;
    const PlacedSamples samples{v.lit_share / (static_cast<float>(per_hit) * chance), static_cast<float>(per_hit) * chance};
    for (int slot = 0; slot < slots; ++slot) {
        if (light_count == slots) {
            const shade::WorldLight& light = lights[std::size_t(slot)];
            gather_light(v, light, samples, [&](const auto& sample) {
                if (per_hit > 1) for_squares(numbers(v, Use::Light, slot), v.first_of(per_hit), per_hit, sample);
                else sample(light.has_extent() ? light_square(v, slot) : Vec2f(0.5f));
            });
            continue;
        }
        const Sequence squares = numbers(v, Use::Light, slot), choices = numbers(v, Use::LightChoice, slot);
        for (int n = 0; n < per_hit; ++n) {
            const std::uint32_t index = v.first_of(per_hit) + static_cast<std::uint32_t>(n);
            const float at = (static_cast<float>(slot) + choices.interval(index)) / static_cast<float>(slots);
            const int light = std::min(static_cast<int>(at * static_cast<float>(light_count)), light_count - 1);
            gather_light(v, lights[std::size_t(light)], samples, [&](const auto& sample) { sample(squares.square(index)); });
        }
    }
}

void Integrator::gather_from_tree(const Vertex& v, int first_slot)
{
    const shade::LightTree& tree = context_.lights.tree();
    const int per_hit = light_samples_at(v.path), draws = tree_draws_at(v.path);
    const Sequence choices = numbers(v, Use::LightChoice, first_slot);
    for (int n = 0; n < per_hit; ++n) {
        shade::LightTree::Pick picks[kTreeDraws];
        const std::uint32_t index = v.first_of(per_hit) + static_cast<std::uint32_t>(n);
        const int count = tree.draw(v.receiver, choices.interval(index), std::span(picks, std::size_t(draws)));
        for (int k = 0; k < count; ++k) prefetch_object(context_.lights.lights()[picks[k].light]);
        for (int k = 0; k < count; ++k) {
            const float expected = static_cast<float>(per_hit) * picks[k].expected;
            const shade::WorldLight& light = context_.lights.lights()[picks[k].light];
            gather_light(v, light, {v.lit_share / expected, expected}, [&](const auto& sample) {
                sample(light.has_extent()
                           ? numbers(v, Use::Light, kFirstTreeSlot + static_cast<int>(picks[k].light)).square(index)
                           : Vec2f(0.5f));
            });
        }
    }
}

template <class Draw>
void Integrator::gather_light(const Vertex& v, const shade::WorldLight& light, const PlacedSamples& samples, Draw&& draw)
{
    if ((light.groups & v.hit.lit_by) == 0) return;
    const int per_hit = light_samples_at(v.path);
    // Lights without an extent are found by their samples alone in any case.
    const bool is_left_to_samples = light.has_extent() && shade::FrameLights::is_left_to_samples(light, v.start, v.peak);
    const shade::SampleCounts counts{samples.expected, is_left_to_samples ? 0.0f : float(scatter_samples_at(v.path))};
    const Vec3f to_middle(light.position - v.start);
    draw([&](Vec2f square) {
        test(v, shade::test_of(*v.for_eye, light.sample_from(to_middle, {square}), counts), samples.share, per_hit);
    });
}

void Integrator::gather_sky(const Vertex& v)
{
    if (!(v.occlusion > 0)) return;
    const int samples = light_samples_at(v.path);
    // What passes a surface beside its gaps, as through clear glass, is seen behind it and not on it.
    const Vec3f clear = v.surface.transmittance - Vec3f(1 - v.surface.opacity);
    const Vec3f share = v.lit_share * (Vec3f(1) - clear / v.surface.opacity);
    if (is_black(share)) return;
    const shade::ShadingFrame axes(v.surface.normal);
    const Sequence squares = numbers(v, Use::Scatter);
    const float reach = context_.settings.ao_distance > 0 ? context_.scale.to_frame(context_.settings.ao_distance)
                                                          : std::numeric_limits<float>::infinity();
    for (int n = 0; n < samples; ++n) {
        const Vec3f direction = axes.to_world(
            shade::cosine_direction(squares.square(v.first_of(samples) + static_cast<std::uint32_t>(n))));
        if (!(glm::dot(direction, v.surface.normal_geometric) > 0)) continue;
        const Vec3f absorption = absorption_along(v, direction);
        const Vec3f unabsorbed = share * (v.occlusion / static_cast<float>(samples));
        const Vec3f light = unabsorbed * left_by_body(absorption, reach);
        if (context_.log) context_.log->light_sample(direction, reach, light);
        accel::Ray& ray = shadows_.add(v.path.sample, light, v.limit);
        ray.origin = v.surface.start(direction);
        ray.direction = direction;
        ray.start_level = v.hit.start_level;
        ray.time = v.ray.time;
        ray.t_far = reach;
        const float density = glm::dot(direction, v.surface.normal) / shade::kPi;
        ray.footprint = shade::scattered_beam({v.width, 0}, density, samples * context_.settings.spp);
        if (absorption != Vec3f(0)) shadows_.starts_in_body(absorption, unabsorbed);
    }
}

accel::Ray Integrator::scattered_ray(const Vertex& v, const shade::ScatterSample& s, int samples) const noexcept
{
    accel::Ray ray;
    ray.origin = v.surface.start(s.direction);
    ray.direction = s.direction;
    ray.start_level = v.hit.start_level;
    const bool stays = glm::dot(s.direction, v.surface.normal_geometric) >= 0;
    ray.start_side = stays ? v.hit.side : accel::other_side(v.hit.side);
    ray.time = v.ray.time;
    ray.kinds = kind_of(s.lobe);
    const shade::Beam beam{v.width, v.ray.footprint.b};
    const float cosine = std::max(glm::dot(v.surface.normal, v.surface.to_eye), 0.0f);
    lod::Footprint smooth{beam.width, 0};
    if (s.lobe == shade::Lobe::Transmission) {
        smooth.b = std::max(beam.spread, 0.0f);
        if (v.surface.is_solid)
            smooth = shade::refracted_footprint(beam, v.hit.curvature, cosine,
                                                std::fabs(glm::dot(v.surface.normal, s.direction)), v.surface.eta);
    } else if (s.lobe != shade::Lobe::Diffuse) {
        smooth = shade::mirrored_beam(beam, v.hit.curvature, cosine);
    }
    ray.footprint = shade::followable(shade::scattered_beam(smooth, s.density, samples * context_.settings.spp),
                                      context_.settings.shading_rate);
    return ray;
}

bool Integrator::needs_scattering(const Vertex& v) const noexcept
{
    const bool is_direct = context_.settings.integrator == IntegratorKind::Direct;
    const bool goes_on = v.path.bounces < context_.settings.bounces &&
                         !(is_direct && shade::narrowest_lobe(v.surface) > kMirrorAlpha);
    return goes_on || !context_.lights.leaves_all_to_samples(v.start, v.peak, v.hit.lit_by);
}

void Integrator::scatter_on(const Vertex& v, float chance)
{
    const int samples = scatter_samples_at(v.path);
    const auto scatter = [&](int n, float lobe, Vec2f square) {
        const shade::ScatterSample s = shade::sample_scatter(*v.for_eye, lobe, square);
        if (!is_black(s.weight)) follow(v, s, {n, samples, chance});
    };
    const Sequence lobes = numbers(v, Use::Lobe), squares = numbers(v, Use::Scatter);
    for (int n = 0; n < samples; ++n) {
        const std::uint32_t index = v.first_of(samples) + static_cast<std::uint32_t>(n);
        scatter(n, lobes.interval(index), squares.square(index));
    }
}

void Integrator::follow(const Vertex& v, const shade::ScatterSample& s, const ScatterNumber& number,
                        const shade::Environment::Light* sky)
{
    const Settings& settings = context_.settings;
    const bool is_last = v.path.bounces >= settings.bounces;
    const bool is_direct = settings.integrator == IntegratorKind::Direct;

    Path& next = next_paths_.emplace_back(v.path);
    next.throughput = v.share * s.weight / (static_cast<float>(number.samples) * number.chance);
    next.coverage = 0;
    next.key = scattered_key(v.path.key, static_cast<std::uint32_t>(number.n));
    next.density = s.density;
    next.peak = v.peak;
    next.receiver = v.receiver;
    next.tree_draws = static_cast<std::uint8_t>(tree_draws_at(v.path));
    next.light_samples = static_cast<float>(light_samples_at(v.path));
    next.scatter_samples = static_cast<float>(number.samples);
    next.is_before_focus = false;
    next.stands_for = v.path.stands_for / number.chance;
    next.passed = 0;
    next.straight = 1;
    ++next.bounces;
    next.absorption = absorption_along(v, s.direction);
    const accel::Ray& ray = *new (&next_rays_.emplace_back()) accel::Ray(scattered_ray(v, s, number.samples));
    if (context_.log) context_.log->scattered(s, next);

    if (is_last || (is_direct && s.alpha > kMirrorAlpha)) {
        next.is_probe = context_.lights.meshes().any_emitter();
        if (!next.is_probe) {
            look_for_light(next, ray, sky);
            drop_last();
        }
        return;
    }
    const bool is_certain = is_direct && v.path.passed < kPassedForSure;
    const float survival = is_certain ? 1 : survival_of(next.throughput);
    if (!(survival < 1)) return;
    const bool survives = numbers(v, Use::Survival).interval(v.first_of(1)) < survival;
    if (context_.log) context_.log->decided("the path goes on", survival, survives);
    if (!survives) return drop_last();
    next.throughput /= survival;
}

void Integrator::look_for_light(const Path& next, const accel::Ray& ray, const shade::Environment::Light* known_sky)
{
    // Lights without a surface and the sky need no hit: the ray is occluded or not.
    const auto add = [&](float t_far, Vec3f radiance) {
        const Vec3f left = left_by_body(next.absorption, t_far);
        const Vec3f reaches = next.throughput * left * radiance, unabsorbed = next.throughput * radiance;
        if (is_black(unabsorbed)) return;
        if (context_.log) context_.log->light_sample(ray.direction, t_far, limited(reaches, limit(next)));
        accel::Ray& shadow = shadows_.add(next.sample, reaches, limit(next));
        shadow = ray;
        shadow.t_far = t_far;
        if (next.absorption != Vec3f(0)) shadows_.starts_in_body(next.absorption, unabsorbed);
    };
    const float infinity = std::numeric_limits<float>::infinity();
    const auto cross = [&](const shade::WorldLight& light, const shade::LightCrossing& c, float expected) {
        if ((light.groups & next.receiver.groups) == 0) return;
        const shade::SampleCounts counts{next.light_samples * expected, next.scatter_samples};
        add(c.distance, c.radiance * counts.of_scatter(next.density, c.density));
    };
    context_.lights.for_crossings({ray.origin, ray.direction, infinity}, next.peak, {next.receiver, next.tree_draws}, cross);
    if (context_.lights.environment().is_black()) return;
    const shade::Environment::Light sky = known_sky ? *known_sky : context_.lights.environment().look_up(ray.direction);
    const shade::SampleCounts counts{next.light_samples, next.scatter_samples};
    add(infinity, sky.radiance * counts.of_scatter(next.density, sky.density));
}

}  // namespace occam::render
