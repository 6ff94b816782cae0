#include "render/shadow_queue.h"

#include <algorithm>

#include "render/shade_point.h"
#include "shade/surface.h"

namespace occam::render {

accel::Ray behind(accel::Ray ray, float t) noexcept
{
    ray.t_near = t * (1 + 4 * std::numeric_limits<float>::epsilon());
    return ray;
}

shade::ShadePoint shade_point(const accel::Ray& ray, const accel::SurfaceHit& hit, float texture_width) noexcept
{
    shade::ShadePoint p;
    p.position = hit.position;
    p.to_eye = -ray.direction;
    p.normal_geometric = hit.normal_geometric;
    p.normal_shading = hit.normal_shading;
    p.back_side = hit.back_side;
    p.to_start = hit.to_start;
    p.start_normal = hit.start_normal;
    p.self_distance = hit.self_distance;
    p.tangent = hit.tangent;
    p.tangent_sign = hit.tangent_sign;
    p.u_gradient = hit.u_gradient;
    p.v_gradient = hit.v_gradient;
    for (int set = 0; set < 2; ++set) {
        p.texture.uv[set] = hit.uv[set];
        p.texture.uv_width[set] = hit.uv_width[set] * texture_width;
    }
    p.phase_one = hit.phase_one_channels > 0 ? hit.phase_one : nullptr;
    p.color = hit.color;
    p.material = hit.material;
    return p;
}

void ShadowQueue::clear() noexcept
{
    shadows_.clear();
    rays_.clear();
}

void ShadowQueue::collect_blocked()
{
    blocked_.clear();
    blocked_rays_.clear();
    for (std::size_t i = 0; i < shadows_.size(); ++i) {
        if (!occluded_[i]) continue;
        if (!may_pass_) {
            shadows_[i].radiance = Vec3f(0);
            continue;
        }
        blocked_.push_back(static_cast<std::uint32_t>(i));
        blocked_rays_.push_back(rays_[i]);
    }
}

void ShadowQueue::pass_blocked()
{
    std::size_t kept = 0;
    for (std::size_t i = 0; i < blocked_.size(); ++i) {
        const accel::SurfaceHit& hit = blocked_hits_[i];
        if (!hit.is_hit()) continue;
        const Vec3f passes = culls_ && is_culled(hit)
                                 ? Vec3f(1)
                                 : shade::passes_straight(shade_point(blocked_rays_[i], hit, texture_width_), textures_);
        Vec3f& radiance = shadows_[blocked_[i]].radiance;
        if (std::max({passes.x, passes.y, passes.z}) < kLeastShare) {
            radiance = Vec3f(0);
            continue;
        }
        radiance *= passes;
        blocked_rays_[kept] = behind(blocked_rays_[i], hit.t);
        blocked_[kept++] = blocked_[i];
    }
    blocked_.resize(kept);
    blocked_rays_.resize(kept);
}

void ShadowQueue::add_light(std::span<Vec3f> sums)
{
    // What is still on its way after the last layer counts as blocked.
    for (const std::uint32_t i : blocked_) shadows_[i].radiance = Vec3f(0);
    for (const Shadow& s : shadows_) sums[s.sample] += s.radiance;
}

}  // namespace occam::render
