// The start of phase two of shading: the parameters of a material at one point, seen from one side. They are all that the
// BSDF reads.
//
// glTF 2.0 metallic-roughness with KHR_materials_ior, _specular, _clearcoat, _sheen, _anisotropy, _transmission, _volume,
// _emissive_strength and _unlit. There are two departures: both sides of every face are visible (as in path tracers;
// double_sided decides nothing), and occlusion maps do not dim light whose path is traced (ambient_share).
#pragma once

#include <array>
#include <cstdint>

#include "io/texture/texture_store.h"
#include "shade/microfacet.h"
#include "shade/shade_point.h"

namespace occam::shade {

/// Colours are linear Rec.709; vectors are unit vectors in world axes.
struct Surface {
    Vec3d position{0};
    Vec3d start_point{0};         ///< on the mesh that secondary rays see
    Vec3f start_normal{0, 0, 1};  ///< normal of that mesh, on the side of normal_geometric
    float self_distance = 0;
    Vec3f to_eye{0, 0, 1};
    Vec3f normal_geometric{0, 0, 1};  ///< on the side of to_eye
    Vec3f normal{0, 0, 1};            ///< shading normal, with the normal map applied
    Vec3f coat_normal{0, 0, 1};       ///< the coat lies smoothly over the normal map, or has one of its own

    Vec3f base_color{0};  ///< factor, texture and vertex colour
    float opacity = 1;    ///< share that is there at all; below 1 where the material blends, 0 or 1 where it masks
    /// Transmittance straight on: through the share that is not there, through smooth thin glass, and through the boundary
    /// of a body that does not bend light.
    Vec3f transmittance{0};
    Vec3f emission{0};   ///< towards the eye, without the share of the coat
    bool unlit = false;  ///< base_color is the radiance; nothing else counts

    Vec3f diffuse{0};  ///< base_color times what is neither metal nor glass
    Vec3f f0{0.04f};   ///< reflectance at normal incidence, dielectric and metal mixed
    float f90 = 1;     ///< reflectance at grazing incidence
    /// Reflectance of the dielectric alone; light that it reflects does not reach the base below it.
    float dielectric_f0 = 0.04f, dielectric_f90 = 1;
    /// The layer is a dielectric in one share and metal in another, or there is a layer on a share only. If so, these are
    /// the shares in f0 and f90, and the dielectric's colour at normal incidence. The metal's is base_color.
    bool is_mixed = false;
    float dielectric_share = 1, metal_share = 0;
    Vec3f dielectric_color{0.04f};
    float alpha = 0.36f;  ///< GGX width, roughness squared
    Vec3f tangent{0};     ///< across the normal: the direction of brush strokes; zero: the lobe of the layer is isotropic
    /// GGX widths of an anisotropic layer, along the strokes and across them; alpha is their geometric mean.
    float alpha_along = 0, alpha_across = 0;
    Vec3f sheen{0};         ///< colour of the sheen (shade/sheen.h); zero: there is none
    float sheen_alpha = 1;  ///< width of the distribution of the sheen
    float coat = 0;         ///< share of the clear coat
    float coat_alpha = kMinAlpha;

    bool is_matte = false;  ///< only `diffuse` scatters light, so what follows from the other lobes need not be computed

    Vec3f transmission{0};     ///< tint of what a rough thin pane or a solid body transmits; zero: nothing
    bool is_solid = false;     ///< The surface bounds a body (KHR_materials_volume) and refracts light.
    bool is_straight = false;  ///< It bounds a body that does not bend light: what passes straight on enters or leaves it.
    float solid_share = 1;     ///< Solid: the share of the surface that is glass. f0 and diffuse describe the rest.
    float eta = 1;             ///< solid: refractive index behind the surface over that on the eye's side
    /// The surface bounds a body of either kind. All light that crosses it enters or leaves the body, also where the surface
    /// is metal, opaque or not there because it blends.
    bool bounds_body = false;
    /// Coefficient per world length inside of the body that the surface bounds (Beer-Lambert).
    Vec3f absorption_inside{0};

