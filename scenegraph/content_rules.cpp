#include "scenegraph/content_rules.h"

#include <cmath>
#include <type_traits>

#include "base/error_without_file.h"
#include "base/overloaded.h"
#include "scenegraph/interpolation.h"

namespace occam {
namespace {

// Checks the values of one object.
class Rules {
public:
    Rules(const char* kind, const std::string& name) : where_(naming(kind, name)) {}

    void require(bool holds, const char* value, const char* rule) const
    {
        if (!holds) throw error_without_file(std::string(value) + " must be " + rule, where_);
    }
    void finite(float v, const char* value) const { require(std::isfinite(v), value, "finite"); }
    void at_least_0(float v, const char* value) const { require(std::isfinite(v) && v >= 0, value, "finite and 0 or more"); }
    void from_0_to_1(float v, const char* value) const { require(v >= 0 && v <= 1, value, "from 0 to 1"); }
    void from_0_to_half_turn(float v, const char* value) const { require(v >= 0 && v <= 3.1416f, value, "from 0 to pi"); }
    /// last   the last of the choices, which are numbered from 0
    template <class E>
    void choice(E v, E last, const char* value) const
    {
        require(static_cast<std::underlying_type_t<E>>(v) <= static_cast<std::underlying_type_t<E>>(last), value,
                "one of its choices");
    }
    template <class Vec>
    void color(Vec v, const char* value) const
    {
        for (int c = 0; c < int(Vec::length()); ++c) at_least_0(v[c], value);
    }

private:
    std::string where_;
};

// Returns whether the three rows that count in an affine matrix are finite.
bool is_finite(const Mat4d& m) noexcept
{
    for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 3; ++r)
            if (!std::isfinite(m[c][r])) return false;
    return true;
}

void check_use(const Rules& rules, const TextureUse& use)
{
    for (const float v : {use.offset.x, use.offset.y, use.scale.x, use.scale.y, use.rotation})
        rules.finite(v, "the transform of a texture");
    for (const TextureUse::Wrap wrap : {use.wrap_s, use.wrap_t})
        rules.choice(wrap, TextureUse::Wrap::Mirror, "the way in which a texture repeats");
    rules.require(use.uv_set == 0 || use.uv_set == 1, "the set of texture coordinates of a texture", "0 or 1");
}

}  // namespace

std::string naming(const char* kind, const std::string& name)
{
    return name.empty() ? kind : std::string(kind) + " '" + name + "'";
}

Mat4d checked_affine(const Mat4d& m, const char* value, const char* kind, const std::string& name)
{
    constexpr double kMostRounding = 1e-6;
    const Rules rules(kind, name);
    rules.require(is_finite(m), value, "finite");
    const Vec4d last(m[0][3], m[1][3], m[2][3], m[3][3] - 1);
    for (int c = 0; c < 4; ++c)
        rules.require(std::abs(last[c]) <= kMostRounding, value, "affine: its last row is 0, 0, 0, 1");
    Mat4d affine = m;
    for (int c = 0; c < 4; ++c) affine[c][3] = c == 3 ? 1 : 0;
    return affine;
}

void check(const Material& m)
{
    const Rules rules("material", m.name);
    rules.color(m.base_color, "the base colour");
    rules.color(m.emission, "the emission");
    rules.color(m.specular_color, "the specular colour");
    rules.color(m.attenuation_color, "the attenuation colour");
    rules.color(m.sheen_color, "the sheen colour");
    rules.from_0_to_1(m.roughness, "the roughness");
    rules.from_0_to_1(m.metallic, "the metallic share");
    rules.from_0_to_1(m.transmission, "the transmission");
    rules.from_0_to_1(m.clearcoat, "the clearcoat");
    rules.from_0_to_1(m.clearcoat_roughness, "the clearcoat's roughness");
    rules.from_0_to_1(m.sheen_roughness, "the sheen's roughness");
    rules.from_0_to_1(m.anisotropy, "the anisotropy");
    rules.finite(m.anisotropy_rotation, "the anisotropy's rotation");
    rules.from_0_to_1(m.specular, "the specular share");
    rules.at_least_0(m.ior, "the index of refraction");
    rules.at_least_0(m.thickness, "the thickness");
    // An infinite distance is glTF's default, and makes the body clear.
    rules.require(m.attenuation_distance >= 0, "the attenuation distance", "0 or more");
    rules.finite(m.normal_scale, "the scale of the normal map");
    rules.finite(m.clearcoat_normal_scale, "the scale of the clearcoat's normal map");
    rules.finite(m.bump_scale, "the scale of the bump map");
    rules.from_0_to_1(m.occlusion_strength, "the strength of the occlusion map");
    rules.finite(m.alpha_cutoff, "the alpha cutoff");
    rules.choice(m.alpha_mode, AlphaMode::Blend, "the alpha mode");
    for (const TextureUse* use : texture_uses(m)) check_use(rules, *use);
}

void check(const Cage& cage)
{
    const Rules rules("cage", cage.name);
    rules.choice(cage.scheme, Scheme::Triangles, "the scheme");
    rules.choice(cage.boundary, BoundaryRule::None, "the rule for borders");
    rules.choice(cage.face_varying, FaceVaryingRule::None, "the rule for texture coordinates");
    if (!cage.displacement) return;
    rules.choice(cage.displacement->space, Displacement::Space::Tangent, "the space of the displacement");
    for (const TextureUse::Wrap wrap : {cage.displacement->texture.wrap_s, cage.displacement->texture.wrap_t})
        rules.choice(wrap, TextureUse::Wrap::Mirror, "the way in which a texture repeats");
}

