// Trees over triangles that are cut where their boxes overlap, beside trees over whole triangles, in turns.
//
// *hair*: 4,000 long cards on a ball. *beams*: 600 thin boxes in all directions. *mixed*: hair with balls of small
// triangles. *turned room*: the furnished room, turned off the axes. Each stands still, and turns by 0.6 with its vertices
// in four segments while the shutter is open. Camera rays are coherent; diffuse rays start at their hits.

#include <cmath>
#include <random>

#include "render/camera_rays.h"
#include "tests/bench/rooms.h"
#include "tests/bench/subjects.h"
#include "tests/bench/suites.h"

namespace occam::bench {
namespace {

constexpr int kRuns = 5, kWidth = 240, kHeight = 160, kSegments = 4;
constexpr std::size_t kMemoryBytes = std::size_t(1) << 30;

Vec3f turned(Vec3f p, float angle, Vec3f axis)
{
    const Vec3f n = glm::normalize(axis);
    return p * std::cos(angle) + glm::cross(n, p) * std::sin(angle) + n * (glm::dot(n, p) * (1 - std::cos(angle)));
}

/// Builds a list of triangles, three corners each.
struct Soup {
    std::vector<Vec3f> corners;
    std::mt19937 random{1};

    float number() { return static_cast<float>(random() >> 8) * 0x1p-23f - 1; }
    Vec3f direction()
    {
        const float z = number(), angle = 3.14159265f * number(), r = std::sqrt(1 - z * z);
        return {r * std::cos(angle), r * std::sin(angle), z};
    }
    void quad(Vec3f a, Vec3f b, Vec3f c, Vec3f d) { corners.insert(corners.end(), {a, b, c, a, c, d}); }
    void hair(int cards)
    {
        for (int i = 0; i < cards; ++i) {
            const Vec3f root = direction(), along = root + 0.6f * Vec3f(number(), number(), number());
            const Vec3f wide = 0.006f * glm::normalize(glm::cross(root, direction()));
            quad(root - wide, root + wide, root + along + wide, root + along - wide);
        }
    }
    void beams(int count)
    {
        for (int i = 0; i < count; ++i) {
            const Vec3f at = 2.0f * Vec3f(number(), number(), number()), along = (1.25f + 0.75f * number()) * direction();
            const Vec3f u = 0.04f * glm::normalize(glm::cross(along, direction())),
                        v = 0.04f * glm::normalize(glm::cross(along, u));
            const Vec3f side[4] = {-u - v, u - v, u + v, v - u};
            for (int k = 0; k < 4; ++k)
                quad(at - along + side[k], at - along + side[(k + 1) % 4], at + along + side[(k + 1) % 4],
                     at + along + side[k]);
        }
    }
    void balls(int count, int fineness)
    {
        for (int i = 0; i < count; ++i) {
            const Vec3f centre = 2.0f * Vec3f(number(), number(), number());
            const float radius = 0.35f + 0.15f * number(), step = 3.14159265f / float(fineness);
            const auto at = [&](int row, int column) {
                const float a = step * float(column), b = step * float(row);
                return centre + radius * Vec3f(std::sin(b) * std::cos(a), std::sin(b) * std::sin(a), std::cos(b));
            };
            for (int row = 0; row < fineness; ++row)
                for (int column = 0; column < 2 * fineness; ++column)
                    quad(at(row, column), at(row, column + 1), at(row + 1, column + 1), at(row + 1, column));
        }
    }
};

void add_rows(Report& report, const std::string& name, const std::vector<Vec3f>& corners, const Camera& eye, bool moves)
{
    Scene scene;
    Cage mesh;
    mesh.scheme = Scheme::Triangles;
    mesh.positions = corners;
    for (std::uint32_t v = 0; v < corners.size(); ++v) mesh.face_vertices.push_back(v);
    mesh.materials = {scene.add(Material())};
    NodeDesc desc;
    desc.cages = {scene.add(std::move(mesh))};
    const CageId cage = desc.cages.front();
    scene.add_node(scene.root(), std::move(desc));
    if (moves)
        scene.record_shutter(kSegments, [&](double tau) {
            std::vector<Vec3f> now = corners;
            for (Vec3f& p : now) p = turned(p, 0.6f * static_cast<float>(tau - 0.5), {3, 1, 2});
            scene.write_vertices(cage, now);
        });
    scene.refit();
    const render::CameraRays camera(eye, kWidth, kHeight);
    std::vector<accel::Ray> rays = rays_of_a_frame(camera, kWidth, kHeight, 1);
    lod::TopologyCache topologies;
    const accel::Frame frame(scene, topologies, camera.levels(1));
    accel::Tracer whole(frame, kMemoryBytes, {.spatial = false}), cut(frame, kMemoryBytes);
    std::vector<accel::SurfaceHit> hits(rays.size());
    const double whole_cold = repeat(1, [&] { trace_closest(whole, rays, hits); }).front();
    const double cut_cold = repeat(1, [&] { trace_closest(cut, rays, hits); }).front();
    const std::vector<accel::Ray> diffuse = diffuse_rays(rays, hits);
    for (const bool is_camera : {true, false}) {
        const std::vector<accel::Ray>& all = is_camera ? rays : diffuse;
        hits.resize(all.size());
        std::vector<double> without, with;
        trace_closest(whole, all, hits);
        trace_closest(cut, all, hits);
        for (int run = 0; run < kRuns; ++run) {
            without.push_back(repeat(1, [&] { trace_closest(whole, all, hits); }).front() * 1e9 / double(all.size()));
            with.push_back(repeat(1, [&] { trace_closest(cut, all, hits); }).front() * 1e9 / double(all.size()));
        }
        Row row{"motion",
                "spatial splits: " + name + (moves ? ", moving" : ", still") + (is_camera ? ", camera" : ", diffuse")};
        row.add("rays", double(all.size())).add("whole_ns_a_ray", without).add("cut_ns_a_ray", with);
        row.add("whole_over_cut", ratios(without, with));
        if (is_camera) row.add("whole_cold_s", whole_cold).add("cut_cold_s", cut_cold);
        row.add("whole_mb", 1e-6 * double(whole.counters().peak_bytes));
        report.add(row.add("cut_mb", 1e-6 * double(cut.counters().peak_bytes)));
    }
}

}  // namespace

void run_spatial_splits(Report& report)
{
    const Camera outside = Camera::look_at({4, 2, 4}, {0, 0, 0}, {0, 1, 0}, 0.7f);
    Soup hair, beams, mixed;
    hair.hair(4000);
    beams.beams(600);
    mixed.hair(1000);
    mixed.balls(10, 12);
    WholeScene room = furnished_room();
    room.scene.refit();
    lod::TopologyCache topologies;
    std::vector<Vec3f> of_room = room.triangles(topologies, {});
    const Vec3f axis(1, 2, 3);
    for (Vec3f& p : of_room) p = turned(p, 0.7f, axis);
    const auto place = [&](Vec3f p) { return Vec3d(turned(p, 0.7f, axis)); };
    const Camera inside = Camera::look_at(place({0.6f, 1.7f, 0.6f}), place({5, 0.8f, 4}), place({0, 1, 0}), 1.0f);
    for (const bool moves : {false, true}) {
        if (report.wants("spatial splits: hair")) add_rows(report, "hair", hair.corners, outside, moves);
        if (report.wants("spatial splits: beams")) add_rows(report, "beams", beams.corners, outside, moves);
        if (report.wants("spatial splits: mixed")) add_rows(report, "mixed", mixed.corners, outside, moves);
        if (report.wants("spatial splits: turned room")) add_rows(report, "turned room", of_room, inside, moves);
    }
}

}  // namespace occam::bench
