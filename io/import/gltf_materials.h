// Conversion of the materials, textures and samplers of a glTF into the material model.
#pragma once

#include <map>
#include <optional>

#include "io/import/gltf_accessor.h"
#include "io/import/gltf_occam.h"

namespace occam::import {

/// Replaces the image of a colour when that image is missing. Other values are then those of their factors alone, except for
/// emission: an emitter whose image is missing does not emit.
inline constexpr Vec4f kMissingColor{0.5f, 0.5f, 0.5f, 1.0f};

class MaterialImporter {
public:
    MaterialImporter(const tinygltf::Model& model, AccessorReader& accessors, Scene& scene, Report& report);

    /// Returns the material by its index in the file, which is none if there is no such material; -1 gives glTF's default.
    MaterialId material(int index);
    /// Throws Error if there is no such texture.
    Displacement displacement(const DisplacementExtras& extras, const std::string& where);

private:
    Material convert(const tinygltf::Material& m, const std::string& where);
    void add_extensions(const tinygltf::ExtensionMap& extensions, Material& material, const std::string& where);
    void set_specular_glossiness(const tinygltf::Value& value, Material& material, const std::string& where);
    TextureUse use(int texture, int uv_set, const tinygltf::ExtensionMap& extensions, TextureRole role,
                   const std::string& where);
    TextureUse use(const tinygltf::Value& info, TextureRole role, const std::string& where);
    void transform(const tinygltf::Value& transform, TextureUse& use) const;
    /// Throws Error if there is no such texture.
    void require_texture(int index, const std::string& where) const;
    TextureId image(int index, TextureRole role, const std::string& where);
    std::optional<Texture> describe(int image,
                                    TextureRole role);  ///< none, and a warning, if it is missing or outside of the folder

    /// Returns the bytes of a view for an image that keeps them. Throws Error if the sum of such bytes is far more than the
    /// buffers hold.
    std::span<const unsigned char> bytes_of_view(int view, const std::string& where);

    const tinygltf::Model& model_;
    AccessorReader& accessors_;
    Scene& scene_;
    Report& report_;
    std::vector<int> first_image_;  ///< of each image, the first that is read from the same place
    std::size_t view_bytes_left_;   ///< what images in buffer views may still take
    std::vector<MaterialId> materials_;
    MaterialId default_material_;  ///< made when a primitive without a material is met
    std::map<std::pair<int, TextureRole>, TextureId> images_;
    std::map<int, std::shared_ptr<const std::vector<std::byte>>> encoded_;
};

}  // namespace occam::import
