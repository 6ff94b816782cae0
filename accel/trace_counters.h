// Counts what tracing and building cost.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "lod/deformed_cage.h"

namespace occam::accel {

/// Holds what one ray cost that was traced alone. What it built depends on the rays before it.
struct RayCost {
    std::uint64_t nodes = 0;         ///< interior nodes of the tree that it entered
    std::uint64_t tests = 0;         ///< triangles that it was tested against
    std::uint64_t igrids = 0;        ///< igrids that it was tested against
    std::uint64_t igrids_built = 0;  ///< those among them that did not exist before
    double seconds = 0;              ///< with what was built on the way
};

struct TraceCounters {
    std::uint64_t rays = 0, packets = 0, kd_nodes = 0, kd_visited = 0, kd_expanded = 0, grids = 0, micropolygons = 0,
                  faces_touched = 0, flushes = 0;
    std::uint64_t vertices_diced = 0, vertices_shaded = 0;
    std::uint64_t vertices_looked_up = 0;  ///< vertices at which VertexShader made values
    std::size_t peak_bytes = 0;
    double build_seconds = 0;  ///< time to build the tree, without dicing
    double dice_seconds = 0;
    double shade_seconds = 0;    ///< time of phase one: normals, texture coordinates, VertexShader's values
    lod::DeformCounters deform;  ///< its seconds are included in those of building and dicing
    static constexpr int kFinestLevel = -60, kLevels = 121;
    /// The number of diced micropolygons; the triangles of meshes do not count.
    std::uint64_t diced = 0;
    /// The number of micropolygons that each kind of ray was the first to ask for.
    std::uint64_t diced_for_camera = 0, diced_for_occlusion = 0;
    std::array<std::uint64_t, kLevels> micropolygons_of_level{};  ///< begins with kFinestLevel
    TraceCounters& operator+=(const TraceCounters& other) noexcept;
};

}  // namespace occam::accel
