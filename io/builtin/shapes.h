// Cages by rule: rings of vertices joined to tubes, boxes, and the floor. Faces run counter-clockwise seen from outside.
//
// All but the sheets are closed: every edge lies in two faces that run along it in opposite senses.
#pragma once

#include <string>
#include <vector>

#include "scenegraph/cage.h"

namespace occam::builtin {

/// A ring of a tube: centre + x cos + y sin. x cross y points along the tube; rings of one tube turn the same way.
struct Ring {
    Vec3f centre;
    Vec3f x, y;
    float sharpness = 0;  ///< of the edges along the ring
};

/// How the end of a tube is closed: one face of as many corners as the ring has, or triangles about a point.
enum class Cap { Face, Point };

/// Quads between neighbouring rings of `columns` vertices. UVs: u once around, v from 0 to 1 by the length of the profile.
Cage tube(std::string name, const std::vector<Ring>& rings, std::uint32_t columns, Cap first, Cap last);

/// The same with the last ring joined to the first; u and v each run from 0 to 1.
Cage closed_tube(std::string name, const std::vector<Ring>& rings, std::uint32_t columns);

/// A point of a lathe's profile.
struct Turn {
    float radius, y;
    float sharpness = 0;
};

/// Turned about the y axis. The profile starts at the bottom and may come back inside: a vessel. Its ends are closed at the
/// axis.
Cage lathe(std::string name, const std::vector<Turn>& profile, std::uint32_t columns, Cap first, Cap last);

/// Stands on y = 0, centred about the y axis. Each side is 3 x 3 quads; the outer ones are `margin` wide, so that the middle
/// stays flat and smooth edges are about as wide. The twelve edges have that sharpness. UVs: each side from 0 to 1.
Cage box(std::string name, Vec3f size, float margin, float sharpness);

/// A cube from whose sides grow six arms with knobs, of that length from the middle. Eight vertices of valence six.
Cage jack(std::string name, float length, float width);

/// A strip of floor over x in [-width / 2, width / 2], flat from z = front back to z = back. UVs are lengths in world units.
/// Open.
struct FloorSize {
    float width, front, back;
    std::uint32_t columns, rows;
};
Cage floor_sheet(std::string name, const FloorSize& size);

/// A backdrop: leaves the floor at z = front, bends upwards with `radius`, then stands upright to `height`. Open.
struct WallSize {
    float width, front, radius, height;
    std::uint32_t columns, rows;
};
Cage wall_sheet(std::string name, const WallSize& size);

}  // namespace occam::builtin
