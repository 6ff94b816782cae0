#include "render/eye_body.h"

#include <cmath>

#include "render/shade_point.h"
#include "render/shadow_queue.h"
#include "shade/surface.h"

namespace occam::render {
namespace {

// Up, since what bounds water is above the eye more often than not; a little aslant, so that edges of boxes are rarely met.
const Vec3f kUp = glm::normalize(Vec3f(0.037f, 1, 0.021f));

accel::Ray ray_up(const accel::Ray& from) noexcept
{
    accel::Ray ray;
    ray.origin = from.origin;
    ray.direction = kUp;
    ray.kinds = from.kinds;
    ray.time = from.time;
    return ray;  // with the footprint of the camera: its own rays have others, which share this one's answer
}

}  // namespace

void EyeBody::collect(std::span<const accel::Ray> rays)
{
    if (!places_.empty()) {
        places_.front() = places_.back();
        places_.resize(1);
    }
    place_of_.clear();
    probes_.clear();
    rays_up_.clear();
    for (const accel::Ray& ray : rays) {
        const bool is_known = !places_.empty() && places_.back().origin == ray.origin && places_.back().time == ray.time;
        if (!is_known) {
            probes_.push_back({static_cast<std::uint32_t>(places_.size()), 0});
            places_.push_back({ray.origin, ray.time, Vec3f(0), false});
            rays_up_.push_back(ray_up(ray));
        }
        place_of_.push_back(static_cast<std::uint32_t>(places_.size() - 1));
    }
    rays_ = rays_up_;
    goes_up_ = true;
}

void EyeBody::turn_back()
{
    const std::size_t known = places_.size() - rays_up_.size();
    goes_up_ = false;
    for (std::size_t k = 0; k < rays_up_.size(); ++k) {
        Place& place = places_[known + k];
        place.is_enclosed = false;
        if (place.absorption == Vec3f(0)) continue;
        probes_.push_back({static_cast<std::uint32_t>(known + k), 0});
        rays_.push_back(rays_up_[k]);
        rays_.back().direction = -kUp;
    }
}

void EyeBody::tell(std::span<Path> paths)
{
    for (std::size_t i = 0; i < paths.size(); ++i) {
        const Place& place = places_[place_of_[i]];
        paths[i].absorption = place.is_enclosed ? place.absorption : Vec3f(0);
    }
}

bool EyeBody::ends(std::size_t probe, const accel::SurfaceHit& hit)
{
    const Material& m = *hit.material;
    if (!(m.transmission > 0) || !(m.thickness > 0)) return false;
    const shade::Surface s = shade::evaluate(shade_point(rays_[probe], hit, texture_width_), textures_);
    if (!s.bounds_body()) return false;
    Probe& of = probes_[probe];
    of.entered += hit.back_side ? -1 : 1;
    if (of.entered >= 0) return false;
    Place& place = places_[of.place];
    if (goes_up_) place.absorption = s.absorption_inside;
    else place.is_enclosed = place.absorption == s.absorption_inside;
    return true;
}

void EyeBody::follow(std::size_t first, int most)
{
    for (std::size_t i = 0; i < hit_counts_.size(); ++i) {
        const accel::SurfaceHit* hits = &hits_[i * static_cast<std::size_t>(most)];
        const accel::HitCount known = hit_counts_[i];
        bool is_done = known.is_all;
        for (int k = 0; k < known.count; ++k)
            if (ends(first + i, hits[k])) {
                is_done = true;
                break;
            }
        if (is_done) continue;
        probes_[kept_] = probes_[first + i];
        rays_[kept_++] = behind(rays_[first + i], hits[known.count - 1].t);
    }
}

}  // namespace occam::render
