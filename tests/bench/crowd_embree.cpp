#include "tests/bench/crowd_embree.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <mutex>
#include <stdexcept>

#include "tests/bench/harness.h"

namespace occam::bench {
namespace {

constexpr int kAll[8] = {-1, -1, -1, -1, -1, -1, -1, -1};
constexpr int kTile = 16;
constexpr double kFieldOfView = 0.78539816339744831;  // 45 degrees

std::uint32_t scramble(std::uint32_t x)
{
    x = (x ^ 61) ^ (x >> 16);
    x *= 9;
    x ^= x >> 4;
    x *= 0x27d4eb2d;
    return x ^ (x >> 15);
}
float number(std::uint32_t a, std::uint32_t b) { return float(scramble(a * 747796405u + scramble(b)) >> 8) * 0x1p-24f; }

struct View {
    Vec3f eye, right, up, forward;
    explicit View(const Crowd& crowd) : eye(crowd.eye())
    {
        forward = glm::normalize(-eye);
        right = glm::normalize(glm::cross(forward, Vec3f(0, 1, 0)));
        up = glm::cross(right, forward);
        const auto scale = static_cast<float>(2 * std::tan(kFieldOfView / 2) / kCrowdPixels);
        right *= scale;
        up *= scale;
    }
    Vec3f direction(float x, float y) const
    {
        return glm::normalize(forward + right * (x - kCrowdPixels / 2) - up * (y - kCrowdPixels / 2));
    }
};

// Says which camera rays a packet holds: those of a sample of 4 x 2 pixels.
struct PacketOfPixels {
    int x, y, sample, samples, frame;
};

void set_camera_rays(const View& view, const PacketOfPixels& of, RTCRayHit8& p)
{
    const auto frame = static_cast<std::uint32_t>(of.frame);
    for (int l = 0; l < 8; ++l) {
        const int x = of.x + l % 4, y = of.y + l / 4;
        const std::uint32_t seed = static_cast<std::uint32_t>((y * kCrowdPixels + x) * of.samples + of.sample) * 2u;
        const Vec3f d = view.direction(float(x) + number(seed, frame), float(y) + number(seed + 1, frame));
        p.ray.org_x[l] = view.eye.x, p.ray.org_y[l] = view.eye.y, p.ray.org_z[l] = view.eye.z;
        p.ray.dir_x[l] = d.x, p.ray.dir_y[l] = d.y, p.ray.dir_z[l] = d.z;
        p.ray.tnear[l] = 0, p.ray.tfar[l] = std::numeric_limits<float>::infinity();
        p.ray.time[l] = 0, p.ray.mask[l] = ~0u, p.ray.id[l] = 0, p.ray.flags[l] = 0;
        p.hit.geomID[l] = p.hit.primID[l] = p.hit.instID[0][l] = RTC_INVALID_GEOMETRY_ID;
    }
}

// Sets a lane to a ray from its hit to a point of the light, and returns the cosine there.
float set_shadow_ray(const RTCRayHit8& p, int l, const SquareLight& to, std::uint32_t seed, std::uint32_t draw,
                     RTCRay8& shadow)
{
    const double u = double(number(seed, draw)) - 0.5, v = double(number(seed, draw + 1)) - 0.5;
    const Vec3f at(to.centre + to.right * (u * to.side) + to.up * (v * to.side));
    const Vec3f eye(p.ray.org_x[l], p.ray.org_y[l], p.ray.org_z[l]), d(p.ray.dir_x[l], p.ray.dir_y[l], p.ray.dir_z[l]);
    Vec3f n = glm::normalize(Vec3f(p.hit.Ng_x[l], p.hit.Ng_y[l], p.hit.Ng_z[l]));
    if (glm::dot(n, d) > 0) n = -n;
    const Vec3f from = eye + d * p.ray.tfar[l] + n * (1e-4f * p.ray.tfar[l]);
    const Vec3f way = at - from;
    const float distance = glm::length(way);
    const Vec3f w = way / distance;
    shadow.org_x[l] = from.x, shadow.org_y[l] = from.y, shadow.org_z[l] = from.z;
    shadow.dir_x[l] = w.x, shadow.dir_y[l] = w.y, shadow.dir_z[l] = w.z;
    shadow.tfar[l] = distance * 0.9999f;
    return std::max(0.0f, glm::dot(n, w));
}

}  // namespace

EmbreeCrowd::EmbreeCrowd(const Crowd& crowd) : crowd_(crowd), device_(rtcNewDevice(nullptr))
{
    if (!device_) throw std::runtime_error("no Embree device");
    rtcSetDeviceMemoryMonitorFunction(
        device_,
        [](void* self, ssize_t change, bool) {
            auto& crowd_here = *static_cast<EmbreeCrowd*>(self);
            const std::size_t now = crowd_here.bytes_ += static_cast<std::size_t>(change);
            std::size_t peak = crowd_here.peak_bytes_;
            while (now > peak && !crowd_here.peak_bytes_.compare_exchange_weak(peak, now)) {
            }
            return true;
        },
        this);
    scene_ = rtcNewScene(device_);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_DYNAMIC | RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_LOW);

