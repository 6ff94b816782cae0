// Closed rooms under a bright sky, and how many pixels of a picture from inside are lit.
#pragma once

#include <occam/occam.h>

#include <optional>

namespace occam::test {

/// A closed cage, and where a camera in it looks from and to.
struct Room {
    std::string name;
    Cage cage;
    Vec3d eye{0.13, 0.07, 0.11}, target{-0.4, 0.2, -1};
};

/// Returns boxes, cubes, poles, a prism and a torus.
std::vector<Room> rooms();
/// Returns rooms with walls at right angles or like a star. Floor and ceiling are single faces that are not convex.
std::vector<Room> rooms_with_concave_floors();
/// Returns a room whose walls meet at an angle of so many degrees. The camera looks at the edge where they do.
Room wedge(double degrees, Scheme scheme);
/// Returns a sphere of quads with two poles. Its vertices are moved in and out, and some of its edges are creased.
Cage lump(std::uint64_t seed);

/// How a room and the camera in it move while the shutter is open.
enum class Moves { Not, Slides, Turns, Grows, Bends };

/// What shines outside: a sky; point lights behind the walls, by a fiftieth of the way from the camera; or emissive panels
/// along the walls, by so little behind them that they barely do not touch. Lamps are for convex rooms, and panels for those
/// whose walls are flat, too. Nothing shines outside if there is a lamp at the camera's eye, which lights the room.
enum class Outside { Sky, Lamps, Panels, LampInside };

struct Look {
    float rate = 1;
    render::Lod lod = render::Lod::On;
    IntegratorKind integrator = IntegratorKind::Path;
    bool displaced = false;
    double scale = 1;
    std::optional<Trs> place{};  ///< instead of `scale`
    bool sheared = false;        ///< what is placed leans along x, as a matrix tells
    bool instanced = false;      ///< the room is one of three instances of a node that stands elsewhere
    bool crossed = false;        ///< the room is crossed by another instance of it
    Moves moves = Moves::Not;
    Outside outside = Outside::Sky;
    float lens = 0, focus = 0;  ///< radius and distance, in units of the room; 0: a pinhole camera
    bool parallel = false;      ///< the camera is orthographic
    TreeKind tree = TreeKind::Auto;
    bool veiled = false;  ///< sheets that let all light pass hang in the room and beyond its walls
    float field = 1.5f;   ///< vertical angle of the camera's view, radians
    int width = 24, height = 18, spp = 4;
};

/// Returns the number of pixels that are not black in a picture from inside the room, with a bright sky outside.
int lit_pixels(const Room& room, const Look& look);
/// Expects that no pixel of that picture is lit.
void expect_dark(const Room& room, const Look& look);

}  // namespace occam::test
