// Closed cages with a displacement, for tests that need no data.
#pragma once

#include <string>
#include <vector>

#include "io/texture/texture_store.h"
#include "scenegraph/scene.h"

namespace occam::test {

/// Holds a cage and the store of its displacement's texture.
struct DisplacedCage {
    DisplacedCage(std::string called, Cage of, float bound, std::uint64_t seed,
                  Displacement::Space space = Displacement::Space::Normal);

    std::string name;
    Cage cage;
    Scene scene;  ///< holds nothing but the texture
    TextureStore textures;
};

/// Replaces the texture of a displacement by one texel.
void set_texel(DisplacedCage& displaced, Vec3f texel);

/// Gives every face a chart of its own, so that each edge is a seam.
void add_charts(Cage& cage);

/// Gives a cage a skin of two joints, where the weight of the second joint grows with x. bent_joints() returns a pose of
/// them that bends and twists the cage.
void add_skin(Cage& cage);
std::vector<Mat4d> bent_joints();

/// Returns cages with creases, poles, n-gons and seams, by index. Noise of 64 x 64 texels that reaches the bound displaces
/// them; the last four are displaced by vectors, two in the object's axes and two in those of the surface.
DisplacedCage displaced_case(int index);
inline constexpr int kDisplacedCases = 10;

}  // namespace occam::test
