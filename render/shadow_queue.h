// Shadow rays of a batch: collected while hits are shaded, traced together, added in the order they came in.
//
// A ray that meets something may pass it where it blends, masks or is clear glass: it is then shot again from there, in
// order of t. So what a sample gets depends on the sample alone. There is no limit to the surfaces that a ray passes: one
// that has little light left is ended by chance (Russian roulette), and weighs more where it goes on.
//
// Threads  one worker's own.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "accel/tracer.h"
#include "io/texture/texture_store.h"
#include "render/path.h"

namespace occam::render {

/// A ray whose share of light has fallen below this goes on through further surfaces by chance.
inline constexpr float kLeastShare = 1.0f / 1024;
/// Returns the chance with which a ray of that share goes on: 1 from kLeastShare on.
inline float passing_chance(float share) noexcept { return std::min(share / kLeastShare, 1.0f); }

/// The back of a single-sided surface, for Settings::back_faces = false. Bodies of glass have to be left again.
inline bool is_culled(const accel::SurfaceHit& hit) noexcept
{
    return hit.back_side && !hit.material->double_sided && !(hit.material->transmission > 0);
}

/// The rest of a ray behind a hit: the interval is open at its near end, and rounding of t must not find the hit again.
accel::Ray behind(accel::Ray ray, float t) noexcept;

class ShadowQueue {
public:
    /// may_pass   some material of the scene lets light pass straight on
    /// culls      and so do the backs of single-sided surfaces
    ShadowQueue(const TextureStore& textures, bool may_pass, bool culls, float texture_width) noexcept
        : textures_(textures), texture_width_(texture_width), may_pass_(may_pass || culls), culls_(culls)
    {
    }

    std::size_t size() const noexcept { return rays_.size(); }
    /// True if a ray that meets something may go on behind it.
    bool may_pass() const noexcept { return may_pass_; }
    void clear() noexcept;
    /// `radiance` is added to sums[sample] as far as nothing is in the way of the ray, which is the caller's to write.
    accel::Ray& add(std::uint32_t sample, Vec3f radiance)
    {
        shadows_.push_back({sample, radiance});
        accel::Ray& ray = rays_.emplace_back();
        ray.kinds = accel::RayKind::Shadow;
        return ray;
    }

    /// Traces all rays and adds what they bring. Returns how many were shot. Tracer: see Integrator::run.
    /// luck   a random number in [0, 1) for each sample, which decides with the ray's direction how the ray ends
    template <class Tracer>
    std::uint64_t trace(Tracer& tracer, std::span<Vec3f> sums, std::span<const float> luck)
    {
        std::uint64_t shot = rays_.size();
        occluded_.assign(rays_.size(), 0);
        tracer.occluded(rays_, occluded_);
        collect_blocked();
        while (!blocked_rays_.empty()) {
            shot += blocked_rays_.size();
            if (blocked_hits_.size() < blocked_rays_.size()) blocked_hits_.resize(blocked_rays_.size());
            tracer.closest(blocked_rays_, std::span(blocked_hits_).first(blocked_rays_.size()));
            pass_blocked(luck);
        }
        add_light(sums);
        return shot;
    }

private:
    struct Shadow {
        std::uint32_t sample;
        Vec3f radiance;
    };
    /// A shadow ray that met something.
    struct Blocked {
        std::uint32_t shadow;  ///< index into shadows_
        float share;           ///< what the surfaces so far let pass, in the brightest channel
    };

    /// Of the rays that met something, those that may pass it: their hits are to be found.
    void collect_blocked();
    void pass_blocked(std::span<const float> luck);
    void add_light(std::span<Vec3f> sums);

    const TextureStore& textures_;
    float texture_width_;
    bool may_pass_, culls_;
    // Parallel arrays, kept from batch to batch for their memory.
    std::vector<Shadow> shadows_;
    std::vector<accel::Ray> rays_;
    std::vector<std::uint8_t> occluded_;
    std::vector<Blocked> blocked_;
    std::vector<accel::Ray> blocked_rays_;
    std::vector<accel::SurfaceHit> blocked_hits_;
};

}  // namespace occam::render
