// Intersects rays with a mesh igrid, through its tree of eight-wide boxes (accel/triangle_tree.h).
//
// A single ray tests eight boxes, then eight triangles, at once, and goes to the nearest box first. A packet is tested
// against the boxes of a node as one ray; the rays that enter a box go on together, and where few are left each goes on
// alone. Both ways run the same operations on the same numbers for each pair of a ray and a triangle.
//
// Query and Coordinates are as in accel/igrid_intersect.h.
#pragma once

#include <bit>
#include <cmath>
#include <utility>

#include "accel/gap_triangles.h"
#include "accel/in_box.h"
#include "accel/packet.h"
#include "accel/triangle.h"

namespace occam::accel {

/// Tells a query how many triangles it was tested against, if it counts them.
template <class Query>
OCCAM_ALWAYS_INLINE void count_tests(Query& query, int triangles) noexcept
{
    if constexpr (requires { query.tested(triangles); }) query.tested(triangles);
}

/// Refers to the rays that meet an igrid, in the frame of its cage: a packet, or one ray in all lanes.
struct RaysInGrid {
    const RayLanes& lanes;
    const bool (&negative)[3];  ///< the signs of their directions
    const RaySpan& span;        ///< where they are in its item
};

template <class Query, class Coordinates = StillCoordinates>
class TriangleTracer {
public:
    TriangleTracer(IGrid& grid, const RaysInGrid& rays, Query& query, const Coordinates& read = {})
        : grid_(grid),
          ray_(rays.lanes),
          span_(rays.span),
          query_(query),
          read_(read),
          nodes_(grid.mesh().triangles.nodes + std::size_t(read.key()) * grid.mesh().triangles.node_count),
          blocks_(grid.mesh().triangles.blocks + std::size_t(read.key()) * grid.mesh().triangles.block_count),
          axes_{ray_.kx, ray_.ky, ray_.kz}
    {
        for (int a = 0; a < 3; ++a) {
            near_[a] = (rays.negative[a] ? a + 3 : a) * kWidth;
            far_[a] = (rays.negative[a] ? a : a + 3) * kWidth;
        }
    }

    /// Each lane holds one ray. as_one() returns them all as one ray, in the cage's frame.
    template <class AsOne>
    void packet(vmask active, AsOne&& as_one) noexcept
    {
        const auto& rays = as_one();
        struct Todo {
            vmask alive;
            float begin;  ///< where the first of the rays enters
            std::uint32_t child;
        };
        Todo todo[kMostTodo];
        int size = 0;
        todo[size++] = {active, -FLT_MAX, 0};
        while (size > 0) {
            const Todo next = todo[--size];
            const unsigned lanes = bits(next.alive);
            if (std::popcount(lanes) < kWorthAPacket) {
                for (unsigned left = lanes; left != 0; left &= left - 1)
                    single_of_packet(next.child, std::countr_zero(left));
                continue;
            }
            if (TriangleNode::is_block(next.child)) {
                const std::uint32_t block = TriangleNode::block_of(next.child);
                if (std::popcount(lanes) < kWorthAllTriangles) triangles_in_turn(block, lanes);
                else triangles_packet(block, next.alive);
                continue;
            }
            const TriangleNode& node = nodes_[next.child];
            alignas(32) float begin[kWidth];
            const int base = size;
            const vfloat end = limit();
            for (unsigned maybe = as_one_in_boxes(rays, node, next.alive, begin); maybe != 0; maybe &= maybe - 1) {
                const int i = std::countr_zero(maybe);
                const vmask here = next.alive & in_box_at(node.boxes + i, end);
                if (none(here)) continue;
                int at = size++;
                for (; at > base && todo[at - 1].begin < begin[i]; --at) todo[at] = todo[at - 1];
                todo[at] = {here, begin[i], node.children[i]};
            }
        }
    }

    /// All lanes hold ray `lane` of the query.
    void single(int lane) noexcept
    {
        const VecLanes origin{ray_.origin[axes_[0]], ray_.origin[axes_[1]], ray_.origin[axes_[2]]};
        nearest_first(0, {{ray_, origin, span_, read_, lane}, BoxRay(ray_, span_)});
    }

private:
    static constexpr int kWidth = TriangleNode::kWidth;
    /// The number of live rays below which each is tested against all triangles of a block at once.
    static constexpr int kWorthAllTriangles = kLanes - 1;
    static constexpr int kMostTodo = TriangleTree::kMostDepth * (kWidth - 1) + 2;

    /// Holds what boxes are tested by, for one ray in all lanes. The interval in which the ray is in a box is widened by
    /// more than rounding: culling must never decide a hit (accel/in_box.h).
    struct BoxRay {
        vfloat origin[3], to_near[3], to_far[3], t_near, pad;
        float shift;

