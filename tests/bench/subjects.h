// The subjects of the benchmarks: cages made by code, Suzanne of the shared data, and rays towards them.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "accel/frame.h"
#include "accel/tracer.h"
#include "lod/posed_cage.h"
#include "lod/topology_cache.h"
#include "render/camera_rays.h"
#include "scenegraph/scene.h"

namespace occam::bench {

/// Returns a torus of quads about y, with equal steps.
Cage torus(std::uint32_t around, std::uint32_t across);
/// Returns `valence` sectors of 3 x 3 quads about a middle vertex, bumpy; face 0 is at the middle. `crease` is the sharpness
/// of the edges from the middle along the face's side u, 0 for none.
Cage fan(int valence, float crease = 0);
/// Returns the folder of the shared data, which may be absent.
std::filesystem::path shared_folder();
/// Returns a control cage of the shared data, without its materials; none if it is absent.
/// file   below the data folder
std::optional<Cage> shared_cage(const char* file);
std::optional<Cage> suzanne();

/// Holds one cage alone in a scene, as a camera sees it.
class Subject {
public:
    /// camera         none: one that frames the cage closely
    /// shading_rate   target edge length of micropolygons, pixels
    Subject(std::string name, Cage cage, int width, int height, std::optional<Camera> camera = {}, float shading_rate = 1);

    std::string name;
    Scene scene;
    lod::TopologyCache topologies;
    double topology_seconds = 0;
    lod::PosedCage posed;  ///< at the level that a frame chooses
    std::unique_ptr<accel::Frame> frame;

    /// Returns rays in the order of a renderer: tiles of 16 x 16 pixels, 2 x 2 samples per pixel.
    std::vector<accel::Ray> camera_rays() const;

private:
    int width_, height_;
    Camera camera_;
    Arena pose_;  ///< of `posed`
};

/// Returns a torus from outside, the same from inside its tube (every ray hits), and Suzanne (if the data is present).
std::vector<std::unique_ptr<Subject>> usual_subjects(int width, int height);

/// Returns camera rays in the order of a renderer, with the places, moments and points of the lens that the samples of a
/// frame have.
std::vector<accel::Ray> rays_of_a_frame(const render::CameraRays& camera, int width, int height, int samples);

/// Returns a ray from each hit, at the time of the ray that hit, about its normal with density proportional to the cosine.
std::vector<accel::Ray> diffuse_rays(std::span<const accel::Ray> rays, std::span<const accel::SurfaceHit> hits);

inline constexpr std::size_t kBatch = 4096;  ///< rays that a renderer hands over at once
void trace_closest(accel::Tracer& tracer, std::span<const accel::Ray> rays, std::span<accel::SurfaceHit> hits);
void trace_occluded(accel::Tracer& tracer, std::span<const accel::Ray> rays, std::span<std::uint8_t> occluded);

/// Holds tracers of one scene in both trees, to be timed in turns.
struct TreePair {
    TreePair(const Scene& scene, lod::TopologyCache& topologies, const lod::LevelSettings& levels, std::size_t memory_bytes);

    accel::Frame kd_frame, bvh_frame;
    accel::Tracer kd, bvh;
    accel::TreeKind usual;  ///< the tree that a frame of this scene has by default
};

/// Returns all micropolygons of a cage at its level, three corners each, in its dicing frame; gap triangles, which have no
/// area, are left out. A cage that moves has them at each key of its motion, in the same order.
std::vector<Vec3f> micropolygons(const lod::PosedCage& cage, int key = 0);

}  // namespace occam::bench