    const Cage& cage = crowd.cage;
    for (std::size_t corner = 0; const std::uint32_t size : cage.face_sizes) {
        for (std::uint32_t c = 0; c < size; ++c) edges_.push_back(cage.face_vertices[corner + (c + 1) % size]);
        corner += size;
    }
    for (int i = 0; i < crowd.copies; ++i) {
        RTCGeometry g = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_SUBDIVISION);
        rtcSetGeometryBuildQuality(g, RTC_BUILD_QUALITY_LOW);
        vertices_.push_back(static_cast<Vec3f*>(rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                                        sizeof(Vec3f), cage.positions.size() + 1)));
        void* index = rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, 4, cage.face_vertices.size());
        std::memcpy(index, cage.face_vertices.data(), cage.face_vertices.size() * 4);
        void* face = rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_FACE, 0, RTC_FORMAT_UINT, 4, cage.face_sizes.size());
        std::memcpy(face, cage.face_sizes.data(), cage.face_sizes.size() * 4);
        levels_.push_back(static_cast<float*>(
            rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_LEVEL, 0, RTC_FORMAT_FLOAT, 4, cage.face_vertices.size())));
        rtcSetGeometrySubdivisionMode(g, 0, RTC_SUBDIVISION_MODE_PIN_CORNERS);
        rtcAttachGeometry(scene_, g);
        copies_.push_back(g);
    }
    RTCGeometry ground = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_QUAD);
    auto* corners = static_cast<Vec3f*>(
        rtcSetNewGeometryBuffer(ground, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3f), 5));
    const auto floor = crowd.floor();
    std::copy(floor.begin(), floor.end(), corners);
    auto* quad = static_cast<std::uint32_t*>(
        rtcSetNewGeometryBuffer(ground, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, 16, 1));
    for (std::uint32_t c = 0; c < 4; ++c) quad[c] = c;
    rtcCommitGeometry(ground);
    rtcAttachGeometry(scene_, ground);
    rtcReleaseGeometry(ground);
}

EmbreeCrowd::~EmbreeCrowd()
{
    for (RTCGeometry g : copies_) rtcReleaseGeometry(g);
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
}

void EmbreeCrowd::write_vertices(int frame)
{
    // This is the loop of an application: one thread, as in Occam's benchmark.
    std::vector<Vec3f> positions;
    for (int i = 0; i < crowd_.copies; ++i) {
        crowd_.twist(i, frame, positions);
        const Vec3f place(crowd_.place(i));
        for (std::size_t v = 0; v < positions.size(); ++v) vertices_[static_cast<std::size_t>(i)][v] = positions[v] + place;
    }
}

