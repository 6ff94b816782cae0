// What a node and its subtree hold besides boxes, so that a frame finds what it looks for (lights, surfaces that emit or
// transmit, displaced cages, the largest parts) without visiting the rest of the scene.
//
// Contents are brought up to date together with bounds: an edit marks its path to the root, and Scene::refit() sums them up.
//
// Threads  as Scene.
#pragma once

#include <algorithm>
#include <cstdint>

namespace occam {

struct Contents {
    /// What a subtree may hold; the values combine to a mask.
    enum Kind : std::uint8_t {
        Lights = 1,       ///< a placed light
        Emitters = 2,     ///< a surface whose material has an emission that is not zero
        Passing = 4,      ///< a surface that blends or may be clear glass, so that light may pass it straight on
        OverWhite = 8,    ///< a surface whose base colour is not within [0, 1]
        Displaced = 16,   ///< a displaced cage
        Subdivided = 32,  ///< a cage that is diced: a subdivision surface, or a cage that is made on demand
        Masked = 64       ///< a surface with an alpha mask, which may have holes
    };

    std::uint8_t kinds = 0;
    std::uint32_t widest = 0;             ///< most things that opening one node puts side by side
    std::uint32_t largest_face = 0;       ///< corners
    std::uint32_t deformed_vertices = 0;  ///< of the largest cage that a skin or morph targets deform
    std::uint32_t joints = 0;             ///< of the largest skin that a node wears

    void add(const Contents& other) noexcept
    {
        kinds |= other.kinds;
        widest = std::max(widest, other.widest);
        largest_face = std::max(largest_face, other.largest_face);
        deformed_vertices = std::max(deformed_vertices, other.deformed_vertices);
        joints = std::max(joints, other.joints);
    }
    bool has(std::uint8_t any_of) const noexcept { return (kinds & any_of) != 0; }
    friend bool operator==(const Contents&, const Contents&) = default;
};

struct Material;

/// Transmission through a surface without a volume that is smoother than this does not scatter.
inline constexpr float kClearRoughness = 0.05f;
/// Returns true if light may pass straight on through a surface of this material: it masks, blends or is clear glass.
bool may_pass(const Material& material) noexcept;
/// Returns the kinds of Contents that a surface of this material is.
std::uint8_t kinds_of(const Material& material) noexcept;

}  // namespace occam
