// The points that determine how much room a scene takes in a picture.
//
// Meshes give their vertices. Cages give the control points of a refined cage, whose convex hull holds the limit surface and
// fits it far more closely than the hull of the original cage.
//
// Space    world.
// Memory   the points of cages and meshes in object axes, those of refined cages at most about two million; of refined cages
//          that are deformed the connectivity instead. All of it is kept until this object is destroyed.
// Threads  one.
#pragma once

#include <functional>
#include <memory>

#include "scenegraph/scene.h"

namespace occam::lod {

class Extent {
public:
    Extent();
    ~Extent();

    /// Calls `visit` with points whose convex hull holds all that rays of the camera can hit, in the scene's current pose.
    /// Bounds must be up to date (Scene::refit()). Vertices that no visible face uses are left out. Those of holes, and of
    /// the outermost faces with BoundaryRule::None, pull at the faces beside them all the same, so that a face that is
    /// concave there may reach out of the hull by a small part of what they stand out.
    void visit_points(const Scene& scene, const std::function<void(Vec3d)>& visit);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace occam::lod
