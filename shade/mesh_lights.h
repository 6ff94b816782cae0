// Emissive surfaces: all triangles with an emissive material, as one light.
//
// A point is drawn in proportion to area times the luminance of the material's mean emission. So its density per area
// depends on the material alone, and a ray that happens to hit an emissive surface can ask for it. Only triangles that
// stand still are sampled; emissive subdivision surfaces and deformed meshes are found by scattered rays alone.
//
// Space    world axes, frame lengths (scenegraph/frame_scale.h).
// Memory   a double and an index per triangle; the vertices stay in the scene. Borrows scene and textures.
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
    /// The textures must be prepared.
    MeshLights(const Scene& scene, const TextureStore& textures, const FrameScale& scale = {});

    bool is_empty() const noexcept { return meshes_.empty(); }
    /// Returns true if any surface is emissive, whether it is sampled here or not.
    bool any_emitter() const noexcept { return any_emitter_; }

    /// Returns area times mean luminance of everything that is emissive, counting one side, in squared world length.
    /// Subdivision surfaces are measured by their cage, and what deforms or is made on demand by its bounding box, so the
    /// figure is an estimate.
    double power() const noexcept { return power_; }

    LightSample sample(Vec3d point, LightNumbers numbers) const noexcept;

    /// Returns the density per area of the points on the node's surfaces of that material, or 0 if they are not sampled.
    float area_density(NodeId node, const Material* material) const noexcept;

private:
    struct Mesh {
        const Cage* cage;
        const Material* material;
        Mat4d world_from_object;
        std::uint32_t first;  ///< index into sums_
        float area_density;   ///< not yet divided by the total
    };
    struct Known {
        NodeId node;
        const Material* material;
        float area_density;
    };
    struct TrianglePoints {
        Vec3d a, b, c;
    };

    /// moves   the surface moves while the shutter is open: points on it are not sampled
    void add(const Node& node, NodeId id, const CageSlot& slot, const Mat4d& world_from_object, const Scene& scene,
             bool moves);
    static TrianglePoints corners(const Mesh& mesh, std::uint32_t face) noexcept;

    const TextureStore* textures_ = nullptr;
    bool any_emitter_ = false;
    double power_ = 0;
    std::vector<Mesh> meshes_;
    std::vector<std::uint32_t> faces_;
    std::vector<double> sums_;  ///< running sums of area times luminance
    std::vector<Known> known_;  ///< sorted
};

}  // namespace occam::shade
