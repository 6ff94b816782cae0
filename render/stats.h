// The cost of a frame: the numbers that --stats writes, under the same names but for `tree`, which is accel there, and the
// micropolygons for camera and shadow rays, which are given for each cell.
//
// The seconds of build, tessellate, deform (which is a part of those two), trace, shade, phase_one (a part of shade) and
// film are summed over the workers; total, load, edit, refit, texture and write are wall time. Keys may be added, but not
// renamed.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "render/settings.h"

namespace occam::render {

struct FrameStats {
    struct Scene {
        std::uint64_t nodes = 0, cages = 0, faces = 0, triangles_in = 0, lights = 0, warnings = 0;
    } scene;
    struct Motion {
        int segments = 0;         ///< of the scene's shutter; 0: nothing moves in it
        int camera_segments = 0;  ///< of the camera's own path
    } motion;
    struct Seconds {
        double total = 0, load = 0, edit = 0, refit = 0, build = 0, tessellate = 0, deform = 0, trace = 0, shade = 0,
               phase_one = 0, texture = 0, film = 0, write = 0;
    } seconds;
    struct Lights {
        bool has_default = false;  ///< daylight and a lamp were added, since the scene has no light of its own that would do
        bool has_emitters = false;  ///< some surface of the scene is emissive
    } lights;
    struct Rays {
        std::uint64_t primary = 0, shadow = 0, ao = 0, glossy = 0, diffuse = 0;
        double per_second = 0;  ///< per second of the frame's wall time
        std::uint64_t total() const noexcept { return primary + shadow + ao + glossy + diffuse; }
    } rays;
    struct Built {
        std::uint64_t kd_nodes = 0, grids = 0, micropolygons = 0, faces_touched = 0, vertices_deformed = 0,
                      vertices_shaded = 0;     ///< vertices whose normals and coordinates were computed
        std::uint64_t vertices_looked_up = 0;  ///< vertices at which materials were looked up (ShadeAt::Vertex)
        std::uint64_t hits_looked_up = 0;      ///< hits at which materials were looked up
        /// The number of cells of the shading rate's size on the visible surfaces, and the number of micropolygons of
        /// surfaces (two for the quad of each cell) that camera rays and shadow or occlusion rays were the first to ask
        /// for. Each worker counts its own.
        double visible_cells = 0;
        std::uint64_t by_camera_rays = 0, by_shadow_rays = 0;
        double quads_per_cell(std::uint64_t count) const noexcept
        {
            return visible_cells > 0 ? 0.5 * double(count) / visible_cells : 0;
        }
        std::map<int, std::uint64_t> by_level;  ///< micropolygons built at each level
    } built;
    struct Memory {
        std::uint64_t peak_bytes = 0, arena_peak_bytes = 0, texture_bytes = 0, flushes = 0;
        std::uint64_t floor_bytes = 0;  ///< the smallest budget with which the frame is begun
        std::uint64_t queue_bytes = 0;  ///< part of the budget for rays on their way; the arenas have the rest
        std::uint64_t film_bytes = 0;   ///< bytes of the picture, beside the budget
    } memory;
    /// Counts the work of each worker. The cost of a shared tree counts for its first worker, whoever has built it.
    struct Worker {
        double cpu_seconds = 0,
               build_seconds = 0;  ///< all work of the worker, and the part of it that is building and dicing
        std::uint64_t tiles = 0, kd_nodes = 0, grids = 0, micropolygons = 0, arena_peak_bytes = 0;
    };
    std::vector<Worker> workers;
    struct Image {
        int width = 0, height = 0, spp = 0;
        std::uint64_t checksum = 0;  ///< of the beauty layer; 0: the picture was cancelled
        std::uint64_t samples = 0;   ///< of an earlier run, too, if it goes on from one; fewer than spp a pixel where
                                     ///< Settings::error ends some early
        int least_samples = 0;       ///< least number of a pixel that is not done; spp if all are done
        std::uint64_t samples_not_finite = 0;  ///< black in the picture, of an earlier run, too
    } image;
    Settings settings;
    int threads = 0;
    accel::TreeKind tree = accel::TreeKind::Kd;  ///< the tree of this frame, which is never Auto
    bool complete = true;  ///< false: cancelled or out of time; Image::least_samples says what there is
    std::vector<std::string> warnings;
};

/// Returns the largest resident size of this process so far.
std::uint64_t process_peak_bytes() noexcept;

std::string to_json(const FrameStats& stats);
/// Returns all settings as the statistics have them.
std::string to_json(const Settings& settings);

}  // namespace occam::render
