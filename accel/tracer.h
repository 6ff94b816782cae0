// Which surface does this ray meet first? One worker's lazy trees, and the two questions they answer.
//
// A Tracer holds an arena with a kd-tree whose root is one lazy node, and builds what its rays touch. Answers are by
// value, so that between two batches everything it built can be dropped: the safe point of the memory budget.
//
// Space    ray origins and hit positions in world axes, double; directions unit. t is world length along the ray.
// Memory   what is built lies in the tracer's arena, at most `budget_bytes`; past it the tracer drops all of it and
//          goes on with the same rays. The floor is what one ray needs: it is always granted.
// Threads  one tracer a worker; Frame is shared and const. The answers do not depend on budget or thread, nor on whether a
//          tree is shared.
#pragma once

#include <array>
#include <limits>
#include <memory>
#include <span>

#include "lod/deformed_cage.h"
#include "lod/footprint.h"
#include "lod/vertex_shader.h"
#include "scenegraph/scene.h"

namespace occam::accel {

class Frame;

using occam::RayKind;

/// Stands for a ray that may start anywhere.
inline constexpr std::int8_t kAnyLevel = std::numeric_limits<std::int8_t>::min();

struct Ray {
    Vec3d origin{0};
    Vec3f direction{0, 0, -1};  ///< unit
    float t_near = 0;
    float t_far = std::numeric_limits<float>::infinity();
    lod::Footprint footprint;           ///< full width of the beam along the ray; none: the camera's at the origin
    std::uint8_t kinds = RayKind::All;  ///< what the ray is for; what none of these may see is not met
    /// The ray sees cages at this level around its origin, and then goes over to what its footprint asks for. A secondary
    /// ray has the level of the mesh that its origin lies on: SurfaceHit::start_level.
    std::int8_t start_level = kAnyLevel;
};

/// What phase two needs of a surface point, by value. Pointers are into the scene.
struct SurfaceHit {
    // Down to uv, floats are written four at a time (accel/hit.cpp).
    float t = std::numeric_limits<float>::infinity();  ///< infinity: nothing was met, and nothing else here is set
    float self_distance = 0;    ///< a secondary ray starts this far along start_normal: more than rounding may do
    float uv_width[2]{};        ///< of the ray's footprint, in units of uv
    Vec3f normal_geometric{0};  ///< unit, of the micropolygon, towards the ray's origin
    /// Mean curvature from the vertices' normals, 1 / world length; positive where the surface bulges towards the ray's
    /// origin.
    float curvature = 0;
    Vec3f normal_shading{0};  ///< unit, interpolated, on the side of normal_geometric
    /// With n the outward normal (-normal_shading on the back side), tangent_sign * cross(n, tangent) is where v falls: a
    /// normal map's +Y (glTF 2.0, sec. 3.9.3).
    float tangent_sign = 1;
    /// Unit, world, across the outward shading normal: where u of the material's normal map grows. Zero without a map or
    /// coordinates.
    Vec3f tangent{0};
    float blend = 0;    ///< how far the surface has gone from `level` to the coarser one of its pair, 0 to 1
    Vec2f uv[2]{};      ///< the first two sets
    Vec3d position{0};  ///< on the micropolygon
    /// From `position` to where secondary rays start: the same place of the mesh of start_level, which is what they see
    /// there. It keeps off the micropolygon's edges by more than rounding may do.
    Vec3f to_start{0};
    Vec3f start_normal{0};  ///< unit, of the micropolygon there, on the side of normal_geometric
    /// Gradients of the coordinates that the material's bump map uses, over the micropolygon, per world length; zero: no
    /// bump.
    Vec3f u_gradient{0}, v_gradient{0};
    Vec4f color{1};              ///< vertex colour
    int phase_one_channels = 0;  ///< VertexShader's values at the hit; 0: none were made, look them up
    float phase_one[lod::VertexShader::kMaxChannels] = {};  ///< so many of them
    const Material* material = nullptr;                     ///< never null at a hit
    NodeId node;
    LightGroups lit_by = kAllGroups;
    std::uint32_t face = 0;               ///< of the cage
    bool back_side = false;               ///< the ray came from behind the face
    int level = 0;                        ///< finer one of the pair of levels that the cage is seen at
    std::int8_t start_level = kAnyLevel;  ///< of that pair's two levels, for Ray::start_level
    std::uint32_t micropolygon = 0;       ///< a number of the quad, mixed: for pictures of the grid

