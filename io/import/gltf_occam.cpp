#include "io/import/gltf_occam.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_set>

#include "io/import/gltf_value.h"

namespace occam::import {

namespace {

using tinygltf::Value;

// Reads one object under extras.occam: every key is asked for by its type, and a key that was never asked for is unknown.
class Reader {
public:
    Reader(const Value& value, std::string where, Report& report) : value_(value), where_(std::move(where)), report_(report)
    {
        if (value.Type() != tinygltf::NULL_TYPE && !value.IsObject()) refuse("must be an object");
    }
    const Value* find(const std::string& key)
    {
        asked_.push_back(key);
        return value_.Has(key) ? &value_.Get(key) : nullptr;
    }
    std::string string(const std::string& key)
    {
        const Value* v = find(key);
        return v ? string(*v, key + " must be a string") : std::string();
    }
    std::optional<float> number(const std::string& key)
    {
        const Value* v = find(key);
        if (!v) return std::nullopt;
        if (!v->IsNumber()) refuse(key + " must be a number");
        const auto number = static_cast<float>(v->GetNumberAsDouble());
        if (!std::isfinite(number)) refuse(key + " must be a number between -3.4e38 and 3.4e38");
        return number;
    }
    std::optional<int> index(const std::string& key)
    {
        const Value* v = find(key);
        if (!v) return std::nullopt;
        if (!v->IsInt() || v->GetNumberAsInt() < 0) refuse(key + " must be an index");
        return v->GetNumberAsInt();
    }
    template <class Vec>
    std::optional<Vec> numbers(const std::string& key)
    {
        if (!find(key)) return std::nullopt;
        const std::optional<Vec> v = vector<Vec>(value_, key.c_str());
        if (!v) refuse(key + " must be an array of " + std::to_string(Vec::length()) + " numbers");
        for (int i = 0; i < Vec::length(); ++i)
            if (!std::isfinite((*v)[i])) refuse(key + " must hold numbers between -3.4e38 and 3.4e38");
        return v;
    }
    template <class Enum, std::size_t N>
    std::optional<Enum> choice(const std::string& key, const std::array<std::pair<const char*, Enum>, N>& choices)
    {
        if (!find(key)) return std::nullopt;
        const std::string word = string(key);
        std::string known;
        for (const auto& [name, value] : choices) {
            if (word == name) return value;
            known += known.empty() ? name : std::string(", ") + name;
        }
        refuse(key + " must be one of " + known);
    }
    /// Returns each string of an array once, in the order of the array.
    std::optional<std::vector<std::string>> strings(const std::string& key)
    {
        const Value* v = find(key);
        if (!v) return std::nullopt;
        if (!v->IsArray()) refuse(key + " must be an array of strings");
        std::vector<std::string> list;
        std::unordered_set<std::string> known;
        for (std::size_t i = 0; i < v->ArrayLen(); ++i) {
            const std::string& text = string(v->Get(i), key + " must be an array of strings");
            if (known.insert(text).second) list.push_back(text);
        }
        return list;
    }
    void warn_unknown()
    {
        for (const std::string& key : value_.Keys())
            if (std::find(asked_.begin(), asked_.end(), key) == asked_.end())
                report_.warn("unknown key '" + key + "'", where_);
    }
    [[noreturn]] void refuse(const std::string& what) const { throw Error(report_.name(), what, where_); }

private:
    // Every node that shows a mesh has copies of its strings, so their length is limited. It is that of a path.
    const std::string& string(const Value& value, const std::string& otherwise) const
    {
        constexpr std::size_t kMost = 4096;
        if (!value.IsString()) refuse(otherwise);
        const std::string& text = value.Get<std::string>();
        if (text.size() > kMost) refuse("a string is longer than " + std::to_string(kMost) + " bytes");
        return text;
    }

