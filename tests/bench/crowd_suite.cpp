// The suite renders a crowd that deforms every frame, beside Embree on the same cages and rays (crowd.h has the rules).
//
// The time of a frame is the wall time of everything from the application's edit to the last pixel. The two renderers take
// turns, frame by frame.
#include "tests/bench/crowd_embree.h"
#include "tests/bench/crowd_occam.h"
#include "tests/bench/subjects.h"
#include "tests/bench/suites.h"

namespace occam::bench {
namespace {

constexpr int kFrames = 3;

void run_case(Report& report, const Crowd& crowd, const Recipe& recipe)
{
    const std::string name = crowd.name + " x " + std::to_string(crowd.copies);
    if (!report.wants(name + " " + recipe.name)) return;
    OccamCrowd ours(crowd);
    EmbreeCrowd theirs(crowd);
    std::vector<double> frame, edit, cpu, peer, peer_cpu, peer_commit, peer_trace;
    std::uint64_t peer_rays = 0;
    for (int f = 0; f <= kFrames; ++f) {
        const double start = process_seconds();
        const double seconds = ours.render(f, recipe);
        const double between = process_seconds();
        const EmbreeCrowd::Frame other = theirs.render(f, recipe);
        const double end = process_seconds();
        if (f == 0) continue;  // the first frame makes what is kept from frame to frame
        cpu.push_back(between - start);
        peer_cpu.push_back(end - between);
        frame.push_back(seconds);
        edit.push_back(ours.edit_seconds());
        peer.push_back(other.edit_seconds + other.commit_seconds + other.trace_seconds);
        peer_commit.push_back(other.commit_seconds);
        peer_trace.push_back(other.trace_seconds);
        peer_rays = other.rays;
    }
    const FrameStats& s = ours.stats();
    Row row{"crowd", name};
    row.recipe = recipe.name;
    row.add("copies", crowd.copies).add("faces", double(crowd.faces())).add("frame_seconds", frame);
    row.add("rays", double(s.rays.total())).add("bytes", double(s.memory.arena_peak_bytes));
    row.add("micropolygons", double(s.built.micropolygons)).add("edit_seconds", edit);
    row.add("refit_seconds", s.seconds.refit)
        .add("build_seconds", s.seconds.build)
        .add("tessellate_seconds", s.seconds.tessellate);
    row.add("trace_seconds", s.seconds.trace).add("shade_seconds", s.seconds.shade).add("film_seconds", s.seconds.film);
    row.add("faces_touched", double(s.built.faces_touched))
        .add("grids", double(s.built.grids))
        .add("flushes", double(s.memory.flushes));
    row.add("embree_frame_seconds", peer).add("embree_commit_seconds", peer_commit).add("embree_trace_seconds", peer_trace);
    row.add("embree_rays", double(peer_rays)).add("embree_bytes", double(theirs.peak_bytes()));
    row.add("cpu_seconds", cpu).add("embree_cpu_seconds", peer_cpu);
    row.add("ratio", ratios(frame, peer)).add("cpu_ratio", ratios(cpu, peer_cpu));
    row.note =
        "cpu_: of all threads, what a busy machine disturbs least; frame, edit and refit: wall clock; stages from build to "
        "film: workers' seconds summed, of the last frame";
    report.add(std::move(row));
}

}  // namespace

void run_crowd(Report& report)
{
    const auto cage_of = [&](const char* file) {
        std::optional<Cage> cage = shared_cage(file);
        if (!cage) report.add({"crowd", file, {}, "skipped: no shared data (set OCCAM_SHARED)"});
        return cage;
    };
    if (const std::optional<Cage> cage = cage_of("subdiv/suzanne.obj"))
        for (const Crowd& crowd : {Crowd("suzanne", *cage, 64, 1), Crowd("suzanne", *cage, 1210, 0.3)})
            for (const Recipe& recipe : kRecipes) run_case(report, crowd, recipe);
    if (const std::optional<Cage> cage = cage_of("subdiv/chess/Queen.obj")) {
        const Crowd crowd("queen", *cage, 16, 1);
        for (const Recipe& recipe : kRecipes) run_case(report, crowd, recipe);
    }
}

}  // namespace occam::bench
