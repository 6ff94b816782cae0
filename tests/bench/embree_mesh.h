// Runs Embree 3 on the same triangles, to compare its times and answers with ours.
//
// Rays are prepared outside the timed part: call reset() first, then time closest() or occluded(), then read the answers.
#pragma once

#include <embree3/rtcore.h>

#include <memory>
#include <span>
#include <vector>

#include "accel/tracer.h"

namespace occam::bench {

/// Holds a scene of Embree's own device, with the settings that all comparisons use: robust, and built for high quality by
/// one thread.
class EmbreeScene {
public:
    EmbreeScene();
    ~EmbreeScene();
    EmbreeScene(const EmbreeScene&) = delete;
    EmbreeScene& operator=(const EmbreeScene&) = delete;

    std::size_t bytes = 0;     ///< of all that Embree has allocated
    double build_seconds = 0;  ///< CPU, one thread

    RTCScene scene() const noexcept { return scene_; }

protected:
    RTCDevice device() const noexcept { return device_; }
    /// Takes the one geometry of the scene, which is released, and builds the tree.
    void build(RTCGeometry geometry);

private:
    RTCDevice device_ = nullptr;
    RTCScene scene_ = nullptr;
};

class EmbreeMesh : public EmbreeScene {
public:
    /// corners  three for each triangle, in a frame translated by `anchor`
    EmbreeMesh(std::span<const Vec3f> corners, Vec3d anchor);

    /// Holds what a renderer keeps of a vertex for shading: here the normal is the triangle's own.
    struct Corner {
        Vec3f position, normal;
    };
    std::vector<Corner> corners;  ///< three a triangle

    Vec3d anchor() const noexcept { return anchor_; }

private:
    Vec3d anchor_;
};

/// Holds what is needed for shading, made from a hit of Embree's: the part of accel::SurfaceHit that these scenes need.
struct ShadedHit {
    float t = 0;
    Vec3d position;
    Vec3f normal_geometric, normal_shading;
    float curvature = 0;
    unsigned primitive = 0;
    bool back_side = false;
};

/// Holds a set of rays in Embree's form.
class EmbreeRays {
public:
    /// as_packets   traces packets of eight neighbours (see is_coherent); otherwise single rays
    EmbreeRays(const EmbreeMesh& mesh, std::span<const accel::Ray> rays, bool as_packets);

    bool is_coherent = true;  ///< what packets tell Embree of their rays

    void reset();
    void closest();
    void occluded();
    /// Calls closest(), and fills each batch of as many rays as fit before the next is traced; the hits of the last batch
    /// remain.
    void closest_filled(std::span<ShadedHit> batch);

    float t(std::size_t i) const noexcept;  ///< valid after closest(); infinity if nothing was hit
    bool is_occluded(std::size_t i) const noexcept;

private:
    void fill(unsigned primitive, float u, float v, float distance, Vec3f direction, ShadedHit& hit) const noexcept;

    const EmbreeMesh& mesh_;
    std::vector<RTCRayHit> single_, single_start_;
    std::vector<RTCRayHit8> packet_, packet_start_;
    std::size_t count_;
};

}  // namespace occam::bench