        BoxRay(const RayLanes& ray, const RaySpan& span) noexcept : shift(first_lane(ray.shift))
        {
            for (int a = 0; a < 3; ++a) {
                origin[a] = ray.origin[a];
                to_near[a] = ray.inverse[a] * vfloat(1 - 5 * FLT_EPSILON);
                to_far[a] = ray.inverse[a] * vfloat(1 + 5 * FLT_EPSILON);
            }
            // A factor widens no interval that ends before the origin: the padding does.
            const float from = first_lane(span.t_near) - shift;
            pad = 8 * FLT_EPSILON * (std::fabs(shift) + max(-from, 0.0f));
            t_near = from - 4 * FLT_EPSILON * (std::fabs(shift) + std::fabs(first_lane(span.t_near)));
        }
        /// Returns a limit on t as one on the distance to boxes.
        float end(float t) const noexcept { return (t - shift) + 4 * FLT_EPSILON * (std::fabs(t) + std::fabs(shift)); }
    };
    /// Holds what triangles are tested by, for one ray in all lanes.
    struct AtTriangles {
        const RayLanes& ray;
        const VecLanes& origin;  ///< along kx, ky, kz
        const RaySpan& span;
        const Coordinates& read;
        int lane;  ///< of the query
    };
    /// Holds one ray in all lanes.
    struct Alone : AtTriangles {
        const BoxRay& boxes;
    };

    vfloat limit() const noexcept { return min(query_.limit(), span_.t_end); }
    std::ptrdiff_t next_boxes() const noexcept { return grid_.mesh().triangles.node_floats_of_a_key(); }
    std::ptrdiff_t next_corners() const noexcept { return grid_.mesh().triangles.block_floats_of_a_key(); }

    /// Returns the parts of a node that the rays of a packet may enter, taken as one.
    template <class AsOne>
    unsigned as_one_in_boxes(const AsOne& rays, const TriangleNode& node, [[maybe_unused]] vmask alive,
                             float* begin) const noexcept
    {
        if constexpr (!Coordinates::kMove) return rays.in_boxes(node.boxes, FLT_MAX, begin);
        else {
            // These are boxes that hold the node's at the times of all these rays.
            alignas(32) float swept[6 * kWidth];
            const vfloat first = lowest(select(alive, read_.share(), 1.0f)),
                         last = highest(select(alive, read_.share(), 0.0f));
            for (int at = 0; at < 6 * kWidth; at += kLanes) {
                const vfloat here = vfloat::load(node.boxes + at), next = vfloat::load(node.boxes + at + next_boxes());
                const vfloat from = lod::between_keys(first, here, next), to = lod::between_keys(last, here, next);
                (at < 3 * kWidth ? min(from, to) : max(from, to)).store(swept + at);
            }
            return rays.in_boxes(swept, FLT_MAX, begin);
        }
    }
    vmask in_box_at(const float* box, vfloat end) const noexcept
    {
        const auto plane = [&](int row) { return read_.one(box + row, next_boxes()); };
        return in_box(ray_, {plane(near_[0]), plane(near_[1]), plane(near_[2])},
                      {plane(far_[0]), plane(far_[1]), plane(far_[2])}, span_.t_near, end);
    }

    void single_of_packet(std::uint32_t child, int lane) noexcept
    {
        const RayLanes ray = spread(ray_, lane);
        const VecLanes origin{ray.origin[axes_[0]], ray.origin[axes_[1]], ray.origin[axes_[2]]};
        const RaySpan span{spread(span_.t_near, lane), spread(span_.t_end, lane)};
        const Coordinates read = of_lane(read_, lane);
        const BoxRay boxes(ray, span);
        nearest_first(child, {{ray, origin, span, read, lane}, boxes});
    }
    static StillCoordinates of_lane(const StillCoordinates& all, int) noexcept { return all; }
    static MovingCoordinates of_lane(const MovingCoordinates& all, int lane) noexcept
    {
        return {all.key(), spread(all.share(), lane)};
    }

    /// Returns which parts of a node a ray enters before `end`, and where.
    OCCAM_ALWAYS_INLINE unsigned enter(const TriangleNode& node, const Alone& one, vfloat end, float* t) const noexcept
    {
        const BoxRay& ray = one.boxes;
        unsigned which = 0;
        for (int first = 0; first < kWidth; first += kLanes) {
            const auto at = [&](int row, int a, const vfloat& per_length) {
                return (one.read.many(node.boxes + row + first, next_boxes()) - ray.origin[a]) * per_length;
            };
            const vfloat in = max(max(at(near_[0], 0, ray.to_near[0]), at(near_[1], 1, ray.to_near[1])),
                                  max(at(near_[2], 2, ray.to_near[2]), ray.t_near));
            const vfloat out = min(min(at(far_[0], 0, ray.to_far[0]), at(far_[1], 1, ray.to_far[1])),
                                   min(at(far_[2], 2, ray.to_far[2]), end));
            in.store(t + first);
            which |= bits(in <= out + ray.pad) << first;
        }
        return which;
    }

