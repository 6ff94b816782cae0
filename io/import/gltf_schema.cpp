#include "io/import/gltf_schema.h"

#include "scenegraph/interpolation.h"

namespace occam::import {

namespace {

using Kind = Rule::Kind;
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kMaxBytes = 9007199254740992.0;  // 2^53: what a JSON number holds exactly
constexpr bool kRequired = true;

constexpr char kInterpolationWords[] = "|LINEAR|STEP|CUBICSPLINE|";
consteval bool has_all_interpolations()
{
    for (const InterpolationRow& row : kInterpolations)
        if (std::string_view(kInterpolationWords).find(row.name) == std::string_view::npos) return false;
    return true;
}
static_assert(has_all_interpolations());

// Every object may also have `extensions` and `extras`, and every element of a root array a `name`. An object named "X/E" is
// the extension E where it is allowed: in objects of type X.
constexpr Rule kRules[] = {
    {"root", "asset", Kind::Object, "asset", 0, 0, kRequired},
    {"root", "extensionsUsed", Kind::Strings},
    {"root", "extensionsRequired", Kind::Strings},
    {"root", "accessors", Kind::Objects, "accessor"},
    {"root", "animations", Kind::Objects, "animation"},
    {"root", "buffers", Kind::Objects, "buffer"},
    {"root", "bufferViews", Kind::Objects, "bufferView"},
    {"root", "cameras", Kind::Objects, "camera"},
    {"root", "images", Kind::Objects, "image"},
    {"root", "materials", Kind::Objects, "material"},
    {"root", "meshes", Kind::Objects, "mesh"},
    {"root", "nodes", Kind::Objects, "node"},
    {"root", "samplers", Kind::Objects, "sampler"},
    {"root", "scene", Kind::Index, "scenes"},
    {"root", "scenes", Kind::Objects, "scene"},
    {"root", "skins", Kind::Objects, "skin"},
    {"root", "textures", Kind::Objects, "texture"},

    {"asset", "version", Kind::String, "", 0, 0, kRequired},
    {"asset", "minVersion", Kind::String},
    {"asset", "generator", Kind::String},
    {"asset", "copyright", Kind::String},

    {"accessor", "bufferView", Kind::Index, "bufferViews"},
    {"accessor", "byteOffset", Kind::Integer, "", 0, kMaxBytes},
    {"accessor", "componentType", Kind::Choice, "|5120|5121|5122|5123|5125|5126|", 0, 0, kRequired},
    {"accessor", "normalized", Kind::Boolean},
    {"accessor", "count", Kind::Integer, "", 1, 4294967295.0, kRequired},
    {"accessor", "type", Kind::Choice, "|SCALAR|VEC2|VEC3|VEC4|MAT2|MAT3|MAT4|", 0, 0, kRequired},
    {"accessor", "max", Kind::Numbers, "", 1, 16},
    {"accessor", "min", Kind::Numbers, "", 1, 16},
    {"accessor", "sparse", Kind::Object, "sparse"},
    {"sparse", "count", Kind::Integer, "", 1, 2147483647.0, kRequired},
    {"sparse", "indices", Kind::Object, "sparse.indices", 0, 0, kRequired},
    {"sparse", "values", Kind::Object, "sparse.values", 0, 0, kRequired},
    {"sparse.indices", "bufferView", Kind::Index, "bufferViews", 0, 0, kRequired},
    {"sparse.indices", "byteOffset", Kind::Integer, "", 0, 2147483647.0},
    {"sparse.indices", "componentType", Kind::Choice, "|5121|5123|5125|", 0, 0, kRequired},
    {"sparse.values", "bufferView", Kind::Index, "bufferViews", 0, 0, kRequired},
    {"sparse.values", "byteOffset", Kind::Integer, "", 0, 2147483647.0},

    {"animation", "channels", Kind::Objects, "channel", 0, 0, kRequired},
    {"animation", "samplers", Kind::Objects, "animation.sampler", 0, 0, kRequired},
    {"channel", "sampler", Kind::Integer, "", 0, 2147483647.0, kRequired},
    {"channel", "target", Kind::Object, "channel.target", 0, 0, kRequired},
    {"channel.target", "node", Kind::Index, "nodes"},
    {"channel.target", "path", Kind::String, "", 0, 0, kRequired},
    {"animation.sampler", "input", Kind::Index, "accessors", 0, 0, kRequired},
    {"animation.sampler", "interpolation", Kind::Choice, kInterpolationWords},
    {"animation.sampler", "output", Kind::Index, "accessors", 0, 0, kRequired},

    {"buffer", "uri", Kind::String},
    {"buffer", "byteLength", Kind::Integer, "", 1, kMaxBytes, kRequired},
    {"bufferView", "buffer", Kind::Index, "buffers", 0, 0, kRequired},
    {"bufferView", "byteOffset", Kind::Integer, "", 0, kMaxBytes},
    {"bufferView", "byteLength", Kind::Integer, "", 1, kMaxBytes, kRequired},
    {"bufferView", "byteStride", Kind::Integer, "", 4, 252},
    {"bufferView", "target", Kind::Choice, "|34962|34963|"},

    {"camera", "type", Kind::Choice, "|perspective|orthographic|", 0, 0, kRequired},
    {"camera", "perspective", Kind::Object, "perspective"},
    {"camera", "orthographic", Kind::Object, "orthographic"},
    {"perspective", "aspectRatio", Kind::Positive, "", 0, kInf},
    {"perspective", "yfov", Kind::Positive, "", 0, kInf, kRequired},
    {"perspective", "zfar", Kind::Positive, "", 0, kInf},
    {"perspective", "znear", Kind::Positive, "", 0, kInf, kRequired},
    {"orthographic", "xmag", Kind::Number, "", -kInf, kInf, kRequired},
    {"orthographic", "ymag", Kind::Number, "", -kInf, kInf, kRequired},
    {"orthographic", "zfar", Kind::Positive, "", 0, kInf, kRequired},
    {"orthographic", "znear", Kind::Number, "", 0, kInf, kRequired},

    {"image", "uri", Kind::String},
    {"image", "mimeType", Kind::String},
    {"image", "bufferView", Kind::Index, "bufferViews"},
    {"sampler", "magFilter", Kind::Choice, "|9728|9729|"},
    {"sampler", "minFilter", Kind::Choice, "|9728|9729|9984|9985|9986|9987|"},
    {"sampler", "wrapS", Kind::Choice, "|33071|33648|10497|"},
    {"sampler", "wrapT", Kind::Choice, "|33071|33648|10497|"},
    {"texture", "sampler", Kind::Index, "samplers"},
    {"texture", "source", Kind::Index, "images"},

    {"material", "pbrMetallicRoughness", Kind::Object, "pbrMetallicRoughness"},
    {"material", "normalTexture", Kind::Object, "normalTexture"},
    {"material", "occlusionTexture", Kind::Object, "occlusionTexture"},
    {"material", "emissiveTexture", Kind::Object, "textureInfo"},
    {"material", "emissiveFactor", Kind::Numbers, "", 3, 3},
    {"material", "alphaMode", Kind::Choice, "|OPAQUE|MASK|BLEND|"},
    {"material", "alphaCutoff", Kind::Number, "", 0, kInf},
    {"material", "doubleSided", Kind::Boolean},
    {"pbrMetallicRoughness", "baseColorFactor", Kind::Numbers, "", 4, 4},
    {"pbrMetallicRoughness", "baseColorTexture", Kind::Object, "textureInfo"},
    {"pbrMetallicRoughness", "metallicFactor", Kind::Number, "", 0, 1},
    {"pbrMetallicRoughness", "roughnessFactor", Kind::Number, "", 0, 1},
    {"pbrMetallicRoughness", "metallicRoughnessTexture", Kind::Object, "textureInfo"},
    {"textureInfo", "index", Kind::Index, "textures", 0, 0, kRequired},
    {"textureInfo", "texCoord", Kind::Integer, "", 0, 255},
    {"normalTexture", "index", Kind::Index, "textures", 0, 0, kRequired},
    {"normalTexture", "texCoord", Kind::Integer, "", 0, 255},
    {"normalTexture", "scale", Kind::Number},
    {"occlusionTexture", "index", Kind::Index, "textures", 0, 0, kRequired},
    {"occlusionTexture", "texCoord", Kind::Integer, "", 0, 255},
    {"occlusionTexture", "strength", Kind::Number, "", 0, 1},

    {"mesh", "primitives", Kind::Objects, "primitive", 0, 0, kRequired},
    {"mesh", "weights", Kind::Numbers, "", 1, kInf},
    {"primitive", "attributes", Kind::IndexMap, "accessors", 0, 0, kRequired},
    {"primitive", "indices", Kind::Index, "accessors"},
    {"primitive", "material", Kind::Index, "materials"},
    {"primitive", "mode", Kind::Integer, "", 0, 6},
    {"primitive", "targets", Kind::IndexMaps, "accessors"},

    {"node", "camera", Kind::Index, "cameras"},
    {"node", "children", Kind::Indices, "nodes"},
    {"node", "skin", Kind::Index, "skins"},
    {"node", "matrix", Kind::Numbers, "", 16, 16},
    {"node", "mesh", Kind::Index, "meshes"},
    {"node", "rotation", Kind::Numbers, "", 4, 4},
    {"node", "scale", Kind::Numbers, "", 3, 3},
    {"node", "translation", Kind::Numbers, "", 3, 3},
    {"node", "weights", Kind::Numbers, "", 1, kInf},
    {"scene", "nodes", Kind::Indices, "nodes"},
    {"skin", "inverseBindMatrices", Kind::Index, "accessors"},
    {"skin", "skeleton", Kind::Index, "nodes"},
    {"skin", "joints", Kind::Indices, "nodes", 0, 0, kRequired},

    {"root/KHR_lights_punctual", "lights", Kind::Objects, "light", 0, 0, kRequired},
    {"light", "color", Kind::Numbers, "", 3, 3},
    {"light", "intensity", Kind::Number, "", 0, kInf},
    {"light", "spot", Kind::Object, "spot"},
    {"light", "type", Kind::Choice, "|directional|point|spot|", 0, 0, kRequired},
    {"light", "range", Kind::Positive, "", 0, kInf},
    {"spot", "innerConeAngle", Kind::Number, "", 0, 1.5707964},
    {"spot", "outerConeAngle", Kind::Positive, "", 0, 1.5707964},
    {"node/KHR_lights_punctual", "light", Kind::Index, "extensions/KHR_lights_punctual/lights", 0, 0, kRequired},

    {"textureInfo/KHR_texture_transform", "offset", Kind::Numbers, "", 2, 2},
    {"textureInfo/KHR_texture_transform", "rotation", Kind::Number},
    {"textureInfo/KHR_texture_transform", "scale", Kind::Numbers, "", 2, 2},
    {"textureInfo/KHR_texture_transform", "texCoord", Kind::Integer, "", 0, 255},

    {"material/KHR_materials_emissive_strength", "emissiveStrength", Kind::Number, "", 0, kInf},
    {"material/KHR_materials_unlit", "", Kind::Any},
    {"material/KHR_materials_ior", "ior", Kind::Number, "", 0, kInf},
    {"material/KHR_materials_transmission", "transmissionFactor", Kind::Number, "", 0, 1},
    {"material/KHR_materials_transmission", "transmissionTexture", Kind::Object, "textureInfo"},
    {"material/KHR_materials_volume", "thicknessFactor", Kind::Number, "", 0, kInf},
    {"material/KHR_materials_volume", "thicknessTexture", Kind::Object, "textureInfo"},
    {"material/KHR_materials_volume", "attenuationDistance", Kind::Positive, "", 0, kInf},
    {"material/KHR_materials_volume", "attenuationColor", Kind::Numbers, "", 3, 3},
    {"material/KHR_materials_clearcoat", "clearcoatFactor", Kind::Number, "", 0, 1},
    {"material/KHR_materials_clearcoat", "clearcoatTexture", Kind::Object, "textureInfo"},
    {"material/KHR_materials_clearcoat", "clearcoatRoughnessFactor", Kind::Number, "", 0, 1},
    {"material/KHR_materials_clearcoat", "clearcoatRoughnessTexture", Kind::Object, "textureInfo"},
    {"material/KHR_materials_clearcoat", "clearcoatNormalTexture", Kind::Object, "normalTexture"},
    {"material/KHR_materials_specular", "specularFactor", Kind::Number, "", 0, 1},
    {"material/KHR_materials_specular", "specularTexture", Kind::Object, "textureInfo"},
    {"material/KHR_materials_specular", "specularColorFactor", Kind::Numbers, "", 3, 3},
    {"material/KHR_materials_specular", "specularColorTexture", Kind::Object, "textureInfo"},
    {"material/KHR_materials_sheen", "sheenColorFactor", Kind::Numbers, "", 3, 3},
    {"material/KHR_materials_sheen", "sheenColorTexture", Kind::Object, "textureInfo"},
    {"material/KHR_materials_sheen", "sheenRoughnessFactor", Kind::Number, "", 0, 1},
    {"material/KHR_materials_sheen", "sheenRoughnessTexture", Kind::Object, "textureInfo"},
    {"material/KHR_materials_anisotropy", "anisotropyStrength", Kind::Number, "", 0, 1},
    {"material/KHR_materials_anisotropy", "anisotropyRotation", Kind::Number},
    {"material/KHR_materials_anisotropy", "anisotropyTexture", Kind::Object, "textureInfo"},
    {"material/KHR_materials_pbrSpecularGlossiness", "diffuseFactor", Kind::Numbers, "", 4, 4},
    {"material/KHR_materials_pbrSpecularGlossiness", "diffuseTexture", Kind::Object, "textureInfo"},
    {"material/KHR_materials_pbrSpecularGlossiness", "specularFactor", Kind::Numbers, "", 3, 3},
    {"material/KHR_materials_pbrSpecularGlossiness", "glossinessFactor", Kind::Number, "", 0, 1},
    {"material/KHR_materials_pbrSpecularGlossiness", "specularGlossinessTexture", Kind::Object, "textureInfo"},
    {"root/KHR_materials_variants", "variants", Kind::Objects, "variant", 0, 0, kRequired},
    {"variant", "name", Kind::String, "", 0, 0, kRequired},
    {"primitive/KHR_materials_variants", "mappings", Kind::Objects, "variants.mapping", 0, 0, kRequired},
    {"variants.mapping", "variants", Kind::Indices, "extensions/KHR_materials_variants/variants", 0, 0, kRequired},
    {"variants.mapping", "material", Kind::Index, "materials", 0, 0, kRequired},
    {"node/EXT_mesh_gpu_instancing", "attributes", Kind::IndexMap, "accessors", 0, 0, kRequired},
    {"texture/EXT_texture_webp", "source", Kind::Index, "images", 0, 0, kRequired},
    {"primitive/FB_ngon_encoding", "", Kind::Any},
    {"(only declared)/KHR_mesh_quantization", "", Kind::Any},
};

}  // namespace

std::span<const Rule> gltf_schema() { return kRules; }

}  // namespace occam::import
