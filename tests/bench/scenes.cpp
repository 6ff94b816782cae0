// The suite renders whole scenes (path tracing, ambient occlusion and direct light), beside Embree on the same triangles.
// Cages are diced for Embree at the one level that `--lod off` chooses for each; Occam's rays each have levels of their own.
//
// For the traced part, rays of each kind are recorded once, batch by batch as a renderer asks for them. Then both trace the
// same rays in turns, at default levels; Embree traces single rays and packets of eight. Occam's hits are written to one
// batch again and again, as a renderer does, which shades them before it traces the next batch. Whole frames compare Occam's
// renderer with a plain diffuse path tracer on Embree that shoots as many camera samples, with one shadow ray to the last
// lamp at each hit.

#include <cmath>

#include "api/include/occam/occam.h"
#include "render/camera_rays.h"
#include "render/compare.h"
#include "render/setting_rows.h"
#include "render/tiles.h"
#include "tests/bench/embree_mesh.h"
#include "tests/bench/rooms.h"
#include "tests/bench/subjects.h"
#include "tests/bench/suites.h"

namespace occam::bench {
namespace {

constexpr int kRuns = 5, kWidth = 192, kHeight = 108, kSide = 2, kBounces = 6;
constexpr std::size_t kMemoryBytes = std::size_t(1) << 30;

std::vector<accel::Ray> camera_rays(const render::CameraRays& camera)
{
    std::vector<accel::Ray> rays;
    for (const render::PixelRect& tile : render::make_tiles({0, 0, kWidth, kHeight}))
        for (const auto [x, y] : render::pixels_of(tile))
            for (int s = 0; s < kSide * kSide; ++s)
                rays.push_back(camera.ray(x + (s % kSide + 0.5) / kSide, y + (s / kSide + 0.5) / kSide));
    return rays;
}

// Holds rays of a frame that are all traced for their nearest hit, or all for any hit.
struct Recorded {
    std::string what;
    bool is_any;
    std::vector<std::vector<accel::Ray>> batches{};
    bool is_coherent = false;  ///< what Embree's packets are told

