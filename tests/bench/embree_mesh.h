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

    RTCScene scene() const noexcept { return scene_; }
    Vec3d anchor() const noexcept { return anchor_; }

private:
    RTCDevice device_ = nullptr;
    RTCScene scene_ = nullptr;
    Vec3d anchor_;
};

/// A set of rays as Embree wants them.
class EmbreeRays {
public:
    /// as_packets   of eight neighbours, with the flag for coherent rays; otherwise one by one
    EmbreeRays(const EmbreeMesh& mesh, std::span<const accel::Ray> rays, bool as_packets);

    void reset();
    void closest();
    void occluded();

    float t(std::size_t i) const noexcept;  ///< after closest(): infinity if nothing was met
    bool is_occluded(std::size_t i) const noexcept;

private:
    const EmbreeMesh& mesh_;
    std::vector<RTCRayHit> single_, single_start_;
    std::vector<RTCRayHit8> packet_, packet_start_;
    std::size_t count_;
};

}  // namespace occam::bench
