// Answers which surface a ray hits first, and whether a ray is occluded.
//
// A Tracer holds an arena with a kd-tree whose root is one lazy node, and builds what its rays touch. It answers by
// value, so that between two batches everything that it has built can be dropped: this is the safe point of the memory
// budget.
//
// Space    Ray origins and hit positions are in world axes and frame lengths (scenegraph/frame_scale.h), in double;
//          directions are unit vectors. t is the length along the ray.
// Memory   What is built lies in the tracer's arena and takes at most `memory_bytes`. When that is exceeded, the tracer
//          drops all of it and goes on with the same rays. The minimum is what one ray needs, which is always granted.
// Threads  Each worker has one tracer; Frame is shared and const. The answers depend neither on the budget, nor on the
//          thread, nor on whether the tree is shared.
#pragma once

#include <array>
#include <iosfwd>
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

/// The start level of a ray that may start anywhere.
inline constexpr std::int8_t kAnyLevel = std::numeric_limits<std::int8_t>::min();

struct Ray {
    Vec3d origin{0};
    Vec3f direction{0, 0, -1};  ///< unit length
    float t_near = 0;
    float t_far = std::numeric_limits<float>::infinity();
    /// The full width of the beam along the ray. If it is not set, the camera's footprint at the origin is used.
    lod::Footprint footprint;
    /// The purposes of the ray; surfaces that none of these kinds may see are not hit.
    std::uint8_t kinds = RayKind::All;
    /// The ray sees cages at this level around its origin, and then goes over to the level that its footprint asks for.
    /// A secondary ray has the level of the mesh on which its origin lies: SurfaceHit::start_level.
    std::int8_t start_level = kAnyLevel;
    /// The moment at which the ray sees the scene: 0 when the shutter opens, 1 when it closes.
    float time = 0;
};

/// Holds what phase two needs of a surface point, by value. Pointers point into the scene.
struct SurfaceHit {
    float t = std::numeric_limits<float>::infinity();  ///< infinity if nothing was hit; then nothing else here is set
    /// The offset of a secondary ray's origin along start_normal, larger than rounding errors.
    float self_distance = 0;
    float uv_width[2]{};        ///< the width of the ray's footprint, in units of uv
    Vec3f normal_geometric{0};  ///< unit normal of the micropolygon, towards the ray's origin
    /// The mean curvature from the vertices' normals, in 1 / frame length. It is positive where the surface bulges
    /// towards the ray's origin.
    float curvature = 0;
    Vec3f normal_shading{0};  ///< unit length, interpolated, on the side of normal_geometric
    /// With the outward normal n (-normal_shading on the back side), tangent_sign * cross(n, tangent) is the direction
    /// in which v decreases: a normal map's +Y (glTF 2.0, sec. 3.9.3).
    float tangent_sign = 1;
    /// A unit vector in world space, perpendicular to the outward shading normal, along which u of the material's
    /// normal map grows. It is zero without a map or texture coordinates.
    Vec3f tangent{0};
    float blend = 0;    ///< the share of the coarser level of the pair, 0 at `level` to 1
    Vec2f uv[2]{};      ///< the first two sets of texture coordinates
    Vec3d position{0};  ///< on the micropolygon
    /// The offset from `position` to where secondary rays start: the same place of the mesh of start_level, which is
    /// the mesh that they see there. It keeps off the micropolygon's edges by more than rounding errors.
    Vec3f to_start{0};
    Vec3f start_normal{0};  ///< unit normal of the micropolygon there, on the side of normal_geometric
    /// The gradients of the texture coordinates that the material's bump map uses, over the micropolygon, per world
    /// length. They are zero without a bump map.
    Vec3f u_gradient{0}, v_gradient{0};
    Vec4f color{1};  ///< vertex colour
    /// The number of VertexShader's values at the hit; if it is 0, none were made, and textures must be looked up.
    int phase_one_channels = 0;
    float phase_one[lod::VertexShader::kMaxChannels] = {};  ///< the first phase_one_channels are valid
    const Material* material = nullptr;                     ///< never null at a hit
    NodeId node;
    LightGroups lit_by = kAllGroups;
    std::uint32_t face = 0;               ///< face index in the cage
    bool back_side = false;               ///< the ray came from behind the face
    int level = 0;                        ///< the finer level of the pair at which the ray sees the cage, world lengths
    std::int8_t start_level = kAnyLevel;  ///< one of that pair's two levels, for Ray::start_level
    std::uint32_t micropolygon = 0;       ///< a hashed number of the quad, for pictures of the grid
    /// The velocity of the place on the micropolygon, at the ray's time, per shutter.
    Vec3f velocity{0};

