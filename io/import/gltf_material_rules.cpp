#include <algorithm>
#include <string_view>

#include "io/import/gltf_json.h"
#include "io/import/gltf_rules.h"
#include "io/import/gltf_schema.h"

namespace occam::import {

namespace {

using nlohmann::json;

const json& member_of(const json& object, const std::string& key)
{
    static const json none;
    const auto found = object.is_object() ? object.find(key) : object.end();
    return object.is_object() && found != object.end() ? *found : none;
}

// Returns the part of the material that rules for this type of object are about.
const json& part_of(const json& material, std::string_view type)
{
    static const json none;
    constexpr std::string_view kExtension = "material/";
    if (type == "material") return material;
    if (type == "pbrMetallicRoughness") return member_of(material, "pbrMetallicRoughness");
    if (!type.starts_with(kExtension)) return none;
    return member_of(member_of(material, "extensions"), std::string(type.substr(kExtension.size())));
}

bool is_texture(const Rule& rule)
{
    constexpr std::string_view kTypes[] = {"textureInfo", "normalTexture", "occlusionTexture"};
    return rule.kind == Rule::Kind::Object && std::ranges::find(kTypes, rule.detail) != std::end(kTypes);
}

}  // namespace

std::set<std::int64_t> coordinate_sets(const json& material)
{
    constexpr const char* kGlossiness = "material/KHR_materials_pbrSpecularGlossiness";
    const bool has_glossiness = part_of(material, kGlossiness).is_object();
    std::set<std::int64_t> sets;
    for (const Rule& rule : gltf_schema()) {
        if (!is_texture(rule) || std::string_view(rule.key) == "thicknessTexture") continue;
        if (has_glossiness && std::string_view(rule.object) == "pbrMetallicRoughness") continue;
        const json& texture = member_of(part_of(material, rule.object), rule.key);
        if (!texture.is_object()) continue;
        const json& transform = member_of(member_of(texture, "extensions"), "KHR_texture_transform");
        const std::int64_t set = integer(texture, "texCoord", 0);
        sets.insert(transform.is_object() ? integer(transform, "texCoord", set) : set);
    }
    const json& bump = member_of(member_of(member_of(material, "extras"), "occam"), "bump");
    const json& set = member_of(bump, "texCoord");
    if (bump.is_object() && (set.is_null() || set.is_number_integer()))
        sets.insert(set.is_null() ? 0 : set.get<std::int64_t>());
    return sets;
}

}  // namespace occam::import
