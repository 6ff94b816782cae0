// What the objects of a random case look like, and what lights them (random_case.h).
#pragma once

#include "tests/support/case_random.h"

namespace occam::test {

/// Gives a cage or a mesh the material that the part's features ask for, with its textures and its displacement.
void paint(Cage& cage, Scene& scene, const RandomCase& c, const RandomPart& part);

/// Returns a light of any kind.
Light random_light(CaseRandom& random);

/// Adds the lights and the environment of the case.
/// origin   of the case's world
void light(Scene& scene, const RandomCase& c, Vec3d origin);

}  // namespace occam::test
