// Cages with creases and corners of every sharpness on edges that are drawn, as modellers leave them: lines of creases end
// in darts, meet at vertices of any valence, and cross corners.
#pragma once

#include <cstdint>
#include <vector>

#include "scenegraph/cage.h"

namespace occam::test {

/// Returns the edges of a closed cage, each once, without sharpness.
std::vector<Crease> edges_of(const Cage& cage);

/// Returns the cage with creases and corners of 0.25 to 11.25 in steps of a quarter on some of its edges and vertices.
Cage creased(Cage cage, std::uint64_t seed);

/// Returns the cage with one sharpness on each edge by the chance of 1 / `one_in`, and on one vertex in twelve.
Cage creased_evenly(Cage cage, float sharpness, std::uint64_t one_in, std::uint64_t seed);

}  // namespace occam::test
