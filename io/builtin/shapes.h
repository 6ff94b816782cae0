// Cages made by rule: rings of vertices joined to tubes, boxes, and the floor. Faces run counter-clockwise seen from
// outside.
//
// All cages but the sheets are closed: every edge lies in two faces, which run along it in opposite directions.
#pragma once

#include <string>
#include <vector>

#include "scenegraph/cage.h"

namespace occam::builtin {

/// Describes a ring of a tube: centre + x cos + y sin. x cross y points along the tube; all rings of one tube turn the same
/// way.
struct Ring {
    Vec3f centre;
    Vec3f x, y;
    float sharpness = 0;  ///< sharpness of the edges along the ring
};

/// Says how the end of a tube is closed: with one face of as many corners as the ring has, or with triangles about a point.
enum class Cap { Face, Point };

/// Returns a tube with quads between neighbouring rings of `columns` vertices. Of the UVs, u runs once around, and v runs
/// from 0 to 1 by the length of the profile.
Cage tube(std::string name, const std::vector<Ring>& rings, std::uint32_t columns, Cap first, Cap last);

/// Returns such a tube with the last ring joined to the first; u and v each run from 0 to 1.
Cage closed_tube(std::string name, const std::vector<Ring>& rings, std::uint32_t columns);

/// A point of a lathe's profile.
struct Turn {
    float radius, y;
    float sharpness = 0;
};

/// Returns a profile turned about the y axis. The profile starts at the bottom and may come back inside, as for a vessel.
/// Its ends are closed at the axis.
Cage lathe(std::string name, const std::vector<Turn>& profile, std::uint32_t columns, Cap first, Cap last);

/// Returns a box that stands on y = 0, centred about the y axis. Each side has 3 x 3 quads; the outer ones are `margin`
/// wide, so that the middle stays flat and smooth edges are about as wide. The twelve edges have the given sharpness. UVs
/// run from 0 to 1 on each side.
Cage box(std::string name, Vec3f size, float margin, float sharpness);

/// Returns a cube from whose sides six arms with knobs grow, of the given length from the middle. Eight vertices have
/// valence six.
Cage jack(std::string name, float length, float width);

/// Describes an open strip of floor over x in [-width / 2, width / 2], flat from z = front back to z = back. UVs are lengths
/// in world units.
struct FloorSize {
    float width, front, back;
    std::uint32_t columns, rows;
};
Cage floor_sheet(std::string name, const FloorSize& size);

/// Describes an open backdrop: it leaves the floor at z = front, bends upwards with `radius`, then stands upright to
/// `height`.
struct WallSize {
    float width, front, radius, height;
    std::uint32_t columns, rows;
};
Cage wall_sheet(std::string name, const WallSize& size);

}  // namespace occam::builtin
