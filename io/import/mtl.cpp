#include "io/import/mtl.h"

#include <tiny_obj_loader.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <sstream>
#include <unordered_map>

#include "io/import/files.h"
#include "io/import/mtl_statements.h"
#include "io/import/words.h"
#include "io/texture/decode.h"
#include "io/texture/decode_budget.h"

namespace occam::import {

namespace {

constexpr float kMissingColor = 0.5f;  // a colour whose image is missing is grey
constexpr std::size_t kMaxLibraryBytes = std::size_t(256) << 20;

constexpr float kLeastUnknownIor = 10;  // an index from this one on is none of a dielectric, and is not taken

float unit(float x) { return x >= 0 ? std::min(x, 1.0f) : 0.0f; }
Vec3f not_negative(const float (&c)[3])
{
    const auto part = [](float x) { return x >= 0 && std::isfinite(x) ? x : 0.0f; };
    return {part(c[0]), part(c[1]), part(c[2])};
}

bool is_given(float x) { return x != kNotGiven; }
bool is_given(const float (&c)[3]) { return is_given(c[0]) || is_given(c[1]) || is_given(c[2]); }

// Returns true for the illumination model of MTL that has a Lambertian surface without highlights, unless values of the
// extension for physically based rendering say more.
bool is_diffuse_alone(const tinyobj::material_t& m)
{
    const bool is_extended = is_given(m.roughness) || m.metallic > 0 || m.clearcoat_thickness > 0 ||
                             !m.roughness_texname.empty() || !m.metallic_texname.empty();
    return m.illum == 1 && !is_extended;
}

// Returns true if the image, reduced to at most 64 texels a side, has no colour. Returns false if it cannot be read, or if
// the budget has nothing left for it; the texture store, which has the same budget for all images, will report that.
bool is_grey(const Texture& texture, DecodeBudget& budget)
{
    constexpr float kColor = 4.0f / 255;
    try {
        const TextureSource source(texture, &budget);
        std::error_code ignored;
        if (!budget.takes_bytes(source.bytes_to_decode(), std::filesystem::file_size(texture.path, ignored))) return false;
        int halvings = 0;
        while (std::max(source.width(), source.height()) >> halvings > 64) ++halvings;
        const MipImage image = source.decode(halvings);
        for (int y = 0; y < image.height(); ++y)
            for (int x = 0; x < image.width(); ++x) {
                const Vec4f t = image.texel(0, x, y);
                if (std::abs(t.x - t.z) > kColor || std::abs(t.y - t.z) > kColor) return false;
            }
        return true;
    } catch (const Error&) {
        return false;
    }
}

class LibraryReader {
public:
    LibraryReader(Scene& scene, Report& report) : scene_(scene), report_(report) {}

    void read(const std::string& line)
    {
        if (read_file_named(line)) return;
        const std::string names(without_comment(line));
        if (names != line && read_file_named(names)) return;
        std::istringstream words(names);
        std::string name;
        while (words >> name)
            if (name == names || !read_file_named(name))
                report_.warn("material library is missing, or not in the scene's folder", name);
    }

    /// Returns the materials so far; none if no library could be read.
    std::optional<std::map<std::string, MaterialId>> take()
    {
        const bool is_read = std::any_of(is_there_.begin(), is_there_.end(), [](const auto& name) { return name.second; });
        return is_read ? std::optional(std::move(materials_)) : std::nullopt;
    }

private:
    // Reads a library once, however often it is named. Returns false if there is none of that name.
    bool read_file_named(const std::string& name)
    {
        const auto [known, is_new] = is_there_.try_emplace(name, false);
        if (is_new) known->second = read_new(name);
        return known->second;
    }

    bool read_new(const std::string& name)
    {
        std::string form = name;
        if (!report_.folder().find(form).is_file) std::replace(form.begin(), form.end(), '\\', '/');
        const auto& [path, is_file] = report_.folder().find(form);
        if (!is_file) return false;
        if (!paths_.insert(*path).second) return true;  // it is there by another name
        beside_ = form.substr(0, form.rfind('/') + 1);
        report_.add_file(*path);
        const std::string text = prepare_mtl(read_text(*path, kMaxLibraryBytes), name, report_);
        std::map<std::string, int> index;
        std::vector<tinyobj::material_t> list;
        std::string warnings, errors;
        TextStream stream(text);
        tinyobj::LoadMtl(&index, &list, &stream, &warnings, &errors);
        for (const tinyobj::material_t& m : list) add_image_files(m);
        // The library always gives one material, even for an empty file: that one has no name.
        for (const tinyobj::material_t& m : list)
            if (!m.name.empty() && !materials_.count(m.name)) materials_.emplace(m.name, scene_.add(convert(m)));
        for (const tinyobj::material_t& m : list)
            if (const std::string alone(without_comment(m.name)); alone != m.name && !alone.empty())
                materials_.emplace(alone, materials_.at(m.name));
        return true;
    }

