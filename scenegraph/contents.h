// What a node and its subtree hold besides boxes, so that a frame finds what it looks for (lights, surfaces that emit or
// transmit, displaced cages, the largest parts) without visiting the rest of the scene.
//
// They also tell how many surfaces lie one behind the other: instances of instances may be more than can be opened.
//
// Contents are brought up to date together with bounds: an edit marks its path to the root, and Scene::refit() sums them up.
//
// Threads  as Scene.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/box.h"
#include "base/error.h"
#include "scenegraph/poles.h"

namespace occam {

struct Contents {
    /// A mask of what a subtree may hold.
    using Kinds = std::uint16_t;
    enum Kind : Kinds {
        Lights = 1,       ///< a placed light
        Emitters = 2,     ///< a surface whose material has an emission that is not zero
        Passing = 4,      ///< a surface that light may pass straight on, but for the holes of a mask: see may_pass()
        OverLimit = 8,    ///< a surface whose material has a value beyond a limit (scenegraph/material_limits.h)
        Displaced = 16,   ///< a displaced cage
        Subdivided = 32,  ///< a cage that is diced: a subdivision surface, or a cage that is made on demand
        Masked = 64,      ///< a surface with an alpha mask, which may have holes
        Moving = 128,     ///< a node that moves or changes while the shutter is open, or whose cages or skin do
        Absorbing = 256   ///< a surface that bounds a body which absorbs light
    };

    Kinds kinds = 0;
    std::uint32_t widest = 0;             ///< most things that opening one node puts side by side
    std::uint32_t levels = 0;             ///< most nodes on a way down, the first one included
    std::uint32_t largest_face = 0;       ///< corners
    std::size_t derived_points = 0;       ///< the most that a pose of one cage keeps (scenegraph/large_parts.h)
    std::uint32_t deformed_vertices = 0;  ///< of the largest cage that a skin or morph targets deform
    std::uint32_t joints = 0;             ///< of the largest skin that a node wears
    std::uint32_t written_faces = 0;      ///< of the largest cage whose vertices move by keys of their own
    /// Lengths in the axes of the node that edges at poles do not exceed. Cages on demand have none, because nobody knows
    /// their faces.
    Poles poles;
    /// What is placed below counts by the number of surfaces that a ray meets in it times the size of its box in the axes of
    /// the node (Contents::size_of); this is the sum. See layers_in().
    double crossed = 0;
    double most_layers = 0;  ///< the largest layers_in() of the nodes
    /// The same for surfaces that light may pass: they count by the number of their own boxes that hold a point times the
    /// volume of the box around them all. See depth_in().
    double held = 0;
    double most_depth = 0;  ///< the largest depth_in() of the nodes
    /// The sum of the areas of the surfaces that light may pass, in the node's axes; those of a deformed cage count at rest.
    /// See passed_in().
    double passing_area = 0;
    double most_passed = 0;  ///< the largest passed_in() of the nodes
    /// The sum over all that is placed below of the terms that a frame may add up to pose the vertices: vertices times morph
    /// targets whose weight is not 0, and four for each set of joints that a vertex has; for each key of a shutter in which
    /// the weights change or the joints move.
    double pose_terms = 0;

