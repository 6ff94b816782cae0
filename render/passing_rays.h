// Rays that may pass the surfaces which they hit, whose hits are therefore looked at in order of t.
//
// At first one hit of each ray is found, and then more and more of those rays that go on, so that the work grows with the
// number of surfaces that they pass.
//
// Threads  each worker owns its own.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>

#include "accel/tracer.h"
#include "base/kept_blocks.h"
#include "render/pass_budget.h"

namespace occam::render {

/// Of            type of what is known of a ray
/// kHitsAtOnce   how many hits of all rays are found together
template <class Of, std::size_t kHitsAtOnce>
class PassingRays {
public:
    explicit PassingRays(PassBudget& budget) noexcept : budget_(budget) {}

    void clear() noexcept
    {
        of_.clear();
        rays_.clear();
    }
    void add(const Of& of, const accel::Ray& ray)
    {
        of_.push_back(of);
        rays_.push_back(ray);
    }

    /// Follows the rays until none goes on, and forgets them. Returns how many were shot. See Integrator::run for Tracer.
    /// passes   is called with (Of&, Ray&, const SurfaceHit&), and either returns false, or moves the ray behind the hit and
    ///          returns true
    /// leaves   is called with (Of&, const Ray&) for a ray that has passed all of its hits
    template <class Tracer, class Passes, class Leaves>
    std::uint64_t trace(Tracer& tracer, const Passes& passes, const Leaves& leaves)
    {
        std::uint64_t shot = 0;
        for (int most = 1; !rays_.empty(); most = std::min(most * 4, accel::kMostNearest)) {
            shot += rays_.size();
            const std::size_t at_once = kHitsAtOnce / static_cast<std::size_t>(most), all = rays_.size();
            kept_ = 0;
            for (std::size_t first = 0; first < all; first += at_once) {
                const std::size_t n = std::min(at_once, all - first);
                hits_.resize(n * static_cast<std::size_t>(most));
                counts_.resize(n);
                tracer.nearest(std::span(rays_).subspan(first, n), most, hits_, counts_);
                for (std::size_t i = 0; i < n; ++i)
                    follow(first + i, {&hits_[i * static_cast<std::size_t>(most)], static_cast<std::size_t>(most)},
                           counts_[i], passes, leaves);
            }
            budget_.spend(std::exchange(passed_, 0));
            of_.resize(kept_);
            rays_.resize(kept_);
        }
        return shot;
    }

private:
    /// Lets a ray pass the hits that were found, and keeps it if it may have more.
    template <class Passes, class Leaves>
    void follow(std::size_t i, std::span<const accel::SurfaceHit> hits, accel::HitCount known, const Passes& passes,
                const Leaves& leaves)
    {
        for (const accel::SurfaceHit& hit : hits.first(static_cast<std::size_t>(known.count)))
            if (passes(of_[i], rays_[i], hit)) ++passed_;
            else return;
        if (known.is_all) return leaves(of_[i], rays_[i]);
        of_[kept_] = of_[i];
        rays_[kept_++] = rays_[i];
    }

    PassBudget& budget_;
    std::uint64_t passed_ = 0;  ///< the number of surfaces that rays have passed since the budget was asked
    // These are parallel arrays, kept from batch to batch for their memory.
    KeptVector<Of> of_;
    KeptVector<accel::Ray> rays_;
    std::size_t kept_ = 0;  ///< the number of rays that go on
    KeptVector<accel::SurfaceHit> hits_;
    KeptVector<accel::HitCount> counts_;
};

}  // namespace occam::render
