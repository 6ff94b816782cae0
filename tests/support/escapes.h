// Rays from inside a closed cage, aimed where surfaces leak: at T-vertices, vertices and edges, to an ulp (watertightness
// "With a level for each ray").
#pragma once

#include <string>

#include "accel/tracer.h"
#include "tests/support/diced_mesh.h"

namespace occam::test {

struct EscapeCount {
    std::uint64_t rays = 0, escaped = 0, not_finite = 0;
    std::uint64_t met_again = 0;  ///< of the escaped: those that have met the cage again from outside
    std::size_t starts = 0;       ///< points inside from which rays start; 0: nothing could be tested
    std::string replay;           ///< the first escapes, as origin and direction
};

/// Places the cage by `world_from_object` and shoots `rays` rays from inside, of which 45 % are aimed at T-vertices (if
/// there are any) and vertices, 15 % at edges, and the rest anywhere. `exponent` is the log2 of the largest rate of a patch,
/// and `textures` hold the texture of the cage's displacement.
EscapeCount count_escapes(const Cage& cage, const Mat4d& world_from_object, int exponent, std::uint64_t rays,
                          std::uint64_t seed, const TextureStore* textures = nullptr);

}  // namespace occam::test
