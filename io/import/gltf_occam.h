// Reads what Occam adds to glTF under extras.occam: cages by file, how polygons are subdivided, area lights, the
// environment, which rays see a node and which lights illuminate it, and bump maps.
#pragma once

#include <tiny_gltf.h>

#include <compare>
#include <optional>

#include "io/import/report.h"

namespace occam::import {

struct DisplacementExtras {
    int texture = -1;
    float scale = 1, midlevel = 0.5f, bound = 0;
    Displacement::Space space = Displacement::Space::Normal;
    auto operator<=>(const DisplacementExtras&) const = default;
};

/// Holds the additions of a material.
struct BumpExtras {
    int texture = -1;
    int uv_set = 0;
    float scale = 1;  ///< the world height of a texel of 1
};

/// Says how polygons become a cage; what is not set stays as the file has it.
struct CageStyle {
    enum class Scheme : unsigned char { CatmullClark, Bilinear, None };
    std::optional<Scheme> scheme;
    std::optional<BoundaryRule> boundary;
    std::optional<FaceVaryingRule> face_varying;
    std::optional<DisplacementExtras> displacement;
    auto operator<=>(const CageStyle&) const = default;

    /// Applies everything but the displacement, whose texture the importer handles.
    void apply(Cage& cage) const;
};

inline constexpr std::size_t kMostLightGroups = 32;  ///< one for each bit of LightGroups

struct NodeExtras {
    std::string cage;  ///< relative path as written; empty: none
    CageStyle style;
    int material = -1;
    std::optional<AreaLight> area_light;
    std::uint8_t hidden_from = 0;                    ///< bits of RayKind
    std::string light_group;                         ///< group of the node's light; empty: it lights everything
    std::optional<std::vector<std::string>> lit_by;  ///< groups, each once; none: by all lights
};
struct EnvironmentExtras {
    std::string image;
    float rotation_deg = 0, strength = 1;
};

/// Returns the additions of a node or mesh over those of `below`, which for a node are those of its mesh. Unknown keys are
/// warnings, wrong types throw Error.
NodeExtras node_extras(const tinygltf::Value& value, NodeExtras below, const std::string& where, Report& report);
std::optional<BumpExtras> bump_extras(const tinygltf::Value& material, const std::string& where, Report& report);
std::optional<EnvironmentExtras> environment_extras(const tinygltf::Value& scene, const std::string& where, Report& report);

}  // namespace occam::import
