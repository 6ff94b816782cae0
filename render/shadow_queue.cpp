#include "render/shadow_queue.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/hash.h"
#include "render/light_limit.h"
#include "render/path_log.h"
#include "render/shade_point.h"
#include "shade/surface.h"

namespace occam::render {
namespace {

// Returns a random number in [0, 1) for a ray of a sample at the surface it has come to. It depends on these alone.
float number_of(const accel::Ray& ray, float luck) noexcept
{
    const auto word = [](float a, float b) {
        return (std::uint64_t(std::bit_cast<std::uint32_t>(a)) << 32) | std::bit_cast<std::uint32_t>(b);
    };
    std::uint64_t bits = mix_bits(word(luck, ray.t_near) + 0x9e3779b97f4a7c15ull);
    bits = mix_bits(bits ^ word(ray.direction.x, ray.direction.y)) ^ std::bit_cast<std::uint32_t>(ray.direction.z);
    return static_cast<float>(mix_bits(bits) >> 40) * 0x1p-24f;
}

// Returns SurfaceHit::to_start for a surface that rays leave on the eye's side only: self_distance along the normal from
// there, they start on the ray that found the surface, a little before its end. In an acute corner the normal leads through
// the other wall, while that ray has come from inside the room. A ray that itself began within that distance of the surface
// did so in a corner without more room, and the next ray starts where it did. Where the surface moves from level to level,
// the normal is followed: the ray has met another mesh than that of the start.
Vec3f start_on_ray(const accel::Ray& ray, const accel::SurfaceHit& hit) noexcept
{
    constexpr float kFarthest = 64;  // in units of self_distance
    const float cosine = -glm::dot(hit.start_normal, ray.direction), away = hit.self_distance;
    // Where all levels have one plane, the mesh of the start is the one that the ray has met.
    const auto is_along = [&](Vec3f normal) { return glm::dot(normal, hit.normal_geometric) >= 1 - 0x1p-14f; };
    const bool is_same_mesh = hit.start_level == accel::kAnyLevel ||
                              (is_along(hit.start_normal) && is_along(hit.normal_shading) &&
                               std::abs(glm::dot(hit.to_start, hit.start_normal)) <= 0.25f * away);
    if (!(cosine > 0) || !is_same_mesh) return hit.to_start;
    if (ray.t_near <= 0 && ray.start_level == hit.start_level && hit.t * cosine < away)
        return Vec3f(ray.origin - hit.position) - hit.start_normal * away;
    const float height = std::min(away, std::max(0.25f * away, 0.5f * hit.t * cosine));
    const float back = std::min({height / cosine, kFarthest * away, 0.5f * std::max(hit.t - ray.t_near, 0.0f)});
    return hit.to_start - ray.direction * back + hit.start_normal * (height - back * cosine - away);
}

}  // namespace

accel::Ray behind(accel::Ray ray, float t) noexcept
{
    ray.t_near = accel::behind(t);
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
    p.to_start = hit.material->transmission > 0 ? hit.to_start : start_on_ray(ray, hit);
    p.start_normal = hit.start_normal;
    p.self_distance = hit.self_distance;
    p.axes = {hit.tangent, hit.tangent_sign, hit.v_axis};
    p.other_axes = hit.other_axes;
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
    starts_.clear();
}

void ShadowQueue::collect_blocked()
{
    blocked_.clear();
    auto start = starts_.cbegin();
    for (std::size_t i = 0; i < shadows_.size(); ++i) {
        const bool is_in_body = start != starts_.cend() && start->shadow == i;
        const Start* const body = is_in_body ? &*start++ : nullptr;
        if (!occluded_[i]) continue;
        if (!may_pass()) {
            shadows_[i].radiance = Vec3f(0);
            continue;
        }
        if (body) shadows_[i].radiance = body->radiance;
        blocked_.add({static_cast<std::uint32_t>(i), 1, 0, body ? body->absorption : Vec3f(0)}, rays_[i]);
    }
}

bool ShadowQueue::passes(Blocked& of, accel::Ray& ray, const accel::SurfaceHit& hit, std::span<const float> luck)
{
    const shade::StraightPass pass = shade::passes_straight(shade_point(ray, hit, rules_.texture_width), textures_);
    const Vec3f transmittance = pass.transmittance * left_by_body(of.absorption, hit.t - start_of(ray), scale_);
    if (pass.bounds_body) of.absorption = hit.back_side ? Vec3f(0) : pass.absorption_inside;
    Shadow& shadow = shadows_[of.shadow];
    const float share = of.share * std::max({transmittance.x, transmittance.y, transmittance.z});
    const float chance = passing_chance(share, ++of.passed);
    ray = behind(ray, hit.t);
    const bool goes_on = chance >= 1 || (chance > 0 && number_of(ray, luck[shadow.sample]) < chance);
    if (rules_.log) {
        rules_.log->shadow_ray_at(ray.direction, hit.t);
        rules_.log->passes(transmittance, chance > 0);
        if (chance > 0 && chance < 1) rules_.log->decided("the ray goes on", chance, goes_on);
    }
    if (!goes_on) {
        shadow.radiance = Vec3f(0);
        return false;
    }
    shadow.radiance *= chance < 1 ? transmittance / chance : transmittance;
    shadow.limit /= chance;
    of.share = share / chance;
    return true;
}

void ShadowQueue::end(const Blocked& of, const accel::Ray& ray)
{
    shadows_[of.shadow].radiance *= left_by_body(of.absorption, ray.t_far - start_of(ray), scale_);
}

void ShadowQueue::add_light(std::span<Vec3f> sums)
{
    for (const Shadow& s : shadows_) sums[s.sample] += limited(s.radiance, s.limit);
}

}  // namespace occam::render