// An edge gets as many pieces as its length in pixels at its middle has target edge lengths. So both of its faces give it
// the same number.
void EmbreeCrowd::write_levels(int copy, double edge_pixels)
{
    const Vec3f* p = vertices_[static_cast<std::size_t>(copy)];
    float* level = levels_[static_cast<std::size_t>(copy)];
    const Vec3f eye(crowd_.eye());
    const auto pieces = static_cast<float>(kCrowdPixels / (2 * std::tan(kFieldOfView / 2)) / edge_pixels);
    for (std::size_t c = 0; c < edges_.size(); ++c) {
        const Vec3f a = p[crowd_.cage.face_vertices[c]], b = p[edges_[c]];
        level[c] = std::clamp(glm::distance(a, b) * pieces / glm::distance((a + b) * 0.5f, eye), 1.0f, 4096.0f);
    }
}

EmbreeCrowd::Frame EmbreeCrowd::render(int frame, const Recipe& recipe)
{
    const double start = wall_seconds();
    write_vertices(frame);
    const double edited = wall_seconds();
    tbb::parallel_for(0, crowd_.copies, [&](int i) {
        write_levels(i, double(recipe.edge_pixels));
        RTCGeometry g = copies_[static_cast<std::size_t>(i)];
        rtcUpdateGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0);
        rtcUpdateGeometryBuffer(g, RTC_BUFFER_TYPE_LEVEL, 0);
        rtcCommitGeometry(g);
    });
    rtcCommitScene(scene_);
    const double committed = wall_seconds();
    Frame made = trace(frame, recipe);
    made.edit_seconds = edited - start;
    made.commit_seconds = committed - edited;
    made.trace_seconds = wall_seconds() - committed;
    return made;
}

EmbreeCrowd::Frame EmbreeCrowd::trace(int frame, const Recipe& recipe) const
{
    const View view(crowd_);
    const std::array<SquareLight, 2> lights = crowd_.lights();
    Frame made;
    std::mutex mutex;
    constexpr int kTiles = kCrowdPixels / kTile;
    tbb::parallel_for(0, kTiles * kTiles, [&](int tile) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        std::uint64_t rays = 0;
        double sum = 0;
        const int x0 = tile % kTiles * kTile, y0 = tile / kTiles * kTile;
        // The packets cover 4 x 2 pixels.
        for (int block = 0; block < kTile * kTile / 8; ++block)
            for (int sample = 0; sample < recipe.primary; ++sample) {
                alignas(32) RTCRayHit8 p;
                const int x = x0 + block % (kTile / 4) * 4, y = y0 + block / (kTile / 4) * 2;
                set_camera_rays(view, {x, y, sample, recipe.primary, frame}, p);
                rtcIntersect8(kAll, scene_, &context, &p);
                rays += 8;
                int valid[8];
                int hits = 0;
                for (int l = 0; l < 8; ++l) hits += (valid[l] = p.hit.geomID[l] != RTC_INVALID_GEOMETRY_ID ? -1 : 0) != 0;
                if (hits == 0) continue;
                for (std::size_t light = 0; light < lights.size(); ++light)
                    for (int s = 0; s < recipe.shadow; ++s) {
                        alignas(32) RTCRay8 shadow = p.ray;
                        float shine[8];
                        for (int l = 0; l < 8; ++l) {
                            const int seed = tile * 4096 + block * 128 + sample * 16 + l;
                            const auto draw = static_cast<std::uint32_t>(light * 64 + std::size_t(s) * 2);
                            if (valid[l])
                                shine[l] = set_shadow_ray(p, l, lights[light], static_cast<std::uint32_t>(seed), draw,
                                                          shadow);
                        }
                        rtcOccluded8(valid, scene_, &context, &shadow);
                        for (int l = 0; l < 8; ++l)
                            if (valid[l] && shadow.tfar[l] >= 0) sum += double(shine[l]);
                        rays += static_cast<std::uint64_t>(hits);
                    }
            }
        const std::lock_guard lock(mutex);
        made.rays += rays;
        made.mean_luminance += sum / (double(kCrowdPixels) * kCrowdPixels * recipe.primary * recipe.shadow);
    });
    return made;
}

}  // namespace occam::bench
