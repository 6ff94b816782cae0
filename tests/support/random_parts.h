// The objects of a random case, as they are added to a scene, and how they move (random_case.h).
#pragma once

#include "tests/support/random_case.h"

namespace occam::test {

/// Holds what of an added part may move.
struct AddedPart {
    RandomPart part;
    NodeId node, joint;  ///< joint: the one that bends it, if it is skinned
    CageId cage;
    Mat4d place;
    std::vector<NodeId> swarm;  ///< instances that fly apart
};

/// Returns the middle of the world of a case.
Vec3d origin_of(const RandomCase& c);
/// Adds a part as its features say, below the root.
AddedPart add_part(Scene& scene, const RandomCase& c, const RandomPart& part);
/// Moves a part to where it is at a moment of the shutter, in one of several ways.
void move_part(Scene& scene, const RandomCase& c, const AddedPart& added, double tau);
/// Moves the instances of a part that fly apart, each along a path with a bend.
void move_swarm(Scene& scene, const RandomCase& c, const AddedPart& added, double tau);

}  // namespace occam::test
