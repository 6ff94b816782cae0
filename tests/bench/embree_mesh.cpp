#include "tests/bench/embree_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "tests/bench/harness.h"

namespace occam::bench {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr int kAll[8] = {-1, -1, -1, -1, -1, -1, -1, -1};

}  // namespace

EmbreeScene::EmbreeScene() : device_(rtcNewDevice("threads=1"))
{
    if (!device_) throw std::runtime_error("no Embree device");
    rtcSetDeviceMemoryMonitorFunction(
        device_,
        [](void* self, ssize_t change, bool) {
            static_cast<EmbreeScene*>(self)->bytes += static_cast<std::size_t>(change);
            return true;
        },
        this);
    scene_ = rtcNewScene(device_);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
}

EmbreeScene::~EmbreeScene()
{
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
}

void EmbreeScene::build(RTCGeometry geometry)
{
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    const double start = process_seconds();
    rtcCommitScene(scene_);
    build_seconds = process_seconds() - start;
}

EmbreeMesh::EmbreeMesh(std::span<const Vec3f> positions, Vec3d anchor) : anchor_(anchor)
{
    RTCGeometry mesh = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_TRIANGLE);
    void* vertices = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3f),
                                             positions.size());
    std::memcpy(vertices, positions.data(), positions.size_bytes());
    auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                                   3 * sizeof(unsigned), positions.size() / 3));
    for (unsigned i = 0; i < positions.size(); ++i) indices[i] = i;
    corners.reserve(positions.size());
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const Vec3f* of = &positions[i / 3 * 3];
        corners.push_back({positions[i], glm::normalize(glm::cross(of[1] - of[0], of[2] - of[0]))});
    }
    build(mesh);
}

EmbreeRays::EmbreeRays(const EmbreeMesh& mesh, std::span<const accel::Ray> rays, bool as_packets)
    : mesh_(mesh), count_(rays.size())
{
    if (as_packets) packet_start_.resize((count_ + 7) / 8);
    else single_start_.resize(count_);
    for (std::size_t i = 0; i < (as_packets ? packet_start_.size() * 8 : count_); ++i) {
        const accel::Ray& ray = rays[std::min(i, count_ - 1)];
        const Vec3f origin(ray.origin - mesh.anchor()), d = ray.direction;
        if (as_packets) {
            RTCRayHit8& p = packet_start_[i / 8];
            const std::size_t l = i % 8;
            p.ray.org_x[l] = origin.x, p.ray.org_y[l] = origin.y, p.ray.org_z[l] = origin.z;
            p.ray.dir_x[l] = d.x, p.ray.dir_y[l] = d.y, p.ray.dir_z[l] = d.z;
            p.ray.tnear[l] = ray.t_near, p.ray.tfar[l] = ray.t_far;
            p.ray.time[l] = 0, p.ray.mask[l] = ~0u, p.ray.id[l] = 0, p.ray.flags[l] = 0;
            p.hit.geomID[l] = p.hit.primID[l] = p.hit.instID[0][l] = RTC_INVALID_GEOMETRY_ID;
        } else {
            RTCRayHit& r = single_start_[i];
            r.ray = {origin.x, origin.y, origin.z, ray.t_near, d.x, d.y, d.z, 0, ray.t_far, ~0u, 0, 0};
            r.hit.geomID = r.hit.primID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        }
    }
}

void EmbreeRays::reset()
{
    packet_ = packet_start_;
    single_ = single_start_;
}

