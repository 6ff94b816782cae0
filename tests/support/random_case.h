// Scenes with settings made from a seed, for tests that compare one way of rendering them with another.
//
// A case is a list of features. What a feature does in detail follows from the seed, so a case can be made smaller by taking
// features away while the rest stays as it was: shrunk() does that with a case that fails.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "occam/occam.h"

namespace occam::test {

/// Lists what may be special about one object of a case, as bits of RandomPart::features.
enum class PartFeature : unsigned {
    Noise,      ///< vertices are moved by up to 8 % of the cage's size
    Creases,    ///< some edges have a sharpness of 0.25 to 10, in steps of a quarter
    Corners,    ///< some vertices are sharp
    Hole,       ///< one face is invisible
    Fin,        ///< a triangle stands on an edge, which three faces then share
    Bilinear,   ///< the scheme is bilinear
    Triangles,  ///< the cage is rendered as it is, as triangles
    Displaced,  ///< a texture moves the surface along its normal
    Skinned,    ///< two joints bend it
    Mirrored,   ///< its matrix mirrors
    Stretched,  ///< its matrix scales axes differently
    Large,      ///< a thousand times the size of the others, and as far away
    Small,      ///< a thousandth of the size of the others
    Instanced,  ///< three instances stand beside it
    Textured,   ///< a texture gives its base colour
    Glass,      ///< light passes through it
    Metal,      ///< it reflects
    Holes,      ///< an alpha mask cuts holes into it
    Veil,       ///< a texture makes it transparent in places, instead of a mask
    Bumped,     ///< a texture tilts its normals
    Coated,     ///< it has a clear coat
    Sheen,      ///< it has the sheen of cloth
    Strokes,    ///< it is brushed
    Specular,   ///< its highlight has a colour, a strength and an index of refraction
    Body,       ///< it bounds a refracting body, which colours light
    Shining,    ///< it emits light
    Moving      ///< it moves while the shutter is open
};
inline constexpr unsigned kPartFeatures = 27;

/// Lists what may be special about the picture, as bits of RandomCase::settings.
enum class SettingFeature : unsigned {
    Path,          ///< path tracing of three bounces
    Ao,            ///< ambient occlusion; ignored if Path is set
    AtVertices,    ///< materials are looked up at vertices
    Frozen,        ///< secondary rays keep their level
    LodOff,        ///< one level for each cage; Frozen is then ignored
    Coarse,        ///< a shading rate of 3
    Fine,          ///< a shading rate of 0.5; ignored if Coarse is set
    Lens,          ///< the camera has a thin lens
    Orthographic,  ///< the camera's rays are parallel
    Far,           ///< everything is 10^5 units from the origin
    Still,         ///< no jitter
    Adaptive,      ///< tiles end early
    Cropped,       ///< a part of the frame
    OneSided,      ///< rays pass the backs of single-sided surfaces
    Layers,        ///< all layers beside the picture
    Environment,   ///< light from all around, mostly from an image with a bright texel
    Lamps,         ///< placed lights of all kinds, few or many
    LightSamples,  ///< three samples of each light
    Clamped,       ///< light that was scattered twice is limited
    Filtered,      ///< a wide reconstruction filter
    Rounds,        ///< the picture is made in rounds
    Shutter,       ///< the shutter is open, and the camera moves
    Swarm          ///< forty small instances of each part, which fly apart while the shutter is open
};
inline constexpr unsigned kSettingFeatures = 23;

struct RandomPart {
    std::uint32_t key = 0;  ///< its random numbers are those of this number and the case's seed
    unsigned features = 0;
    std::string cage;  ///< one of made_cages()

    bool has(PartFeature f) const noexcept { return features >> static_cast<unsigned>(f) & 1; }
    void remove(PartFeature f) noexcept { features &= ~(1u << static_cast<unsigned>(f)); }
};

struct RandomCase {
    std::uint64_t seed = 0;
    unsigned settings = 0;
    std::vector<RandomPart> parts;

    bool has(SettingFeature f) const noexcept { return settings >> static_cast<unsigned>(f) & 1; }
    void remove(SettingFeature f) noexcept { settings &= ~(1u << static_cast<unsigned>(f)); }
};

/// Makes a case of one to four parts.
RandomCase random_case(std::uint64_t seed);

Scene scene_of(const RandomCase& c);
Settings settings_of(const RandomCase& c);
Camera camera_of(const RandomCase& c, Scene& scene);

/// Returns everything that the case is made of as one line.
std::string description(const RandomCase& c);

/// Returns whether a frame was refused because it would not end, as docs/files.md says: some displacements are that steep.
/// What the checks below find in such a case is no fault.
bool is_hopeless(const Error& e);

/// A check returns what is wrong with a case, or an empty string.
using CaseCheck = std::function<std::string(const RandomCase&)>;

/// Removes parts and features from a failing case for as long as it still fails. Returns a case that passes whichever
/// further part or feature is removed.
RandomCase shrunk(RandomCase failing, const CaseCheck& check);

/// Renders the case by one thread, by several with a kd-tree each and with a common tree of boxes, and by two with half of
/// the memory that two would take, or with four times the least where that is more. The picture must be the same and every
/// sample finite.
std::string check_pictures(const RandomCase& c);

/// Counts what check_closedness() has tested.
struct Tested {
    std::size_t cages = 0;
    std::uint64_t rays = 0;
    std::size_t hopeless = 0;  ///< cases that were refused, in which nothing was tested
};

/// Sends `rays` rays from inside every closed cage of the case, where it is placed and as it is posed: none may escape.
/// tested   is added to, unless it is null
std::string check_closedness(const RandomCase& c, std::uint64_t rays, Tested* tested = nullptr);

}  // namespace occam::test
