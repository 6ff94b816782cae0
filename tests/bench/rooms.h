// Scenes of triangle meshes as level designers make them: walls of two large triangles beside small props.
//
// The rules use no random source but a fixed hash, so every run has the same triangles.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "scenegraph/scene.h"

namespace occam::bench {

/// Holds a scene, a camera inside it, and the scene's triangles in world axes for the peer that it is compared with.
struct TriangleScene {
    std::string name;
    Scene scene;
    Camera camera;

    /// Returns three corners for each triangle of each visible placement. The scene must hold meshes alone.
    std::vector<Vec3f> triangles() const;
};

/// Returns a closed room of about 8,000 triangles in one mesh: a table, chairs, shelves with small things, and spheres.
TriangleScene furnished_room();
/// Returns a level of eight by eight such rooms with doors, in one mesh of about 60,000 triangles.
TriangleScene level_of_rooms();
/// Returns a hall with 3,000 instances of three small meshes.
TriangleScene many_objects();
/// Returns the game map and the garage of the shared data, as far as they are there, seen from their middles.
std::vector<TriangleScene> shared_triangle_scenes();

}  // namespace occam::bench
