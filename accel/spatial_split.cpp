#include "accel/spatial_split.h"

#include <algorithm>
#include <limits>

#include "accel/triangle_part.h"

namespace occam::accel {
namespace {

using lod::BoxedFace;

// Three axes, 16 bins and all parts make trees that save rays two per cent more, and cost three times as much.
constexpr int kBins = 8;
constexpr std::size_t kSamples = 64;  // number of parts by which a plane is chosen

struct Plane {
    int axis = -1;
    float at = 0, cost = std::numeric_limits<float>::infinity();
};

// Returns whether parts of a triangle may have boxes of their own. A sliver may not: rounding may move the point that a ray
// hits along it by eps times its length over its width (accel/triangle_tree.cpp).
bool may_split(const TriangleCorners& corners, std::uint32_t face) noexcept
{
    constexpr float kLeastWidth = 0x1p-11f;  // as a share of the longest edge
    for (std::size_t key = 0; key < corners.at_keys.size(); key += corners.middle.size()) {
        const Vec3f* p = &corners.at_keys[key + std::size_t(face) * 3];
        const Vec3f a = p[1] - p[0], b = p[2] - p[0], c = p[2] - p[1];
        const float longest = std::max(glm::dot(a, a), std::max(glm::dot(b, b), glm::dot(c, c)));
        if (!(glm::length(glm::cross(a, b)) > longest * kLeastWidth)) return false;
    }
    return true;
}

// Cuts a box around a part of a triangle at a plane; both sides still hold what they held of the triangle. It is quick and
// may leave the boxes larger than needed, since it only serves to choose a plane.
void cut(const Box3f& whole, const Vec3f* triangle, int axis, float plane, Box3f& below, Box3f& above) noexcept
{
    below = above = {};
    for (int i = 0; i < 3; ++i) {
        const Vec3f &a = triangle[i], &b = triangle[i < 2 ? i + 1 : 0];
        if (a[axis] <= plane) below.add(a);
        if (a[axis] >= plane) above.add(a);
        if ((a[axis] < plane) == (b[axis] < plane)) continue;
        Vec3f p = a + (b - a) * ((plane - a[axis]) / (b[axis] - a[axis]));
        p[axis] = plane;
        below.add(p);
        above.add(p);
    }
    below = {glm::max(below.lo, whole.lo), glm::min(below.hi, whole.hi)};
    above = {glm::max(above.lo, whole.lo), glm::min(above.hi, whole.hi)};
}

struct Bin {
    Box3f box;
    std::size_t begin = 0, end = 0;  ///< numbers of parts that begin and end here
};

// Tries all planes between the bins of an axis.
void try_axis(std::span<const BoxedFace> parts, const TriangleCorners& corners, const Box3f& all, int axis,
              std::size_t spare, Plane& best)
{
    const float from = all.lo[axis], width = all.extent()[axis] / float(kBins), scale = 1 / width;
    if (!(scale < std::numeric_limits<float>::max()) || !(width > 0)) return;
    const auto bin_of = [&](float x) {
        const float bin = (x - from) * scale;  // NaN belongs to the first bin
        return bin > 0 ? bin < float(kBins) ? static_cast<int>(bin) : kBins - 1 : 0;
    };
    const auto plane_below = [&](int bin) { return from + width * float(bin); };
    Bin bins[kBins];
    const std::size_t step = (parts.size() + kSamples - 1) / kSamples;
    for (std::size_t at = 0; at < parts.size(); at += step) {
        const BoxedFace& part = parts[at];
        int b = bin_of(part.box.lo[axis]);
        const int last = std::max(b, bin_of(part.box.hi[axis]));
        bins[b].begin += step;
        bins[last].end += step;
        Box3f rest = part.box, here;
        for (; b < last; ++b) {
            Box3f next;
            cut(rest, corners.of(part.face), axis, plane_below(b + 1), here, next);
            bins[b].box.add(here);
            rest = next;
        }
        bins[last].box.add(rest);
    }
    struct Side {
        Box3f box;
        std::size_t count = 0;
        float cost() const noexcept { return count == 0 ? 0.0f : box.half_area() * blocks_of(count); }
    } above[kBins + 1], below;
    for (int b = kBins - 1; b > 0; --b) {
        above[b] = above[b + 1];
        above[b].box.add(bins[b].box);
        above[b].count += bins[b].end;
    }
    for (int b = 1; b < kBins; ++b) {
        below.box.add(bins[b - 1].box);
        below.count += bins[b - 1].begin;
        if (below.count == 0 || above[b].count == 0 || below.count + above[b].count > parts.size() + spare) continue;
        const float cost = below.cost() + above[b].cost();
        if (cost < best.cost) best = {axis, plane_below(b), cost};
    }
}

// Puts a part on both sides, or on the only one where something of it is.
void divide(const BoxedFace& part, const TriangleCorners& corners, const Plane& plane, SpatialParts& to)
{
    const int axis = plane.axis;
    if (part.box.lo[axis] < plane.at && part.box.hi[axis] > plane.at && may_split(corners, part.face)) {
        TrianglePart below(corners.of(part.face));
        below.cut_to(part.box);
        TrianglePart above = below;
        below.cut_above(axis, plane.at);
        above.cut_below(axis, plane.at);
        if (!below.is_empty() && !above.is_empty()) {
            to.below.push_back({below.box(), part.face});
            to.above.push_back({above.box(), part.face});
            return;
        }
    }
    (part.box.lo[axis] + part.box.hi[axis] < 2 * plane.at ? to.below : to.above).push_back(part);
}

}  // namespace

bool split_in_space(std::span<const BoxedFace> parts, const TriangleCorners& corners, float below_cost, std::size_t spare,
                    SpatialParts& to)
{
    Box3f all;
    for (const BoxedFace& part : parts) all.add(part.box);
    const Vec3f e = all.extent();
    const int longest = e.x >= e.y && e.x >= e.z ? 0 : e.y >= e.z ? 1 : 2;
    Plane best;
    try_axis(parts, corners, all, longest, spare, best);
    if (!(best.cost < below_cost)) return false;
    to.below.clear();
    to.above.clear();
    for (const BoxedFace& part : parts) divide(part, corners, best, to);
    const auto cost = [](const std::vector<BoxedFace>& side) {
        Box3f box;
        for (const BoxedFace& part : side) box.add(part.box);
        return box.half_area() * blocks_of(side.size());
    };
    return !to.below.empty() && !to.above.empty() && to.below.size() + to.above.size() <= parts.size() + spare &&
           cost(to.below) + cost(to.above) < below_cost;
}

}  // namespace occam::accel
