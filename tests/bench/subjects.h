// What the benchmarks look at: cages made by code, Suzanne of the shared data, and rays towards them.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "accel/frame.h"
#include "accel/tracer.h"
#include "lod/posed_cage.h"
#include "lod/topology_cache.h"
#include "scenegraph/scene.h"

namespace occam::bench {

/// A torus about y of quads, as every step the same.
Cage torus(std::uint32_t around, std::uint32_t across);
/// `valence` sectors of 3 x 3 quads about a middle vertex, bumpy; face 0 is at the middle. `crease`: sharpness of the edges
/// from the middle along the face's side u, 0 for none.
Cage fan(int valence, float crease = 0);
/// Of the shared data; it may be absent.
std::filesystem::path shared_folder();
/// A control cage of the shared data, without its materials; none if it is absent.
/// file   below the data folder
std::optional<Cage> shared_cage(const char* file);
std::optional<Cage> suzanne();

/// One cage alone in a scene, as a camera sees it.
class Subject {
public:
    /// camera         none: one that frames the cage closely
    /// shading_rate   wanted micropolygon edge, pixels
    Subject(std::string name, Cage cage, int width, int height, std::optional<Camera> camera = {}, float shading_rate = 1);

    std::string name;
    Scene scene;
    lod::TopologyCache topologies;
    double topology_seconds = 0;
    lod::PosedCage posed;  ///< at the level that a frame chooses
    std::unique_ptr<accel::Frame> frame;

    /// Rays in the order of a renderer: tiles of 16 x 16 pixels, 2 x 2 samples a pixel.
    std::vector<accel::Ray> camera_rays() const;

private:
    int width_, height_;
    Camera camera_;
};

/// A torus from outside, the same from inside its tube (every ray hits), and Suzanne (if it is there).
std::vector<std::unique_ptr<Subject>> usual_subjects(int width, int height);

/// A ray from each hit, about its normal with density proportional to the cosine.
std::vector<accel::Ray> diffuse_rays(std::span<const accel::Ray> rays, std::span<const accel::SurfaceHit> hits);

inline constexpr std::size_t kBatch = 4096;  ///< rays that a renderer hands over at once
void trace_closest(accel::Tracer& tracer, std::span<const accel::Ray> rays, std::span<accel::SurfaceHit> hits);
void trace_occluded(accel::Tracer& tracer, std::span<const accel::Ray> rays, std::span<std::uint8_t> occluded);

/// All micropolygons of a cage at its level, three corners each, in its dicing frame; closers (which have no area) left out.
std::vector<Vec3f> micropolygons(const lod::PosedCage& cage);

}  // namespace occam::bench
