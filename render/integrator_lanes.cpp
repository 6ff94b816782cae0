// The work of an integrator at several hits side by side: what integrator_light.cpp does at one.
#include <algorithm>

#include "render/integrator.h"

namespace occam::render {
namespace {

// Lanes do not pay for fewer surfaces.
constexpr int kFewestInLanes = std::min(3, kLanes);

}  // namespace

bool Integrator::may_wait(const Vertex& v, const Chances& chance) const noexcept
{
    const bool is_whole = !(chance.pass > 0) && chance.light == 1 && chance.scatter == 1;
    return waits_ && is_whole && v.path.absorption == Vec3f(0) && shade::SurfaceLanes::takes(v.surface);
}

void Integrator::shade_or_wait(Vertex& v, const Chances& chance)
{
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
    if (count < kFewestInLanes) {
        for (int k = 0; k < count; ++k) gather_and_scatter(waiting(k), {0, 1, 1});
        return;
    }
    shade::SurfaceLanes surfaces;
    for (int k = 0; k < kLanes; ++k) surfaces.set(k, waiting(std::min(k, count - 1)).surface);
    surfaces.complete();
    draw_for_waiting(count);
    shade::LaneFloats peak;
    peak = surfaces.peak_density();
    bool is_scattered[kLanes] = {}, any_scattered = false;
    for (int k = 0; k < kLanes; ++k) {
        Vertex& of = waiting(std::min(k, count - 1));
        of.peak = peak.of[k];
        is_scattered[k] = k < count && needs_scattering(of);
        any_scattered |= is_scattered[k];
    }
    tests_.clear();
    gather_in_lanes(surfaces, count);
    shade::SurfaceLanes::Samples samples;
    if (any_scattered)
        samples = surfaces.sample_scatter(vfloat::load(drawn_.lobe), vfloat::load(drawn_.scatter.x),
                                          vfloat::load(drawn_.scatter.y));
    const bool sees_sky = any_scattered && context_.lights.environment().has_density() &&
                          !context_.lights.meshes().any_emitter();
    shade::Environment::Light skies[kLanes];
    if (sees_sky) {
        Vec3f directions[kLanes];
        for (int k = 0; k < kLanes; ++k) directions[k] = samples.directions.vector(k);
        context_.lights.environment().look_up(directions, skies);
    }
    for (int k = 0; k < count; ++k) {
        const Vertex& of = waiting(k);
        for (const LightTests& t : tests_) {
            if ((t.not_black >> k & 1) == 0) continue;
            const Vec3f direction = t.directions.vector(k), radiance = t.radiances.vector(k);
            shoot(of,
                  {of.start, direction, t.directions.number(k), radiance, t.radiances.number(k), t.kinds[std::size_t(k)]},
                  radiance * of.lit_share, t.spread.of[k]);
        }
        if (is_scattered[k] && (samples.not_black >> k & 1) != 0)
            follow(of, samples.at(k, of.surface), {0, 1, 1}, sees_sky ? &skies[k] : nullptr);
    }
}

void Integrator::gather_in_lanes(const shade::SurfaceLanes& surfaces, int count)
{
    const auto vertex = [&](int k) -> const Vertex& { return waiting(std::min(k, count - 1)); };
    const shade::FrameLights& all = context_.lights;
    gather_placed_in_lanes(surfaces, count);
    shade::LightSamples samples;
    if (!all.meshes().is_empty()) {
        const int slot = environment_slot() - 1;
        for (int k = 0; k < kLanes; ++k) {
            const Vertex& of = vertex(k);
            const SurfaceNumbers::Squares& squares = drawn_.light[slot];
            const shade::LightNumbers u{Vec2f(squares.x[k], squares.y[k]),
                                        numbers(of, Use::LightChoice, slot).interval(of.first_of(1))};
            samples.set(k, all.meshes().sample(of.start, of.receiver.of_all_groups(), u));
        }
        add_tests(surfaces, samples.lanes(), 1.0f);
        tests_.back().kinds = samples.kinds;
    }
    if (all.environment().has_density()) {
        Vec2f squares[kLanes];
        shade::Environment::Light lights[kLanes];
        const SurfaceNumbers::Squares& drawn = drawn_.light[environment_slot()];
        for (int k = 0; k < kLanes; ++k) squares[k] = {drawn.x[k], drawn.y[k]};
        all.environment().draw(squares, lights);
        for (int k = 0; k < kLanes; ++k) samples.set(k, shade::sample_of(lights[k]));
        add_tests(surfaces, samples.lanes(), 1.0f);
    }
}

void Integrator::gather_placed_in_lanes(const shade::SurfaceLanes& surfaces, int count)
{
    const vfloat one = 1.0f, zero = 0.0f;
    shade::LanePoints start;
    shade::LaneFloats peak;
    for (int k = 0; k < kLanes; ++k) {
        const Vertex& of = waiting(std::min(k, count - 1));
        start.set(k, of.start);
        peak.of[k] = of.peak;
        widths_.of[k] = of.width;
    }
    const int slots = static_cast<int>(context_.lights.lights_outside_tree());
    for (int slot = 0; slot < slots; ++slot) {
        const shade::WorldLight& light = context_.lights.lights()[static_cast<std::size_t>(slot)];
        const SurfaceNumbers::Squares& squares = drawn_.light[slot];
        const bool has_extent = light.has_extent();
        shade::LaneFloats u, v, is_lit;
        for (int k = 0; k < kLanes; ++k) {
            u.of[k] = has_extent ? squares.x[k] : 0.5f;
            v.of[k] = has_extent ? squares.y[k] : 0.5f;
            is_lit.of[k] = (light.groups & waiting(std::min(k, count - 1)).hit.lit_by) != 0 ? 1.0f : 0.0f;
        }
        // Lights without an extent are found by their samples alone in any case.
        vfloat scatter_count = one;
        const shade::LaneVectors to_middle = start.to(light.position);
        if (has_extent) scatter_count = select(shade::is_left_to_samples(light, to_middle.lanes(), peak.lanes()), zero, one);
        shade::LightSampleLanes sample = shade::sample_from(light, to_middle, u, v);
        sample.radiance = select(is_lit.lanes() > zero, sample.radiance, shade::all_channels(zero));
        add_tests(surfaces, sample, scatter_count);
    }
}

void Integrator::add_tests(const shade::SurfaceLanes& surfaces, const shade::LightSampleLanes& sample, vfloat scatter_count)
{
    const vfloat one = 1.0f, zero = 0.0f, spp = static_cast<float>(context_.settings.spp);
    const shade::LightSampleLanes found = surfaces.test_of(sample, one, scatter_count);
    const shade::VecLanes& radiance = found.radiance;
    LightTests& test = tests_.emplace_back();
    test.kinds.fill(accel::RayKind::Shadow);
    test.directions.set(found.direction, found.distance);
    test.radiances.set(radiance, found.density);
    test.not_black = bits((radiance.x > zero) | (radiance.y > zero) | (radiance.z > zero));
    test.spread = shade::light_spread<vfloat>(widths_.lanes(), sample.distance, sample.density, spp);
}

}  // namespace occam::render
