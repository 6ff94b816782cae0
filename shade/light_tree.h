// A tree over the placed lights of a scene with many of them, or over its emissive triangles, by which a point draws the
// lights that matter to it, and a ray finds those that it crosses.
//
// The tree has nodes of up to eight children, whose importance for a point is estimated side by side, in lanes: power over
// squared distance, times the cosines at the lights and at the point (Conty Estevez and Kulla 2018), which are means over
// the child's box. The estimate of a child is zero only if no light in it gives anything, so that any sum of samples over
// their expected numbers is unbiased. Trees are built by the surface area orientation heuristic of the same paper. Suns have
// no place, and are not in the tree.
//
// Several lights are drawn for a point at once. The tree is first divided for the point into up to 71 parts,
// always where most of the light may come from, and one light of each part is drawn. So the few lights near a point are
// parts of their own, which are sampled without any choice, and all that is far away is one part or a few (adaptive
// splitting in the same paper). From parts that give little a light is drawn by chance.
//
// Space    world axes, relative to an origin of the tree's own; floats. Boxes are padded by what floats lose there, so the
//          origin is where the receivers are: a light that is very far from there needs no exact box.
// Memory   about 160 bytes a light.
// Threads  const after construction.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/box.h"
#include "shade/lights.h"

namespace occam::shade {

/// Describes the point that lights are chosen for.
struct Receiver {
    Vec3f point{0};  ///< relative to the tree's origin
    Vec3f normal{0, 0, 1};
    LightGroups groups = kAllGroups;
    bool is_two_sided = false;  ///< light from behind counts, too

    /// Returns the same receiver for lights of any group, as emissive surfaces are.
    Receiver of_all_groups() const noexcept
    {
        Receiver all = *this;
        all.groups = kAllGroups;
        return all;
    }
};

class LightTree {
public:
    struct Pick {
        std::uint32_t light;  ///< index in the list
        float expected;       ///< the number of picks of it that is to be expected of the draws; at most 1
        float rest;           ///< what the choice has left of the number: it is uniform in [0, 1) again
    };
    /// A triangle that shines to both sides.
    struct Triangle {
        Vec3d corner[3];
        double power;  ///< area times luminance
    };

    LightTree() = default;
    /// Makes a tree over the lights of the list from index `first` on, none of which may be a sun.
    /// middle   that of the scene; none: that of the lights
    LightTree(std::span<const WorldLight> lights, std::size_t first, std::optional<Vec3d> middle = {});
    /// Returns the origin of a tree over lights in a box: the middle of the box, unless a light is so far from the scene
    /// that floats would not tell those near it apart. Then it is a place near the middle of the scene, the same one while
    /// the scene moves by less than its size.
    static Vec3d origin_for(const Box3d& places, std::optional<Vec3d> middle) noexcept;
    /// Makes a tree over `count` parts of emissive surfaces, which triangles_of(part) returns until it is called again.
    template <class TrianglesOf>
    LightTree(std::size_t count, Vec3d origin, TrianglesOf&& triangles_of);

    bool is_empty() const noexcept { return nodes_.empty(); }
    Vec3d origin() const noexcept { return origin_; }
    Vec3f relative(Vec3d point) const noexcept { return Vec3f(point - origin_); }

    /// The largest number of lights that are drawn at once.
    static constexpr int kMostDraws = 16;
    /// Draws as many lights as there are places for picks, at most kMostDraws; `number` is uniform in [0, 1). Returns the
    /// number of picks, which is smaller where fewer lights give nearly all of the light, and where a part of the tree that
    /// was chosen turns out to give nothing.
    int draw(const Receiver& receiver, float number, std::span<Pick> picks) const noexcept;
    /// Returns the number of picks of a light that is to be expected of draw() with places for `draws` picks.
    float expected(std::uint32_t light, const Receiver& receiver, int draws) const noexcept;

    /// Calls visit(light) for every light with an area that the ray may cross.
    template <class Visit>
    void for_crossed(Vec3d origin, Vec3f direction, Visit&& visit) const;
    /// Calls visit(light) for every light whose box holds the point, or a place that is as near to it in each axis.
    template <class Visit>
    void for_boxes_around(Vec3d point, float within, Visit&& visit) const;
    /// Returns whether found(light) is true for any light with an area that covers `share` or more of the squared sine that
    /// WorldLight::sine2_subtended() measures, as seen from the point.
    template <class Found>
    bool any_covering(Vec3d point, float share, Found&& found) const;

private:
    /// The largest number of children of a node.
    static constexpr std::size_t kWide = 8;
    /// What the estimate reads, for one light or for a subtree.
    struct Emitter {
        Box3f box;  ///< of all that shines, padded against rounding
        float power = 0;
        Vec3f axis{0, 0, 1};  ///< of a cone that holds all directions of full brightness
        float cos_axis = 1;   ///< half angle of that cone
        float cos_fall = 1;   ///< beyond the cone, light falls to zero within this angle
        float range2 = 0;     ///< squared distance beyond which nothing arrives
        float reach2 = 0;     ///< largest squared radius of a light with an area; 0: there is none
        LightGroups groups = 0;
        bool is_two_sided = false;
    };
    struct Leaf {
        Emitter emitter;
        std::uint32_t light;
    };
    /// The children of a node: parallel rows, with a column for each child.
    struct alignas(32) Node {
        float middle[3][kWide]{}, half[3][kWide]{};  ///< of the child's box
        float power[kWide]{};                        ///< 0: there is no such child
        float axis[3][kWide]{}, cos_axis[kWide]{}, sin_axis[kWide]{};
        float cos_end[kWide]{};  ///< beyond this angle from the axis nothing shines; a bound
        float range2[kWide]{}, reach2[kWide]{};
        float is_two_sided[kWide]{};  ///< 1 or 0
        float is_subtree[kWide]{};    ///< 1, or 0 for a light
        LightGroups groups[kWide]{};
        std::uint32_t below[kWide]{};  ///< a node, or a light
        std::uint32_t place = 0;       ///< of this node in its parent
        std::uint32_t children = 0;
        bool has_groups = false;  ///< some light below lights certain groups only
    };
    /// A child of a node: the index of the node times kWide, plus its column.
    using Place = std::uint32_t;
    /// What the children of a node give to a receiver, and how much of it is in doubt.
    struct Estimates {
        alignas(32) float light[kWide]{};
        alignas(32) float doubt[kWide]{};
        float sum() const noexcept;
    };
    /// Leaves are cut in two halves of equal numbers below this depth of cuts, so that stacks of a fixed size suffice.
    static constexpr int kDepth = 48, kMaxDepth = kDepth + 33;

