#include "io/import/gltf_extensions.h"

#include <algorithm>
#include <array>

namespace occam::import {

namespace {

constexpr auto kExtensions = std::to_array<Extension>({
    {"EXT_mesh_gpu_instancing",
     "one instance for each `TRANSLATION`, `ROTATION` and `SCALE`; at most 1,048,576 in a file; equal ones of a node are "
     "one, and more than 16,384 that a ray would meet on average are refused"},
    {"EXT_texture_webp", "the WebP image is taken instead of the other one, even if its file is missing"},
    {"FB_ngon_encoding", "triangles that were one polygon are one face again where the mesh is subdivided"},
    {"KHR_lights_punctual", "directional, point and spot lights"},
    {"KHR_materials_anisotropy", "a GGX lobe of two widths, turned by factor and texture"},
    {"KHR_materials_clearcoat", "all"},
    {"KHR_materials_emissive_strength", "all"},
    {"KHR_materials_ior", "all"},
    {"KHR_materials_pbrSpecularGlossiness", "used instead of metallic-roughness where a material has both"},
    {"KHR_materials_sheen",
     "the Charlie lobe of Estevez and Kulla 2017 over the rest, which gets what the sheen does not reflect to the eye"},
    {"KHR_materials_specular", "all"},
    {"KHR_materials_transmission", "thin panes, and bodies with `KHR_materials_volume`"},
    {"KHR_materials_unlit", "the base colour is the radiance"},
    {"KHR_materials_variants", "`--variant NAME` chooses one; without it the primitives' own materials"},
    {"KHR_materials_volume", "a thickness above 0 makes the mesh a body; thickness textures are not read"},
    {"KHR_mesh_quantization", "all"},
    {"KHR_texture_transform", "all"},
    {"KHR_xmp_json_ld", "metadata, which is not read and changes no picture"},
});
static_assert(std::ranges::is_sorted(kExtensions, {}, &Extension::name));

}  // namespace

std::span<const Extension> gltf_extensions() { return kExtensions; }

bool is_understood(std::string_view extension)
{
    return std::ranges::binary_search(kExtensions, extension, {}, &Extension::name);
}

std::string gltf_extension_table()
{
    std::string table = "| extension | what is read |\n|---|---|\n";
    for (const Extension& e : kExtensions) table.append("| `").append(e.name).append("` | ").append(e.what).append(" |\n");
    return table;
}

}  // namespace occam::import
