#include "render/integrator.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "base/luminance.h"
#include "render/light_limit.h"
#include "render/path_log.h"
#include "render/shade_point.h"
#include "render/views.h"

namespace occam::render {
namespace {

// Returns the key of a path's random numbers, which is new at each of its surfaces and for each branch there.
std::uint32_t child_key(std::uint32_t key, std::uint32_t branch) noexcept
{
    return static_cast<std::uint32_t>(mix_bits((std::uint64_t(key) << 8) + branch + 1) >> 32);
}

float mean(Vec3f c) noexcept { return (c.x + c.y + c.z) / 3; }

}  // namespace

Integrator::Integrator(const FrameContext& context)
    : context_(context),
      texture_width_(sample_width(context.settings.spp)),
      has_mattes_(context.settings.has(Aov::CryptomatteObject) || context.settings.has(Aov::CryptomatteMaterial)),
      shows_cost_(shows_cost(context.settings.view)),
      wants_occlusion_(context.settings.integrator == IntegratorKind::Ao || context.settings.has(Aov::Occlusion)),
      shadows_(context.textures, context.passes, context.scale, {context.may_pass, texture_width_, context.log}),
      eye_body_(context.textures, context.passes, texture_width_),
      seeks_eye_body_(context.may_start_in_body && context.settings.view == View::Beauty)
{
    waits_ = !context.log && context.settings.light_samples == 1 && context.lights.tree().is_empty() &&
             context.lights.lights_outside_tree() <= static_cast<std::size_t>(kMaxLightsPerHit);
    surfaces_to_draw_.light_slots = light_slots_to_draw();
}

void Integrator::place(std::span<const CameraSample> samples, std::span<SampleResult> results) const
{
    constexpr std::size_t kBlock = SurfacesToDraw::kMost;
    SurfacesToDraw block;
    for (std::size_t first = 0; first < samples.size(); first += kBlock) {
        const std::size_t count = std::min(kBlock, samples.size() - first);
        for (std::size_t k = 0; k < count; ++k) {
            block.x[k] = samples[first + k].x;
            block.y[k] = samples[first + k].y;
            block.index[k] = static_cast<std::uint32_t>(samples[first + k].index);
        }
        Vec2f in_pixel[kBlock];
        context_.sampler.draw_in_pixels(block, in_pixel);
        for (std::size_t k = 0; k < count; ++k) {
            const PixelFilter::Place place = context_.filter.place(in_pixel[k]);
            results[first + k] = {};
            results[first + k].offset = place.offset;
            results[first + k].weight = place.weight;
        }
    }
}

void Integrator::begin(std::span<const CameraSample> samples, std::span<SampleResult> results)
{
    Path path;
    path.is_before_focus = context_.camera.ends_at_focus();
    paths_.assign(samples.size(), path);
    rays_.resize(samples.size());
    mattes_.clear();
    waiting_count_ = 0;
    lit_.assign(samples.size(), Vec3f(0));
    luck_.assign(samples.size(), 0);
    place(samples, results);
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const CameraSample& s = samples[i];
        if (shadows_.may_pass())
            luck_[i] = context_.sampler.interval(s.x, s.y, static_cast<std::uint32_t>(s.index), Dimension::luck());
        const Vec2f lens = context_.camera.has_lens()
                               ? context_.sampler.square(s.x, s.y, static_cast<std::uint32_t>(s.index), Dimension::lens())
                               : Vec2f(0.5f);
        const float time = context_.moves
                               ? context_.sampler.interval(s.x, s.y, static_cast<std::uint32_t>(s.index), Dimension::time())
                               : 0.0f;
        paths_[i].sample = static_cast<std::uint32_t>(i);
        new (&rays_[i]) accel::Ray(context_.camera.ray(s.x + 0.5 + double(results[i].offset.x),
                                                       s.y + 0.5 + double(results[i].offset.y), lens, time));
    }
    counters_.rays.primary += samples.size();
}

void Integrator::log_eye_body() const
{
    if (context_.log) context_.log->starts_in(paths_.front().absorption);
}

std::size_t Integrator::end_of_chunk(std::size_t first) const noexcept
{
    constexpr std::size_t kHitsAtOnce = 4096;
    const std::size_t most = hits_of_each_ == 1 ? paths_.size() : kHitsAtOnce / static_cast<std::size_t>(hits_of_each_);
    std::size_t end = first;
    while (end < paths_.size() && end - first < most && hits_at_once(paths_[end]) == hits_of_each_) ++end;
    return end;
}