    // Returns the first place of a file that the name may mean, or else the last one in the folder, if there is one. Names
    // are those of files beside the library, or else beside the scene.
    const Folder::Place& image_place(const std::string& name)
    {
        const Folder::Place* last = nullptr;
        for (std::string form : {name, std::string(without_comment(name))})
            for (int with_slashes = 0; with_slashes < 2; ++with_slashes) {
                if (with_slashes) std::replace(form.begin(), form.end(), '\\', '/');  // as programs for Windows write them
                for (const std::string& folder : {form.starts_with('/') ? std::string() : beside_, std::string()}) {
                    const Folder::Place& place = report_.folder().find(folder + form);
                    if (!last || place.path) last = &place;
                    if (last->is_file) return *last;
                }
            }
        return *last;
    }

    // Returns whether two names are of one image, however they are spelled.
    bool is_same_image(const std::string& a, const std::string& b)
    {
        if (a == b || a.empty() || b.empty()) return a == b;
        const Folder::Place &place_a = image_place(a), &place_b = image_place(b);
        return place_a.is_file && place_b.is_file && place_a.path == place_b.path;
    }

    // Lists the images that the material names, also those of kinds that are not read.
    void add_image_files(const tinyobj::material_t& m)
    {
        for (const std::string* name :
             {&m.ambient_texname, &m.diffuse_texname, &m.specular_texname, &m.specular_highlight_texname, &m.bump_texname,
              &m.displacement_texname, &m.alpha_texname, &m.reflection_texname, &m.roughness_texname, &m.metallic_texname,
              &m.sheen_texname, &m.emissive_texname, &m.normal_texname}) {
            if (name->empty()) continue;
            if (const Folder::Place& place = image_place(*name); place.is_file) report_.add_file(*place.path);
        }
    }

    TextureUse texture(const std::string& name, const tinyobj::texture_option_t& option, TextureRole role)
    {
        TextureUse use;
        if (name.empty()) return use;
        const auto& [path, is_file] = image_place(name);
        if (!path) {
            report_.warn_of_file("texture is not in the scene's folder", name);
            return use;
        }
        if (!is_file) {
            report_.warn_of_file("image file is missing", name);
            return use;
        }
        const auto [known, is_new] = textures_.try_emplace({path->string(), role});
        if (is_new) {
            Texture t;
            t.name = report_.name() + ": " + name, t.role = role, t.path = *path;
            known->second = scene_.add(std::move(t));
        }
        use.texture = known->second;
        // The file has st = scale * uv + offset with v upwards. Here v runs downwards, so that
        // 1 - (s (1 - v) + o) = s v + 1 - s - o.
        const float su = option.scale[0], sv = option.scale[1], ou = option.origin_offset[0], ov = option.origin_offset[1];
        if (std::isfinite(su) && std::isfinite(sv) && std::isfinite(ou) && std::isfinite(ov))
            use.scale = {su, sv}, use.offset = {ou, 1 - sv - ov};
        if (option.clamp) use.wrap_s = use.wrap_t = TextureUse::Wrap::Clamp;
        return use;
    }

    // Many materials may name the image, so it is decoded once.
    bool holds_heights(TextureId texture)
    {
        const auto [known, is_new] = is_grey_.try_emplace(texture, false);
        if (is_new) known->second = is_grey(scene_.texture(texture), budget_);
        return known->second;
    }

    // Adds the normal map or the bump map. A normal map comes from `norm`, or from `map_Bump`, to which exporters write both
    // kinds: an image without any colour holds heights, in file units times -bm.
    void add_normals(const tinyobj::material_t& m, Material& material)
    {
        if (!m.normal_texname.empty()) {
            material.normal_texture = texture(m.normal_texname, m.normal_texopt, TextureRole::Data);
        } else if (!m.bump_texname.empty()) {
            const TextureUse use = texture(m.bump_texname, m.bump_texopt, TextureRole::Data);
            const bool has_heights = use && holds_heights(use.texture);
            (has_heights ? material.bump_texture : material.normal_texture) = use;
            if (std::isfinite(m.bump_texopt.bump_multiplier))
                (has_heights ? material.bump_scale : material.normal_scale) = m.bump_texopt.bump_multiplier;
        }
    }

