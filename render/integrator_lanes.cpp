// The work of an integrator at several hits side by side: what integrator_light.cpp does at one.
#include <algorithm>
#include <limits>

#include "render/integrator.h"

namespace occam::render {
namespace {

// Lanes do not pay for fewer surfaces.
constexpr int kFewestInLanes = std::min(3, kLanes);

}  // namespace

bool Integrator::may_wait(const Vertex& v, const Chances& chance) const noexcept
{
    return waits_ && !(chance.pass > 0) && chance.light == 1 && chance.scatter == 1 && shade::SurfaceLanes::takes(v.surface);
}

void Integrator::shade_or_wait(std::size_t i, Vertex& v, const Chances& chance)
{
    v.drawn = numbers_of(i, v);
    if (may_wait(v, chance)) {
        if (++waiting_count_ == kLanes) shade_waiting();
        return;
    }
    shade_waiting();
    gather_and_scatter(v, chance);
}

void Integrator::shade_waiting()
{
    const int count = waiting_count_;
    waiting_count_ = 0;
    const auto vertex = [&](int k) -> Vertex& { return waiting_[static_cast<std::size_t>(k)].at(); };
    if (count < kFewestInLanes) {
        for (int k = 0; k < count; ++k) gather_and_scatter(vertex(k), {0, 1, 1});
        return;
    }
    shade::SurfaceLanes surfaces;
    for (int k = 0; k < kLanes; ++k) surfaces.set(k, vertex(std::min(k, count - 1)).surface);
    surfaces.complete();
    shade::LaneFloats lobe, u, v, peak;
    peak = surfaces.peak_density();
    bool is_scattered[kLanes] = {}, any_scattered = false;
    for (int k = 0; k < kLanes; ++k) {
        Vertex& of = vertex(std::min(k, count - 1));
        of.peak = peak.of[k];
        lobe.of[k] = of.drawn.lobe;
        u.of[k] = of.drawn.scatter.x;
        v.of[k] = of.drawn.scatter.y;
        is_scattered[k] = k < count && needs_scattering(of);
        any_scattered |= is_scattered[k];
    }
    tests_.clear();
    gather_in_lanes(surfaces, count);
    shade::SurfaceLanes::Samples samples;
    if (any_scattered) samples = surfaces.sample_scatter(lobe.lanes(), u.lanes(), v.lanes());
    const bool sees_sky = any_scattered && context_.lights.environment().has_density() &&
                          !context_.lights.meshes().any_emitter();
    shade::Environment::Light skies[kLanes];
    if (sees_sky) {
        Vec3f directions[kLanes];
        for (int k = 0; k < kLanes; ++k) directions[k] = samples.direction.at(k);
        context_.lights.environment().look_up(directions, skies);
    }
    for (int k = 0; k < count; ++k) {
        const Vertex& of = vertex(k);
        for (const LightTests& t : tests_) {
            const Vec3f radiance = t.samples.radiance.at(k), direction = t.samples.direction.at(k);
            if (!(radiance.x > 0 || radiance.y > 0 || radiance.z > 0)) continue;
            shoot(of, {of.surface.start(direction), direction, t.samples.distance.of[k], radiance, t.samples.density.of[k]},
                  of.lit_share, t.spread.of[k]);
        }
        if (is_scattered[k] && (samples.not_black >> k & 1) != 0)
            follow(of, samples.at(k, of.surface), {0, 1, 1}, sees_sky ? &skies[k] : nullptr);
    }
}

void Integrator::gather_in_lanes(const shade::SurfaceLanes& surfaces, int count)
{
    const auto vertex = [&](int k) -> const Vertex& {
        return waiting_[static_cast<std::size_t>(std::min(k, count - 1))].at();
    };
    const shade::FrameLights& all = context_.lights;
    const vfloat one = 1.0f, zero = 0.0f;
    shade::LanePoints position, start;
    shade::LaneFloats peak, width;
    for (int k = 0; k < kLanes; ++k) {
        position.set(k, vertex(k).surface.position);
        start.set(k, vertex(k).start);
        peak.of[k] = vertex(k).peak;
        width.of[k] = vertex(k).width;
    }
    const auto add = [&](const shade::LightSampleLanes& sample, vfloat scatter_count) {
        LightTests& test = tests_.emplace_back();
        test.samples = surfaces.test_of(sample, one, scatter_count);
        test.spread = shade::light_spread<vfloat>(width.lanes(), sample.distance, sample.density,
                                                  static_cast<float>(context_.settings.spp));
    };
    const int slots = static_cast<int>(all.lights_outside_tree());
    for (int slot = 0; slot < slots; ++slot) {
        const shade::WorldLight& light = all.lights()[static_cast<std::size_t>(slot)];
        shade::LaneFloats u, v, is_lit;
        for (int k = 0; k < kLanes; ++k) {
            const Vec2f square = light.has_extent() ? light_square(vertex(k), slot) : Vec2f(0.5f);
            u.of[k] = square.x;
            v.of[k] = square.y;
            is_lit.of[k] = (light.groups & vertex(k).hit.lit_by) != 0 ? 1.0f : 0.0f;
        }
        // Lights without an area are found by their samples alone in any case.
        vfloat scatter_count = one;
        if (light.has_area())
            scatter_count = select(shade::is_left_to_samples(light, start.to(light.position).lanes(), peak.lanes()), zero,
                                   one);
        shade::LightSampleLanes sample = shade::sample_from(light, position.to(light.position), u, v);
        sample.radiance = select(is_lit.lanes() > zero, sample.radiance, shade::all_channels(zero));
        add(sample, scatter_count);
    }
    shade::LightSamples samples;
    if (!all.meshes().is_empty()) {
        for (int k = 0; k < kLanes; ++k) {
            const Vertex& of = vertex(k);
            const shade::LightNumbers u{light_square(of, slots),
                                        numbers(of, Use::LightChoice, slots).interval(of.first_of(1))};
            samples.set(k, all.meshes().sample(of.surface.position, of.receiver.of_all_groups(), u));
        }
        add(samples.lanes(), one);
    }
    if (all.environment().has_density()) {
        Vec2f squares[kLanes];
        shade::Environment::Light lights[kLanes];
        for (int k = 0; k < kLanes; ++k) squares[k] = light_square(vertex(k), environment_slot());
        all.environment().draw(squares, lights);
        for (int k = 0; k < kLanes; ++k) samples.set(k, shade::sample_of(lights[k]));
        add(samples.lanes(), one);
    }
}

}  // namespace occam::render
