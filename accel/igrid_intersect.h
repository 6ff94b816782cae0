// Intersects rays with an igrid. A packet descends the box tree together; a single ray tests eight boxes, then eight
// quads, at once. The triangles of a mesh have a tracer of their own (accel/triangle_tracer.h).
//
// Both ways run the same operations on the same numbers for each pair of a ray and a triangle, so they find the same
// bits. The choice between them is a matter of speed (kWorthAPacket in accel/packet.h).
//
// Each vertex of a lattice is blended and then sheared once per ray, and is shared by the triangles around it. Where
// all rays are before or behind the blend, the stored fine or coarse positions serve unchanged and give the same bits,
// since the ends of the blend are exact.
//
// An igrid that moves is read by other Coordinates, which interpolate between two keys at each ray's own time; all else is
// the same. The rays of a packet are then in one segment of the igrid's motion.
//
// The Query type provides:
// limit()                     returns the current t_far of the lanes (for a single ray, in all lanes);
// t_of(lane)                  returns that of one ray, by the lane under which its hits are offered;
// offer(lane, t, grid, id)    takes a hit with t in (t_near, limit], decides ties and filters;
// tested(triangles)           counts what a single ray is tested against, if the query has it.
#pragma once

#include <bit>
#include <type_traits>

#include "accel/gap_triangles.h"
#include "accel/in_box.h"
#include "accel/lattice_vertices.h"
#include "accel/triangle.h"
#include "accel/triangle_tracer.h"

namespace occam::accel {

template <class Query, class Coordinates = StillCoordinates>
class IGridTracer {
public:
    IGridTracer(IGrid& grid, const RaysInGrid& rays, Query& query, const Coordinates& read = {})
        : grid_(grid),
          ray_(rays.lanes),
          origin_{ray_.origin[ray_.kx], ray_.origin[ray_.ky], ray_.origin[ray_.kz]},
          read_(read),
          boxes_(at_key(grid.boxes)),
          vertices_(read, grid.floats_of_a_key),
          span_(rays.span),
          query_(query)
    {
        const int axes[3] = {ray_.kx, ray_.ky, ray_.kz};
        for (int a = 0; a < 3; ++a) {
            axes_[a] = axes[a];
            near_[a] = (rays.negative[a] ? a + 3 : a) * kRow;
            far_[a] = (rays.negative[a] ? a : a + 3) * kRow;
        }
    }

    /// Each lane holds one ray. as_one() returns them all as one ray, in the cage's frame.
    template <class AsOne>
    void packet(vmask active, AsOne&& as_one) noexcept
    {
        if constexpr (Coordinates::kMove) {
            // The tree's boxes hold the whole motion. Gap triangles may lie outside of the igrid's own box.
            if (grid_.hanging_blocks == 0) active = active & in_root();
            if (none(active)) return;
        }
        const bool blends = choose_vertices(active);
        const auto meet = [&](int block) {
            const vmask alive = active & in_leaf(boxes_, block);
            if (none(alive)) return;
            if (blends) quads_packet<true>(lattice().blocks[block], alive);
            else quads_packet<false>(lattice().blocks[block], alive);
        };
        if (boxes_.leaves < kWorthAGroup)
            for (int block = 0; block < boxes_.leaves; ++block) meet(block);
        else {
            const auto& rays = as_one();
            const auto in = [&](const float* boxes) {
                if constexpr (!Coordinates::kMove) return rays.in_boxes(boxes, FLT_MAX);
                else {
                    alignas(32) float swept[BoxTree::kFloats];
                    sweep(boxes, active, swept);
                    return rays.in_boxes(swept, FLT_MAX);
                }
            };
            for_each_block(boxes_, in, meet);
        }
        if (grid_.hanging_blocks > 0) gaps_packet(active, blends);
    }

