// The suites of benchmarks: each measures one stage, with an error or a count beside the time.
#pragma once

#include "tests/bench/harness.h"

namespace occam::bench {

void run_import(Report& report);
void run_dice(Report& report);
void run_build(Report& report);
void run_trace(Report& report);
void run_scenes(Report& report);
void run_trees(Report& report);
void run_motion(Report& report);
void run_motion_flat(Report& report);     ///< belongs to run_motion()
void run_motion_embree(Report& report);   ///< belongs to run_motion()
void run_spatial_splits(Report& report);  ///< belongs to run_motion()
void run_light(Report& report);
void run_light_frames(Report& report);  ///< belongs to run_light()
void run_shade(Report& report);
void run_converge(Report& report);
void run_memory(Report& report);
void run_budgets(Report& report);  ///< belongs to run_memory()
void run_frame(Report& report);
void run_game(Report& report);
void run_first(Report& report);
void run_levels(Report& report);
void run_crowd(Report& report);
void run_hidden(Report& report);
void run_nodes(Report& report);
void run_edits(Report& report);
void run_lights(Report& report);
void run_figure11(Report& report);
void run_workers(Report& report);

struct Suite {
    const char* name;
    const char* summary;
    void (*run)(Report&);
};

inline constexpr Suite kSuites[] = {
    {"import", "an OBJ and a GLB file of 100 MB, beside the parser libraries alone", run_import},
    {"dice", "points with tangents of one patch, beside OpenSubdiv's Bfr", run_dice},
    {"build", "topology, lazy trees and grids of a large cage, from cold", run_build},
    {"trace", "closest and any hit on one thread, beside Embree on the same triangles", run_trace},
    {"scenes", "whole scenes: path, ambient occlusion, direct; levels on and off; beside Embree", run_scenes},
    {"trees", "whole frames in the kd-tree and in the tree of boxes, in turns", run_trees},
    {"lights", "10,000 lights beside the ten of them that matter: error at equal time", run_lights},
    {"motion", "rays in scenes that move: in both trees, over growing motion and defocus, and beside Embree", run_motion},
    {"light", "secondary rays by kind, with footprints and without; what shading and textures cost", run_light},
    {"shade", "materials looked up at vertices or at hits: counts, time, error; over shading rates and samples", run_shade},
    {"converge", "light with level of detail on and off at many samples, over shading rates", run_converge},
    {"memory", "bytes a resident micro-triangle; frames under parts of the memory that they take", run_memory},
    {"frame", "whole frames at 4 samples, with their error against 64", run_frame},
    {"game", "a sequence of small frames, all new: the game of the samples", run_game},
    {"levels", "level of detail of each ray, of each cage, and of a ray's origin: time, memory, difference", run_levels},
    {"first", "from the file to the first finished tile, 500,000 faces", run_first},
    {"crowd", "cages that all deform every frame, beside Embree rebuilding its own", run_crowd},
    {"hidden", "frames with 10^5 to 10^7 hidden faces that deform, beside the same without them", run_hidden},
    {"nodes", "frames with up to 10^6 hidden nodes in a flat list, beside ten", run_nodes},
    {"edits", "refitting after edits, in trees of 10^2 to 10^6 nodes", run_edits},
    {"workers", "one worker, two, eight, 32: trees of their own and shared ones, and what is built again", run_workers},
    {"figure11", "building 605,000 faces lazily, by hierarchy, by scanning: each switched on and off", run_figure11},
};

}  // namespace occam::bench
