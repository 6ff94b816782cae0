#include "scenegraph/import/mtl.h"

#include <tiny_obj_loader.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "scenegraph/import/files.h"

namespace occam::import {

namespace {

constexpr std::size_t kMaxLibraryBytes = std::size_t(256) << 20;

float unit(float x) { return x >= 0 ? std::min(x, 1.0f) : 0.0f; }
Vec3f not_negative(const float (&c)[3])
{
    const auto part = [](float x) { return x >= 0 && std::isfinite(x) ? x : 0.0f; };
    return {part(c[0]), part(c[1]), part(c[2])};
}

class LibraryReader {
public:
    LibraryReader(const std::filesystem::path& folder, Scene& scene, Report& report)
        : folder_(folder), scene_(scene), report_(report)
    {
    }

    void read(const std::string& names)
    {
        if (read_file_named(names)) return;
        std::istringstream words(names);
        std::string name;
        while (words >> name)
            if (name == names || !read_file_named(name))
                report_.warn("material library is missing, or not in the scene's folder", name);
    }

    std::map<std::string, MaterialId> materials;

private:
    bool read_file_named(const std::string& name)
    {
        const auto path = inside(folder_, name);
        if (!path || !std::filesystem::is_regular_file(*path)) return false;
        const std::string text = import::read_file(*path, kMaxLibraryBytes);
        std::map<std::string, int> index;
        std::vector<tinyobj::material_t> list;
        std::string warnings, errors;
        TextStream stream(text);
        tinyobj::LoadMtl(&index, &list, &stream, &warnings, &errors);
        // The library always gives one material, even of an empty file: that one has no name.
        for (const tinyobj::material_t& m : list)
            if (!m.name.empty() && !materials.count(m.name)) materials.emplace(m.name, scene_.add(convert(m)));
        return true;
    }

    TextureUse texture(const std::string& name, const tinyobj::texture_option_t& option, TextureRole role)
    {
        TextureUse use;
        if (name.empty()) return use;
        const auto path = inside(folder_, name);
        if (!path) {
            report_.warn("texture is not in the scene's folder", name);
            return use;
        }
        const auto [known, is_new] = textures_.try_emplace({path->string(), role});
        if (is_new) {
            Texture t;
            t.name = name, t.role = role, t.path = *path;
            known->second = scene_.add(std::move(t));
        }
        use.texture = known->second;
        // st = scale * uv + offset with v upwards; ours runs downwards: 1 - (s (1 - v) + o) = s v + 1 - s - o.
        const float su = option.scale[0], sv = option.scale[1], ou = option.origin_offset[0], ov = option.origin_offset[1];
        if (std::isfinite(su) && std::isfinite(sv) && std::isfinite(ou) && std::isfinite(ov))
            use.scale = {su, sv}, use.offset = {ou, 1 - sv - ov};
        if (option.clamp) use.wrap_s = use.wrap_t = TextureUse::Wrap::Clamp;
        return use;
    }

    Material convert(const tinyobj::material_t& m)
    {
        Material material;
        material.name = m.name;
        Vec3f diffuse = not_negative(m.diffuse);
        if (!m.diffuse_texname.empty()) {
            // Exporters write black or nothing beside a map (the library makes 0.6 of nothing) and mean the map alone.
            const bool says_nothing = diffuse == Vec3f(0) || diffuse == Vec3f(0.6f);
            if (says_nothing) diffuse = Vec3f(1);
            material.base_color_texture = texture(m.diffuse_texname, m.diffuse_texopt, TextureRole::Color);
        }
        material.base_color = Vec4f(diffuse, unit(m.dissolve));
        if (material.base_color.w < 1 || (!m.alpha_texname.empty() && m.alpha_texname == m.diffuse_texname))
            material.alpha_mode = AlphaMode::Blend;
        else if (!m.alpha_texname.empty()) report_.warn("an alpha map of its own (map_d) is left out", m.name);
        material.emission = not_negative(m.emission);
        if (!m.emissive_texname.empty()) {
            material.emission_texture = texture(m.emissive_texname, m.emissive_texopt, TextureRole::Color);
            if (material.emission == Vec3f(0)) material.emission = Vec3f(1);
        }
        if (m.roughness > 0 || m.metallic > 0) {
            material.roughness = unit(m.roughness);
            material.metallic = unit(m.metallic);
        } else if (m.shininess > 1) {
            // Blinn's exponent of a highlight as wide as that of roughness^2 (Walter et al. 2007, sec. 5.2).
            material.roughness = unit(std::sqrt(std::sqrt(2.0f / (m.shininess + 2.0f))));
        }
        if (!m.normal_texname.empty())
            material.normal_texture = texture(m.normal_texname, m.normal_texopt, TextureRole::Data);
        if (!m.roughness_texname.empty() || !m.metallic_texname.empty())
            report_.warn("maps of roughness and metalness (map_Pr, map_Pm) are left out", m.name);
        if (m.ior >= 1 && m.ior < 10) material.ior = m.ior;
        material.clearcoat = unit(m.clearcoat_thickness);
        material.clearcoat_roughness = unit(m.clearcoat_roughness);
        return material;
    }

    const std::filesystem::path& folder_;
    Scene& scene_;
    Report& report_;
    std::map<std::pair<std::string, TextureRole>, TextureId> textures_;
};

}  // namespace

std::map<std::string, MaterialId> read_mtl(const std::vector<std::string>& libraries, const std::filesystem::path& folder,
                                           Scene& scene, Report& report)
{
    LibraryReader reader(folder, scene, report);
    for (const std::string& names : libraries) reader.read(names);
    return std::move(reader.materials);
}

}  // namespace occam::import