    /// All lanes hold ray `lane` of the query.
    void single(int lane) noexcept
    {
        if constexpr (Coordinates::kMove)
            if (grid_.hanging_blocks == 0 && none(in_root())) return;
        const bool blends = choose_vertices(vmask(true));
        const auto in = [&](const BoxTree& tree) { return [&](const float* boxes) { return in_boxes(tree, boxes); }; };
        for_each_block(boxes_, in(boxes_), [&](int block) { quads_single(lattice().blocks[block], lane, blends); });
        if (grid_.hanging_blocks == 0) return;
        const Boxes gap_boxes = at_key(lattice().hanging_boxes);
        for_each_block(gap_boxes, in(gap_boxes), [&](int block) {
            count_tests(query_, IGrid::kBlock);
            gaps().intersect(block, {lane, ray_, origin_, vertices_.blend, read_}, blends);
        });
    }

private:
    using Boxes = std::conditional_t<Coordinates::kMove, BoxTree, const BoxTree&>;
    static constexpr int kColumns = LatticeBlock::kColumns, kRows = LatticeBlock::kRows;
    static constexpr int kWorthAGroup = 4;  ///< number of blocks from which on a packet tests eight of them as one ray
    static constexpr int kRow = Coordinates::kMove ? 1 : BoxTree::kGroup;  ///< one length of rows in trees that stand still

    /// Returns the boxes of the rays' key.
    Boxes at_key(const BoxTree& all) const noexcept
    {
        if constexpr (Coordinates::kMove) return all.at_key(read_.key());
        else return all;
    }
    /// Returns the number of floats from a coordinate to the same one at the next key.
    std::ptrdiff_t next_key() const noexcept { return grid_.floats_of_a_key; }

    LatticeGrid& lattice() const noexcept { return grid_.lattice(); }

    /// Returns whether rays blend in a lattice. If not, one of the two positions of each vertex serves all rays.
    bool choose_vertices(vmask active) noexcept
    {
        const std::ptrdiff_t first = Coordinates::kMove ? read_.key() * next_key() : 0;
        for (int a = 0; a < 3; ++a) {
            vertices_.fine[a] = lattice().fine[axes_[a]] + first;
            vertices_.coarse[a] = lattice().coarse[axes_[a]] + first;
        }
        vertices_.still = vertices_.fine;
        if (!grid_.blends()) return false;
        vertices_.blend = ray_.blend.along(axes_[0], axes_[1], axes_[2]);
        vfloat lowest[3], highest[3];
        for (int a = 0; a < 3; ++a) {
            const vmask falls = vertices_.blend.d[a] < vfloat(0.0f);
            const float *low = boxes_.root() + axes_[a] * kRow, *high = low + 3 * kRow;
            const vfloat lo = read_.one(low, boxes_.floats_of_a_key), hi = read_.one(high, boxes_.floats_of_a_key);
            lowest[a] = select(falls, hi, lo);
            highest[a] = select(falls, lo, hi);
        }
        if (none(active & (vertices_.blend.ramp({highest[0], highest[1], highest[2]}) > vfloat(0.0f)))) return false;
        if (none(active & (vertices_.blend.ramp({lowest[0], lowest[1], lowest[2]}) < vfloat(1.0f)))) {
            vertices_.still = vertices_.coarse;
            return false;
        }
        return true;
    }

    /// Intersects the gap triangles with the rays of a packet, one by one.
    void gaps_packet(vmask active, bool blends) noexcept
    {
        const Boxes boxes = at_key(lattice().hanging_boxes);
        for (int block = 0; block < grid_.hanging_blocks; ++block) {
            unsigned lanes = bits(active & in_leaf(boxes, block));
            for (; lanes != 0; lanes &= lanes - 1) {
                const int lane = std::countr_zero(lanes);
                const VecLanes origin{spread(origin_.x, lane), spread(origin_.y, lane), spread(origin_.z, lane)};
                const OneRay<Coordinates> one{lane, spread(ray_, lane), origin,
                                              blends ? spread(vertices_.blend, lane) : vertices_.blend,
                                              of_lane(read_, lane)};
                gaps().intersect(block, one, blends);
            }
        }
    }

    static StillCoordinates of_lane(const StillCoordinates& all, int) noexcept { return all; }
    static MovingCoordinates of_lane(const MovingCoordinates& all, int lane) noexcept
    {
        return {all.key(), spread(all.share(), lane)};
    }
    GapTriangles<Query, Coordinates> gaps() noexcept
    {
        return {lattice(), vertices_.fine, vertices_.coarse, vertices_.still, span_, query_};
    }