std::size_t Integrator::shade_some(std::size_t first, std::size_t end, std::span<const CameraSample> samples,
                                   std::span<SampleResult> results)
{
    const Stopwatch watch(counters_.shade_seconds);
    shadows_.clear();
    std::size_t i = first;
    for (; i < end && shadows_.size() < context_.shadow_batch; ++i) {
        const std::uint32_t sample = paths_[i].sample;
        const accel::HitCount known = hit_counts_[i - first_of_chunk_];
        const accel::SurfaceHit* hit = &hits_[(i - first_of_chunk_) * static_cast<std::size_t>(hits_of_each_)];
        const accel::SurfaceHit* const last = hit + known.count;
        bool goes_on = true;
        for (; goes_on && hit != last; ++hit) {
            if (paths_[i].is_camera()) count_cells(rays_[i], *hit);
            goes_on = shade_hit(i, *hit, samples[sample], results[sample]);
        }
        if (!goes_on) continue;
        shade_waiting();
        if (known.is_all) shade_miss(i, results[sample]);
        else push(paths_[i], rays_[i]);
    }
    shade_waiting();
    return i;
}

void Integrator::count_cells(const accel::Ray& ray, const accel::SurfaceHit& hit)
{
    constexpr double kSteepest = 0.1;  // least cosine, since at a silhouette the area of the surface has no bound
    const double facing = std::abs(double(glm::dot(hit.normal_geometric, ray.direction))),
                 rate = double(context_.settings.shading_rate);
    counters_.visible_cells += 1 / (std::max(facing, kSteepest) * rate * rate);
}

void Integrator::shade_miss(std::size_t i, SampleResult& result)
{
    const Path& path = paths_[i];
    const accel::Ray& ray = rays_[i];
    if (path.is_before_focus) {
        Path next = path;
        next.is_before_focus = false;
        const accel::Ray rest = context_.camera.behind_focus(ray);
        next.throughput *= left_by_body(path.absorption, start_of(rest) - start_of(ray));
        push(next, rest);
        return;
    }
    if (shows_cost_) {
        result.radiance += path.throughput * cost_color(context_.settings.view, costs_[i - first_of_chunk_]);
        result.alpha += path.coverage;
        return;
    }
    if (!path.is_camera()) {
        cross_lights(path, ray, std::numeric_limits<float>::infinity(), result);
        const shade::Environment::Light sky = context_.lights.environment().look_up(ray.direction);
        const float weight = shade::SampleCounts{path.light_samples, path.scatter_samples}.of_scatter(path.density,
                                                                                                      sky.density);
        const Vec3f light = limited(path.throughput * sky.radiance * weight, limit(path));
        result.radiance += light;
        if (context_.log) context_.log->added("the environment", light);
        return;
    }
    if (!context_.settings.background || context_.settings.view != View::Beauty) return;
    const bool is_ao = context_.settings.integrator == IntegratorKind::Ao;
    const Vec3f light = path.throughput * (is_ao ? Vec3f(1) : context_.lights.environment().radiance(ray.direction));
    result.radiance += light;
    result.alpha += path.coverage;
    if (context_.log) context_.log->added("the background", light);
}

void Integrator::cross_lights(const Path& path, const accel::Ray& ray, float t_far, SampleResult& result) const
{
    const auto add = [&](const shade::WorldLight& light, const shade::LightCrossing& crossing, float expected) {
        if (crossing.distance <= ray.t_near || (light.groups & path.receiver.groups) == 0) return;
        const shade::SampleCounts counts{path.light_samples * expected, path.scatter_samples};
        const float weight = counts.of_scatter(path.density, crossing.density);
        const Vec3f arrives = path.throughput * left_by_body(path.absorption, crossing.distance - start_of(ray));
        const Vec3f found = limited(arrives * crossing.radiance * weight, limit(path));
        result.radiance += found;
        if (context_.log) context_.log->added("a light that the ray crosses", found);
    };
    context_.lights.for_crossings({ray.origin, ray.direction, t_far}, path.peak, {path.receiver, path.tree_draws}, add);
}

Vec2f Integrator::motion_of(const accel::Ray& ray, const accel::SurfaceHit& hit) const
{
    if (!context_.settings.has(Aov::Motion) || !context_.moves) return Vec2f(0);
    const Vec2d per_shutter = context_.camera.pixel_velocity(hit.position, Vec3d(hit.velocity), ray.time);
    return Vec2f(per_shutter / context_.settings.shutter.length());
}