void EmbreeRays::closest()
{
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    if (!packet_.empty() && is_coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    for (RTCRayHit8& p : packet_) rtcIntersect8(kAll, mesh_.scene(), &context, &p);
    for (RTCRayHit& r : single_) rtcIntersect1(mesh_.scene(), &context, &r);
}

// Interpolates by hand, since rtcInterpolate() serves surfaces of all kinds and is slower.
void EmbreeRays::fill(unsigned primitive, float u, float v, float distance, Vec3f direction, ShadedHit& hit) const noexcept
{
    const EmbreeMesh::Corner* of = &mesh_.corners[std::size_t(primitive) * 3];
    const float w = 1 - u - v;
    const Vec3f e = of[1].position - of[0].position, f = of[2].position - of[0].position;
    const Vec3f across = glm::cross(e, f);
    const float squared = glm::dot(across, across);
    hit.t = distance;
    hit.primitive = primitive;
    hit.position = mesh_.anchor() + Vec3d(of[0].position + e * u + f * v);
    hit.normal_geometric = across / std::sqrt(squared);
    hit.normal_shading = glm::normalize(of[0].normal * w + of[1].normal * u + of[2].normal * v);
    // The curvature is half the divergence of the normal over the triangle.
    const Vec3f along_e = glm::cross(f, across) / squared, along_f = glm::cross(across, e) / squared;
    hit.curvature = 0.5f * (glm::dot(of[1].normal - of[0].normal, along_e) + glm::dot(of[2].normal - of[0].normal, along_f));
    hit.back_side = glm::dot(hit.normal_geometric, direction) > 0;
    if (hit.back_side) hit.normal_geometric = -hit.normal_geometric, hit.curvature = -hit.curvature;
    if (glm::dot(hit.normal_shading, hit.normal_geometric) < 0) hit.normal_shading = -hit.normal_shading;
}

void EmbreeRays::closest_filled(std::span<ShadedHit> batch)
{
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    if (!packet_.empty() && is_coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    for (std::size_t first = 0; first < count_; first += batch.size()) {
        const std::size_t end = std::min(first + batch.size(), count_);
        if (!packet_.empty())
            for (std::size_t i = first; i < end; i += 8) rtcIntersect8(kAll, mesh_.scene(), &context, &packet_[i / 8]);
        else
            for (std::size_t i = first; i < end; ++i) rtcIntersect1(mesh_.scene(), &context, &single_[i]);
        for (std::size_t i = first; i < end; ++i) {
            ShadedHit& hit = batch[i - first];
            if (packet_.empty()) {
                const RTCRayHit& r = single_[i];
                if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) hit.t = kInfinity;
                else fill(r.hit.primID, r.hit.u, r.hit.v, r.ray.tfar, {r.ray.dir_x, r.ray.dir_y, r.ray.dir_z}, hit);
                continue;
            }
            const RTCRayHit8& p = packet_[i / 8];
            const std::size_t l = i % 8;
            if (p.hit.geomID[l] == RTC_INVALID_GEOMETRY_ID) hit.t = kInfinity;
            else
                fill(p.hit.primID[l], p.hit.u[l], p.hit.v[l], p.ray.tfar[l],
                     {p.ray.dir_x[l], p.ray.dir_y[l], p.ray.dir_z[l]}, hit);
        }
    }
}

void EmbreeRays::occluded()
{
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    if (!packet_.empty() && is_coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    for (RTCRayHit8& p : packet_) rtcOccluded8(kAll, mesh_.scene(), &context, &p.ray);
    for (RTCRayHit& r : single_) rtcOccluded1(mesh_.scene(), &context, &r.ray);
}

float EmbreeRays::t(std::size_t i) const noexcept
{
    const bool is_packet = !packet_.empty();
    const unsigned geometry = is_packet ? packet_[i / 8].hit.geomID[i % 8] : single_[i].hit.geomID;
    if (geometry == RTC_INVALID_GEOMETRY_ID) return kInfinity;
    return is_packet ? packet_[i / 8].ray.tfar[i % 8] : single_[i].ray.tfar;
}

bool EmbreeRays::is_occluded(std::size_t i) const noexcept
{
    return (packet_.empty() ? single_[i].ray.tfar : packet_[i / 8].ray.tfar[i % 8]) < 0;
}

}  // namespace occam::bench
