// A polygon mesh as the application owns it: the cage of a subdivision surface, or a triangle mesh.
//
// Space    object axes, in float.
// Memory   The scene owns it. It holds no derived data: what the engine makes of it lives in lod/.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/box.h"
#include "scenegraph/ids.h"
#include "scenegraph/material.h"

namespace occam {

enum class Scheme : std::uint8_t {
    CatmullClark,  ///< limit surface of the cage (Catmull and Clark 1978; creases: DeRose et al. 1998)
    Bilinear,      ///< each quad is a bilinear patch; an n-gon is n of them around its centroid
    Triangles      ///< every face is a triangle, rendered as it is, with the file's vertex normals
};

/// Says what happens at the border of an open Catmull-Clark cage (OpenSubdiv's VtxBoundaryInterpolation).
enum class BoundaryRule : std::uint8_t { EdgeAndCorner, EdgeOnly, None };

/// Where texture coordinates are interpolated linearly (OpenSubdiv's FVarLinearInterpolation).
enum class FaceVaryingRule : std::uint8_t { CornersPlus1, CornersPlus2, CornersOnly, Boundaries, All, None };

/// The sharpness of an edge between two vertices: 0 is smooth, and kInfiniteSharpness or more is never smoothed.
struct Crease {
    std::uint32_t v0, v1;
    float sharpness;
};
struct Corner {
    std::uint32_t vertex;
    float sharpness;
};
inline constexpr float kInfiniteSharpness = 10.0f;

/// Texture coordinates. `indices` has one entry a face corner (as Cage::face_vertices); if it is empty, each vertex has a
/// value.
struct UvSet {
    std::vector<Vec2f> values{};  ///< in glTF's axes: v runs downwards, and (0, 0) is the image's top left
    std::vector<std::uint32_t> indices{};
};

/// The offsets of one morph target; each array is empty or has one entry a vertex.
struct MorphTarget {
    std::string name{};
    std::vector<Vec3f> positions{}, normals{};
};

/// Four joints and four weights a vertex (glTF JOINTS_n and WEIGHTS_n; there are `sets` of them, one after the other).
struct SkinBinding {
    int sets = 0;
    std::vector<glm::u16vec4> joints;  ///< sets * vertices, set-major
    std::vector<Vec4f> weights;        ///< laid out as joints; the weights of a vertex sum to 1
};

/// Moves the points of the limit surface, in object units.
struct Displacement {
    enum class Space : std::uint8_t {
        Normal,  ///< along the surface normal, by scale * (R of the texture - midlevel)
        Object,  ///< by the vector scale * (RGB of the texture - midlevel) in the axes of the object at rest, turned as
                 ///< poses turn the surface
        Tangent  ///< by such a vector in the surface's own axes: where u grows, where v falls, outward (those of normal
                 ///< maps)
    };
    TextureUse texture{};
    float scale = 0, midlevel = 0.5f;
    /// No point moves farther. Bounds of the surface are grown by it on all sides, so rays that are much finer than the
    /// bound look at much that they do not meet: it is best as small as the texture allows.
    float bound = 0;
    Space space = Space::Normal;
};

struct Cage {
    std::string name{};
    Scheme scheme = Scheme::CatmullClark;
    BoundaryRule boundary = BoundaryRule::EdgeAndCorner;
    FaceVaryingRule face_varying = FaceVaryingRule::CornersPlus1;

    std::vector<Vec3f> positions{};
    std::vector<std::uint32_t> face_sizes{};     ///< corners of each face, 3 or more; empty for Scheme::Triangles
    std::vector<std::uint32_t> face_vertices{};  ///< counter-clockwise seen from outside, face after face
    std::vector<Crease> creases{};
    std::vector<Corner> corners{};
    std::vector<std::uint32_t> holes{};  ///< faces that shape their neighbours but are not rendered

    std::vector<Vec3f> normals{};  ///< one unit vector a vertex, for Scheme::Triangles only; empty: faceted
    std::vector<UvSet> uv_sets{};
    std::vector<Vec4f> colors{};                 ///< linear RGBA; empty: white
    std::vector<std::uint32_t> color_indices{};  ///< one entry a face corner; empty: one colour a vertex
    std::vector<MaterialId> materials{};         ///< slots; empty: the default material
    std::vector<std::uint16_t> face_slots{};     ///< index into materials for each face; empty: 0

    std::optional<Displacement> displacement{};

    std::vector<MorphTarget> morph_targets{};
    std::vector<float> morph_weights{};  ///< at rest
    SkinBinding skin{};

    /// Returns whether its points move: it must be a smooth or bilinear surface with the coordinates that the displacement
    /// needs.
    bool is_displaced() const noexcept
    {
        return displacement && scheme != Scheme::Triangles && displacement->bound > 0 && displacement->scale != 0 &&
               displacement->texture.uv_set >= 0 && std::size_t(displacement->texture.uv_set) < uv_sets.size();
    }
    std::size_t face_count() const noexcept
    {
        return scheme == Scheme::Triangles ? face_vertices.size() / 3 : face_sizes.size();
    }
    Box3d bounds() const noexcept
    {
        Box3d b;
        for (Vec3f p : positions) b.add(Vec3d(p));
        return b;
    }
};

/// A cage that is described by its bounds and is made when a ray first enters them.
struct OnDemandCage {
    std::string name{};
    Box3d bounds{};  ///< object axes; not empty; holds every vertex of the cage that `make` returns
    /// Makes the cage. It must be a pure function: any thread calls it, perhaps more than once, and it must return the same
    /// cage each time. That cage has no skin, no morph targets and no displacement, and its materials are those below. If
    /// the function throws, or the cage leaves the bounds, the frame ends with that error. What sanitize() repairs is listed
    /// in FrameStats::warnings, of each frame of a renderer that has the cage made by then, and is an Error with
    /// Settings::strict; a Query and verify() do not say it.
    std::function<Cage()> make{};
    std::vector<MaterialId> materials{};  ///< slots; empty: the default material
};

/// The largest coordinate that may be used: the sum of the areas of up to 280,000 boxes of that size stays below the largest
/// float. Where more boxes are all as large as that, a tree over them is worse, not wrong. What is computed in a frame is in
/// its own unit of length (scenegraph/frame_scale.h).
inline constexpr float kMaxCoordinate = 1e16f;
inline bool is_usable(Vec3f p) noexcept
{
    return std::abs(p.x) <= kMaxCoordinate && std::abs(p.y) <= kMaxCoordinate && std::abs(p.z) <= kMaxCoordinate;
}

/// Repairs an untrusted cage so that all later code may rely on these rules: the sizes of its arrays fit together, indices
/// are in range, numbers are finite, and faces have at least three vertices, none of them twice, and at most kMaxFaceCorners
/// corners. In a cage that is no triangle mesh at most 4096 faces share a vertex. A corner that repeats its neighbour is
/// removed from its face. Faces, creases, corners and holes that break a rule are dropped (a dropped face takes its hole tag
/// with it). Returns one line for each kind of repair, with its count, and nothing if there was nothing to repair. Throws
/// Error if the arrays do not fit together.
std::vector<std::string> sanitize(Cage& cage);
inline constexpr std::uint32_t kMaxFaceCorners = 4096;

}  // namespace occam
