// Surfaces that shine: all triangles with an emissive material, as one light.
//
// A point is drawn by area times the luminance of the material's mean emission, so its density per area depends on the
// material alone, and a ray that happens to meet a shining surface can ask for it. Triangles that stand still are
// sampled; emissive subdivision surfaces and deformed meshes are found by scattered rays alone.
//
// Space    world.
// Memory   a float and an index a triangle; vertices stay the scene's. Borrows scene and textures.
// Threads  const after construction.
#pragma once

#include <cstdint>
#include <vector>

#include "io/texture/texture_store.h"
#include "scenegraph/scene.h"
#include "shade/lights.h"

namespace occam::shade {

class MeshLights {
public:
    MeshLights() = default;
    /// Textures must be prepared.
    MeshLights(const Scene& scene, const TextureStore& textures);

    bool is_empty() const noexcept { return meshes_.empty(); }
    /// True if anything shines at all, sampled here or not.
    bool any_emitter() const noexcept { return any_emitter_; }

    /// Area times mean luminance of everything that shines, one side of it, in squared world length. Of subdivision surfaces
    /// the cage is measured, and of what deforms or is made on demand the box around it, so the figure is an estimate.
    double power() const noexcept { return power_; }

    LightSample sample(Vec3d point, LightNumbers numbers) const noexcept;

    /// Density per area of the points of that node's surfaces of that material; 0: they are not sampled.
    float area_density(NodeId node, const Material* material) const noexcept;

private:
    struct Mesh {
        const Cage* cage;
        const Material* material;
        Mat4d world_from_object;
        std::uint32_t first;  ///< in sums_
        float area_density;   ///< not yet divided by the whole
    };
    struct Known {
        NodeId node;
        const Material* material;
        float area_density;
    };
    struct Corners {
        Vec3d a, b, c;
    };

    void add(const Node& node, NodeId id, const CageSlot& slot, const Mat4d& world_from_object, const Scene& scene);
    static Corners corners(const Mesh& mesh, std::uint32_t face) noexcept;

    const TextureStore* textures_ = nullptr;
    bool any_emitter_ = false;
    double power_ = 0;
    std::vector<Mesh> meshes_;
    std::vector<std::uint32_t> faces_;
    std::vector<double> sums_;  ///< running sums of area times luminance
    std::vector<Known> known_;  ///< sorted
};

}  // namespace occam::shade
