// The suite measures secondary rays per second by kind, with their footprints and without, and what shading costs.
//
// "Without" means that each ray keeps the width that its parent had at the hit, so that its surfaces are as fine far away as
// they are near.
//
// The share of a lobe that belongs to one sample is longer in the plane of incidence than across it, by one over the cosine
// at the half vector (reflection doubles angles in one direction only). Footprints have one width, the mean of both. What a
// second width could save or improve lies between the figures of the smaller and the larger one.

#include <cmath>

#include "accel/frame_state.h"
#include "render/sampler.h"
#include "shade/direct.h"
#include "shade/footprints.h"
#include "tests/bench/subjects.h"
#include "tests/bench/suites.h"

namespace occam::bench {
namespace {

constexpr int kRuns = 5, kWidth = 192, kHeight = 192, kSamples = 16;
constexpr std::size_t kMemoryBytes = std::size_t(1) << 30;

struct Kind {
    const char* name;
    float alpha;  // GGX width of the lobe that rays follow
    bool is_diffuse, is_shadow;
};
constexpr Kind kKinds[] = {{"mirror", shade::kMinAlpha, false, false},
                           {"glossy, alpha 0.1", 0.1f, false, false},
                           {"diffuse", 1, true, false},
                           {"shadow of a lamp", 1, false, true}};

shade::Surface surface_at(const accel::Ray& ray, const accel::SurfaceHit& hit, const Kind& kind)
{
    shade::Surface s;
    s.position = hit.position;
    s.start_point = hit.position + Vec3d(hit.to_start);
    s.start_normal = hit.start_normal;
    s.self_distance = hit.self_distance;
    s.to_eye = -ray.direction;
    s.normal_geometric = hit.normal_geometric;
    s.normal = s.coat_normal = hit.normal_shading;
    s.alpha = kind.alpha;
    s.diffuse = Vec3f(kind.is_diffuse ? 0.8f : 0.0f);
    s.f0 = Vec3f(kind.is_diffuse ? 0.0f : 1.0f);
    if (kind.is_diffuse) s.f90 = s.dielectric_f0 = s.dielectric_f90 = 0;
    return s;
}

// Returns one ray of that kind from each hit.
std::vector<accel::Ray> secondary_rays(const Kind& kind, std::span<const accel::Ray> rays,
                                       std::span<const accel::SurfaceHit> hits, const shade::WorldLight& lamp,
                                       bool with_footprint)
{
    const render::Sampler sampler(1, kSamples, true);
    std::vector<accel::Ray> out;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const accel::SurfaceHit& hit = hits[i];
        if (!hit.is_hit()) continue;
        const shade::Surface s = surface_at(rays[i], hit, kind);
        const Vec2f square = sampler.square(int(i), 0, 0, render::Dimension::pixel());
        const float width = rays[i].footprint.at(hit.t);
        accel::Ray ray;
        if (kind.is_shadow) {
            const shade::LightSample light = lamp.sample(s.position, {square, 0.5f});
            if (light.radiance == Vec3f(0) || glm::dot(light.direction, s.normal_geometric) <= 0) continue;
            ray.direction = light.direction;
            ray.t_far = light.distance;
            ray.footprint = {width, shade::light_spread(width, light.distance, light.density, float(kSamples))};
        } else {
            const shade::ScatterSample d = shade::sample_scatter(s, 0.5f, square);
            if (d.weight == Vec3f(0)) continue;
            ray.direction = d.direction;
            const lod::Footprint smooth = kind.is_diffuse ? lod::Footprint{width, 0}
                                                          : shade::mirrored_beam({width, rays[i].footprint.b}, hit.curvature,
                                                                                 glm::dot(s.normal, s.to_eye));
            ray.footprint = shade::followable(shade::scattered_beam(smooth, d.density, kSamples), 1);
        }
        ray.origin = s.start(ray.direction);
        if (!with_footprint) ray.footprint = {width, 0};
        out.push_back(ray);
    }
    return out;
}

// Returns a square light as large as the subject, over its shoulder.
shade::WorldLight lamp_over(const Box3d& bounds)
{
    const double size = glm::length(bounds.extent());
    Mat4d m(1);
    m[0] = Vec4d(1, 0, 0, 0);
    m[1] = Vec4d(0, 0, -1, 0);
    m[2] = Vec4d(0, 1, 0, 0);
    m[3] = Vec4d((bounds.lo + bounds.hi) * 0.5 + Vec3d(0, size, 0), 1);
    return shade::WorldLight::place({"lamp", AreaLight{AreaLight::Shape::Rectangle, Vec2f(float(size)), Vec3f(1)}}, m);
}

accel::Frame levels_of_each_ray(Subject& subject)
{
    lod::LevelSettings levels = subject.frame->state().levels;
    levels.mode = lod::LevelMode::PerRay;
    return accel::Frame(subject.scene, subject.topologies, levels);
}

// Measures glossy rays from grazing hits with the share's smaller width, its mean, and its larger one.
void run_widths(Report& report, Subject& subject)
{
    const accel::Frame frame = levels_of_each_ray(subject);
    const std::vector<accel::Ray> camera = subject.camera_rays();
    accel::Tracer first(frame, kMemoryBytes);
    std::vector<accel::SurfaceHit> hits(camera.size());
    trace_closest(first, camera, hits);
    const Kind glossy{"", 0.2f, false, false};
    const render::Sampler sampler(1, kSamples, true);
    Row row{"light", subject.name + ", glossy from grazing hits"};
    double stretch = 0;
    std::size_t count = 0;
    for (const int power : {1, 0, -1}) {
        std::vector<accel::Ray> rays;
        for (std::size_t i = 0; i < camera.size(); ++i) {
            if (!hits[i].is_hit() || -glm::dot(hits[i].normal_shading, camera[i].direction) > 0.3f) continue;
            const shade::Surface s = surface_at(camera[i], hits[i], glossy);
            const shade::ScatterSample d = shade::sample_scatter(s, 0.5f,
                                                                 sampler.square(int(i), 0, 0, render::Dimension::pixel()));
            if (d.weight == Vec3f(0)) continue;
            const float cosine = glm::dot(glm::normalize(s.to_eye + d.direction), s.to_eye);
            if (power == 0) stretch += 1 / double(cosine);
            const float width = camera[i].footprint.at(hits[i].t);
            const lod::Footprint mean = shade::scattered_beam({width, 0}, d.density, kSamples);
            accel::Ray ray;
            ray.direction = d.direction;
            ray.origin = s.start(ray.direction);
            ray.footprint = shade::followable({mean.a, mean.b * std::pow(cosine, 0.5f * float(power))}, 1);
            rays.push_back(ray);
        }
        count = rays.size();
        accel::Tracer tracer(frame, kMemoryBytes);
        std::vector<accel::SurfaceHit> found(rays.size());
        trace_closest(tracer, rays, found);
        const std::string name = power > 0 ? "smaller" : power == 0 ? "mean" : "larger";
        row.add("mrays_per_s_" + name,
                per(1e-6 * double(rays.size()), repeat(kRuns, [&] { trace_closest(tracer, rays, found); })));
        row.add("micropolygons_" + name, double(tracer.counters().micropolygons));
    }
    row.add("rays", double(count)).add("larger_over_smaller", stretch / double(count));
    report.add(std::move(row));
}

void run_kinds(Report& report, Subject& subject)
{
    const accel::Frame frame = levels_of_each_ray(subject);
    const std::vector<accel::Ray> camera = subject.camera_rays();
    accel::Tracer first(frame, kMemoryBytes);
    std::vector<accel::SurfaceHit> hits(camera.size());
    trace_closest(first, camera, hits);
    const shade::WorldLight lamp = lamp_over(subject.scene.bounds());
    for (const Kind& kind : kKinds) {
        Row row{"light", subject.name + ", " + kind.name};
        for (const bool with_footprint : {true, false}) {
            const std::vector<accel::Ray> rays = secondary_rays(kind, camera, hits, lamp, with_footprint);
            accel::Tracer tracer(frame, kMemoryBytes);
            std::vector<accel::SurfaceHit> found(rays.size());
            std::vector<std::uint8_t> occluded(rays.size());
            const auto trace = [&] {
                if (kind.is_shadow) trace_occluded(tracer, rays, occluded);
                else trace_closest(tracer, rays, found);
            };
            trace();  // this builds everything that is lazy
            const std::string name = with_footprint ? "with_footprints" : "without";
            row.add("mrays_per_s_" + name, per(1e-6 * double(rays.size()), repeat(kRuns, trace)));
            row.add("micropolygons_" + name, double(tracer.counters().micropolygons));
        }
        report.add(std::move(row));
    }
}

void run_shading(Report& report)
{
    struct Case {
        const char* name;
        shade::Surface surface;
    };
    shade::Surface plastic, coated, glass;
    plastic.diffuse = Vec3f(0.5f);
    coated = plastic;
    coated.coat = 1;
    coated.coat_alpha = 0.05f;
    glass.is_solid = true;
    glass.transmission = Vec3f(1);
    glass.eta = 1.5f;
    glass.alpha = 0.1f;
    constexpr int kCount = 200'000;
    const render::Sampler sampler(1, 1, true);
    for (const Case& c : {Case{"layer over base", plastic}, Case{"with a coat", coated}, Case{"rough glass", glass}}) {
        shade::Surface s = c.surface;
        float sum = 0;
        const auto run = [&](auto&& work) {
            return times(repeat(kRuns,
                                [&] {
                                    for (std::uint32_t i = 0; i < kCount; ++i) {
                                        const Vec2f square = sampler.square(int(i & 1023), 0, i, render::Dimension::pixel());
                                        const float cosine = 0.1f + 0.9f * square.x;
                                        s.to_eye = {std::sqrt(1 - cosine * cosine), 0, cosine};
                                        sum += work(square);
                                    }
                                }),
                         1e9 / kCount);
        };
        Row row{"light", std::string("shading, ") + c.name};
        row.add("numbers_ns", run([](Vec2f square) { return square.x; }));
        row.add("sample_ns", run([&](Vec2f square) { return shade::sample_scatter(s, square.y, square).weight.x; }));
        row.add("evaluate_and_density_ns", run([&](Vec2f square) {
                    const Vec3f d = shade::cosine_direction(square);
                    return shade::scatter(s, d).x + shade::scatter_density(s, d);
                }));
        row.note = sum == 0 ? "black" : "each with the numbers";
        report.add(std::move(row));
    }
}

}  // namespace

void run_light(Report& report)
{
    run_shading(report);
    for (const auto& subject : usual_subjects(kWidth, kHeight)) {
        run_kinds(report, *subject);
        run_widths(report, *subject);
    }
    run_light_frames(report);
}

}  // namespace occam::bench