    /// Sends one ray through the tree below a child, to the nearest box first.
    void nearest_first(std::uint32_t child, const Alone& one) noexcept
    {
        struct Todo {
            float begin;
            std::uint32_t child;
        };
        Todo todo[kMostTodo];
        int size = 0;
        const float t_end = first_lane(one.span.t_end);
        const auto end_now = [&] { return one.boxes.end(min(query_.t_of(one.lane), t_end)); };
        const float pad = first_lane(one.boxes.pad);
        float end = end_now();
        while (true) {
            if (TriangleNode::is_block(child)) {
                if (triangles_single(TriangleNode::block_of(child), one)) end = end_now();
            } else {
                const TriangleNode& node = nodes_[child];
                alignas(32) float begin[kWidth];
                unsigned which = enter(node, one, end, begin);
                if (which != 0) {
                    const int first = std::countr_zero(which);
                    Todo nearest{begin[first], node.children[first]};
                    const int base = size;
                    for (which &= which - 1; which != 0; which &= which - 1) {
                        const int i = std::countr_zero(which);
                        Todo farther{begin[i], node.children[i]};
                        if (farther.begin < nearest.begin) std::swap(nearest, farther);
                        int at = size++;
                        for (; at > base && todo[at - 1].begin < farther.begin; --at) todo[at] = todo[at - 1];
                        todo[at] = farther;
                    }
                    child = nearest.child;
                    continue;
                }
            }
            do {
                if (size == 0) return;
                child = todo[--size].child;
            } while (!(todo[size].begin <= end + pad));
        }
    }

    /// Tests the rays of a packet against a block, all rays against one triangle after the other.
    void triangles_packet(std::uint32_t block, vmask alive) noexcept
    {
        const VecLanes origin{ray_.origin[axes_[0]], ray_.origin[axes_[1]], ray_.origin[axes_[2]]};
        const std::uint32_t* faces = grid_.mesh().triangles.faces + block * std::uint32_t(kWidth);
        for (std::uint32_t k = 0; k < std::uint32_t(kWidth); ++k) {
            if (k > 0 && faces[k] == faces[k - 1]) break;  // only spare triangles follow
            const auto corner = [this, block, k](int p) {
                const auto read = [&](int a) {
                    return read_.one(&blocks_[block].corners[p * 3 + axes_[a]][k], next_corners());
                };
                return VecLanes{read(0), read(1), read(2)};
            };
            const auto vertex = [&](int p) { return shear(ray_, origin, corner(p)); };
            const TriangleHit hit = intersect(ray_, vertex(0), vertex(1), vertex(2));
            if (none(hit.is_hit & alive)) continue;
            const vfloat found = narrowed(ray_, origin, hit, corner);
            unsigned lanes = bits(hit.is_hit & alive & (found > span_.t_near) & (found <= limit()));
            if (lanes == 0) continue;
            float t[kLanes];
            found.store(t);
            for (; lanes != 0; lanes &= lanes - 1) {
                const int lane = std::countr_zero(lanes);
                query_.offer(lane, t[lane], grid_, block * std::uint32_t(kWidth) + k);
            }
        }
    }

    /// Does the same for one ray after the other, each against all triangles: this takes as many tests as there are rays.
    void triangles_in_turn(std::uint32_t block, unsigned alive) noexcept
    {
        for (; alive != 0; alive &= alive - 1) {
            const int lane = std::countr_zero(alive);
            const RayLanes ray = spread(ray_, lane);
            const VecLanes origin{ray.origin[axes_[0]], ray.origin[axes_[1]], ray.origin[axes_[2]]};
            const RaySpan span{spread(span_.t_near, lane), spread(span_.t_end, lane)};
            triangles_single(block, {ray, origin, span, of_lane(read_, lane), lane});
        }
    }

    /// Returns whether hits were offered.
    OCCAM_ALWAYS_INLINE bool triangles_single(std::uint32_t block, const AtTriangles& one) noexcept
    {
        count_tests(query_, kWidth);
        bool any_hit = false;
        for (int first = 0; first < kWidth; first += kLanes) {
            const auto corner = [this, &one, block, first](int p) {
                const auto read = [&](int a) {
                    return one.read.many(&blocks_[block].corners[p * 3 + axes_[a]][first], next_corners());
                };
                return VecLanes{read(0), read(1), read(2)};
            };
            const auto vertex = [&](int p) { return shear(one.ray, one.origin, corner(p)); };
            const TriangleHit hit = intersect(one.ray, vertex(0), vertex(1), vertex(2));
            if (none(hit.is_hit)) continue;
            const vfloat found = narrowed(one.ray, one.origin, hit, corner);
            const vfloat end = min(vfloat(query_.t_of(one.lane)), one.span.t_end);
            unsigned lanes = bits(hit.is_hit & (found > one.span.t_near) & (found <= end));
            if (lanes == 0) continue;
            any_hit = true;
            float t[kLanes];
            found.store(t);
            for (; lanes != 0; lanes &= lanes - 1) {
                const int i = std::countr_zero(lanes);
                query_.offer(one.lane, t[i], grid_, block * std::uint32_t(kWidth) + std::uint32_t(first + i));
            }
        }
        return any_hit;
    }

    IGrid& grid_;
    const RayLanes& ray_;
    RaySpan span_;
    Query& query_;
    Coordinates read_;
    const TriangleNode* nodes_;  ///< at the rays' key
    const TriangleBlock* blocks_;
    int axes_[3];           ///< kx, ky, kz
    int near_[3], far_[3];  ///< rows of the planes of a box that the ray crosses first, and last
};

}  // namespace occam::accel
