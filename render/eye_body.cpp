#include "render/eye_body.h"

#include <utility>

#include "render/shade_point.h"
#include "render/shadow_queue.h"
#include "shade/surface.h"

namespace occam::render {
namespace {

// Up, since what bounds water is above the eye more often than not; a little aslant, so that edges of boxes are rarely met.
const Vec3f kUp = glm::normalize(Vec3f(0.037f, 1, 0.021f));

/// Returns a ray with the footprint of the camera: camera rays have others, but share one answer.
accel::Ray ray_from(Vec3d origin, float time, Vec3f direction) noexcept
{
    accel::Ray ray;
    ray.origin = origin;
    ray.direction = direction;
    ray.kinds = accel::RayKind::Camera;
    ray.time = time;
    return ray;
}

}  // namespace

void EyeBody::collect(std::span<const accel::Ray> rays)
{
    if (!places_.empty()) {
        places_.front() = places_.back();
        places_.resize(1);
    }
    known_ = places_.size();
    place_of_.clear();
    for (const accel::Ray& ray : rays) {
        const bool is_known = !places_.empty() && places_.back().origin == ray.origin && places_.back().time == ray.time;
        if (!is_known) {
            probes_.add({static_cast<std::uint32_t>(places_.size()), 0}, ray_from(ray.origin, ray.time, kUp));
            places_.push_back({ray.origin, ray.time, Vec3f(0), false});
        }
        place_of_.push_back(static_cast<std::uint32_t>(places_.size() - 1));
    }
    goes_up_ = true;
}

void EyeBody::turn_back()
{
    goes_up_ = false;
    for (std::size_t k = known_; k < places_.size(); ++k)
        if (const Place& place = places_[k]; place.absorption != Vec3f(0))
            probes_.add({static_cast<std::uint32_t>(k), 0}, ray_from(place.origin, place.time, -kUp));
}

void EyeBody::tell(std::span<Path> paths)
{
    for (std::size_t i = 0; i < paths.size(); ++i) {
        const Place& place = places_[place_of_[i]];
        paths[i].absorption = place.is_enclosed ? place.absorption : Vec3f(0);
    }
}

bool EyeBody::passes(Probe& of, accel::Ray& ray, const accel::SurfaceHit& hit)
{
    const accel::Ray before = std::exchange(ray, behind(ray, hit.t));
    const Material& m = *hit.material;
    if (!(m.transmission > 0) || !(m.thickness > 0)) return true;
    const shade::Surface s = shade::evaluate(shade_point(before, hit, texture_width_), textures_);
    if (!s.bounds_body) return true;
    of.entered += hit.back_side ? -1 : 1;
    if (of.entered >= 0) return true;
    Place& place = places_[of.place];
    if (goes_up_) place.absorption = s.absorption_inside;
    else place.is_enclosed = place.absorption == s.absorption_inside;
    return false;
}

}  // namespace occam::render
