// Writes down what happens to the path of one sample at each of its surfaces, for people who look for a fault.
//
// The rays between them are written by ReplayTracer (render/replay.cpp). A FrameContext without a log costs one comparison
// with null at each step.
//
// Space    Everything is written in world units.
#pragma once

#include <ostream>
#include <string_view>

#include "accel/tracer.h"
#include "base/print.h"
#include "render/path.h"
#include "scenegraph/frame_scale.h"
#include "scenegraph/scene.h"
#include "shade/direct.h"

namespace occam::render {

class PathLog {
public:
    /// The stream and the scene are borrowed.
    PathLog(std::ostream& out, const Scene& scene, const FrameScale& scale)
        : out_(out), digits_(out, 9), scene_(scene), scale_(scale)
    {
    }

    std::ostream& out() noexcept { return out_; }

    /// Writes in what the path starts, after the rays that found it.
    void starts_in(Vec3f absorption);
    /// Begins the part of a ray, before it is traced.
    void ray(const accel::Ray& ray);
    /// Writes what a ray has hit.
    void found(const accel::SurfaceHit& hit);
    void cost(const accel::RayCost& cost);

    /// Writes what is shaded at a hit.
    void surface(const Path& path, const accel::SurfaceHit& hit, const shade::Surface& surface);
    /// Writes light that the path adds to its sample without a ray.
    void added(std::string_view what, Vec3f radiance);
    /// Writes a sample of a light, whose shadow ray is traced later. radiance is what it adds if nothing is in its way.
    void light_sample(Vec3f direction, float t_far, Vec3f radiance);
    /// Writes a direction that was drawn from a lobe, and the path that follows it.
    void scattered(const shade::ScatterSample& sample, const Path& next);
    /// Writes what was decided by comparing a random number with a chance.
    void decided(std::string_view what, float chance, bool is_so);
    /// Writes what of a ray's light a surface lets pass.
    /// goes_on   false if the ray ends there, since nothing of its light is left
    void passes(Vec3f transmittance, bool goes_on);
    /// Writes at which distance a shadow ray has met a surface. Shadow rays are traced later, several at once; the direction
    /// says which of them it is.
    void shadow_ray_at(Vec3f direction, float t);

private:
    std::ostream& out_;
    const Precision digits_;
    const Scene& scene_;
    FrameScale scale_;
};

}  // namespace occam::render
