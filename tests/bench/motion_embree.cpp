// Rays in scenes that move, beside Embree with its own motion blur on the same micropolygons.
//
// 16 x 16 tori move, each its own way: by a tenth of their size or by four sizes in one segment, or by a quarter turn in
// eight. Ours move by their nodes (*placed*), or their vertices are written at each key (*written*); Embree has the vertices
// at each key. All rays see one level of each torus, and have the places and moments of a frame of eight samples.
// first_hits() is measured, which fills about what Embree fills. Embree traces single rays; ours travel as they do in a
// frame.

#include <cmath>
#include <cstring>
#include <map>
#include <stdexcept>

#include "lod/pose_cage.h"
#include "tests/bench/embree_mesh.h"
#include "tests/bench/subjects.h"
#include "tests/bench/suites.h"

namespace occam::bench {
namespace {

constexpr int kRuns = 3, kWidth = 160, kHeight = 160, kSide = 16, kSamples = 8;
constexpr std::size_t kMemoryBytes = std::size_t(3) << 30;

struct Motion {
    const char* name;
    int segments;
    double distance, turn;  ///< in sizes; in radians
};
constexpr Motion kMotions[] = {
    {"still", 0, 0, 0}, {"small", 1, 0.1, 0}, {"four sizes", 1, 4, 0}, {"eight segments", 8, 0, 1.5708}};

struct Stage {
    Scene scene;
    std::vector<NodeId> nodes;

    Stage(const Motion& motion, bool is_written)
    {
        const auto at = [&](int k, double tau) {
            const double way = 2.4 * k, far = motion.distance * 2.8 * tau;
            Trs trs;
            trs.translation = {3.0 * (k % kSide - kSide / 2) + far * std::cos(way), far * std::sin(way),
                               3.0 * (k / kSide - kSide / 2)};
            trs.rotation = {std::sin(0.5 * motion.turn * tau), 0, 0, std::cos(0.5 * motion.turn * tau)};
            return trs;
        };
        const Cage ring = torus(12, 8);
        CageId cage = scene.add(ring);
        for (int k = 0; k < kSide * kSide; ++k) {
            NodeDesc desc;
            if (is_written && k > 0) cage = scene.add(ring);
            if (!is_written) desc.place = at(k, 0);
            desc.cages = {cage};
            nodes.push_back(scene.add_node(scene.root(), std::move(desc)));
        }
        const auto pose = [&](double tau) {
            for (int k = 0; k < kSide * kSide; ++k) {
                const NodeId node = nodes[std::size_t(k)];
                if (!is_written) {
                    scene.set_transform(node, at(k, tau));
                    continue;
                }
                const Mat4d map = at(k, tau).matrix();
                std::vector<Vec3f> moved;
                for (const Vec3f p : ring.positions) moved.push_back(Vec3f(Vec3d(map * Vec4d(Vec3d(p), 1))));
                scene.write_vertices(scene.node(node).cages.front(), moved);
            }
        };
        if (motion.segments > 0) scene.record_shutter(motion.segments, pose);
        else if (is_written) pose(0);
        scene.refit();
    }
};

// A mesh of Embree's with vertices at several keys; equal vertices are shared.
class MovingEmbree : public EmbreeScene {
public:
    explicit MovingEmbree(const std::vector<std::vector<Vec3f>>& corners)
    {
        const auto less = [](Vec3f a, Vec3f b) { return std::memcmp(&a, &b, sizeof(Vec3f)) < 0; };
        std::map<Vec3f, unsigned, decltype(less)> known(less);
        std::vector<unsigned> indices, first;
        for (unsigned i = 0; i < corners[0].size(); ++i) {
            const auto [at, is_new] = known.try_emplace(corners[0][i], static_cast<unsigned>(first.size()));
            if (is_new) first.push_back(i);
            indices.push_back(at->second);
        }
        RTCGeometry mesh = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetGeometryTimeStepCount(mesh, static_cast<unsigned>(corners.size()));
        for (unsigned key = 0; key < corners.size(); ++key) {
            auto* vertices = static_cast<Vec3f*>(
                rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, key, RTC_FORMAT_FLOAT3, sizeof(Vec3f), first.size()));
            for (std::size_t v = 0; v < first.size(); ++v) vertices[v] = corners[key][first[v]];
        }
        void* to = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned),
                                           indices.size() / 3);
        std::memcpy(to, indices.data(), indices.size() * sizeof(unsigned));
        build(mesh);
    }

    void closest(std::vector<RTCRayHit>& rays) const
    {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        for (RTCRayHit& ray : rays) rtcIntersect1(scene(), &context, &ray);
    }
};

std::vector<RTCRayHit> for_embree(std::span<const accel::Ray> rays)
{
    std::vector<RTCRayHit> all(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const Vec3f origin(rays[i].origin), d = rays[i].direction;
        all[i].ray = {origin.x, origin.y, origin.z, rays[i].t_near, d.x, d.y, d.z, rays[i].time, rays[i].t_far, ~0u, 0, 0};
        all[i].hit.geomID = all[i].hit.primID = all[i].hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    }
    return all;
}