    const Value& value_;
    std::string where_;
    Report& report_;
    std::vector<std::string> asked_;
};

constexpr std::array<std::pair<const char*, CageStyle::Scheme>, 3> kSchemes = {
    {{"catmull-clark", CageStyle::Scheme::CatmullClark},
     {"bilinear", CageStyle::Scheme::Bilinear},
     {"none", CageStyle::Scheme::None}}};
constexpr std::array<std::pair<const char*, BoundaryRule>, 3> kBoundaries = {
    {{"edge-and-corner", BoundaryRule::EdgeAndCorner}, {"edge-only", BoundaryRule::EdgeOnly}, {"none", BoundaryRule::None}}};
constexpr std::array<std::pair<const char*, FaceVaryingRule>, 6> kFaceVarying = {
    {{"corners-plus1", FaceVaryingRule::CornersPlus1},
     {"corners-plus2", FaceVaryingRule::CornersPlus2},
     {"corners-only", FaceVaryingRule::CornersOnly},
     {"boundaries", FaceVaryingRule::Boundaries},
     {"all", FaceVaryingRule::All},
     {"none", FaceVaryingRule::None}}};
constexpr std::array<std::pair<const char*, Displacement::Space>, 3> kAxes = {{{"normal", Displacement::Space::Normal},
                                                                               {"object", Displacement::Space::Object},
                                                                               {"tangent", Displacement::Space::Tangent}}};
constexpr std::array<std::pair<const char*, AreaLight::Shape>, 3> kShapes = {
    {{"rect", AreaLight::Shape::Rectangle}, {"disc", AreaLight::Shape::Disc}, {"sphere", AreaLight::Shape::Sphere}}};

constexpr std::array<std::pair<const char*, std::uint8_t>, 5> kRayKinds = {{{"camera", RayKind::Camera},
                                                                            {"shadow", RayKind::Shadow},
                                                                            {"reflection", RayKind::Reflection},
                                                                            {"transmission", RayKind::Transmission},
                                                                            {"diffuse", RayKind::Diffuse}}};

std::uint8_t ray_kinds(const std::vector<std::string>& names, const Reader& reader)
{
    std::uint8_t kinds = 0;
    for (const std::string& name : names) {
        const auto kind = std::find_if(kRayKinds.begin(), kRayKinds.end(),
                                       [&](const auto& known) { return name == known.first; });
        if (kind == kRayKinds.end())
            reader.refuse("hidden_from knows camera, shadow, reflection, transmission and diffuse, not '" + name + "'");
        kinds |= kind->second;
    }
    return kinds;
}

AreaLight area_light(const Value& value, const std::string& where, Report& report)
{
    Reader reader(value, where, report);
    AreaLight light;
    light.shape = reader.choice("shape", kShapes).value_or(AreaLight::Shape::Rectangle);
    light.size = reader.numbers<Vec2f>("size").value_or(Vec2f(1));
    light.radiance = reader.numbers<Vec3f>("radiance").value_or(Vec3f(1));
    if (!(light.size.x > 0 && light.size.y > 0)) reader.refuse("size must be positive");
    if (!(light.radiance.x >= 0 && light.radiance.y >= 0 && light.radiance.z >= 0))
        reader.refuse("radiance must not be negative");
    if (const Value* v = reader.find("two_sided")) {
        if (!v->IsBool()) reader.refuse("two_sided must be true or false");
        light.two_sided = v->Get<bool>();
    }
    reader.warn_unknown();
    return light;
}

DisplacementExtras displacement(const Value& value, const std::string& where, Report& report)
{
    Reader reader(value, where, report);
    DisplacementExtras out;
    const std::optional<int> texture = reader.index("texture");
    if (!texture) reader.refuse("texture is missing");
    out.texture = *texture;
    out.scale = reader.number("scale").value_or(1.0f);
    out.midlevel = reader.number("midlevel").value_or(0.5f);
    out.space = reader.choice("axes", kAxes).value_or(out.space);
    // The bound is what texels between 0 and 1 can reach; a vector has three such components.
    const float longest = out.space == Displacement::Space::Normal ? 1.0f : 1.7320509f;
    out.bound = reader.number("bound").value_or(longest * std::abs(out.scale) *
                                                std::max(std::abs(out.midlevel), std::abs(1 - out.midlevel)));
    if (out.bound < 0) reader.refuse("bound must not be negative");
    reader.warn_unknown();
    return out;
}

}  // namespace

void CageStyle::apply(Cage& cage) const
{
    if (scheme && cage.scheme != occam::Scheme::Triangles)
        cage.scheme = *scheme == Scheme::Bilinear ? occam::Scheme::Bilinear : occam::Scheme::CatmullClark;
    if (boundary) cage.boundary = *boundary;
    if (face_varying) cage.face_varying = *face_varying;
}

NodeExtras node_extras(const Value& value, NodeExtras below, const std::string& where, Report& report)
{
    NodeExtras out = std::move(below);
    Reader reader(member(value, "occam"), where + ".extras.occam", report);
    if (const std::string cage = reader.string("cage"); !cage.empty()) out.cage = cage;
    if (const auto scheme = reader.choice("scheme", kSchemes)) out.style.scheme = scheme;
    if (const auto boundary = reader.choice("boundary", kBoundaries)) out.style.boundary = boundary;
    if (const auto rule = reader.choice("face_varying", kFaceVarying)) out.style.face_varying = rule;
    out.material = reader.index("material").value_or(out.material);
    if (const Value* light = reader.find("area_light"))
        out.area_light = area_light(*light, where + ".extras.occam.area_light", report);
    if (const auto kinds = reader.strings("hidden_from")) out.hidden_from = ray_kinds(*kinds, reader);
    if (const std::string group = reader.string("light_group"); !group.empty()) out.light_group = group;
    if (auto groups = reader.strings("lit_by")) {
        if (groups->size() > kMostLightGroups) reader.refuse("a scene has at most 32 light groups");
        out.lit_by = std::move(groups);
    }
    if (const Value* moves = reader.find("displacement"))
        out.style.displacement = displacement(*moves, where + ".extras.occam.displacement", report);
    reader.warn_unknown();
    return out;
}

std::optional<BumpExtras> bump_extras(const Value& material, const std::string& where, Report& report)
{
    Reader occam(member(material, "occam"), where + ".extras.occam", report);
    const Value* bump = occam.find("bump");
    occam.warn_unknown();
    if (!bump) return std::nullopt;
    Reader reader(*bump, where + ".extras.occam.bump", report);
    const std::optional<int> texture = reader.index("texture");
    if (!texture) reader.refuse("texture is missing");
    const BumpExtras extras{*texture, reader.index("texCoord").value_or(0), reader.number("scale").value_or(1.0f)};
    reader.warn_unknown();
    return extras;
}

std::optional<EnvironmentExtras> environment_extras(const Value& scene, const std::string& where, Report& report)
{
    Reader occam(member(scene, "occam"), where + ".extras.occam", report);
    const Value* environment = occam.find("environment");
    occam.warn_unknown();
    if (!environment) return std::nullopt;
    Reader reader(*environment, where + ".extras.occam.environment", report);
    EnvironmentExtras extras{reader.string("image"), reader.number("rotation_deg").value_or(0.0f),
                             reader.number("strength").value_or(1.0f)};
    if (extras.strength < 0) reader.refuse("strength must not be negative");
    reader.warn_unknown();
    return extras;
}

}  // namespace occam::import