    // Counts what the values of a statement are changed to, because they are out of its range.
    void warn_of_range(const tinyobj::material_t& m, const char* statement, bool is_within)
    {
        if (!is_within) report_.warn(std::string("a value of ") + statement + " is out of range", "material " + m.name);
    }
    void warn_of_ranges(const tinyobj::material_t& m)
    {
        const auto is_unit = [](float x) { return !is_given(x) || (x >= 0 && x <= 1); };
        const auto is_color = [](const float(&c)[3]) { return !is_given(c) || not_negative(c) == Vec3f(c[0], c[1], c[2]); };
        warn_of_range(m, "Kd", is_color(m.diffuse));
        warn_of_range(m, "Ke", is_color(m.emission));
        warn_of_range(m, "d", is_unit(m.dissolve));
        warn_of_range(m, "Pr", is_unit(m.roughness));
        warn_of_range(m, "Pm", is_unit(m.metallic));
        warn_of_range(m, "Pc", is_unit(m.clearcoat_thickness));
        warn_of_range(m, "Pcr", is_unit(m.clearcoat_roughness));
        // The exponent is at most 1000 by the specification, and at most 10000 in files of other programs. Indices of less
        // than 1 stand for none.
        warn_of_range(m, "Ns", m.shininess >= 0 && m.shininess <= 1e6f);
        warn_of_range(m, "Ni", !is_given(m.ior) || (m.ior >= 0 && m.ior < kLeastUnknownIor));
    }

    Material convert(const tinyobj::material_t& m)
    {
        warn_of_ranges(m);
        Material material;
        material.name = m.name;
        Vec3f diffuse = is_given(m.diffuse) ? not_negative(m.diffuse) : Vec3f(1);  // white, as without a material
        if (!m.diffuse_texname.empty()) {
            // Exporters write black beside a map and mean the map alone.
            if (diffuse == Vec3f(0)) diffuse = Vec3f(1);
            material.base_color_texture = texture(m.diffuse_texname, m.diffuse_texopt, TextureRole::Color);
            if (!material.base_color_texture) diffuse *= kMissingColor;
        }
        material.base_color = Vec4f(diffuse, unit(m.dissolve));
        if (material.base_color.w < 1 || !m.alpha_texname.empty()) material.alpha_mode = AlphaMode::Blend;
        // The alpha of the base colour's own image is already in use.
        if (!is_same_image(m.alpha_texname, m.diffuse_texname))
            material.alpha_texture = texture(m.alpha_texname, m.alpha_texopt, TextureRole::Data);
        material.emission = not_negative(m.emission);
        if (!m.emissive_texname.empty()) {
            material.emission_texture = texture(m.emissive_texname, m.emissive_texopt, TextureRole::Color);
            if (material.emission == Vec3f(0)) material.emission = Vec3f(1);
            if (!material.emission_texture) material.emission = Vec3f(0);
        }
        material.metallic = unit(m.metallic);
        if (is_given(m.roughness)) {
            material.roughness = unit(m.roughness);
        } else if (m.shininess > 1) {
            // Blinn's exponent gives a highlight as wide as that of roughness^2 (Walter et al. 2007, sec. 5.2).
            material.roughness = unit(std::sqrt(std::sqrt(2.0f / (m.shininess + 2.0f))));
        }
        // A map without a factor, or with 0, means the map alone, as it does for colours.
        material.roughness_texture = texture(m.roughness_texname, m.roughness_texopt, TextureRole::Data);
        if (material.roughness_texture) material.roughness = m.roughness > 0 ? unit(m.roughness) : 1;
        material.metallic_texture = texture(m.metallic_texname, m.metallic_texopt, TextureRole::Data);
        if (material.metallic_texture) material.metallic = m.metallic > 0 ? unit(m.metallic) : 1;
        if (is_diffuse_alone(m)) material.specular = 0;
        add_normals(m, material);
        if (m.ior >= 1 && m.ior < kLeastUnknownIor) material.ior = m.ior;
        material.clearcoat = unit(m.clearcoat_thickness);
        material.clearcoat_roughness = unit(m.clearcoat_roughness);
        return material;
    }

    Scene& scene_;
    Report& report_;
    std::map<std::string, MaterialId> materials_;
    std::map<std::pair<std::string, TextureRole>, TextureId> textures_;
    std::map<std::string, bool> is_there_;   ///< the names of libraries so far, and whether each is there
    std::set<std::filesystem::path> paths_;  ///< libraries that have been read, by canonical paths
    std::string beside_;                     ///< the folder of the library that is read, below that of the scene
    DecodeBudget budget_;
    std::unordered_map<TextureId, bool> is_grey_;  ///< of the images of bump maps so far
};

}  // namespace

std::optional<std::map<std::string, MaterialId>> read_mtl(const std::vector<std::string>& libraries, Scene& scene,
                                                          Report& report)
{
    LibraryReader reader(scene, report);
    for (const std::string& names : libraries) reader.read(names);
    return reader.take();
}

}  // namespace occam::import
