// The shadow rays of a batch: they are collected while hits are shaded, traced together, and added in the order in which
// they came.
//
// A ray may pass the surface that it hits where this blends, masks, is clear glass or bounds a body that does not bend
// light. It is then shot again from there, in order of t, so the result of a sample depends on the sample alone, and what
// bodies absorb is known piece by piece, as for the rays of paths. The number of surfaces that a ray passes is not limited:
// a ray with little transmittance left is ended by chance (Russian roulette), and weighs more where it continues.
//
// Threads  each worker owns one.
#pragma once

#include <algorithm>
#include <span>

#include "accel/tracer.h"
#include "base/kept_blocks.h"
#include "io/texture/texture_store.h"
#include "render/body_absorption.h"
#include "render/passing_rays.h"
#include "render/path.h"

namespace occam::render {

/// A ray whose transmittance has fallen below this share continues through further surfaces by chance.
inline constexpr float kLeastShare = 1.0f / 1024;
/// Returns the chance with which a ray of that share continues: 1 from kLeastShare on.
inline float passing_chance(float share) noexcept { return std::min(share / kLeastShare, 1.0f); }
/// The number of surfaces from which on a ray that does not come from the camera continues by chance at larger shares, too.
inline constexpr int kCertainPasses = 64;
/// Returns the chance with which a ray continues that does not come from the camera and has passed that many surfaces. The
/// least share rises with each of them, until the ray continues with the transmittance of each surface as its chance. So a
/// ray through thousands of faint surfaces passes as many of them as light does, and does not go on until 1 / 1024 is left.
inline float passing_chance(float share, int passed) noexcept
{
    constexpr float kPerSurface = 1.0f / 256;
    return std::min(share / std::clamp(float(passed - kCertainPasses) * kPerSurface, kLeastShare, 1.0f), 1.0f);
}

/// Returns the rest of a ray behind a hit. The interval is open at its near end, so rounding of t cannot find the hit
/// again.
accel::Ray behind(accel::Ray ray, float t) noexcept;

class PathLog;

class ShadowQueue {
public:
    struct Rules {
        bool may_pass;        ///< a ray that hits a surface may continue behind it
        float texture_width;  ///< width of the texture filter, in pixels
        PathLog* log;         ///< see FrameContext::log
    };
    ShadowQueue(const TextureStore& textures, PassBudget& passes, const FrameScale& scale, const Rules& rules) noexcept
        : textures_(textures), scale_(scale), rules_(rules), blocked_(passes)
    {
    }

    std::size_t size() const noexcept { return rays_.size(); }
    /// Returns true if a ray that hits a surface may continue behind it.
    bool may_pass() const noexcept { return rules_.may_pass; }
    void clear() noexcept;
    /// Adds a ray, which the caller fills in. trace() adds `radiance` to sums[sample], times the transmittance along the
    /// ray.
    /// limit   of what is added, in the brightest channel. A ray that chance lets go on may bring as much as all those for
    ///         which it stands.
    accel::Ray& add(std::uint32_t sample, Vec3f radiance, float limit)
    {
        // They are written where they stay, since reading whole what was just written in parts would wait.
        Shadow& shadow = shadows_.emplace_back();
        shadow.sample = sample;
        shadow.radiance = radiance;
        shadow.limit = limit;
        accel::Ray& ray = rays_.emplace_back();
        ray.kinds = accel::RayKind::Shadow;
        return ray;
    }
    /// Says that the ray that was added last starts in a body. Its radiance is what arrives if the whole way lies in there.
    /// absorption   coefficient of that body, per world length
    /// radiance     what the ray brings if nothing absorbs it, for a ray that leaves the body again
    void starts_in_body(Vec3f absorption, Vec3f radiance)
    {
        if (may_pass()) starts_.push_back({static_cast<std::uint32_t>(shadows_.size() - 1), absorption, radiance});
    }

    /// Traces all rays and adds their radiance. Returns how many were shot. See Integrator::run for Tracer.
    /// luck   a random number in [0, 1) for each sample. With the ray's direction and the place where it starts it decides
    ///        how the ray ends.
    template <class Tracer>
    std::uint64_t trace(Tracer& tracer, std::span<Vec3f> sums, std::span<const float> luck)
    {
        std::uint64_t shot = rays_.size();
        occluded_.assign(rays_.size(), 0);
        tracer.occluded(rays_, occluded_);
        collect_blocked();
        shot += blocked_.trace(
            tracer, [&](Blocked& of, accel::Ray& ray, const accel::SurfaceHit& hit) { return passes(of, ray, hit, luck); },
            [&](const Blocked& of, const accel::Ray& ray) { end(of, ray); });
        add_light(sums);
        return shot;
    }

private:
    struct Shadow {
        std::uint32_t sample = 0;
        Vec3f radiance{0};
        float limit = 0;
    };
    /// Describes a shadow ray that starts in a body: see starts_in_body().
    struct Start {
        std::uint32_t shadow;  ///< index into shadows_
        Vec3f absorption, radiance;
    };
    /// Describes a shadow ray that has hit a surface.
    struct Blocked {
        std::uint32_t shadow;  ///< index into shadows_
        float share;           ///< transmittance so far, in the brightest channel
        int passed;            ///< number of the surfaces so far
        Vec3f absorption;      ///< coefficient behind the last of them, per world length
    };

    /// Collects those rays that have hit a surface and may pass it, so that their hits can be found.
    void collect_blocked();
    /// Returns false if the ray ends at the hit, and else moves it behind.
    bool passes(Blocked& of, accel::Ray& ray, const accel::SurfaceHit& hit, std::span<const float> luck);
    /// Lets a ray that has passed all of its hits come to its end.
    void end(const Blocked& of, const accel::Ray& ray);
    void add_light(std::span<Vec3f> sums);

    const TextureStore& textures_;
    const FrameScale scale_;
    const Rules rules_;
    // These are parallel arrays, kept from batch to batch for their memory.
    KeptVector<Shadow> shadows_;
    KeptVector<accel::Ray> rays_;
    KeptVector<Start> starts_;  ///< of those that start in a body, in the order of the rays
    KeptVector<std::uint8_t> occluded_;
    PassingRays<Blocked, 4096> blocked_;
};

}  // namespace occam::render
