// A stage for tests of the integrator without a scene graph: horizontal planes before a camera, and lights.
#pragma once

#include <cmath>
#include <vector>

#include "render/integrator.h"

namespace occam::test {

/// A tracer whose scene consists of horizontal planes y = height, which are visible from both sides.
struct PlaneTracer {
    struct Plane {
        double height;
        const Material* material;
        double reach = 1e9;  ///< the plane ends at this |x|
    };
    std::vector<Plane> planes;

    void closest(std::span<const accel::Ray> rays, std::span<accel::SurfaceHit> hits) const
    {
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const accel::Ray& ray = rays[i];
            const auto at = [&](float t) { return ray.origin + Vec3d(ray.direction) * double(t); };
            const Plane* found = nullptr;
            float nearest = ray.t_far;
            for (const Plane& plane : planes) {
                const float t = float((plane.height - ray.origin.y) / double(ray.direction.y));
                if (!(t > ray.t_near && t < nearest) || std::fabs(at(t).x) > plane.reach) continue;
                nearest = t;
                found = &plane;
            }
            accel::SurfaceHit& hit = hits[i] = {};
            if (!found) continue;
            hit.t = nearest;
            hit.position = at(nearest);
            hit.normal_geometric = hit.normal_shading = hit.start_normal = {0, ray.direction.y > 0 ? -1.0f : 1.0f, 0};
            hit.self_distance = 1e-4f;
            hit.material = found->material;
            hit.node = {7, 0};
        }
    }
    void nearest(std::span<const accel::Ray> rays, int most, std::span<accel::SurfaceHit> hits,
                 std::span<accel::HitCount> counts) const
    {
        for (std::size_t i = 0; i < rays.size(); ++i) {
            accel::Ray ray = rays[i];
            counts[i] = {};
            for (accel::SurfaceHit hit; counts[i].count < most; ray.t_near = accel::behind(hit.t)) {
                closest({&ray, 1}, {&hit, 1});
                if (!hit.is_hit()) break;
                hits[i * std::size_t(most) + std::size_t(counts[i].count++)] = hit;
            }
            counts[i].is_all = counts[i].count < most;
        }
    }
    void occluded(std::span<const accel::Ray> rays, std::span<std::uint8_t> occluded) const
    {
        std::vector<accel::SurfaceHit> hits(rays.size());
        closest(rays, hits);
        for (std::size_t i = 0; i < rays.size(); ++i) occluded[i] = hits[i].is_hit();
    }
};

/// Returns a Lambertian material, so that expectations have a closed form.
inline Material lambertian(float color, float alpha = 1)
{
    Material m;
    m.base_color = Vec4f(color, color, color, alpha);
    m.specular = 0;
    m.alpha_mode = alpha < 1 ? AlphaMode::Blend : AlphaMode::Opaque;
    return m;
}

/// Returns a sun whose light falls straight down.
inline shade::WorldLight vertical_sun(float irradiance)
{
    shade::WorldLight sun;
    sun.kind = shade::WorldLight::Kind::Sun;
    sun.direction = {0, -1, 0};
    sun.strength = Vec3f(irradiance);
    return sun;
}

/// Runs the integrator over a scene of planes.
struct PlaneStage {
    render::Settings settings;
    TextureStore textures{1 << 20};
    render::CameraRays camera{Camera::look_at({0, 5, 0}, {0, 0, 0}, {0, 0, -1}, 0.5f), 8, 8};
    std::vector<shade::WorldLight> lights{vertical_sun(3.14159265f)};
    shade::Environment environment;
    bool may_pass = true;
    PlaneTracer tracer;

    PlaneStage()
    {
        settings.width = settings.height = 8;
        settings.spp = 4;
        settings.integrator = render::IntegratorKind::Direct;
    }
    render::SampleResult one(int x = 4, int y = 4) { return run({{x, y, 0}}).front(); }
    std::vector<render::SampleResult> run(const std::vector<render::CameraSample>& samples)
    {
        const render::Sampler sampler(settings.seed, settings.spp, settings.jitter);
        const shade::FrameLights frame_lights(lights, environment);
        const render::PixelFilter filter(settings.filter);
        render::PassBudget passes(settings);
        render::FrameContext context{settings, camera, sampler, filter, frame_lights, textures, passes};
        context.may_pass = may_pass;
        render::Integrator integrator(context);
        std::vector<render::SampleResult> results(samples.size());
        integrator.run(tracer, samples, results);
        counters = integrator.counters();
        return results;
    }
    render::IntegratorCounters counters;
};

}  // namespace occam::test