    void add(const Contents& other) noexcept
    {
        kinds |= other.kinds;
        widest = std::max(widest, other.widest);
        levels = std::max(levels, other.levels);
        largest_face = std::max(largest_face, other.largest_face);
        derived_points = std::max(derived_points, other.derived_points);
        deformed_vertices = std::max(deformed_vertices, other.deformed_vertices);
        joints = std::max(joints, other.joints);
        written_faces = std::max(written_faces, other.written_faces);
        poles.add(other.poles);
        crossed += other.crossed;
        most_layers = std::max(most_layers, other.most_layers);
        held += other.held;
        most_depth = std::max(most_depth, other.most_depth);
        passing_area += other.passing_area;
        most_passed = std::max(most_passed, other.most_passed);
        pose_terms += other.pose_terms;
    }
    /// Adds what is placed below as a whole: `box` is its box in the axes of this node, and `own` its box in its own axes.
    /// stretch   the largest factor by which its placement lengthens anything
    void add_placed(const Contents& other, const Box3d& own, const Box3d& box, double stretch) noexcept
    {
        Contents placed = other;
        placed.poles = other.poles.scaled(stretch);
        placed.crossed = other.layers_in(own) * size_of(box);
        placed.held = other.depth_in(own) * volume_of(box);
        // Boxes grow where nodes turn and move, and surfaces do not.
        const double by_boxes = area_of(box) / area_of(own);
        placed.passing_area *= std::isfinite(by_boxes) ? std::min(stretch * stretch, by_boxes) : stretch * stretch;
        ++placed.levels;
        add(placed);
    }
    /// Returns about how many placed surfaces a ray meets that passes through the node's box somewhere: each surface counts
    /// by the size of its box, as in the surface area heuristic. It is 2^60 for that many instances in one place.
    double layers_in(const Box3d& box) const noexcept
    {
        const double layers = crossed / size_of(box);
        return std::isfinite(layers) ? layers : 1;  // boxes that overflow are refused or clipped elsewhere
    }
    /// Returns in about how many boxes of surfaces that light may pass a point of the node's box lies. A ray that goes on
    /// behind such a surface has to look at all of them again. It is 0 for a flat box.
    double depth_in(const Box3d& box) const noexcept
    {
        const double volume = volume_of(box), depth = held / volume;
        return volume > 0 && std::isfinite(depth) ? depth : 0;
    }
    /// Returns about how many surfaces that light may pass a ray meets which crosses the node's box somewhere. Each counts
    /// by its area, and so do those of a flat box: a ray has to be shaded at each of them. It is 0 for a box without an
    /// area.
    double passed_in(const Box3d& box) const noexcept
    {
        const double passes = passing_area / area_of(box);
        return std::isfinite(passes) ? passes : 0;
    }
    /// Returns half the area of a box.
    static double area_of(const Box3d& box) noexcept { return box.is_empty() ? 0 : box.half_area(); }
    static double volume_of(const Box3d& box) noexcept
    {
        if (box.is_empty()) return 0;
        const Vec3d e = box.extent();
        return e.x * e.y * e.z;
    }
    /// Returns a measure of how many rays meet a box. It is positive for flat boxes, too, and for points.
    static double size_of(const Box3d& box) noexcept
    {
        if (box.is_empty()) return 0;
        const Vec3d e = box.extent();
        return std::max((e.x + e.y + e.z) * (e.x + e.y + e.z), 1e-300);
    }
    bool has(Kinds any_of) const noexcept { return (kinds & any_of) != 0; }
    friend bool operator==(const Contents&, const Contents&) = default;
};

/// The most surfaces that a ray may have to meet in a node, by Contents::layers_in(); a frame with more is refused, since it
/// would not end.
inline constexpr double kMostLayers = 1 << 14;
/// The most boxes of surfaces that light may pass in which a point may lie, by Contents::depth_in(); a frame with more is
/// refused, since each ray starts again behind each of these surfaces.
inline constexpr double kMostDepth = 1 << 11;
/// The most surfaces that light may pass and that a ray may have to meet in a node, by Contents::passed_in(); a frame with
/// more is refused, since the ray is shaded at each of them.
inline constexpr double kMostPassed = 1 << 9;
/// The most terms that a frame may have to add up to pose vertices, by Contents::pose_terms; a frame with more is refused.
inline constexpr double kMostPoseTerms = 0x1p34;
/// The most placements that are listed one by one (of lights, of emitters, of displaced cages).
inline constexpr std::size_t kMostListed = std::size_t(1) << 22;

struct Node;
class Scene;
struct Cage;
/// How the faces of a cage lie in its box; each face counts by its own box, at rest: without morph targets and joints.
struct FaceLayers {
    /// What counts of those faces that light may pass.
    struct Passing {
        double held = 0;  ///< in how many boxes of faces a point of the cage's box lies, 1 at least if there is a face
        double area = 0;  ///< the sum of their areas at rest
    };
    double crossed = 1;            ///< how many surfaces a ray meets that passes through the cage's box, 1 at least
    Passing all{1, 0};             ///< of all faces
    std::vector<Passing> of_slot;  ///< of each material slot; empty if all faces are of the first one

    FaceLayers() = default;
    explicit FaceLayers(const Cage& cage) { measure(cage); }
    /// It needs no memory if the cage has as many slots as before.
    void measure(const Cage& cage);
    /// Returns what counts of the faces of those slots for which has(slot) is true.
    /// slots   the number of those for which it may be true
    template <class Has>
    Passing of_those(std::size_t slots, Has&& has) const
    {
        if (of_slot.empty()) return slots > 0 && has(std::size_t(0)) ? all : Passing();
        Passing sum;
        bool has_any = false;
        for (std::size_t slot = 0; slot < std::min(slots, of_slot.size()); ++slot) {
            if (!has(slot)) continue;
            has_any = true;
            sum.held += of_slot[slot].held;
            sum.area += of_slot[slot].area;
        }
        if (has_any) sum.held = std::max(1.0, sum.held);
        return sum;
    }
};

/// Throws Error, naming a node, if a ray may have to meet more than kMostLayers surfaces, or more than kMostPassed that
/// light may pass, if a point may lie in more than kMostDepth boxes of these, or if posing vertices takes more than
/// kMostPoseTerms. The scene must be refitted.
void check_layers(const Scene& scene);
/// Names a node for a message.
std::string naming(const Node& node);
/// Returns the error for a scene with more than kMostListed placements, of which `node` is one.
Error too_many_placements(const Node& node);

struct Material;

/// Transmission through a surface without a volume that is smoother than this does not scatter.
inline constexpr float kClearRoughness = 0.05f;
/// A body whose refractive index differs from 1 by no more than this does not bend light.
inline constexpr float kLeastBend = 1e-3f;
/// Returns true if the surface bounds a body that light passes straight on, whatever its roughness.
bool is_straight_body(const Material& material) noexcept;
/// Returns true if light may pass straight on through a surface of this material: it masks, blends, is clear glass or bounds
/// a body that does not bend light.
bool may_pass(const Material& material) noexcept;
/// Returns the kinds of Contents that a surface of this material is.
Contents::Kinds kinds_of(const Material& material) noexcept;

}  // namespace occam
