// A tree over the placed lights of a scene with many of them, or over its emissive triangles, by which a point draws the
// lights that matter to it, and a ray finds those that it crosses.
//
// At each node one side is chosen by an estimate of what it gives to the point: power over squared distance, bounded
// cosines at the lights and at the point (Conty Estevez and Kulla 2018). The estimate of a node is zero only if no light in
// it gives anything, so that any sum of samples over their expected numbers is unbiased. Trees are built by the surface area
// orientation heuristic of the same paper. Suns have no place, and are not in the tree.
//
// Several lights are drawn for a point at once. The tree is first divided for the point into up to twice as many parts,
// always where most of the light may come from, and one light of each part is drawn. So the few lights near a point are
// parts of their own, which are sampled without any choice, and all that is far away is one part or a few (adaptive
// splitting in the same paper). From parts that give little a light is drawn by chance.
//
// Space    world axes, relative to an origin of the tree's own; floats.
// Memory   about 200 bytes a light.
// Threads  const after construction.
#pragma once

#include <array>
#include <cstdint>
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
    LightTree(std::span<const WorldLight> lights, std::size_t first);
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
    /// Calls visit(light) for every light whose box holds the point.
    template <class Visit>
    void for_boxes_around(Vec3d point, Visit&& visit) const;
    /// Returns whether found(light) is true for any light with an area that covers `share` or more of the squared sine that
    /// WorldLight::sine2_subtended() measures, as seen from the point.
    template <class Found>
    bool any_covering(Vec3d point, float share, Found&& found) const;

private:
    // What the estimate reads, for one light or for a subtree.
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
    struct Node {
        Emitter emitter;
        Vec3f centre{0};
        float radius2 = 0;  ///< of a ball around the box
        float sin_axis = 0;
        std::uint32_t left = 0;   ///< the right child follows it; 0: a leaf
        std::uint32_t light = 0;  ///< of a leaf
        std::uint32_t parent = 0;
    };
    struct Leaf {
        Emitter emitter;
        std::uint32_t light;
    };
    /// A node is split in the middle below this depth, so that stacks of a fixed size suffice.
    static constexpr int kDepth = 48, kMaxDepth = kDepth + 33;

    Emitter emitter_of(const WorldLight& light) const noexcept;
    Emitter emitter_of(const Triangle& triangle) const noexcept;
    void build(std::span<Leaf> leaves, std::size_t lights);
    static Emitter merged(const Emitter& a, const Emitter& b) noexcept;
    static float orientation_of(const Emitter& emitter) noexcept;
    std::size_t split(std::span<Leaf> leaves, int depth) const;
    void build(std::uint32_t node, std::span<Leaf> leaves, int depth);
    static float importance(const Node& node, const Receiver& receiver) noexcept;
    struct Part;
    class Parts;
    static Part part_of(const Node& node, std::uint32_t index, const Receiver& receiver) noexcept;
    Parts divide(const Receiver& receiver, int most) const noexcept;
    /// Draws one light from a subtree. Returns false if what was chosen turns out to give nothing.
    bool draw_below(std::uint32_t node, const Receiver& receiver, double number, Pick& pick) const noexcept;
    /// Returns whether found(light) is true for any light that is below nodes for which enters(node) is true.
    template <class Enters, class Found>
    bool any_leaf(Enters&& enters, Found&& found) const;
    static bool is_crossed(const Node& node, Vec3f origin, Vec3f inverse) noexcept;

    Vec3d origin_{0};
    std::uint32_t first_ = 0;
    std::vector<Node> nodes_;  ///< the root is the first
    static constexpr std::uint32_t kNone = ~0u;
    std::vector<std::uint32_t> leaf_of_;  ///< node of each light from first_ on; kNone for a black light
};

inline bool LightTree::is_crossed(const Node& node, Vec3f origin, Vec3f inverse) noexcept
{
    const Vec3f a = (node.emitter.box.lo - origin) * inverse, b = (node.emitter.box.hi - origin) * inverse;
    const Vec3f low = glm::min(a, b), high = glm::max(a, b);
    const float t_in = std::max({low.x, low.y, low.z, 0.0f}), t_out = std::min({high.x, high.y, high.z});
    return t_in <= t_out * (1 + 0x1p-20f);
}

template <class TrianglesOf>
LightTree::LightTree(std::size_t count, Vec3d origin, TrianglesOf&& triangles_of) : origin_(origin)
{
    std::vector<Leaf> leaves;
    for (std::size_t part = 0; part < count; ++part) {
        Emitter all;
        for (const Triangle& triangle : triangles_of(part)) {
            const Emitter e = emitter_of(triangle);
            if (e.power > 0) all = all.power > 0 ? merged(all, e) : e;
        }
        if (all.power > 0) leaves.push_back({all, static_cast<std::uint32_t>(part)});
    }
    build(leaves, count);
}

template <class Enters, class Found>
bool LightTree::any_leaf(Enters&& enters, Found&& found) const
{
    if (nodes_.empty()) return false;
    std::array<std::uint32_t, kMaxDepth> todo;
    int waiting = 0;
    todo[waiting++] = 0;
    while (waiting > 0) {
        const Node& node = nodes_[todo[--waiting]];
        if (!enters(node)) continue;
        if (node.left == 0) {
            if (found(node.light)) return true;
            continue;
        }
        todo[waiting++] = node.left + 1;
        todo[waiting++] = node.left;
    }
    return false;
}

template <class Visit>
void LightTree::for_boxes_around(Vec3d point, Visit&& visit) const
{
    const Vec3f at = relative(point);
    any_leaf(
        [&](const Node& node) {
            const Box3f& box = node.emitter.box;
            return !glm::any(glm::lessThan(at, box.lo)) && !glm::any(glm::greaterThan(at, box.hi));
        },
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
    any_leaf([&](const Node& node) { return node.emitter.reach2 > 0 && is_crossed(node, from, inverse); },
             [&](std::uint32_t light) {
                 visit(light);
                 return false;
             });
}

template <class Found>
bool LightTree::any_covering(Vec3d point, float share, Found&& found) const
{
    const Vec3f at = relative(point);
    return any_leaf(
        [&](const Node& node) {
            const Vec3f off = glm::max(glm::max(node.emitter.box.lo - at, at - node.emitter.box.hi), Vec3f(0));
            return node.emitter.reach2 > 0 && !(node.emitter.reach2 < share * 0.999f * glm::dot(off, off));
        },
        found);
}

}  // namespace occam::shade
