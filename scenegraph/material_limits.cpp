#include "scenegraph/material_limits.h"

#include <algorithm>
#include <cmath>

namespace occam {
namespace {

bool is_within_1(Vec3f c) noexcept { return c.x >= 0 && c.x <= 1 && c.y >= 0 && c.y <= 1 && c.z >= 0 && c.z <= 1; }

}  // namespace

bool has_base_color_within_limits(const Material& m) noexcept { return is_within_1(Vec3f(m.base_color)); }

bool has_factors_within_limits(const Material& m) noexcept
{
    if (!(m.base_color.w <= 1)) return false;
    if (m.unlit) return true;
    const float ior = std::min(m.ior, kMaxIor), root = (ior - 1) / (ior + 1);
    return is_within_1(m.sheen_color) && is_within_1(m.attenuation_color) && is_within_1(root * root * m.specular_color) &&
           m.ior <= kMaxIor && std::abs(m.normal_scale) <= kMaxNormalScale &&
           std::abs(m.clearcoat_normal_scale) <= kMaxNormalScale;
}

bool has_transforms_within_limits(const Material& m) noexcept
{
    const auto is_within = [](float v) { return std::abs(v) <= kMaxTextureTransform; };
    const auto uses = texture_uses(m);
    return std::all_of(uses.begin(), uses.end(), [&](const TextureUse* use) {
        return !*use || (is_within(use->offset.x) && is_within(use->offset.y) && is_within(use->scale.x) &&
                         is_within(use->scale.y) && is_within(use->rotation));
    });
}

}  // namespace occam
