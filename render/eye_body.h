// Finds the bodies in which camera rays start, since what they absorb counts from the eye on.
//
// A camera ray does not tell: what it hits first may lie in the body with the eye. So a ray more goes up from where it
// starts, through all surfaces, and looks for the boundary of a body that it leaves without having entered it. Another ray
// goes down and has to leave the same body, because a mesh that is not closed encloses nothing.
//
// Cost     Rays that start in the same place at the same moment share the answer, so a pinhole camera in a scene that
//          stands still costs a worker one ray, or two in a body. Any other camera costs one or two for each sample. Scenes
//          without a body that absorbs light are not asked (FrameContext::may_start_in_body).
// Threads  each worker owns one; the answer depends on the place and the moment alone.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "accel/tracer.h"
#include "io/texture/texture_store.h"
#include "render/passing_rays.h"
#include "render/path.h"

namespace occam::render {

class EyeBody {
public:
    /// Borrows the textures and the budget.
    EyeBody(const TextureStore& textures, PassBudget& passes, float texture_width) noexcept
        : textures_(textures), texture_width_(texture_width), probes_(passes)
    {
    }

    /// Sets the absorption of each path to that of the body in which its ray starts. Returns how many rays it took. See
    /// Integrator::run for Tracer.
    template <class Tracer>
    std::uint64_t find(Tracer& tracer, std::span<const accel::Ray> rays, std::span<Path> paths)
    {
        std::uint64_t shot = 0;
        for (std::size_t first = 0; first < rays.size(); first += kRaysAtOnce) {
            const std::size_t n = std::min(kRaysAtOnce, rays.size() - first);
            collect(rays.subspan(first, n));
            shot += probe(tracer);
            turn_back();
            shot += probe(tracer);
            tell(paths.subspan(first, n));
        }
        return shot;
    }

private:
    static constexpr std::size_t kRaysAtOnce = 1024;

    /// Describes where and when rays start.
    struct Place {
        Vec3d origin;
        float time;
        Vec3f absorption;  ///< of the body that the ray up leaves there
        bool is_enclosed;  ///< the last ray leaves that body, too
    };
    /// Describes a ray that has not found out yet.
    struct Probe {
        std::uint32_t place;
        int entered;  ///< number of bodies that it has entered and not left
    };

    /// Lists the places that are not known yet, and their rays up.
    void collect(std::span<const accel::Ray> rays);
    /// Replaces the rays up by those down, in places that may lie in a body that absorbs light.
    void turn_back();
    void tell(std::span<Path> paths);
    /// Returns false if the probe has found out at the hit, and else moves its ray behind.
    bool passes(Probe& of, accel::Ray& ray, const accel::SurfaceHit& hit);

    template <class Tracer>
    std::uint64_t probe(Tracer& tracer)
    {
        return probes_.trace(
            tracer, [&](Probe& of, accel::Ray& ray, const accel::SurfaceHit& hit) { return passes(of, ray, hit); },
            [](const Probe&, const accel::Ray&) {});
    }

    const TextureStore& textures_;
    float texture_width_;
    bool goes_up_ = true;                  ///< the direction of the probes
    std::vector<Place> places_;            ///< the first one is the last of the rays before, if there were any
    std::vector<std::uint32_t> place_of_;  ///< for each of the rays that are looked at together
    std::size_t known_ = 0;                ///< the number of places whose answer was known before
    PassingRays<Probe, 512> probes_;
};

}  // namespace occam::render