    bool is_hit() const noexcept { return t < std::numeric_limits<float>::infinity(); }
};

/// Where a ray ends, without what shading needs.
struct FirstHit {
    float t = std::numeric_limits<float>::infinity();  ///< infinity: nothing was met
    NodeId node;
    std::uint32_t face = 0;  ///< of the cage

    bool is_hit() const noexcept { return t < std::numeric_limits<float>::infinity(); }
};

struct TraceCounters {
    std::uint64_t rays = 0, packets = 0, kd_nodes = 0, kd_visited = 0, kd_expanded = 0, grids = 0, micropolygons = 0,
                  faces_touched = 0, flushes = 0;
    std::uint64_t vertices_diced = 0, vertices_shaded = 0;
    std::uint64_t vertices_looked_up = 0;  ///< at which VertexShader made values
    std::size_t peak_bytes = 0;
    double build_seconds = 0;  ///< of the tree, without dicing
    double dice_seconds = 0;
    double shade_seconds = 0;    ///< of phase one: normals, coordinates, VertexShader's values
    lod::DeformCounters deform;  ///< its seconds are among those of build and dice
    static constexpr int kFinestLevel = -60, kLevels = 121;
    std::uint64_t diced = 0;                                      ///< micropolygons of surfaces: of triangle meshes none
    std::uint64_t diced_for_camera = 0, diced_for_occlusion = 0;  ///< by which rays they were first asked for
    std::array<std::uint64_t, kLevels> micropolygons_of_level{};  ///< of kFinestLevel and up
    TraceCounters& operator+=(const TraceCounters& other) noexcept;
};

/// What makes building cheap, each switchable for a benchmark (Djeu et al. 2011, fig. 11). What rays meet does not depend on
/// it.
struct BuildTechniques {
    bool lazy =
        true;  ///< nodes are split when a ray enters them; else all, down to clusters of base patches, before the first ray
    bool hierarchy = true;  ///< scene nodes and clusters stand for what is below them; else the root lists every base patch
    bool scan = true;       ///< of many boxes, planes at fixed steps are tried; else one at every box's ends
};

struct LazyTree;

/// A tree for several tracers: built once, in the memory of one, where each worker by itself would build much of it again.
/// Tracers wait for each other while it grows.
class SharedTree {
public:
    /// Borrows the frame.
    SharedTree(const Frame& frame, std::size_t budget_bytes);
    ~SharedTree();
    /// What building has cost; of its tracers', these counters are in none. Any thread.
    TraceCounters counters() const;

private:
    friend class Tracer;
    std::unique_ptr<LazyTree> tree_;
};

class Tracer {
public:
    Tracer(const Frame& frame, std::size_t budget_bytes, BuildTechniques techniques = {});
    /// One of those who use the tree; borrows it.
    explicit Tracer(SharedTree& tree);
    ~Tracer();

    /// Nearest hit of each ray in (t_near, t_far). hits.size() == rays.size(); of a ray that misses, t alone is written.
    void closest(std::span<const Ray> rays, std::span<SurfaceHit> hits);
    /// The same, and no more of it than a sensor or a collision asks for: with t as closest() finds it.
    void first_hits(std::span<const Ray> rays, std::span<FirstHit> hits);
    /// occluded[i] becomes 1 if anything lies in (t_near, t_far) of ray i, else 0.
    void occluded(std::span<const Ray> rays, std::span<std::uint8_t> occluded);

    /// Its own, and those of building unless the tree is shared.
    TraceCounters counters() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace occam::accel