void Integrator::record_first(const accel::Ray& ray, const accel::SurfaceHit& hit, const shade::Surface& surface,
                              float occlusion, float covered, SampleResult& result) const
{
    if (covered > 0 && result.alpha == 0) {
        const double to_world = context_.scale.to_world();
        result.first = {static_cast<float>(context_.camera.depth(hit.position, ray.time) * to_world),
                        hit.normal_shading,
                        hit.normal_geometric,
                        hit.uv[0],
                        Vec3f(hit.position * to_world),
                        static_cast<float>(hit.node.slot + 1),
                        motion_of(ray, hit)};
    }
    result.alpha += covered;
    result.albedo += Vec4f(surface.base_color, 1) * covered;
    result.normal += surface.normal * covered;
    result.occlusion += occlusion * covered;
}

void Integrator::record_matte(const accel::SurfaceHit& hit, std::uint32_t sample, float covered)
{
    if (!has_mattes_ || !(covered > 0)) return;
    mattes_.push_back(
        {sample, matte_id(matte_name(*context_.scene, hit.node)), matte_id(matte_name(*hit.material)), covered});
}

void Integrator::add_emission(const Path& path, const accel::SurfaceHit& hit, const shade::Surface& surface, Vec3f share,
                              SampleResult& result) const
{
    if (surface.emission == Vec3f(0)) return;
    float weight = 1;
    if (!path.is_camera()) {
        const float per_area = context_.lights.meshes().area_density(
            {hit.node, hit.cage, hit.material, hit.face, hit.position, hit.self_distance}, path.receiver.of_all_groups());
        const float cosine = std::max(glm::dot(surface.normal_geometric, surface.to_eye), 1e-6f);
        weight = shade::SampleCounts{path.light_samples, path.scatter_samples}.of_scatter(path.density,
                                                                                          per_area * hit.t * hit.t / cosine);
    }
    const Vec3f light = limited(share * surface.emission * weight, limit(path));
    result.radiance += light;
    if (context_.log) context_.log->added("the emission of the surface", light);
    if (path.is_camera()) result.emitted += luminance(share * surface.emission);
}

void Integrator::set_receiver(Vertex& v) const noexcept
{
    v.receiver.groups = v.hit.lit_by;
    if (!context_.lights.needs_receivers()) return;
    v.receiver.point = context_.lights.relative(v.start);
    v.receiver.normal = v.surface.normal_geometric;
    v.receiver.is_two_sided = v.surface.is_solid || v.surface.transmission != Vec3f(0);
}

bool Integrator::shade_hit(std::size_t i, const accel::SurfaceHit& hit, const CameraSample& sample, SampleResult& result)
{
    const accel::Ray& ray = rays_[i];
    Waiting& slot = waiting_[static_cast<std::size_t>(waiting_count_)];
    Path& path = slot.path;
    path = paths_[i];
    const Settings& settings = context_.settings;
    // Only the last piece of a ray knows which lights lie before its end: those behind a surface that it passes come
    // later.
    if (!path.is_camera()) cross_lights(path, ray, hit.t, result);
    path.throughput *= left_by_body(path.absorption, hit.t - start_of(ray));

    counters_.hits_looked_up += hit.phase_one_channels == 0;
    const shade::ShadePoint point = shade_point(ray, hit, texture_width_);
    // It is made in place, as the vertex is.
    const shade::Surface& surface = *new (&slot.surface)
                                        shade::Surface(shade::evaluate(point, context_.textures, plain_surfaces_));
    const float occlusion = wants_occlusion_ ? shade::ambient_share(point, context_.textures) : 1;
    const float covered = path.coverage * surface.opacity;
    if (path.is_camera()) {
        record_first(ray, hit, surface, occlusion, covered, result);
        record_matte(hit, path.sample, covered);
    }
    if (context_.log) context_.log->surface(path, hit, surface);
    const Vec3f share = path.throughput * surface.opacity;
    Vec3f transmittance = surface.transmittance, absorption = surface.absorption_behind(hit.back_side, path.absorption);
    Vertex& v = *new (slot.vertex) Vertex{path, ray, hit, sample, surface, share, share, 0, occlusion};
    set_receiver(v);
    const Chances chance = chances(v);
    if (chance.light > 0) {
        if (chance.light < 1) v.lit_share = share / chance.light;
        v.limit = limit(path.bounces + 1, path.stands_for / chance.light);
    }

    if (settings.view != View::Beauty) {
        const float z = static_cast<float>(context_.camera.depth(hit.position, ray.time));
        result.radiance += share * (shows_cost_ ? cost_color(settings.view, costs_[i - first_of_chunk_])
                                                : view_color(settings.view, hit, z, context_.depth_near, context_.depth_far,
                                                             context_.scene));
        transmittance = Vec3f(1 - surface.opacity);
        absorption = path.absorption;
    } else if (surface.opacity > 0 && settings.integrator == IntegratorKind::Ao) {
        if (chance.light > 0) gather_sky(v);
    } else if (surface.unlit) {
        if (!path.is_probe) result.radiance += limited(share * surface.base_color, limit(path));
        if (path.is_camera()) result.emitted += luminance(share * surface.base_color);
    } else if (surface.opacity > 0) {
        add_emission(path, hit, surface, share, result);
        const bool scatters = !path.is_probe && !surface.only_passes();
        if (scatters && (chance.light > 0 || chance.scatter > 0)) shade_or_wait(v, chance);
    }
    if (!(chance.pass > 0)) return false;
    if (path.is_camera() && chance.pass == 1 && chance.scatter > 0) ++path.splits;
    return pass_straight(i, path, hit.t, {transmittance, path.coverage - covered, chance.pass, absorption}, sample);
}

