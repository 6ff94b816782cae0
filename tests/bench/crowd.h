// The crowd: N copies of a cage, each twisted anew every frame, over a floor under two square lights. So that anyone can
// repeat it, the rules are exact:
//
//   A cage is scaled to unit size (its box's longest side) about its box's centre. Copies stand on a square grid of
//   spacing 1.2 in the xz plane, row after row; the grid's extent is 1.2 times its side. Copy i at frame f is twisted about
//   y: the point (x, y, z) turns by 2 a y with a = 0.3 sin(0.7 f + i). The floor is a square at y = -0.6, twice the extent
//   wide. The camera stands at c (0.1, 0.45, -0.85) extents, and looks at the origin with a whole vertical angle of 45
//   degrees. Two square lights of 0.15 extent at (-0.7, 0.9, -0.3) and (0.8, 0.7, -0.5) extents look at the origin. Pictures
//   have 1024 x 1024 pixels.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "scenegraph/scene.h"

namespace occam::bench {

struct Recipe {
    const char* name;
    int primary;        ///< rays per pixel
    int shadow;         ///< rays for each primary ray that hits and each light
    float edge_pixels;  ///< target edge length of micropolygons
};
inline constexpr std::array<Recipe, 3> kRecipes{{{"fast", 1, 1, 4}, {"balanced", 4, 4, 2}, {"high", 8, 4, 1}}};

inline constexpr int kCrowdPixels = 1024;

struct SquareLight {
    Vec3d centre, towards;  ///< unit direction of emission
    Vec3d right, up;        ///< unit, along its sides
    double side;
};

struct Crowd {
    std::string name;
    Cage cage;  ///< unit size; at rest
    int copies = 0;
    double closeness = 1;  ///< c

    Crowd(std::string name, Cage cage, int copies, double closeness);

    int side() const noexcept;  ///< copies in a row
    double extent() const noexcept { return 1.2 * side(); }
    Vec3d place(int copy) const noexcept;
    Vec3d eye() const noexcept;
    std::array<SquareLight, 2> lights() const noexcept;
    std::array<Vec3f, 4> floor() const noexcept;
    /// Computes the vertices of a copy in its own axes.
    void twist(int copy, int frame, std::vector<Vec3f>& positions) const;
    std::size_t faces() const noexcept { return cage.face_count() * static_cast<std::size_t>(copies); }
};

}  // namespace occam::bench
