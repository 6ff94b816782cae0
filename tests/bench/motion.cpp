// Rays in scenes that move, in the kd-tree over boxes for all times and in the tree of boxes at keys, in turns.
//
// 16 x 16 tori stand side by side. *small*: each moves by a tenth of its size while the shutter is open, its own way.
// *wheels*: each turns by a quarter, in four segments. *together*: all move by twenty sizes the same way. *apart*: each
// flies four sizes, its own way; *chaos*: twenty sizes. Camera rays have random times; diffuse rays start at their hits and
// inherit them. Where things fly far, the kd-tree is measured with a part of the rays, since each ray takes long.
//
// *Table 4* is after that of Hou et al. 2010: what building and tracing take where boxes are interpolated at each ray's
// time, and where they hold all times. In *large motion* and *mild motion* the tori fly four sizes, or a tenth of their
// size; in *thin grids* 256 blades, each turned its own way, fly half of their length. Rays have the places and moments of a
// frame of eight samples. Both trees open the same items, halve igrids in their parameters, and get rays that are sorted by
// time as it pays. What else that table has is no option of the engine; docs/performance.md says why.

#include <cmath>

#include "render/camera_rays.h"
#include "tests/bench/subjects.h"
#include "tests/bench/suites.h"

namespace occam::bench {
namespace {

constexpr int kRuns = 3, kWidth = 160, kHeight = 160, kSide = 16;
constexpr std::size_t kMemoryBytes = std::size_t(2) << 30;

struct Motion {
    const char* name;
    int segments;
    double distance, turn;  ///< in sizes; in radians
    bool is_common;
    std::size_t kd_part;  ///< the kd-tree is measured with one of so many rays
    bool is_thin = false;
};
constexpr Motion kMotions[] = {{"still", 0, 0, 0, false, 1},       {"small", 1, 0.1, 0, false, 1},
                               {"wheels", 4, 0, 1.5708, false, 1}, {"together", 1, 20, 0, true, 128},
                               {"apart", 1, 4, 0, false, 16},      {"chaos", 1, 20, 0, false, 128}};
constexpr Motion kTable[] = {{"table 4, large motion", 1, 4, 0, false, 4},
                             {"table 4, mild motion", 1, 0.1, 0, false, 1},
                             {"table 4, thin grids", 1, 0.5, 0, false, 2, true}};
constexpr int kTableWidth = 128, kTableSamples = 8;

void record(Scene& scene, const Motion& motion)
{
    const CageId cage = scene.add(torus(12, 8));
    std::vector<NodeId> nodes;
    const auto at = [&](int k, double tau) {
        const double way = motion.is_common ? 0.7 : 2.4 * k, far = motion.distance * 2.8 * tau;
        Trs trs;
        trs.translation = {3.0 * (k % kSide - kSide / 2) + far * std::cos(way), far * std::sin(way),
                           3.0 * (k / kSide - kSide / 2)};
        trs.rotation = {std::sin(0.5 * motion.turn * tau), 0, 0, std::cos(0.5 * motion.turn * tau)};
        if (motion.is_thin) {
            trs.rotation = {0.6 * std::sin(0.7 * k), 0.6 * std::cos(0.7 * k), 0, 0.8};
            trs.scale = {1.5, 0.05, 0.05};
        }
        return trs;
    };
    for (int k = 0; k < kSide * kSide; ++k) {
        NodeDesc desc;
        desc.place = at(k, 0);
        desc.cages = {cage};
        nodes.push_back(scene.add_node(scene.root(), std::move(desc)));
    }
    if (motion.segments == 0) return;
    scene.record_shutter(motion.segments, [&](double tau) {
        for (int k = 0; k < kSide * kSide; ++k) scene.set_transform(nodes[std::size_t(k)], at(k, tau));
    });
}

// Returns one of so many rays, in pieces of neighbours from all over the picture.
std::vector<accel::Ray> some_pieces(const std::vector<accel::Ray>& rays, std::size_t part)
{
    constexpr std::size_t kPiece = 16;
    std::vector<accel::Ray> some;
    for (std::size_t i = 0; i < rays.size(); ++i)
        if (i / kPiece % part == part / 2) some.push_back(rays[i]);
    return some;
}

void add_rows(Report& report, const Motion& motion)
{
    Scene scene;
    record(scene, motion);
    scene.refit();
    const Camera eye = Camera::look_at({0, 26, 40}, {0, 0, 0}, {0, 1, 0}, 0.9f);
    const render::CameraRays camera(eye, kWidth, kHeight);
    std::vector<accel::Ray> rays;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            rays.push_back(camera.ray(x + 0.5, y + 0.5));
            rays.back().time = static_cast<float>((x * 7 + y * 13) % 64) / 64 + 1.0f / 128;
        }
    lod::TopologyCache topologies;
    TreePair trees(scene, topologies, camera.levels(1), kMemoryBytes);
    std::vector<accel::SurfaceHit> hits(rays.size());
    const double start = thread_seconds();
    trace_closest(trees.kd, some_pieces(rays, motion.kd_part), hits);
    const double kd_cold = thread_seconds() - start;
    trace_closest(trees.bvh, rays, hits);
    const double bvh_cold = thread_seconds() - start - kd_cold;
    const std::vector<accel::Ray> diffuse = diffuse_rays(rays, hits);
    for (const bool is_camera : {true, false}) {
        const std::vector<accel::Ray>& all = is_camera ? rays : diffuse;
        hits.resize(all.size());
        const std::vector<accel::Ray> some = some_pieces(all, motion.kd_part);
        std::vector<double> kd, bvh;
        trace_closest(trees.kd, some, hits);
        trace_closest(trees.bvh, all, hits);
        const double nano = 1e-9 * double(all.size()), kd_nano = 1e-9 * double(some.size());
        for (int run = 0; run < kRuns; ++run) {
            kd.push_back(repeat(1, [&] { trace_closest(trees.kd, some, hits); }).front() / kd_nano);
            bvh.push_back(repeat(1, [&] { trace_closest(trees.bvh, all, hits); }).front() / nano);
        }
        Row row{"motion", std::string(motion.name) + (is_camera ? ", camera" : ", diffuse")};
        row.add("rays", double(all.size())).add("kd_ns_a_ray", kd).add("bvh_ns_a_ray", bvh);
        row.add("bvh_over_kd", ratios(kd, bvh));
        if (is_camera) row.add("kd_cold_s", kd_cold).add("bvh_cold_s", bvh_cold);
        row.add("kd_mb", 1e-6 * double(trees.kd.counters().peak_bytes));
        report.add(row.add("bvh_mb", 1e-6 * double(trees.bvh.counters().peak_bytes)));
    }
}

void add_table_row(Report& report, const Motion& motion)
{
    Scene scene;
    record(scene, motion);
    scene.refit();
    const render::CameraRays camera(Camera::look_at({0, 26, 40}, {0, 0, 0}, {0, 1, 0}, 0.9f), kTableWidth, kTableWidth);
    const std::vector<accel::Ray> rays = rays_of_a_frame(camera, kTableWidth, kTableWidth, kTableSamples);
    const std::vector<accel::Ray> some = some_pieces(rays, motion.kd_part);
    lod::TopologyCache topologies;
    TreePair trees(scene, topologies, camera.levels(1), kMemoryBytes);
    std::vector<accel::SurfaceHit> hits(rays.size());
    const auto seconds_to_build = [&](accel::Tracer& tracer) {
        trace_closest(tracer, some, hits);
        return tracer.counters().build_seconds + tracer.counters().dice_seconds;
    };
    const double at_keys_build = seconds_to_build(trees.bvh), swept_build = seconds_to_build(trees.kd);
    trace_closest(trees.bvh, rays, hits);  // it learns how to sort them
    std::vector<double> at_keys, swept;
    for (int run = 0; run < kRuns; ++run) {
        at_keys.push_back(repeat(1, [&] { trace_closest(trees.bvh, some, hits); }).front() / double(some.size()));
        swept.push_back(repeat(1, [&] { trace_closest(trees.kd, some, hits); }).front() / double(some.size()));
    }
    Row row{"motion", motion.name};
    row.add("rays", double(some.size())).add("at_keys_build_s", at_keys_build).add("swept_build_s", swept_build);
    row.add("at_keys_ns_a_ray", times(at_keys, 1e9)).add("swept_ns_a_ray", times(swept, 1e9));
    report.add(row.add("swept_over_at_keys", ratios(swept, at_keys)));
}

}  // namespace

void run_motion(Report& report)
{
    for (const Motion& motion : kMotions)
        if (report.wants(motion.name)) add_rows(report, motion);
    for (const Motion& motion : kTable)
        if (report.wants(motion.name)) add_table_row(report, motion);
    run_motion_flat(report);
    run_motion_embree(report);
    run_spatial_splits(report);
}

}  // namespace occam::bench