    Emitter emitter_of(const WorldLight& light) const noexcept;
    Emitter emitter_of(const Triangle& triangle) const noexcept;
    static Emitter merged(std::span<const Emitter> parts) noexcept;
    void build(std::span<const Leaf> leaves, std::size_t lights);
    class Builder;
    bool is_light(Place place) const noexcept { return !(nodes_[place / kWide].is_subtree[place % kWide] > 0); }
    std::uint32_t below(Place place) const noexcept { return nodes_[place / kWide].below[place % kWide]; }

    static void estimate(const Node& node, const Receiver& receiver, Estimates& to) noexcept;
    class Parts;
    Parts divide(const Receiver& receiver, int draws) const noexcept;
    /// Draws one light from the subtree of a node. Returns false if nothing in it gives any light.
    bool draw_below(std::uint32_t node, const Receiver& receiver, double number, Pick& pick) const noexcept;

    /// Returns whether found(light) is true for any light that enters(node) lets in, which returns a bit for each child.
    template <class Enters, class Found>
    bool any_leaf(Enters&& enters, Found&& found) const;
    // These return a bit for each child: one with an area that the ray may cross, one whose box holds the point or comes
    // near it, and one that may cover a share of the squared sine.
    static unsigned crossed(const Node& node, Vec3f origin, Vec3f inverse) noexcept;
    static unsigned around(const Node& node, Vec3f at, float within) noexcept;
    static unsigned covering(const Node& node, Vec3f at, float share) noexcept;

    Vec3d origin_{0};
    std::uint32_t first_ = 0;
    std::vector<Node> nodes_;  ///< the root is the first
    static constexpr Place kNowhere = ~Place(0);
    std::vector<Place> place_of_;  ///< of each light from first_ on; kNowhere for a black light
};

template <class TrianglesOf>
LightTree::LightTree(std::size_t count, Vec3d origin, TrianglesOf&& triangles_of) : origin_(origin)
{
    std::vector<Leaf> leaves;
    std::vector<Emitter> of_part;
    for (std::size_t part = 0; part < count; ++part) {
        of_part.clear();
        for (const Triangle& triangle : triangles_of(part))
            if (const Emitter e = emitter_of(triangle); e.power > 0) of_part.push_back(e);
        if (!of_part.empty()) leaves.push_back({merged(of_part), static_cast<std::uint32_t>(part)});
    }
    build(leaves, count);
}

template <class Enters, class Found>
bool LightTree::any_leaf(Enters&& enters, Found&& found) const
{
    if (nodes_.empty()) return false;
    struct Level {
        std::uint32_t node;
        unsigned left;  ///< bits of the children that are still to be visited
    };
    std::array<Level, kMaxDepth> levels{};
    int depth = 0;
    levels[0] = {0, enters(nodes_[0])};
    while (depth >= 0) {
        Level& at = levels[static_cast<std::size_t>(depth)];
        if (at.left == 0) {
            --depth;
            continue;
        }
        const auto child = static_cast<std::uint32_t>(std::countr_zero(at.left));
        at.left &= at.left - 1;
        const Place place = at.node * std::uint32_t(kWide) + child;
        if (is_light(place)) {
            if (found(below(place))) return true;
        } else {
            levels[static_cast<std::size_t>(++depth)] = {below(place), enters(nodes_[below(place)])};
        }
    }
    return false;
}

template <class Visit>
void LightTree::for_boxes_around(Vec3d point, float within, Visit&& visit) const
{
    const Vec3f at = relative(point);
    any_leaf([&](const Node& node) { return around(node, at, within); },
             [&](std::uint32_t light) {
                 visit(light);
                 return false;
             });
}

template <class Visit>
void LightTree::for_crossed(Vec3d origin, Vec3f direction, Visit&& visit) const
{
    if (nodes_.empty()) return;
    const Vec3f from = relative(origin);
    Vec3f inverse;
    // Without zeros there is no product of zero and infinity.
    for (int i = 0; i < 3; ++i)
        inverse[i] = 1 / (std::fabs(direction[i]) < 1e-18f ? std::copysign(1e-18f, direction[i]) : direction[i]);
    any_leaf([&](const Node& node) { return crossed(node, from, inverse); },
             [&](std::uint32_t light) {
                 visit(light);
                 return false;
             });
}

template <class Found>
bool LightTree::any_covering(Vec3d point, float share, Found&& found) const
{
    const Vec3f at = relative(point);
    return any_leaf([&](const Node& node) { return covering(node, at, share); }, found);
}

}  // namespace occam::shade
