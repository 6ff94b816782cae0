// Cages by rule: rings of vertices joined to tubes, boxes, and the floor. Faces run counter-clockwise seen from outside.
//
// All but sheet() are closed: every edge lies in two faces that run along it in opposite senses.
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

/// Turned about the y axis. The profile starts at the bottom and may come back inside: a vessel. Its ends are closed at the axis.
Cage lathe(std::string name, const std::vector<Turn>& profile, std::uint32_t columns, Cap first, Cap last);

/// Sharpness of the edges of a box, by where they lie.
struct BoxEdges {
    float bottom = kInfiniteSharpness, top = 0, upright = 0;
};

/// Stands on y = 0, centred about the y axis. Each side is 3 x 3 quads; the outer ones are `margin` wide, so that the middle
/// stays flat and round edges are about as wide. UVs: each side from 0 to 1.
Cage box(std::string name, Vec3f size, float margin, BoxEdges edges);

/// A cube from whose sides grow six arms with knobs, of that length from the middle. Eight vertices of valence six.
Cage jack(std::string name, float length, float width);

/// Floor and wall in one over x in [-width / 2, width / 2]: flat from z = front back to z = back, then bent upwards with that
/// radius, then upright to `height`. UVs are lengths in world units. Material slot 0: flat, 1: the rest. Open.
struct SheetSize {
    float width, front, back, radius, height;
    std::uint32_t columns, flat_rows, wall_rows;
};
Cage sheet(std::string name, const SheetSize& size);

}  // namespace occam::builtin