    /// Returns the coefficient that holds on the far side of the surface, seen from the back or from the front.
    /// here   that on the eye's side, which is also that behind a surface that bounds no body
    Vec3f absorption_behind(bool back_side, Vec3f here) const noexcept
    {
        return !bounds_body ? here : back_side ? Vec3f(0) : absorption_inside;
    }
    /// Returns true if light passes straight on and none is scattered.
    bool only_passes() const noexcept { return is_straight && is_matte && diffuse == Vec3f(0); }

    /// Returns where a ray in that direction starts: off the mesh that it sees by more than rounding, to the side that it
    /// leaves by.
    Vec3d start(Vec3f direction) const noexcept
    {
        return start_on(glm::dot(normal_geometric, direction) < 0 ? -1.0f : 1.0f);
    }
    /// Returns where a ray to the side of the eye starts. Light is sampled as seen from there, since a place on the surface
    /// and this point may see a light that is near, or a wall before it, in different directions.
    Vec3d front_start() const noexcept { return start_on(1); }

private:
    Vec3d start_on(float side) const noexcept { return start_point + Vec3d(start_normal) * double(side * self_distance); }
};

/// Evaluates the material at a point. `point.material` is never null; textures must be prepared.
Surface evaluate(const ShadePoint& point, const TextureStore& textures) noexcept;

/// Keeps what evaluate() gives for materials that are the same everywhere and have no lobes that depend on the eye, so that
/// only normals are left to do at a hit.
///
/// Memory   a few surfaces; it borrows the materials, which must not change while it lives.
/// Threads  each worker has its own.
class PlainSurfaces {
public:
    /// Returns the surface of a material without vertex colour and without what depends on the place, or null if it has to
    /// be evaluated at each hit.
    const Surface* find(const Material& material, const TextureStore& textures) noexcept
    {
        Entry& entry = entries_[reinterpret_cast<std::uintptr_t>(&material) / sizeof(Material) % kEntries];
        if (entry.material != &material) fill(entry, material, textures);
        return entry.is_plain ? &entry.surface : nullptr;
    }

private:
    static constexpr std::size_t kEntries = 64;
    struct Entry {
        const Material* material = nullptr;
        bool is_plain = false;
        Surface surface;
    };
    static void fill(Entry& entry, const Material& material, const TextureStore& textures) noexcept;

    std::array<Entry, kEntries> entries_;
};

/// Does the same as the other evaluate(), with the same bits.
Surface evaluate(const ShadePoint& point, const TextureStore& textures, PlainSurfaces& known) noexcept;

/// Returns true if rays pass the back of a surface of the material where those of single-sided ones are left out. Glass is
/// excepted, because rays have to leave bodies again.
inline bool is_single_sided(const Material& material) noexcept
{
    return !material.double_sided && !(material.transmission > 0);
}

/// Returns whether the material's alpha mask has a hole there: then evaluate().opacity is 0.
/// color   vertex colour
bool is_hole(const Material& material, const lod::VertexToShade& at, Vec4f color, const TextureStore& textures) noexcept;

/// Describes what happens to light that comes to a surface and passes it straight on.
struct StraightPass {
    Vec3f transmittance{0};      ///< as that of evaluate()
    bool bounds_body = false;    ///< it enters or leaves a body, whether that bends light or not
    Vec3f absorption_inside{0};  ///< of that body
};
/// Returns what evaluate() gives for light that passes straight on, without computing the rest for surfaces that let none
/// pass.
StraightPass passes_straight(const ShadePoint& point, const TextureStore& textures) noexcept;

/// Returns the share of ambient light, 0 to 1, that the occlusion map of the material leaves. It applies to light that is
/// not traced to its origin. Nothing else reads the map, because traced rays find the same occlusion.
float ambient_share(const ShadePoint& point, const TextureStore& textures) noexcept;

}  // namespace occam::shade
