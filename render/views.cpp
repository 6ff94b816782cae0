#include "render/views.h"

#include <algorithm>
#include <cmath>

#include "base/hash.h"
#include "base/maths.h"

namespace occam::render {
namespace {

Vec3f color_of_number(std::uint64_t number) noexcept
{
    const std::uint64_t bits = mix_bits(number + 1);
    const auto channel = [&](int shift) { return 0.1f + 0.8f * static_cast<float>((bits >> shift) & 0xff) / 255; };
    return {channel(0), channel(8), channel(16)};
}

// Returns the colour of a count on a scale of powers of two, which rises from black over red and yellow to white at
// 2^doublings - 1.
Vec3f heat_of(float count, float doublings) noexcept
{
    const float x = 3 * std::min(maths::log2(1 + count) / doublings, 1.0f);
    return {std::min(x, 1.0f), std::clamp(x - 1, 0.0f, 1.0f), std::clamp(x - 2, 0.0f, 1.0f)};
}

// Returns a number that is 0 for the first cage of a node, and another one for each of the others.
std::uint64_t number_of_cage(const accel::SurfaceHit& hit, const Scene* scene) noexcept
{
    const Node* node = scene ? scene->find(hit.node) : nullptr;
    if (!node) return 0;
    const auto place = std::find(node->cages.begin(), node->cages.end(), hit.cage) - node->cages.begin();
    return place > 0 ? mix_bits(static_cast<std::uint64_t>(place)) : 0;
}

}  // namespace

Vec3f cost_color(View view, const accel::RayCost& cost) noexcept
{
    switch (view) {
        case View::KdSteps:
            return heat_of(static_cast<float>(cost.nodes), 10);
        case View::Tests:
            return heat_of(static_cast<float>(cost.tests), 12);
        case View::Time:
            return heat_of(static_cast<float>(cost.seconds * 1e6), 10);
        case View::Reuse:
            if (cost.igrids == 0) return {0, 0, 0.3f};
            return Vec3f(1 - static_cast<float>(cost.igrids_built) / static_cast<float>(cost.igrids));
        case View::Beauty:
        case View::Depth:
        case View::Normal:
        case View::Uv:
        case View::Face:
        case View::Level:
        case View::Blend:
        case View::Grid:
            break;
    }
    return Vec3f(0);
}

Vec3f view_color(View view, const accel::SurfaceHit& hit, float z, float z_near, float z_far, const Scene* scene) noexcept
{
    switch (view) {
        case View::Beauty:
        case View::KdSteps:
        case View::Tests:
        case View::Reuse:
        case View::Time:
            break;
        case View::Depth:
            return Vec3f(std::clamp((z_far - z) / std::max(z_far - z_near, 1e-30f), 0.0f, 1.0f));
        case View::Normal:
            return hit.normal_shading * 0.5f + 0.5f;
        case View::Uv:
            return {hit.uv[0].x - std::floor(hit.uv[0].x), hit.uv[0].y - std::floor(hit.uv[0].y), 0};
        case View::Face:
            return color_of_number(((std::uint64_t(hit.node.slot) << 32) | hit.face) ^ number_of_cage(hit, scene));
        case View::Level:
            return color_of_number(static_cast<std::uint64_t>(hit.level + 128)) * (1 - 0.5f * hit.blend);
        case View::Blend:
            return Vec3f(hit.blend);
        case View::Grid:
            return color_of_number(hit.micropolygon);
    }
    return Vec3f(0);
}

}  // namespace occam::render