void check(const Texture& texture)
{
    Rules("texture", texture.name).choice(texture.role, TextureRole::Data, "the role");
    if (!texture.pixels.empty() && (texture.width <= 0 || texture.height <= 0 ||
                                    texture.pixels.size() != std::size_t(texture.width) * std::size_t(texture.height)))
        throw error_without_file("a texture's pixels must be width * height", naming("texture", texture.name));
}

void check(const Light& light)
{
    const Rules rules("light", light.name);
    const auto check_kind = Overloaded{[&](const PointLight& point) {
                                           rules.color(point.intensity, "the intensity");
                                           rules.at_least_0(point.range, "the range");
                                           rules.from_0_to_half_turn(point.inner_angle, "the inner angle");
                                           rules.from_0_to_half_turn(point.outer_angle, "the outer angle");
                                       },
                                       [&](const SunLight& sun) { rules.color(sun.irradiance, "the irradiance"); },
                                       [&](const AreaLight& area) {
                                           rules.choice(area.shape, AreaLight::Shape::Sphere, "the shape");
                                           rules.color(area.radiance, "the radiance");
                                           rules.at_least_0(area.size.x, "the width");
                                           rules.at_least_0(area.size.y, "the height");
                                       }};
    std::visit(check_kind, light.kind);
}

void check_view_angle(float fov, const char* where)
{
    Rules(where, {}).require(fov >= kNarrowestView && fov <= kWidestView, "the angle of view",
                             "from 0.00001 to 3.14 radians");
}

void check_aspect(float aspect, const char* where)
{
    Rules(where, {}).require(std::isfinite(aspect) && aspect > 0, "the aspect", "finite and above 0");
}

void check(const CameraLens& lens)
{
    const Rules rules("camera", {});
    if (!lens.orthographic) check_view_angle(lens.fov, "camera");
    rules.at_least_0(lens.aspect, "the aspect");
    rules.require(!lens.orthographic || (std::isfinite(lens.height) && lens.height > 0), "the height", "finite and above 0");
    rules.at_least_0(lens.radius, "the radius of the lens");
    rules.at_least_0(lens.focus, "the focus");
}

void check(const Trs& place, const std::string& name)
{
    const Rules rules("node", name);
    for (int c = 0; c < 3; ++c)
        rules.require(std::isfinite(place.translation[c]) && std::isfinite(place.scale[c]), "a place", "finite");
    constexpr double kMostRounding = 1e-3;  // of the squared length
    rules.require(std::abs(glm::dot(place.rotation, place.rotation) - 1) <= kMostRounding, "a rotation",
                  "a quaternion of unit length");
}

void check(const Environment& environment)
{
    const Rules rules("environment", {});
    rules.color(environment.radiance, "the radiance");
    rules.finite(environment.rotation, "the rotation");
}

void check(const Camera& camera)
{
    const Rules rules("camera", {});
    const auto check_place = [&](const Mat4d& m, const char* value) {
        rules.require(is_finite(m), value, "finite");
        for (int axis = 0; axis < 3; ++axis) {
            const double squared = glm::dot(Vec3d(m[axis]), Vec3d(m[axis]));
            rules.require(std::isfinite(squared) && squared > 0, value, "one whose axes have a length");
        }
    };
    check(camera.lens);
    check_place(camera.world_from_camera, "the place");
    if (camera.keys.empty()) return;
    if (camera.keys.size() < 2 || camera.keys.size() > kMaxCameraKeys)
        throw error_without_file("a camera that moves has from 2 to " + std::to_string(kMaxCameraKeys) + " keys", "camera");
    for (const Mat4d& key : camera.keys) check_place(key, "a key");
}

void check_morph_weights(std::span<const float> weights, const std::string& name)
{
    const Rules rules("node", name);
    for (const float weight : weights) rules.finite(weight, "a morph weight");
}

void check(const Shutter& shutter)
{
    const auto is_good = [](double t) { return std::abs(t) <= kMaxShutterFrames; };
    if (!is_good(shutter.open) || !is_good(shutter.close))
        throw error_without_file("the moments must be finite, and within a million frames", "shutter");
    if (shutter.open > shutter.close) throw error_without_file("it cannot close before it opens", "shutter");
}

void check(const Clip& clip)
{
    const Rules rules("clip", clip.name);
    for (const Channel& channel : clip.channels) {
        rules.choice(channel.path, Channel::Path::Weights, "a channel's path");
        rules.choice(channel.interpolation, Channel::Interpolation::CubicSpline, "a channel's interpolation");
        const bool is_rotation = channel.path == Channel::Path::Rotation;
        const int width = is_rotation ? 4 : 3;
        rules.require(channel.path == Channel::Path::Weights ? channel.width >= 0 : channel.width == width,
                      "a channel's width", "3, of rotations 4, and of weights their number");
        const std::size_t values = row_of(channel.interpolation).values_a_key;
        rules.require(channel.values.size() == channel.times.size() * values * std::size_t(channel.width),
                      "a channel's number of values", "that of its times, times its width, times 3 for a cubic spline");
        for (std::size_t i = 0; i < channel.times.size(); ++i)
            rules.require(std::isfinite(channel.times[i]) && (i == 0 || channel.times[i] > channel.times[i - 1]),
                          "a channel's times", "finite and strictly rising");
        for (const float v : channel.values) rules.finite(v, "a channel's values");
        for (std::size_t key = 0; is_rotation && key < channel.times.size(); ++key) {
            const float* q = &channel.values[(values * key + values / 2) * 4];
            rules.require(q[0] != 0 || q[1] != 0 || q[2] != 0 || q[3] != 0, "a rotation", "a quaternion that is not zero");
        }
    }
}

}  // namespace occam