    vfloat limit() const noexcept { return min(query_.limit(), span_.t_end); }

    vmask in_leaf(const BoxTree& tree, int leaf) const noexcept { return in_box_at(tree, tree.leaf(leaf), row_of(tree)); }
    vmask in_root() const noexcept { return in_box_at(boxes_, boxes_.root(), 1); }
    vmask in_box_at(const BoxTree& tree, const float* box, int row) const noexcept
    {
        const auto plane = [&](int at) { return read_.one(box + at * row, tree.floats_of_a_key); };
        return in_box(ray_, {plane(near_[0]), plane(near_[1]), plane(near_[2])},
                      {plane(far_[0]), plane(far_[1]), plane(far_[2])}, span_.t_near, limit());
    }

    /// Returns by what near_ and far_ are multiplied in a leaf.
    static int row_of(const BoxTree& tree) noexcept { return Coordinates::kMove ? tree.row : 1; }

    /// Returns which of eight neighbouring boxes of a tree the ray enters. All lanes hold the ray.
    unsigned in_boxes(const BoxTree& tree, const float* box) const noexcept
    {
        const auto planes = [&](int at) { return read_.many(box + at * row_of(tree), tree.floats_of_a_key); };
        return bits(in_box(ray_, {planes(near_[0]), planes(near_[1]), planes(near_[2])},
                           {planes(far_[0]), planes(far_[1]), planes(far_[2])}, span_.t_near, limit()));
    }

    /// Makes eight boxes that hold these at the times of all active rays.
    void sweep(const float* boxes, vmask active, float* swept) const noexcept
    {
        const vfloat first = lowest(select(active, read_.share(), 1.0f)),
                     last = highest(select(active, read_.share(), 0.0f));
        for (int at = 0; at < BoxTree::kFloats; at += kLanes) {
            const float* p = boxes + at / BoxTree::kGroup * boxes_.row + at % BoxTree::kGroup;
            const vfloat here = vfloat::load(p), next = vfloat::load(p + boxes_.floats_of_a_key);
            const vfloat from = lod::between_keys(first, here, next), to = lod::between_keys(last, here, next);
            (at < BoxTree::kFloats / 2 ? min(from, to) : max(from, to)).store(swept + at);
        }
    }

    /// Calls in(boxes), which returns the mask of the boxes that are entered among eight neighbours.
    template <class In, class Visit>
    void for_each_block(const BoxTree& tree, In&& in, Visit&& visit) noexcept
    {
        const unsigned real = tree.leaves < kLanes ? (1u << tree.leaves) - 1
                                                   : (1u << kLanes) - 1;  // nodes above the leaves may follow
        // If there are many leaves, only those below the entered nodes of the fourth row are tested.
        unsigned above = ~0u;
        int below = 0;  // log2 of the number of leaves below such a node
        if (kLanes == BoxTree::kGroup && tree.leaves > 2 * kLanes) {
            above = in(tree.fourth_row());
            below = std::countr_zero(static_cast<unsigned>(tree.leaves)) - 3;
        }
        for (int first = 0; above != 0 && first < tree.leaves; first += kLanes) {
            if (above != ~0u && (above >> (first >> below) & ((2u << ((kLanes - 1) >> below)) - 1)) == 0) continue;
            unsigned hit = in(tree.leaf(first)) & real;
            for (; hit != 0; hit &= hit - 1) visit(first + std::countr_zero(hit));
        }
    }

    /// Offers the hits of a packet with one micropolygon at `found`.
    void offer_lanes(vmask is_hit, vfloat found, std::uint32_t id) noexcept
    {
        unsigned lanes = bits(is_hit & (found > span_.t_near) & (found <= limit()));
        if (lanes == 0) return;
        float t[kLanes];
        found.store(t);
        for (; lanes != 0; lanes &= lanes - 1) query_.offer(std::countr_zero(lanes), t[std::countr_zero(lanes)], grid_, id);
    }
    static std::uint32_t quad_id(const LatticeBlock& block, int column, int row, int triangle) noexcept
    {
        const int fast = block.fast + column, slow = block.slow + row;
        return block.is_transposed ? make_id(block.part, slow, fast, 1 - triangle)
                                   : make_id(block.part, fast, slow, triangle);
    }

