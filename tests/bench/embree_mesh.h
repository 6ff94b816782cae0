// The same triangles in Embree 3, to compare times and answers with.
//
// Rays are made ready outside the timed part: reset() before, closest() or occluded() timed, answers after.
#pragma once

#include <embree3/rtcore.h>

#include <memory>
#include <span>
#include <vector>

#include "accel/tracer.h"

namespace occam::bench {

class EmbreeMesh {
public:
    /// corners  three a triangle, in a frame translated by `anchor`
    EmbreeMesh(std::span<const Vec3f> corners, Vec3d anchor);
    ~EmbreeMesh();
    EmbreeMesh(const EmbreeMesh&) = delete;
    EmbreeMesh& operator=(const EmbreeMesh&) = delete;

    std::size_t bytes = 0;     ///< of all that Embree has allocated
    double build_seconds = 0;  ///< CPU, one thread

    /// What a renderer keeps of a vertex to shade with: here the normal is the triangle's own.
    struct Corner {
        Vec3f position, normal;
    };
    std::vector<Corner> corners;  ///< three a triangle

    RTCScene scene() const noexcept { return scene_; }
    Vec3d anchor() const noexcept { return anchor_; }

private:
    RTCDevice device_ = nullptr;
    RTCScene scene_ = nullptr;
    Vec3d anchor_;
};

/// What is shaded with, made from a hit of Embree's; of what accel::SurfaceHit holds the part that these scenes need.
struct ShadedHit {
    float t = 0;
    Vec3d position;
    Vec3f normal_geometric, normal_shading;
    float curvature = 0;
    unsigned primitive = 0;
    bool back_side = false;
};

/// A set of rays as Embree wants them.
class EmbreeRays {
public:
    /// as_packets   of eight neighbours, with the flag for coherent rays; otherwise one by one
    EmbreeRays(const EmbreeMesh& mesh, std::span<const accel::Ray> rays, bool as_packets);

    void reset();
    void closest();
    void occluded();
    /// closest(), and each batch of as many rays as there is room is filled before the next is traced; hits of the last
    /// batch are left.
    void closest_filled(std::span<ShadedHit> batch);

    float t(std::size_t i) const noexcept;  ///< after closest(): infinity if nothing was met
    bool is_occluded(std::size_t i) const noexcept;

private:
    void fill(unsigned primitive, float u, float v, float distance, Vec3f direction, ShadedHit& hit) const noexcept;

    const EmbreeMesh& mesh_;
    std::vector<RTCRayHit> single_, single_start_;
    std::vector<RTCRayHit8> packet_, packet_start_;
    std::size_t count_;
};

}  // namespace occam::bench
