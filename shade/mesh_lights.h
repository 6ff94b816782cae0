// Emissive surfaces: all triangles with an emissive material, as one light.
//
// A tree of lights draws the triangles that matter to the point (shade/light_tree.h), and those within a leaf of it are
// drawn in proportion to area times the luminance of the material's mean emission. So the density per area is known for a
// ray that happens to hit an emissive surface. Only triangles that stand still and that all scattered rays see are sampled;
// emissive subdivision surfaces, deformed meshes and those that are hidden from some scattered rays are found by these rays
// alone.
//
// Space    world axes, frame lengths (scenegraph/frame_scale.h).
// Memory   a double and two indices per triangle; the vertices stay in the scene. A tree takes about 160 bytes a triangle,
//          and some 11 MB at most: of very many triangles, neighbours share a leaf, and sorting them takes 24 bytes a
//          triangle for a moment. Borrows scene and textures.
// Threads  const after construction.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "io/texture/texture_store.h"
#include "scenegraph/scene.h"
#include "shade/light_tree.h"
#include "shade/lights.h"

namespace occam::shade {

class MeshLights {
public:
    MeshLights() = default;
    /// The textures must be prepared. Throws Error if there are more faces than kMostFaces.
    MeshLights(const Scene& scene, const TextureStore& textures, const FrameScale& scale = {});

    bool is_empty() const noexcept { return meshes_.empty(); }
    /// Returns true if any surface is emissive, whether it is sampled here or not.
    bool any_emitter() const noexcept { return any_emitter_; }

    /// Returns area times mean luminance of everything that is emissive, counting one side, in squared frame lengths.
    /// Subdivision surfaces are measured by their cage, and what deforms or is made on demand by its bounding box, so the
    /// figure is an estimate.
    double power() const noexcept { return power_; }

    /// The most faces of emissive objects, counted in each placement: sums over 33 million triangles take 540 MB.
    static constexpr std::size_t kMostFaces = std::size_t(1) << 25;
    /// Leaves out the light of the backs of single-sided surfaces.
    void hide_backs() noexcept { shows_backs_ = false; }
    /// Makes the tree, before anything is sampled. The points of receivers are relative to the origin, if one is given.
    void make_tree(std::optional<Vec3d> origin);
    /// Returns the tree of emissive triangles, which is empty if none is sampled.
    const LightTree& tree() const noexcept { return tree_; }

    /// Draws a point on the surfaces for a receiver. The distance of the sample ends before the surface by what rounding may
    /// move that.
    LightSample sample(Vec3d point, const Receiver& receiver, LightNumbers numbers) const noexcept;

    /// Describes where a ray hits an emissive surface.
    struct Place {
        NodeId node;
        CageId cage;
        const Material* material;
        std::uint32_t face;
        Vec3d position;
        float rounding;  ///< the position may be this far from the surface (accel::SurfaceHit::self_distance)
    };
    /// Returns the density per area with which sample() draws a point there for the receiver, or 0 if the surface is not
    /// sampled.
    float area_density(const Place& place, const Receiver& receiver) const noexcept;

private:
    struct Mesh {
        NodeId node;
        CageId cage_id;
        const Cage* cage;
        const Material* material;
        Mat4d world_from_object;
        float area_density;  ///< not yet divided by the total
        bool is_mirrored;    ///< the placement reverses the orientation of faces
        float extent;        ///< of the cage, as far as its coordinates and so their rounding go
        std::uint8_t kinds;  ///< of the rays that tell whether its light arrives
    };
    struct TrianglePoints {
        Vec3d a, b, c;
    };

    struct Placed;
    void add(const Placed& placed, CageId cage_id, const CageSlot& slot);
    static double distance_to(const TrianglePoints& triangle, Vec3d point) noexcept;
    static TrianglePoints corners(const Mesh& mesh, std::uint32_t face) noexcept;
    /// A point on a triangle, with the density per area with which it was chosen.
    struct Choice {
        std::uint32_t triangle;
        double area_density;
    };
    Choice choose(const Receiver& receiver, float number) const noexcept;
    const Mesh& mesh_of(std::uint32_t triangle) const noexcept { return meshes_[mesh_indices_[triangle]]; }
    /// Puts the triangles in the order of a curve through their middles.
    void sort_by_place();
    /// Returns area times luminance of all triangles before this one.
    double sum_before(std::size_t triangle) const noexcept { return triangle == 0 ? 0 : sums_[triangle - 1]; }
    // The triangles of a leaf of the tree.
    std::uint32_t first_of(std::size_t leaf) const noexcept { return static_cast<std::uint32_t>(leaf * of_a_leaf_); }
    std::uint32_t end_of(std::size_t leaf) const noexcept
    {
        return static_cast<std::uint32_t>(std::min((leaf + 1) * of_a_leaf_, sums_.size()));
    }
    double sum_of(std::size_t leaf) const noexcept { return sum_before(end_of(leaf)) - sum_before(first_of(leaf)); }

    const TextureStore* textures_ = nullptr;
    bool any_emitter_ = false, shows_backs_ = true;
    double power_ = 0;
    std::vector<Mesh> meshes_;
    // Of each triangle: its mesh, its number there, and the sum up to it.
    std::vector<std::uint32_t> mesh_indices_;
    std::vector<std::uint32_t> faces_;
    std::vector<double> sums_;  ///< running sums of area times luminance
    LightTree tree_;
    std::size_t of_a_leaf_ = 1;  ///< triangles
};

}  // namespace occam::shade