    template <bool kBlends>
    OCCAM_NEVER_INLINE void quads_packet(const LatticeBlock& block, vmask alive) noexcept
    {
        ShearedVertex v[kRows][kColumns];
        for (std::uint32_t r = 0; r <= block.rows; ++r)
            for (std::uint32_t c = 0; c <= block.columns; ++c) {
                const std::uint32_t at = block.first + r * block.stride + c;
                // A vertex that is the same in both levels needs no weight.
                if (kBlends && vertices_.blends_at(at)) v[r][c] = shear(ray_, origin_, vertices_.blended(at));
                else v[r][c] = shear(ray_, origin_, vertices_.plain(at));
            }
        // A T-vertex is where it was diced only if neither levels nor time are blended.
        if constexpr (kBlends || Coordinates::kMove)
            for (std::uint32_t h = block.hanging; h < block.hanging + block.hanging_count; ++h) {
                const BlockHanging& at = lattice().block_hanging[h];
                v[at.row][at.column] = shear(ray_, origin_, vertices_.hanging(lattice().hanging[at.hanging], kBlends));
            }
        Edge across[kColumns - 1];  // the upper edges of the last row
        for (int c = 0; c < block.columns; ++c) across[c] = {v[0][c + 1], v[0][c]};
        for (int r = 0; r < block.rows; ++r) {
            Edge left(v[r][0], v[r + 1][0]);
            for (int c = 0; c < block.columns; ++c) {
                const Edge right(v[r][c + 1], v[r + 1][c + 1]), upper(v[r + 1][c + 1], v[r + 1][c]);
                intersect_quad(ray_, {v[r][c], v[r][c + 1], v[r + 1][c], v[r + 1][c + 1]}, {left, right, across[c], upper},
                               [&](const TriangleHit& hit, int triangle) {
                                   const vmask is_hit = hit.is_hit & alive;
                                   if (none(is_hit)) return;
                                   const QuadCorners<kBlends, Coordinates> corner{vertices_, lattice(), block,
                                                                                  c,         r,         triangle};
                                   offer_lanes(is_hit, narrowed(ray_, origin_, hit, corner), quad_id(block, c, r, triangle));
                               });
                left = right;
                across[c] = upper;
            }
        }
    }

    /// Holds the vertices of a block in rows, as one ray sees them, with their coordinates along kx, ky, kz.
    struct OwnRows {
        float v[3][kRows][8];
    };
    template <bool kBlends>
    OCCAM_NEVER_INLINE void blend_rows(const LatticeBlock& block, OwnRows& own) const noexcept
    {
        for (std::uint32_t r = 0; r <= block.rows; ++r)
            for (std::uint32_t c = 0; c <= block.columns; c += kLanes) {
                const std::uint32_t at = block.first + r * block.stride + c;
                const auto load = [&](const float* const* p) {
                    return VecLanes{read_.many(p[0] + at, next_key()), read_.many(p[1] + at, next_key()),
                                    read_.many(p[2] + at, next_key())};
                };
                const VecLanes p = kBlends ? vertices_.blend.between(load(vertices_.fine), load(vertices_.coarse))
                                           : load(vertices_.still);
                p.x.store(&own.v[0][r][c]);
                p.y.store(&own.v[1][r][c]);
                p.z.store(&own.v[2][r][c]);
            }
        for (std::uint32_t h = block.hanging; h < block.hanging + block.hanging_count; ++h) {
            const BlockHanging& at = lattice().block_hanging[h];
            const VecLanes p = vertices_.hanging(lattice().hanging[at.hanging], kBlends);
            own.v[0][at.row][at.column] = first_lane(p.x);
            own.v[1][at.row][at.column] = first_lane(p.y);
            own.v[2][at.row][at.column] = first_lane(p.z);
        }
    }

