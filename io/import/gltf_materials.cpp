#include "io/import/gltf_materials.h"

#include <array>
#include <cmath>
#include <unordered_map>

#include "io/import/files.h"
#include "io/import/gltf_uri.h"
#include "io/import/gltf_value.h"
#include "io/texture/decode.h"
#include "scenegraph/content_rules.h"

namespace occam::import {

namespace {

constexpr std::size_t kMaxShownUri = 80;  // data URIs are long

// Returns what a data URI holds (RFC 2397), or nothing if it is not in base64. tinygltf itself decodes those of a few kinds
// only, WebP not among them.
std::vector<unsigned char> bytes_of_data_uri(const std::string& uri)
{
    constexpr std::string_view kIsEncoded = ";base64,";
    const std::size_t comma = uri.find(',');
    if (comma == std::string::npos || !std::string_view(uri).substr(0, comma + 1).ends_with(kIsEncoded)) return {};
    std::vector<unsigned char> bytes;
    std::string kind;
    const std::string known = "data:application/octet-stream;base64," + uri.substr(comma + 1);
    if (!tinygltf::DecodeDataURI(&bytes, kind, known, 0, false)) bytes.clear();
    return bytes;
}

std::shared_ptr<const std::vector<std::byte>> kept(std::span<const unsigned char> bytes)
{
    const auto* first = reinterpret_cast<const std::byte*>(bytes.data());
    return std::make_shared<const std::vector<std::byte>>(first, first + bytes.size());
}

template <class T>
const T* find(const std::vector<T>& list, int index)
{
    return index >= 0 && static_cast<std::size_t>(index) < list.size() ? &list[static_cast<std::size_t>(index)] : nullptr;
}

std::string named_image(int index, const std::string& name)
{
    return named_element("images", static_cast<std::size_t>(index), name);
}

TextureUse::Wrap wrap_of(int mode)
{
    if (mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return TextureUse::Wrap::Clamp;
    if (mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT) return TextureUse::Wrap::Mirror;
    return TextureUse::Wrap::Repeat;
}

// Returns for each image the first one that is read from the same place: a file may name a large image thousands of times,
// by many spellings or by views of the same bytes.
std::vector<int> same_images(const tinygltf::Model& model, Folder& folder)
{
    std::vector<int> first(model.images.size());
    std::map<std::array<std::size_t, 3>, int> by_bytes;
    std::unordered_map<std::string_view, int> by_uri;
    std::unordered_map<std::string, int> by_path;
    for (std::size_t i = 0; i < first.size(); ++i) {
        const tinygltf::Image& image = model.images[i];
        const int index = static_cast<int>(i);
        first[i] = index;
        if (const tinygltf::BufferView* view = find(model.bufferViews, image.bufferView)) {
            const auto buffer = static_cast<std::size_t>(view->buffer);
            first[i] = by_bytes.try_emplace({buffer, view->byteOffset, view->byteLength}, index).first->second;
        } else if (image.image.empty()) {
            const auto [known, is_new] = by_uri.try_emplace(image.uri, index);
            if (is_new && !image.uri.starts_with("data:"))
                if (const auto& path = folder.find(decode_uri(image.uri)).path)
                    known->second = by_path.try_emplace(path->string(), index).first->second;
            first[i] = known->second;
        }
    }
    return first;
}

// Views that overlap would each have a copy of the bytes, so their sum is limited. Those of ordinary files do not overlap;
// an image that nothing but displacements uses counts twice, since it is opened before they are met.
std::size_t most_view_bytes(const tinygltf::Model& model)
{
    std::size_t bytes = std::size_t(16) << 20;
    for (const tinygltf::Buffer& buffer : model.buffers) bytes += 2 * buffer.data.size();
    return bytes;
}

}  // namespace

MaterialImporter::MaterialImporter(const tinygltf::Model& model, AccessorReader& accessors, Scene& scene, Report& report)
    : model_(model),
      accessors_(accessors),
      scene_(scene),
      report_(report),
      first_image_(same_images(model, report.folder())),
      view_bytes_left_(most_view_bytes(model))
{
    for (std::size_t i = 0; i < model.materials.size(); ++i) {
        const tinygltf::Material& m = model.materials[i];
        const std::string where = named_element("materials", i, m.name);
        Material material = convert(m, where);
        try {
            check(material);
        } catch (const Error& error) {  // finite numbers may overflow in a product or as floats
            report_.warn(std::string("the default material is taken: ") + error.what(), where);
            material = Material();
            material.name = m.name;
        }
        materials_.push_back(scene.add(std::move(material)));
    }
    // The store will read what is used. The rest is only opened here, so that a broken image is reported, and is not kept.
    for (std::size_t i = 0; i < model.images.size(); ++i) {
        const int index = static_cast<int>(i);
        if (first_image_[i] != index || images_.count({index, TextureRole::Color}) ||
            images_.count({index, TextureRole::Data}))
            continue;
        const auto unused = describe(index, TextureRole::Data);
        encoded_.erase(index);
        try {
            if (unused) const TextureSource opened(*unused);
        } catch (const Error& error) {
            report_.warn("unused image cannot be read", named_image(index, model.images[i].name));
        }
    }
}

MaterialId MaterialImporter::material(int index)
{
    if (index < 0) {
        // The default material is one without any property (glTF 2.0, sec. 3.9.6).
        if (!default_material_) default_material_ = scene_.add(convert(tinygltf::Material(), "the default material"));
        return default_material_;
    }
    const MaterialId* id = find(materials_, index);
    return id ? *id : MaterialId();
}

Displacement MaterialImporter::displacement(const DisplacementExtras& extras, const std::string& where)
{
    require_texture(extras.texture, where);
    const TextureUse map = use(extras.texture, 0, {}, TextureRole::Data, where + ".displacement");
    // A displacement without its image leaves the surface where it is.
    return {map, map ? extras.scale : 0, extras.midlevel, extras.bound, extras.space};
}

void MaterialImporter::require_texture(int index, const std::string& where) const
{
    if (!find(model_.textures, index)) throw Error(report_.name(), "there is no texture " + std::to_string(index), where);
}

TextureId MaterialImporter::image(int index, TextureRole role, const std::string& where)
{
    if (!find(model_.images, index)) {
        report_.warn("texture has no image that can be read", where);
        return {};
    }
    index = first_image_[static_cast<std::size_t>(index)];
    const auto [known, is_new] = images_.try_emplace({index, role});
    if (!is_new) return known->second;

    if (std::optional<Texture> t = describe(index, role)) known->second = scene_.add(*std::move(t));
    return known->second;
}

std::span<const unsigned char> MaterialImporter::bytes_of_view(int view, const std::string& where)
{
    const std::span<const unsigned char> bytes = accessors_.view(view, where);
    if (bytes.size() > view_bytes_left_)
        throw Error(report_.name(), "images in buffer views show far more bytes than the buffers hold", where);
    view_bytes_left_ -= bytes.size();
    return bytes;
}

std::optional<Texture> MaterialImporter::describe(int index, TextureRole role)
{
    const tinygltf::Image* i = find(model_.images, index);
    Texture t;
    const std::string name = i->name.empty() ? i->uri.substr(0, kMaxShownUri) : i->name;
    t.name = report_.name() + ": " + named_image(index, name);
    t.role = role;
    const std::string shown = i->uri.substr(0, kMaxShownUri);
    if (const bool is_data_uri = i->uri.starts_with("data:"); is_data_uri || i->bufferView >= 0 || !i->image.empty()) {
        auto& bytes = encoded_[index];
        if (!bytes && i->bufferView >= 0) bytes = kept(bytes_of_view(i->bufferView, named_image(index, i->name)));
        else if (!bytes) bytes = kept(i->image.empty() ? bytes_of_data_uri(i->uri) : i->image);
        if (is_data_uri && bytes->empty()) {
            report_.warn("image is not in base64", named_image(index, shown));
            return std::nullopt;
        }
        t.encoded = bytes;
        return t;
    }
    const auto& [path, is_file] = report_.folder().find(decode_uri(i->uri));
    if (!path) {
        report_.warn_of_file("image is not in the scene's folder", named_image(index, shown));
        return std::nullopt;
    }
    if (!is_file) {
        report_.warn_of_file("image file is missing", shown);
        return std::nullopt;
    }
    report_.add_file(*path);
    t.path = *path;
    return t;
}

void MaterialImporter::transform(const tinygltf::Value& transform, TextureUse& use) const
{
    use.offset = vector<Vec2f>(transform, "offset").value_or(Vec2f(0));
    use.scale = vector<Vec2f>(transform, "scale").value_or(Vec2f(1));
    use.rotation = number(transform, "rotation", 0);
    use.uv_set = integer(transform, "texCoord", use.uv_set);
}

TextureUse MaterialImporter::use(int texture, int uv_set, const tinygltf::ExtensionMap& extensions, TextureRole role,
                                 const std::string& where)
{
    TextureUse result;
    const tinygltf::Texture* t = find(model_.textures, texture);
    if (!t) return result;
    const int webp = integer(extension(t->extensions, "EXT_texture_webp"), "source", -1);
    result.texture = image(webp >= 0 ? webp : t->source, role, where);
    result.uv_set = uv_set;
    if (const tinygltf::Sampler* sampler = find(model_.samplers, t->sampler)) {
        result.wrap_s = wrap_of(sampler->wrapS);
        result.wrap_t = wrap_of(sampler->wrapT);
        result.nearest = sampler->magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
    }
    transform(extension(extensions, "KHR_texture_transform"), result);
    if (result.uv_set < 0 || result.uv_set > 1) {
        report_.warn("only TEXCOORD_0 and TEXCOORD_1 are read: the first is taken", where);
        result.uv_set = 0;
    }
    return result;
}

TextureUse MaterialImporter::use(const tinygltf::Value& info, TextureRole role, const std::string& where)
{
    tinygltf::ExtensionMap extensions;
    const tinygltf::Value& inner = member(info, "extensions");
    for (const std::string& key : inner.Keys()) extensions[key] = inner.Get(key);
    return use(integer(info, "index", -1), integer(info, "texCoord", 0), extensions, role, where);
}

Material MaterialImporter::convert(const tinygltf::Material& m, const std::string& where)
{
    const auto named = [&](const char* part) { return where + "." + part; };
    const tinygltf::PbrMetallicRoughness& pbr = m.pbrMetallicRoughness;
    Material out;
    out.name = m.name;
    out.base_color = vector_of(pbr.baseColorFactor, Vec4f(1));
    out.base_color_texture = use(pbr.baseColorTexture.index, pbr.baseColorTexture.texCoord, pbr.baseColorTexture.extensions,
                                 TextureRole::Color, named("baseColorTexture"));
    if (pbr.baseColorTexture.index >= 0 && !out.base_color_texture) out.base_color *= kMissingColor;
    out.metallic = static_cast<float>(pbr.metallicFactor);
    out.roughness = static_cast<float>(pbr.roughnessFactor);
    out.metallic_roughness_texture = use(pbr.metallicRoughnessTexture.index, pbr.metallicRoughnessTexture.texCoord,
                                         pbr.metallicRoughnessTexture.extensions, TextureRole::Data,
                                         named("metallicRoughnessTexture"));
    out.emission = vector_of(m.emissiveFactor, Vec3f(0)) *
                   number(extension(m.extensions, "KHR_materials_emissive_strength"), "emissiveStrength", 1);
    out.emission_texture = use(m.emissiveTexture.index, m.emissiveTexture.texCoord, m.emissiveTexture.extensions,
                               TextureRole::Color, named("emissiveTexture"));
    if (m.emissiveTexture.index >= 0 && !out.emission_texture) out.emission = Vec3f(0);
    out.normal_texture = use(m.normalTexture.index, m.normalTexture.texCoord, m.normalTexture.extensions, TextureRole::Data,
                             named("normalTexture"));
    out.normal_scale = static_cast<float>(m.normalTexture.scale);
    out.occlusion_texture = use(m.occlusionTexture.index, m.occlusionTexture.texCoord, m.occlusionTexture.extensions,
                                TextureRole::Data, named("occlusionTexture"));
    out.occlusion_strength = static_cast<float>(m.occlusionTexture.strength);
    if (m.alphaMode == "MASK") out.alpha_mode = AlphaMode::Mask;
    if (m.alphaMode == "BLEND") out.alpha_mode = AlphaMode::Blend;
    out.alpha_cutoff = static_cast<float>(m.alphaCutoff);
    out.double_sided = m.doubleSided;
    add_extensions(m.extensions, out, where);
    if (const auto bump = bump_extras(m.extras, where, report_)) {
        require_texture(bump->texture, where);
        out.bump_texture = use(bump->texture, bump->uv_set, {}, TextureRole::Data, where + ".bump");
        out.bump_scale = bump->scale;
    }
    return out;
}

void MaterialImporter::add_extensions(const tinygltf::ExtensionMap& extensions, Material& out, const std::string& where)
{
    const auto map = [&](const tinygltf::Value& value, const char* key, TextureRole role = TextureRole::Data) {
        return use(member(value, key), role, where + "." + key);
    };
    out.unlit = extensions.count("KHR_materials_unlit") > 0;
    out.ior = number(extension(extensions, "KHR_materials_ior"), "ior", 1.5f);

    const tinygltf::Value& transmission = extension(extensions, "KHR_materials_transmission");
    out.transmission = number(transmission, "transmissionFactor", 0);
    out.transmission_texture = map(transmission, "transmissionTexture");

    const tinygltf::Value& volume = extension(extensions, "KHR_materials_volume");
    out.thickness = number(volume, "thicknessFactor", 0);
    out.attenuation_color = vector<Vec3f>(volume, "attenuationColor").value_or(Vec3f(1));
    out.attenuation_distance = number(volume, "attenuationDistance", 0);

    const tinygltf::Value& clearcoat = extension(extensions, "KHR_materials_clearcoat");
    out.clearcoat = number(clearcoat, "clearcoatFactor", 0);
    out.clearcoat_roughness = number(clearcoat, "clearcoatRoughnessFactor", 0);
    out.clearcoat_texture = map(clearcoat, "clearcoatTexture");
    out.clearcoat_roughness_texture = map(clearcoat, "clearcoatRoughnessTexture");
    out.clearcoat_normal_texture = map(clearcoat, "clearcoatNormalTexture");
    out.clearcoat_normal_scale = number(member(clearcoat, "clearcoatNormalTexture"), "scale", 1);

    const tinygltf::Value& specular = extension(extensions, "KHR_materials_specular");
    out.specular = number(specular, "specularFactor", 1);
    out.specular_color = vector<Vec3f>(specular, "specularColorFactor").value_or(Vec3f(1));
    out.specular_texture = map(specular, "specularTexture");
    out.specular_color_texture = map(specular, "specularColorTexture", TextureRole::Color);

    const tinygltf::Value& sheen = extension(extensions, "KHR_materials_sheen");
    out.sheen_color = vector<Vec3f>(sheen, "sheenColorFactor").value_or(Vec3f(0));
    out.sheen_roughness = number(sheen, "sheenRoughnessFactor", 0);
    out.sheen_color_texture = map(sheen, "sheenColorTexture", TextureRole::Color);
    out.sheen_roughness_texture = map(sheen, "sheenRoughnessTexture");

    const tinygltf::Value& anisotropy = extension(extensions, "KHR_materials_anisotropy");
    out.anisotropy = number(anisotropy, "anisotropyStrength", 0);
    out.anisotropy_rotation = number(anisotropy, "anisotropyRotation", 0);
    out.anisotropy_texture = map(anisotropy, "anisotropyTexture");

    const tinygltf::Value& glossiness = extension(extensions, "KHR_materials_pbrSpecularGlossiness");
    if (glossiness.IsObject()) set_specular_glossiness(glossiness, out, where);
}

// Makes a dielectric that reflects the specular colour at normal incidence, over a base of the diffuse colour. This is the
// meaning of an index of 0 in KHR_materials_ior.
void MaterialImporter::set_specular_glossiness(const tinygltf::Value& value, Material& out, const std::string& where)
{
    out.base_color = vector<Vec4f>(value, "diffuseFactor").value_or(Vec4f(1));
    out.base_color_texture = use(member(value, "diffuseTexture"), TextureRole::Color, where + ".diffuseTexture");
    if (value.Has("diffuseTexture") && !out.base_color_texture) out.base_color *= kMissingColor;
    out.metallic = 0;
    out.metallic_roughness_texture = {};
    out.ior = 0;
    out.specular = 1;
    out.specular_texture = {};
    out.specular_color = vector<Vec3f>(value, "specularFactor").value_or(Vec3f(1));
    out.roughness = 1 - number(value, "glossinessFactor", 1);
    out.specular_color_texture = use(member(value, "specularGlossinessTexture"), TextureRole::Color,
                                     where + ".specularGlossinessTexture");
    out.glossiness_texture = out.specular_color_texture;  // its alpha channel holds the glossiness
}

}  // namespace occam::import
