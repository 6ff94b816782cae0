// Closed cages with a displacement, for tests that need no data.
#pragma once

#include <string>
#include <vector>

#include "io/texture/texture_store.h"
#include "scenegraph/scene.h"

namespace occam::test {

/// A cage and the store that its displacement's texture lies in.
struct DisplacedCage {
    DisplacedCage(std::string called, Cage of, float bound, std::uint64_t seed,
                  Displacement::Axes axes = Displacement::Axes::Normal);

    std::string name;
    Cage cage;
    Scene scene;  ///< of the texture alone
    TextureStore textures;
};

/// A chart of its own for every face: each edge is a seam.
void add_charts(Cage& cage);

/// Gives a cage a skin of two joints, the second one's weight growing with x; and a pose of them that bends and twists.
void add_skin(Cage& cage);
std::vector<Mat4d> bent_joints();

/// Over creases, poles, n-gons and seams; noise of 64 x 64 texels that goes to the bound, the last four by vectors: two in
/// the object's axes, two in those of the surface. Named by index.
DisplacedCage displaced_case(int index);
inline constexpr int kDisplacedCases = 10;

}  // namespace occam::test