    std::size_t count() const
    {
        std::size_t n = 0;
        for (const auto& batch : batches) n += batch.size();
        return n;
    }
};

// Records the rays of paths with kBounces diffuse bounces, an ambient occlusion ray at each camera hit, and the rays of
// direct light: camera rays, and shadow rays to a lamp.
std::vector<Recorded> record(accel::Tracer& tracer, const std::vector<accel::Ray>& camera, Vec3d lamp)
{
    Recorded path{"path, 6 bounces", false}, bounces{"bounces alone", false}, ao{"ambient occlusion", true},
        direct{"camera", false, {}, true}, shadow{"shadow", true, {}, true};
    std::vector<accel::SurfaceHit> hits;
    for (std::size_t first = 0; first < camera.size(); first += kBatch) {
        std::vector<accel::Ray> rays(camera.begin() + std::ptrdiff_t(first),
                                     camera.begin() + std::ptrdiff_t(std::min(first + kBatch, camera.size())));
        for (int bounce = 0; bounce <= kBounces && !rays.empty(); ++bounce) {
            hits.resize(rays.size());
            tracer.closest(rays, hits);
            path.batches.push_back(rays);
            (bounce == 0 ? direct : bounces).batches.push_back(rays);
            std::vector<accel::Ray> next = diffuse_rays(rays, hits), to_lamp;
            if (bounce == 0) ao.batches.push_back(next);
            for (std::size_t i = 0; i < rays.size(); ++i) {
                if (!hits[i].is_hit()) continue;
                accel::Ray ray;
                ray.origin = hits[i].position + Vec3d(hits[i].normal_geometric) * double(hits[i].self_distance);
                const Vec3d way = lamp - ray.origin;
                if (glm::dot(way, Vec3d(hits[i].normal_geometric)) <= 0) continue;
                ray.direction = Vec3f(glm::normalize(way));
                ray.t_far = static_cast<float>(glm::length(way));
                ray.footprint = {rays[i].footprint.at(hits[i].t), 0};
                to_lamp.push_back(ray);
            }
            if (!to_lamp.empty()) shadow.batches.push_back(std::move(to_lamp));
            rays = std::move(next);
        }
    }
    return {path, bounces, ao, direct, shadow};
}

Row traced_row(const std::string& scene, const Recorded& recorded, TreePair& trees, const EmbreeMesh& mesh)
{
    std::vector<accel::Ray> all;
    for (const auto& batch : recorded.batches) all.insert(all.end(), batch.begin(), batch.end());
    EmbreeRays theirs(mesh, all, false), packets(mesh, all, true);
    packets.is_coherent = recorded.is_coherent;
    std::vector<accel::SurfaceHit> hits(kBatch);
    std::vector<float> t(all.size());
    std::vector<std::uint8_t> occluded(all.size());
    const auto trace = [&](accel::Tracer& tracer) {
        std::size_t at = 0;
        for (const auto& batch : recorded.batches) {
            if (recorded.is_any) tracer.occluded(batch, std::span(occluded).subspan(at, batch.size()));
            else tracer.closest(batch, std::span(hits).first(batch.size()));
            for (std::size_t i = 0; i < batch.size() && !recorded.is_any; ++i) t[at + i] = hits[i].t;
            at += batch.size();
        }
    };
    trace(trees.kd);
    trace(trees.bvh);
    std::vector<double> kd_s, bvh_s, theirs_s, packets_s;
    const auto timed = [&](EmbreeRays& rays) {
        rays.reset();
        return repeat(1, [&] { recorded.is_any ? rays.occluded() : rays.closest(); }).front();
    };
    for (int run = 0; run < kRuns; ++run) {
        kd_s.push_back(repeat(1, [&] { trace(trees.kd); }).front());
        bvh_s.push_back(repeat(1, [&] { trace(trees.bvh); }).front());
        theirs_s.push_back(timed(theirs));
        packets_s.push_back(timed(packets));
    }
    std::size_t disagree = 0;
    for (std::size_t i = 0; i < all.size(); ++i)
        disagree += recorded.is_any ? (occluded[i] != 0) != theirs.is_occluded(i)
                                    : std::isfinite(t[i]) != std::isfinite(theirs.t(i));
    const double mega = 1e-6 * double(all.size());
    const std::vector<double>& ours_s = trees.usual == accel::TreeKind::Bvh ? bvh_s : kd_s;
    Row row{"scenes", scene + ", " + recorded.what};
    row.add("rays", double(all.size())).add("occam_mrays_per_s", per(mega, ours_s));
    row.add("kd_mrays_per_s", per(mega, kd_s))
        .add("bvh_mrays_per_s", per(mega, bvh_s))
        .add("bvh_over_kd", ratios(kd_s, bvh_s));
    row.add("embree_mrays_per_s", per(mega, theirs_s)).add("occam_over_embree", ratios(theirs_s, ours_s));
    row.add("embree_packets_mrays_per_s", per(mega, packets_s)).add("occam_over_packets", ratios(packets_s, ours_s));
    return row.add("disagree_hit_or_miss", double(disagree));
}

// Returns the number of rays that a plain diffuse path tracer on Embree traces: one path for each sample, and one shadow ray
// at each hit.
std::size_t plain_paths(const EmbreeMesh& mesh, const std::vector<accel::Ray>& camera, Vec3d lamp,
                        std::vector<float>& picture)
{
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    std::size_t traced = 0;
    std::uint32_t state = 1;
    const auto random = [&] {
        state = state * 1664525u + 1013904223u;
        return static_cast<float>(state >> 8) * 0x1p-24f;
    };
    const Vec3f light(lamp - mesh.anchor());
    picture.assign(camera.size(), 0);
    for (std::size_t i = 0; i < camera.size(); ++i) {
        Vec3f origin(camera[i].origin - mesh.anchor()), d = camera[i].direction;
        float share = 1;
        for (int bounce = 0; bounce <= kBounces; ++bounce) {
            RTCRayHit r;
            r.ray = {origin.x, origin.y, origin.z, 1e-4f, d.x, d.y, d.z, 0, INFINITY, ~0u, 0, 0};
            r.hit.geomID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
            rtcIntersect1(mesh.scene(), &context, &r);
            ++traced;
            if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) break;
            Vec3f n = glm::normalize(Vec3f(r.hit.Ng_x, r.hit.Ng_y, r.hit.Ng_z));
            if (glm::dot(n, d) > 0) n = -n;
            origin = origin + d * r.ray.tfar + n * 1e-4f;
            share *= 0.7f;
            const Vec3f way = light - origin;
            const float distance = glm::length(way), cosine = glm::dot(way, n) / distance;
            if (cosine > 0) {
                RTCRay shadow{origin.x, origin.y, origin.z, 1e-4f, way.x / distance, way.y / distance, way.z / distance, 0,
                              distance, ~0u,      0,        0};
                rtcOccluded1(mesh.scene(), &context, &shadow);
                ++traced;
                if (shadow.tfar >= 0) picture[i] += share * cosine / (distance * distance);
            }
            const float r2 = random(), angle = 6.2831853f * random();
            const Vec3f u = glm::normalize(glm::cross(n, std::abs(n.x) < 0.5f ? Vec3f(1, 0, 0) : Vec3f(0, 1, 0)));
            d = std::sqrt(r2) * (std::cos(angle) * u + std::sin(angle) * glm::cross(n, u)) + std::sqrt(1 - r2) * n;
        }
    }
    return traced;
}

Row frame_row(const WholeScene& of, Scene& scene, const EmbreeMesh& mesh, const std::vector<accel::Ray>& camera, Vec3d lamp,
              IntegratorKind kind)
{
    Renderer renderer(Resources{.threads = 1}), kd(Resources{.threads = 1, .tree = TreeKind::Kd}),
        bvh(Resources{.threads = 1, .tree = TreeKind::Bvh});
    Settings settings{.width = kWidth, .height = kHeight, .spp = kSide * kSide};
    settings.integrator = kind;
    settings.bounces = kBounces;

    const auto seconds_of = [&](Renderer& with) {
        const double start = process_seconds();
        with.render(scene, of.camera, settings);
        return process_seconds() - start;
    };
    std::vector<double> ours, theirs, rates, their_rates, in_kd, in_bvh;
    std::vector<float> picture;
    for (int run = 0; run < kRuns; ++run) {
        ours.push_back(seconds_of(renderer));
        in_kd.push_back(seconds_of(kd));
        in_bvh.push_back(seconds_of(bvh));
        rates.push_back(1e-6 * double(renderer.stats().rays.total()) / ours.back());
        if (kind != IntegratorKind::Path) continue;
        const double their_start = process_seconds();
        const std::size_t traced = plain_paths(mesh, camera, lamp, picture);
        theirs.push_back(process_seconds() - their_start);
        their_rates.push_back(1e-6 * double(traced) / theirs.back());
    }
    const FrameStats::Seconds& s = renderer.stats().seconds;
    const double arena_mb = 1e-6 * double(renderer.stats().memory.arena_peak_bytes);
    Row row{"scenes", of.name + ", whole frame, " + std::string(render::name_of(kind))};
    row.add("cpu_s", ours).add("occam_mrays_per_s", rates).add("rays", double(renderer.stats().rays.total()));
    row.add("trace_s", s.trace).add("shade_s", s.shade).add("build_s", s.build + s.tessellate);
    row.add("kd_cpu_s", in_kd).add("bvh_cpu_s", in_bvh).add("bvh_over_kd", ratios(in_kd, in_bvh));
    row.add("arena_peak_mb", arena_mb);
    if (!theirs.empty())
        row.add("plain_embree_mrays_per_s", their_rates).add("occam_over_embree", ratios(rates, their_rates));
    return row;
}

// Frames with levels of detail and without, in turns; how far their pictures differ, beside that of two seeds.
Row levels_row(WholeScene& of, IntegratorKind kind)
{
    Renderer renderer(Resources{.threads = 1});
    Settings settings{.width = kWidth, .height = kHeight, .spp = kSide * kSide};
    settings.integrator = kind;
    settings.bounces = kBounces;
    std::vector<double> seconds[2];
    Image pictures[2];
    double arena_mb[2] = {};
    for (int run = 0; run < kRuns; ++run)
        for (const bool is_off : {false, true}) {
            settings.lod = is_off ? render::Lod::Off : render::Lod::On;
            const double start = process_seconds();
            pictures[is_off] = renderer.render(of.scene, of.camera, settings);
            seconds[is_off].push_back(process_seconds() - start);
            arena_mb[is_off] = 1e-6 * double(renderer.stats().memory.arena_peak_bytes);
        }
    ++settings.seed;
    const Image other_seed = renderer.render(of.scene, of.camera, settings);
    Row row{"scenes", of.name + ", levels, " + std::string(render::name_of(kind))};
    row.add("on_cpu_s", seconds[0]).add("off_cpu_s", seconds[1]).add("on_over_off", ratios(seconds[0], seconds[1]));
    row.add("rmse_on_from_off", render::compare(pictures[0], pictures[1], "beauty").rmse);
    row.add("rmse_of_another_seed", render::compare(other_seed, pictures[1], "beauty").rmse);
    return row.add("on_arena_mb", arena_mb[0]).add("off_arena_mb", arena_mb[1]);
}

// The time from the first call of a new renderer, with nothing built, to the first finished tile of the middle.
Row first_pixel_row(WholeScene& of)
{
    std::vector<double> seconds;
    for (int run = 0; run < 3; ++run) {
        Renderer renderer;
        const double start = wall_seconds();
        Job job = renderer.start(of.scene, of.camera, {.crop_x0 = 0.4f, .crop_x1 = 0.6f, .crop_y0 = 0.4f, .crop_y1 = 0.6f});
        while (job.progress().fraction <= 0 && !job.wait_for(std::chrono::milliseconds(1))) {
        }
        seconds.push_back(wall_seconds() - start);
        job.cancel();
        job.wait();
    }
    Row row{"scenes", of.name + ", first pixel"};
    row.note = "wall time; the file is read before";
    return row.add("first_tile_s", seconds).add("peak_memory_mb", 1e-6 * double(render::process_peak_bytes()));
}

void run_scene(Report& report, WholeScene& of)
{
    of.scene.refit();
    const render::CameraRays camera(of.camera, kWidth, kHeight);
    const std::vector<accel::Ray> rays = camera_rays(camera);
    Vec3d lamp = of.camera.eye() + Vec3d(0, 0.5, 0);
    of.scene.for_each_placement([&](NodeId, const Node& node, const Mat4d& world) {
        if (of.scene.find(node.light)) lamp = Vec3d(world[3]);
    });
    lod::TopologyCache topologies;
    const std::vector<Vec3f> corners = of.triangles(topologies, camera.levels(1));
    const EmbreeMesh mesh(corners, Vec3d(0));
    TreePair trees(of.scene, topologies, camera.levels(1), kMemoryBytes);
    accel::Tracer& tracer = trees.usual == accel::TreeKind::Bvh ? trees.bvh : trees.kd;
    for (const Recorded& recorded : record(tracer, rays, lamp)) report.add(traced_row(of.name, recorded, trees, mesh));
    Row row{"scenes", of.name + ", trees"};
    const accel::TraceCounters counters = tracer.counters();
    row.add("triangles", double(corners.size()) / 3).add("kd_nodes", double(counters.kd_nodes));
    row.add("igrids", double(counters.grids)).add("triangles_in_igrids", double(counters.micropolygons));
    row.add("build_s", counters.build_seconds + counters.dice_seconds).add("embree_build_s", mesh.build_seconds);
    report.add(row.add("arena_mb", 1e-6 * double(counters.peak_bytes)).add("embree_mb", 1e-6 * double(mesh.bytes)));
    for (const IntegratorKind kind : {IntegratorKind::Path, IntegratorKind::Ao, IntegratorKind::Direct})
        report.add(frame_row(of, of.scene, mesh, rays, lamp, kind));
    for (const IntegratorKind kind : {IntegratorKind::Path, IntegratorKind::Direct}) report.add(levels_row(of, kind));
    report.add(first_pixel_row(of));
}

}  // namespace

void run_scenes(Report& report)
{
    std::vector<WholeScene> all;
    all.push_back(furnished_room());
    all.push_back(level_of_rooms());
    all.push_back(many_objects());
    all.push_back(crowd_of_cages());
    all.push_back(figure_with_hair());
    const std::size_t own = all.size();
    for (WholeScene& shared : shared_scenes()) all.push_back(std::move(shared));
    for (WholeScene& scene : all)
        if (report.wants(scene.name)) run_scene(report, scene);
    if (all.size() == own) report.add({"scenes", "shared scenes", {}, "skipped: no shared data (set OCCAM_SHARED)"});
}

}  // namespace occam::bench
