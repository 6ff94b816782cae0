// The suite measures closest and any hits on one thread with a tree that is already built, in turns with Embree on the same
// micropolygons.
//
// Occam's closest() also fills SurfaceHit (position in double, normals, curvature, texture coordinates, material), which
// Embree's does not, except where both are filled; its first_hits() fills distance, node and face, where Embree fills
// distance, ids, normal and barycentrics. Embree sees all micropolygons of the cage, but no gap triangles (they have no
// area). Embree's rays are laid out beforehand.

#include <cmath>

#include "accel/frame_state.h"
#include "tests/bench/embree_mesh.h"
#include "tests/bench/subjects.h"
#include "tests/bench/suites.h"

namespace occam::bench {
namespace {

constexpr int kRuns = 9, kWidth = 288, kHeight = 288;
constexpr std::size_t kMemoryBytes = std::size_t(1) << 30;

struct Turns {
    std::vector<double> occam, embree;
    std::vector<double> kd, bvh;  ///< one of them is occam
};

template <class Trace>
void in_batches(std::size_t rays, Trace&& trace)
{
    for (std::size_t i = 0; i < rays; i += kBatch) trace(i, std::min(kBatch, rays - i));
}

template <class Ours, class Theirs>
Turns in_turns(TreePair& trees, EmbreeRays& theirs, Ours&& trace_ours, Theirs&& trace_theirs)
{
    Turns turns;
    trace_ours(trees.kd);  // this builds everything that is lazy
    trace_ours(trees.bvh);
    for (int i = 0; i < kRuns; ++i) {
        turns.kd.push_back(repeat(1, [&] { trace_ours(trees.kd); }).front());
        turns.bvh.push_back(repeat(1, [&] { trace_ours(trees.bvh); }).front());
        theirs.reset();
        turns.embree.push_back(repeat(1, trace_theirs).front());
    }
    turns.occam = trees.usual == accel::TreeKind::Bvh ? turns.bvh : turns.kd;
    return turns;
}

Row row_of(const std::string& name, const Turns& turns, std::size_t rays)
{
    const double mega = 1e-6 * static_cast<double>(rays);
    Row row{"trace", name};
    row.add("rays", double(rays));
    row.add("occam_mrays_per_s", per(mega, turns.occam)).add("embree_mrays_per_s", per(mega, turns.embree));
    row.add("occam_over_embree", ratios(turns.embree, turns.occam));
    row.add("kd_mrays_per_s", per(mega, turns.kd)).add("bvh_mrays_per_s", per(mega, turns.bvh));
    row.add("bvh_over_kd", ratios(turns.kd, turns.bvh));
    return row;
}

void run_rays(Report& report, const std::string& name, TreePair& trees, const EmbreeMesh& mesh,
              std::span<const accel::Ray> rays, bool coherent)
{
    std::vector<accel::SurfaceHit> hits(rays.size());
    std::vector<std::uint8_t> occluded(rays.size());
    EmbreeRays theirs(mesh, rays, coherent);

    // A renderer shades one batch of hits before it asks for the next, so they stay in its caches.
    const auto batch_by_batch = [&](accel::Tracer& tracer) {
        in_batches(rays.size(), [&](std::size_t i, std::size_t n) { tracer.closest(rays.subspan(i, n), {hits.data(), n}); });
    };
    // For the same amount of work, everything that shading needs is filled from Embree's hits, too.
    std::vector<ShadedHit> shaded(kBatch);
    report.add(row_of(name + " closest, both filled",
                      in_turns(trees, theirs, batch_by_batch, [&] { theirs.closest_filled(shaded); }), rays.size()));
    const Turns closest = in_turns(trees, theirs, batch_by_batch, [&] { theirs.closest(); });
    trace_closest(trees.usual == accel::TreeKind::Bvh ? trees.bvh : trees.kd, rays, hits);
    std::size_t met = 0, other_answer = 0, other_distance = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const float t = theirs.t(i);
        met += hits[i].is_hit();
        if (hits[i].is_hit() != std::isfinite(t)) ++other_answer;
        else if (hits[i].is_hit() && std::abs(hits[i].t - t) > 1e-4f * t) ++other_distance;
    }
    report.add(row_of(name + " closest", closest, rays.size())
                   .add("hits", double(met))
                   .add("disagree_hit_or_miss", double(other_answer))
                   .add("disagree_in_t_by_1e-4", double(other_distance)));

    std::vector<accel::FirstHit> first(rays.size());
    const Turns found = in_turns(
        trees, theirs,
        [&](accel::Tracer& tracer) {
            in_batches(rays.size(), [&](std::size_t i, std::size_t n) {
                tracer.first_hits(rays.subspan(i, n), {&first[i], n});
            });
        },
        [&] { theirs.closest(); });
    std::size_t other_hit = 0;
    for (std::size_t i = 0; i < rays.size(); ++i)
        other_hit += first[i].t != hits[i].t || (first[i].is_hit() && first[i].face != hits[i].face);
    report.add(row_of(name + " first", found, rays.size()).add("disagree_with_closest", double(other_hit)));

    const Turns any = in_turns(
        trees, theirs, [&](accel::Tracer& tracer) { trace_occluded(tracer, rays, occluded); }, [&] { theirs.occluded(); });
    std::size_t disagree = 0, met_any = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        met_any += occluded[i];
        disagree += (occluded[i] != 0) != theirs.is_occluded(i);
    }
    report.add(
        row_of(name + " any", any, rays.size()).add("hits", double(met_any)).add("disagree_hit_or_miss", double(disagree)));
}

}  // namespace

void run_trace(Report& report)
{
    for (const auto& subject : usual_subjects(kWidth, kHeight)) {
        if (!report.wants(subject->name)) continue;
        const std::vector<accel::Ray> rays = subject->camera_rays();
        TreePair trees(subject->scene, subject->topologies, subject->frame->state().levels, kMemoryBytes);
        accel::Tracer& tracer = trees.usual == accel::TreeKind::Bvh ? trees.bvh : trees.kd;
        std::vector<accel::SurfaceHit> hits(rays.size());
        trace_closest(tracer, rays, hits);
        const std::vector<accel::Ray> diffuse = diffuse_rays(rays, hits);

        const std::vector<Vec3f> corners = micropolygons(subject->posed);
        const EmbreeMesh mesh(corners, subject->posed.anchor);
        run_rays(report, subject->name + " camera", trees, mesh, rays, true);
        run_rays(report, subject->name + " diffuse", trees, mesh, diffuse, false);
        Row row{"trace", subject->name + " scene"};
        row.add("embree_triangles", double(corners.size()) / 3).add("embree_build_s", mesh.build_seconds);
        row.add("occam_micropolygons", double(tracer.counters().micropolygons))
            .add("occam_build_s", tracer.counters().build_seconds);
        report.add(row.add("occam_dice_s", tracer.counters().dice_seconds));
    }
}

}  // namespace occam::bench
