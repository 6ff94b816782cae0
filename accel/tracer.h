// Answers which surface a ray hits first, and whether a ray is occluded.
//
// A Tracer holds an arena with a tree whose root is one lazy node, and builds what its rays touch. It answers by
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

#include <iosfwd>
#include <memory>
#include <span>

#include "accel/build_techniques.h"
#include "accel/ray.h"
#include "accel/surface_hit.h"
#include "accel/trace_counters.h"

namespace occam::accel {

class Frame;
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
