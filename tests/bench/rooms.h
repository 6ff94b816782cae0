// Whole scenes: rooms and levels of triangle meshes as level designers make them, with walls of two large triangles beside
// small props, a crowd of cages, a figure with clothes and hair, and scenes of the shared data.
//
// The rules use no random source but a fixed hash, so every run has the same triangles.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "lod/footprint.h"
#include "lod/topology_cache.h"
#include "scenegraph/scene.h"

namespace occam::bench {

/// Holds a scene and a camera that looks at it.
struct WholeScene {
    std::string name;
    Scene scene;
    Camera camera;

    /// Returns three corners in world axes for each triangle of each visible placement, for the peer that the scene is
    /// compared with: meshes and cages as they are posed. Cages are diced at the level that `levels` chooses for each.
    std::vector<Vec3f> triangles(lod::TopologyCache& topologies, lod::LevelSettings levels) const;
};

/// Returns a closed room of about 8,000 triangles in one mesh: a table, chairs, shelves with small things, and spheres.
WholeScene furnished_room();
/// Returns a level of eight by eight such rooms with doors, in one mesh of about 60,000 triangles.
WholeScene level_of_rooms();
/// Returns a hall with 3,000 instances of three small meshes.
WholeScene many_objects();
/// Returns 64 tori of quads, which are subdivided, over a floor under two square lights (tests/bench/crowd.h).
WholeScene crowd_of_cages();
/// Returns a figure of subdivision cages in clothes, which are thin shells over it, with 4,000 cards of hair.
WholeScene figure_with_hair();
/// Returns scenes of the shared data, as far as they are there: a game map and a garage, seen from their middles, a chess
/// set and a skinned knight.
std::vector<WholeScene> shared_scenes();

}  // namespace occam::bench