    bool is_hit() const noexcept { return t < std::numeric_limits<float>::infinity(); }
};

/// The largest number of hits of one ray that Tracer::nearest() finds at once.
inline constexpr int kMostNearest = 64;

/// Returns the t_near of the rest of a ray behind a hit. The interval of a ray is open at its near end, so rounding of t
/// cannot find the hit again.
inline float behind(float t) noexcept { return t * (1 + 4 * std::numeric_limits<float>::epsilon()); }

struct HitCount {
    std::int16_t count = 0;
    bool is_all = true;  ///< false: there may be more hits behind these
};

/// Holds where a ray ends, without what shading needs.
struct FirstHit {
    float t = std::numeric_limits<float>::infinity();  ///< infinity if nothing was hit
    NodeId node;
    std::uint32_t face = 0;  ///< face index in the cage

    bool is_hit() const noexcept { return t < std::numeric_limits<float>::infinity(); }
};

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

/// Switches what makes building cheap, each part by itself, for benchmarks (Djeu et al. 2011, fig. 11). The hits of
/// rays do not depend on it.
struct BuildTechniques {
    bool lazy =
        /// Nodes are split when a ray enters them; otherwise all are split before the first ray, down to clusters of
        /// base patches.
        true;
    /// Scene nodes and clusters represent everything below them; otherwise the root lists every base patch.
    bool hierarchy = true;
    /// For many boxes, planes at fixed steps are tried; otherwise one plane at each end of every box.
    bool scan = true;
};

struct LazyTree;

/// A tree for several tracers. It is built once, in the memory of one tree, where each worker by itself would build
/// much of it again. Tracers wait for each other while it grows.
class SharedTree {
public:
    /// Borrows the frame.
    SharedTree(const Frame& frame, std::size_t memory_bytes);
    ~SharedTree();
    /// Returns what building has cost. The counters of its tracers do not include these. Any thread may call it.
    TraceCounters counters() const;

private:
    friend class Tracer;
    std::unique_ptr<LazyTree> tree_;
};

class Tracer {
public:
    Tracer(const Frame& frame, std::size_t memory_bytes, BuildTechniques techniques = {});
    /// Creates one of the tracers that use the tree, which is borrowed.
    explicit Tracer(SharedTree& tree);
    ~Tracer();

    /// Finds the nearest hit of each ray in (t_near, t_far). Requires hits.size() == rays.size(). For a ray that
    /// misses, only t is written.
    void closest(std::span<const Ray> rays, std::span<SurfaceHit> hits);
    /// Finds up to `most` hits of each ray at once, the nearest first: those that repeated calls of closest() would find,
    /// each from where the one before ended (behind()). Those of ray i are written from hits[i * most] on. Requires 1 <=
    /// most <= kMostNearest, hits.size() == rays.size() * most and counts.size() == rays.size().
    void nearest(std::span<const Ray> rays, int most, std::span<SurfaceHit> hits, std::span<HitCount> counts);
    /// Finds the same hits as closest(), but only what a sensor or a collision test asks for, with the same t as closest().
    void first_hits(std::span<const Ray> rays, std::span<FirstHit> hits);
    /// Sets occluded[i] to 1 if anything lies in (t_near, t_far) of ray i, else to 0.
    void occluded(std::span<const Ray> rays, std::span<std::uint8_t> occluded);
    /// Finds the hit that closest() finds, with the same bits, and returns what it cost. If a stream is given, everything
    /// that the ray does is written there (accel/narration.h).
    RayCost observe(const Ray& ray, SurfaceHit& hit, std::ostream* out = nullptr);

    /// Returns its own counters, including those of building unless the tree is shared.
    TraceCounters counters() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace occam::accel
