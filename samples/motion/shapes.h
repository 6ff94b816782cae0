// The shapes that the cart and the runner are made of: small control cages of smooth surfaces.
#pragma once

#include <occam/occam.h>

namespace sample {

/// Returns a surface of revolution about y. Each point of the profile is (radius, y), from the lowest to the highest; the
/// ends are closed.
occam::Cage turned(const std::vector<occam::Vec2f>& profile, int around, occam::MaterialId material);

/// Returns a limb: it hangs from the origin down to y = -length, and is thicker at the top.
occam::Cage limb(float length, float top_radius, float bottom_radius, occam::MaterialId material);

/// Returns a ring about z.
occam::Cage ring(float radius, float thickness, occam::MaterialId material);

/// Returns a box about the origin whose edges are rounded.
occam::Cage rounded_box(occam::Vec3f size, occam::MaterialId material);

}  // namespace sample
