// What Occam adds to glTF under extras.occam: cages by file, how polygons are subdivided, area lights, the environment,
// which rays see a node and which lights light it, bump maps.
#pragma once

#include <tiny_gltf.h>

#include <compare>
#include <optional>

#include "io/import/report.h"

namespace occam::import {

struct DisplacementExtras {
    int texture = -1;
    float scale = 1, midlevel = 0.5f, bound = 0;
    Displacement::Axes axes = Displacement::Axes::Normal;
    auto operator<=>(const DisplacementExtras&) const = default;
};

/// Of a material.
struct BumpExtras {
    int texture = -1;
    int uv_set = 0;
    float scale = 1;  ///< world length that a texel of 1 is high
};

/// How polygons become a cage; what is not said is left as the file has it.
struct CageStyle {
    enum class Scheme : unsigned char { CatmullClark, Bilinear, None };
    std::optional<Scheme> scheme;
    std::optional<BoundaryRule> boundary;
    std::optional<FaceVaryingRule> face_varying;
    std::optional<DisplacementExtras> displacement;
    auto operator<=>(const CageStyle&) const = default;

    /// All but the displacement, whose texture is the importer's.
    void apply(Cage& cage) const;
};

struct NodeExtras {
    std::string cage;  ///< relative path as written; empty: none
    CageStyle style;
    int material = -1;
    std::optional<AreaLight> area_light;
    std::uint8_t hidden_from = 0;                    ///< bits of RayKind
    std::string light_group;                         ///< of the node's light; empty: it lights everything
    std::optional<std::vector<std::string>> lit_by;  ///< groups; none: by all lights
};
struct EnvironmentExtras {
    std::string image;
    float rotation_deg = 0, strength = 1;
};

/// Of a node, over those of its mesh: what the node says goes first. Unknown keys are warnings, wrong types throw Error.
NodeExtras node_extras(const tinygltf::Value& node, const tinygltf::Value& mesh, const std::string& where, Report& report);
std::optional<BumpExtras> bump_extras(const tinygltf::Value& material, const std::string& where, Report& report);
std::optional<EnvironmentExtras> environment_extras(const tinygltf::Value& scene, const std::string& where, Report& report);

}  // namespace occam::import