Integrator::Chances Integrator::chances_of_both(const Vertex& v) const
{
    float light = lighting_chance(v.path.straight * v.surface.opacity, v.path.passed);
    if (light < 1) {
        const bool is_lit = numbers(v, Dimension::Use::Faint).interval(v.first_of(1)) < light;
        if (context_.log) context_.log->decided("the surface is lit", light, is_lit);
        if (!is_lit) light = 0;
    }
    if (v.path.is_camera() && v.path.splits < kMaxSplits) return {1, light, light};
    const float pass = std::clamp(mean(v.surface.transmittance), 0.05f, 1 - kLeastShare);
    const bool is_passing = numbers(v, Dimension::Use::Passing).interval(v.first_of(1)) < pass;
    if (context_.log) context_.log->decided("the ray goes straight on and is not scattered", pass, is_passing);
    return is_passing ? Chances{pass, 0, light} : Chances{0, 1 - pass, light};
}

bool Integrator::pass_straight(std::size_t i, const Path& path, float t, const Passing& passing, const CameraSample& sample)
{
    Path next = path;
    next.throughput *= passing.light / passing.chance;
    next.coverage = passing.coverage / passing.chance;
    next.stands_for /= passing.chance;
    next.absorption = passing.absorption;
    next.key = child_key(path.key, 0);
    next.passed = static_cast<std::uint16_t>(std::min(path.passed + 1, 0xffff));
    next.straight *= std::max({passing.light.x, passing.light.y, passing.light.z}) / passing.chance;
    const float share = std::max({next.throughput.x, next.throughput.y, next.throughput.z, next.coverage});
    const float chance = path.is_camera() ? passing_chance(share)
                                          : std::min(passing_chance(share), passing_chance(next.straight, next.passed));
    if (context_.log) context_.log->passes(passing.light, chance > 0);
    if (!(chance > 0)) return false;
    if (chance < 1) {
        const Dimension survival = Dimension::at(next.key, Dimension::Use::Survival, 1);
        const auto index = static_cast<std::uint32_t>(sample.index);
        const bool goes_on = context_.sampler.interval(sample.x, sample.y, index, survival) < chance;
        if (context_.log) context_.log->decided("the ray goes on", chance, goes_on);
        if (!goes_on) return false;
        next.throughput /= chance;
        next.coverage /= chance;
        next.stands_for /= chance;
        next.straight /= chance;
    }
    paths_[i] = next;
    rays_[i] = behind(rays_[i], t);
    ++passed_;
    return true;
}

void Integrator::push(const Path& path, const accel::Ray& ray)
{
    next_paths_.push_back(path);
    next_rays_.push_back(ray);
}

void Integrator::group_by_hits()
{
    const auto count = [this](const Path& path) { return hits_at_once(path); };
    if (std::ranges::is_sorted(paths_, {}, count)) return;
    std::vector<std::uint32_t> order(paths_.size());
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return count(paths_[i]); });
    for (const std::uint32_t i : order) push(paths_[i], rays_[i]);
    paths_.swap(next_paths_);
    rays_.swap(next_rays_);
    next_paths_.clear();
    next_rays_.clear();
}

void Integrator::extend()
{
    context_.passes.spend(std::exchange(passed_, 0));
    paths_.swap(next_paths_);
    rays_.swap(next_rays_);
    next_paths_.clear();
    next_rays_.clear();
    group_by_hits();
    for (std::size_t i = 0; i < paths_.size(); ++i) {
        const std::uint8_t kinds = rays_[i].kinds;
        std::uint64_t& count = (kinds & accel::RayKind::Camera) != 0    ? counters_.rays.primary
                               : (kinds & accel::RayKind::Diffuse) != 0 ? counters_.rays.diffuse
                                                                        : counters_.rays.glossy;
        ++count;
    }
}

}  // namespace occam::render