// Returns the corners of all micropolygons of a stage at each key, in world axes.
std::vector<std::vector<Vec3f>> all_micropolygons(const Stage& stage, int segments, lod::TopologyCache& topologies,
                                                  const lod::LevelSettings& levels)
{
    std::vector<std::vector<Vec3f>> keys(static_cast<std::size_t>(segments) + 1);
    for (const NodeId id : stage.nodes) {
        Arena arena;
        lod::DeformCounters counters;
        const Node& node = stage.scene.node(id);
        const CageSlot& slot = stage.scene.cage(node.cages.front());
        std::vector<Mat4d> matrices = stage.scene.world_from_node_keys(id);
        if (matrices.empty()) matrices = {stage.scene.world_from_node(id)};
        const lod::PosedCage& posed = lod::pose_cage({slot, node, id, nullptr, matrices, segments}, levels,
                                                     {topologies.get(slot), nullptr, arena, counters});
        for (std::size_t key = 0; key < keys.size(); ++key)
            for (const Vec3f p : micropolygons(posed, static_cast<int>(key)))
                keys[key].push_back(Vec3f(posed.anchor + Vec3d(p)));
    }
    return keys;
}

// What the still rows found, with which the others are compared: [camera, diffuse].
struct Rates {
    double ours[2]{}, embree[2]{}, ours_mb = 0, embree_mb = 0;
};

class Comparison {
public:
    Comparison(Report& report, const Motion& motion, bool is_written)
        : report_(report),
          motion_(motion),
          name_(std::string("beside Embree, ") + motion.name + (is_written ? ", written" : ", placed")),
          stage_(motion, is_written),
          camera_(Camera::look_at({0, 26, 40}, {0, 0, 0}, {0, 1, 0}, 0.9f), kWidth, kHeight),
          levels_(camera_.levels(0.5f))
    {
        levels_.mode = lod::LevelMode::PerInstance;
        levels_.motion_edges = 0;  // no key is left out
    }

    void run(Rates& still)
    {
        const std::vector<std::vector<Vec3f>> corners = all_micropolygons(stage_, motion_.segments, topologies_, levels_);
        const MovingEmbree embree(corners);
        const accel::Frame frame(stage_.scene, topologies_, levels_);
        accel::Tracer tracer(frame, kMemoryBytes);
        const std::vector<accel::Ray> rays = rays_of_a_frame(camera_, kWidth, kHeight, kSamples);
        std::vector<accel::SurfaceHit> hits(rays.size());
        trace_closest(tracer, rays, hits);
        const std::vector<accel::Ray> diffuse = diffuse_rays(rays, hits);
        for (int kind = 0; kind < 2; ++kind) add_row(kind == 0 ? rays : diffuse, kind, tracer, embree, still);
        Row row{"motion", name_ + ", memory"};
        const double ours_mb = 1e-6 * double(tracer.counters().peak_bytes), embree_mb = 1e-6 * double(embree.bytes);
        if (motion_.segments == 0) still.ours_mb = ours_mb, still.embree_mb = embree_mb;
        row.add("triangles", double(corners[0].size()) / 3).add("occam_mb", ours_mb).add("embree_mb", embree_mb);
        row.add("occam_over_still", ours_mb / still.ours_mb).add("embree_over_still", embree_mb / still.embree_mb);
        row.add("occam_build_and_dice_s", tracer.counters().build_seconds + tracer.counters().dice_seconds);
        report_.add(row.add("embree_build_s", embree.build_seconds));
    }

private:
    void add_row(const std::vector<accel::Ray>& rays, int kind, accel::Tracer& tracer, const MovingEmbree& embree,
                 Rates& still)
    {
        std::vector<accel::FirstHit> first(rays.size());
        const auto ours = [&] {
            for (std::size_t i = 0; i < rays.size(); i += kBatch) {
                const std::size_t count = std::min(kBatch, rays.size() - i);
                tracer.first_hits(std::span(rays).subspan(i, count), std::span(first).subspan(i, count));
            }
        };
        const std::vector<RTCRayHit> start = for_embree(rays);
        std::vector<RTCRayHit> theirs = start;
        ours();
        embree.closest(theirs);
        std::size_t disagree = 0;
        for (std::size_t i = 0; i < rays.size(); ++i)
            disagree += first[i].is_hit() != (theirs[i].hit.geomID != RTC_INVALID_GEOMETRY_ID);
        std::vector<double> seconds[2];
        for (int run = 0; run < kRuns; ++run) {
            seconds[0].push_back(repeat(1, ours).front());
            theirs = start;
            seconds[1].push_back(repeat(1, [&] { embree.closest(theirs); }).front());
        }
        const double mega = 1e-6 * double(rays.size());
        const auto fastest = [&](int whose) {
            return mega / *std::min_element(seconds[whose].begin(), seconds[whose].end());
        };
        if (motion_.segments == 0) still.ours[kind] = fastest(0), still.embree[kind] = fastest(1);
        Row row{"motion", name_ + (kind == 0 ? ", camera" : ", diffuse")};
        row.add("rays", double(rays.size())).add("disagree_hit_or_miss", double(disagree));
        row.add("occam_mrays_per_s", per(mega, seconds[0])).add("embree_mrays_per_s", per(mega, seconds[1]));
        row.add("occam_over_embree", ratios(seconds[1], seconds[0]));
        row.add("occam_over_own_still", fastest(0) / still.ours[kind]);
        report_.add(row.add("embree_over_own_still", fastest(1) / still.embree[kind]));
    }

    Report& report_;
    const Motion& motion_;
    std::string name_;
    Stage stage_;
    lod::TopologyCache topologies_;
    render::CameraRays camera_;
    lod::LevelSettings levels_;
};

}  // namespace

void run_motion_embree(Report& report)
{
    if (!report.wants("beside Embree")) return;
    for (const bool is_written : {false, true}) {
        Rates still;
        for (const Motion& motion : kMotions) Comparison(report, motion, is_written).run(still);
    }
}

}  // namespace occam::bench