    void quads_single(const LatticeBlock& block, int lane, bool blends) noexcept
    {
        count_tests(query_, 2 * block.columns * block.rows);
        OwnRows own;
        const float* from[3] = {vertices_.still[0] + block.first, vertices_.still[1] + block.first,
                                vertices_.still[2] + block.first};
        std::ptrdiff_t stride = block.stride;
        if (Coordinates::kMove || blends) {
            if (!Coordinates::kMove || blends) blend_rows<true>(block, own);
            else blend_rows<false>(block, own);
            for (int a = 0; a < 3; ++a) from[a] = own.v[a][0];
            stride = 8;
        }
        const std::ptrdiff_t upper = block.rows == 2 ? stride : 0;
        // The lanes hold four quads of the lower row, then four of the upper row.
        unsigned real = (1u << block.columns) - 1;
        if (block.rows == 2) real |= real << 4;
        for (int first = 0; first < IGrid::kBlock; first += kLanes) {
            if ((real >> first & ((1u << kLanes) - 1)) == 0) continue;
            const auto position = [x = from[0], y = from[1], z = from[2], stride, upper, first](int dc, int dr) {
                const std::ptrdiff_t low = dr * stride + dc, high = low + upper;
                return VecLanes{vfloat::load_halves(x + low, x + high, first), vfloat::load_halves(y + low, y + high, first),
                                vfloat::load_halves(z + low, z + high, first)};
            };
            const auto corner = [&](int dc, int dr) { return shear(ray_, origin_, position(dc, dr)); };
            const ShearedVertex v00 = corner(0, 0), v10 = corner(1, 0), v01 = corner(0, 1), v11 = corner(1, 1);
            intersect_quad(ray_, {v00, v10, v01, v11}, {{v00, v01}, {v10, v11}, {v10, v00}, {v11, v01}},
                           [&](const TriangleHit& hit, int triangle) {
                               if ((bits(hit.is_hit) & (real >> first)) == 0) return;
                               const vfloat found = narrowed(ray_, origin_, hit, [=](int p) {
                                   return position(kQuadCorners[triangle][p][0], kQuadCorners[triangle][p][1]);
                               });
                               unsigned lanes = bits(hit.is_hit & (found > span_.t_near) & (found <= limit())) &
                                                (real >> first);
                               if (lanes == 0) return;
                               float t[kLanes];
                               found.store(t);
                               for (; lanes != 0; lanes &= lanes - 1) {
                                   const int k = std::countr_zero(lanes), quad = first + k;
                                   query_.offer(lane, t[k], grid_, quad_id(block, quad % 4, quad / 4, triangle));
                               }
                           });
        }
    }

    IGrid& grid_;
    const RayLanes& ray_;
    VecLanes origin_;  ///< along kx, ky, kz
    Coordinates read_;
    Boxes boxes_;                            ///< at the rays' key
    int axes_[3];                            ///< kx, ky, kz
    LatticeVertices<Coordinates> vertices_;  ///< along these axes
    int near_[3], far_[3];  ///< places, over row_of(), of the planes of a box that the ray crosses first, and last
    RaySpan span_;
    Query& query_;
};

/// Intersects a packet, one ray in each lane, with an igrid of either kind.
template <class Query, class AsOne, class Coordinates = StillCoordinates>
OCCAM_ALWAYS_INLINE void meet_packet(IGrid& grid, const RaysInGrid& rays, vmask active, Query& query, AsOne&& as_one,
                                     const Coordinates& read = {}) noexcept
{
    if (grid.is_lattice) IGridTracer(grid, rays, query, read).packet(active, as_one);
    else TriangleTracer(grid, rays, query, read).packet(active, as_one);
}
/// Does the same for one ray, which is in all lanes; it is ray `lane` of the query.
template <class Query, class Coordinates = StillCoordinates>
OCCAM_ALWAYS_INLINE void meet_single(IGrid& grid, const RaysInGrid& ray, int lane, Query& query,
                                     const Coordinates& read = {}) noexcept
{
    if (grid.is_lattice) IGridTracer(grid, ray, query, read).single(lane);
    else TriangleTracer(grid, ray, query, read).single(lane);
}

}  // namespace occam::accel
