// Intersects rays with an igrid. A packet descends the box tree together; a single ray tests eight boxes, then eight
// quads, at once.
//
// Both ways run the same operations on the same numbers for each pair of a ray and a triangle, so they find the same
// bits. The choice between them is a matter of speed (the break-even is at two to three live rays,
// docs/performance.md).
//
// Each vertex of a lattice is blended and then sheared once per ray, and is shared by the triangles around it. Where
// all rays are before or behind the blend, the stored fine or coarse positions serve unchanged and give the same bits,
// since the ends of the blend are exact.
//
// The Query type provides:
// limit()                     returns the current t_far of the lanes (for a single ray, in all lanes);
// offer(lane, t, grid, id)    takes a hit with t in (t_near, limit], decides ties and filters.
#pragma once

#include <bit>

#include "accel/igrid.h"
#include "accel/in_box.h"
#include "accel/triangle.h"

namespace occam::accel {

template <class Query>
class IGridTracer {
public:
    /// t_near and t_end bound the part of each ray that sees the grid, in lanes (for a single ray, in all lanes).
    IGridTracer(IGrid& grid, const RayLanes& ray, const bool (&negative)[3], vfloat t_near, vfloat t_end, Query& query)
        : grid_(grid),
          ray_(ray),
          origin_{ray.origin[ray.kx], ray.origin[ray.ky], ray.origin[ray.kz]},
          t_near_(t_near),
          t_end_(t_end),
          query_(query)
    {
        const int axes[3] = {ray.kx, ray.ky, ray.kz};
        for (int a = 0; a < 3; ++a) {
            axes_[a] = axes[a];
            fine_[a] = grid.fine[axes[a]];
            coarse_[a] = grid.coarse[axes[a]];
            near_[a] = (negative[a] ? a + 3 : a) * BoxTree::kGroup;
            far_[a] = (negative[a] ? a : a + 3) * BoxTree::kGroup;
        }
    }

    /// Each lane holds one ray. as_one() returns them all as one ray, in the cage's frame.
    template <class AsOne>
    void packet(vmask active, AsOne&& as_one) noexcept
    {
        const bool blends = choose_vertices(active);
        const auto meet = [&](int block) {
            const vmask alive = active & in_box_at(grid_.boxes, grid_.boxes.first_leaf() + block);
            if (none(alive)) return;
            if (!grid_.is_lattice) triangles_packet(grid_.block_at[block], alive);
            else if (blends) quads_packet<true>(grid_.blocks[block], alive);
            else quads_packet<false>(grid_.blocks[block], alive);
        };
        if (grid_.boxes.leaves < kWorthAGroup)
            for (int block = 0; block < grid_.boxes.leaves; ++block) meet(block);
        else {
            const auto& rays = as_one();
            for_each_block(
                grid_.boxes, [&](const float* boxes) { return rays.in_boxes(boxes, FLT_MAX); }, meet);
        }
        for (int block = 0; block < grid_.hanging_blocks; ++block) {
            unsigned lanes = bits(active & in_box_at(grid_.hanging_boxes, grid_.hanging_boxes.first_leaf() + block));
            for (; lanes != 0; lanes &= lanes - 1) {
                const int lane = std::countr_zero(lanes);
                const VecLanes origin{spread(origin_.x, lane), spread(origin_.y, lane), spread(origin_.z, lane)};
                hanging_single(block, lane, spread(ray_, lane), origin, blends ? spread(blend_, lane) : blend_, blends);
            }
        }
    }

    /// Copies ray `lane` of the query to all lanes.
    void single(int lane) noexcept
    {
        if (!grid_.is_lattice) {
            nearest_first(lane);
            return;
        }
        const bool blends = choose_vertices(vmask(true));
        const auto in = [&](const float* boxes) { return in_boxes(boxes); };
        for_each_block(grid_.boxes, in, [&](int block) { quads_single(grid_.blocks[block], lane, blends); });
        if (grid_.hanging_blocks > 0)
            for_each_block(grid_.hanging_boxes, in,
                           [&](int block) { hanging_single(block, lane, ray_, origin_, blend_, blends); });
    }

private:
    static constexpr int kColumns = LatticeBlock::kColumns, kRows = LatticeBlock::kRows;
    static constexpr int kWorthAGroup = 4;  ///< number of blocks from which on a packet tests eight of them as one ray

    /// Returns whether rays blend here. If not, one of the two positions of each vertex serves all rays.
    bool choose_vertices(vmask active) noexcept
    {
        vertices_ = fine_;
        if (!grid_.blends()) return false;
        blend_ = ray_.blend.along(axes_[0], axes_[1], axes_[2]);
        vfloat lowest[3], highest[3];
        for (int a = 0; a < 3; ++a) {
            const vmask falls = blend_.d[a] < vfloat(0.0f);
            const vfloat lo = grid_.boxes.lo(0, axes_[a]), hi = grid_.boxes.hi(0, axes_[a]);
            lowest[a] = select(falls, hi, lo);
            highest[a] = select(falls, lo, hi);
        }
        if (none(active & (blend_.ramp({highest[0], highest[1], highest[2]}) > vfloat(0.0f)))) return false;
        if (none(active & (blend_.ramp({lowest[0], lowest[1], lowest[2]}) < vfloat(1.0f)))) {
            vertices_ = coarse_;
            return false;
        }
        return true;
    }

    vfloat limit() const noexcept { return min(query_.limit(), t_end_); }

    vmask in_box_at(const BoxTree& tree, int node) const noexcept
    {
        const float* box = tree.at(node);
        return in_box(ray_, {box[near_[0]], box[near_[1]], box[near_[2]]}, {box[far_[0]], box[far_[1]], box[far_[2]]},
                      t_near_, limit());
    }

    /// Returns which of eight neighbouring boxes the ray enters. All lanes hold the ray.
    unsigned in_boxes(const float* box) const noexcept
    {
        const vfloat near[3] = {vfloat::load(box + near_[0]), vfloat::load(box + near_[1]), vfloat::load(box + near_[2])};
        const vfloat far[3] = {vfloat::load(box + far_[0]), vfloat::load(box + far_[1]), vfloat::load(box + far_[2])};
        return bits(in_box(ray_, near, far, t_near_, limit()));
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
            above = in(tree.at(BoxTree::kFourthRow));
            below = std::countr_zero(static_cast<unsigned>(tree.leaves)) - 3;
        }
        for (int first = 0; above != 0 && first < tree.leaves; first += kLanes) {
            if (above != ~0u && (above >> (first >> below) & ((2u << ((kLanes - 1) >> below)) - 1)) == 0) continue;
            unsigned hit = in(tree.at(tree.first_leaf() + first)) & real;
            for (; hit != 0; hit &= hit - 1) visit(first + std::countr_zero(hit));
        }
    }

    /// Says which of eight neighbouring boxes a ray enters, and where.
    struct Entered {
        unsigned which = 0;
        alignas(32) float t[BoxTree::kGroup];
    };
    OCCAM_ALWAYS_INLINE void enter(const float* box, Entered& entered) const noexcept
    {
        entered.which = 0;
        for (int first = 0; first < BoxTree::kGroup; first += kLanes) {
            const auto load = [&](int plane) { return vfloat::load(box + plane + first); };
            const vfloat near[3] = {load(near_[0]), load(near_[1]), load(near_[2])};
            const vfloat far[3] = {load(far_[0]), load(far_[1]), load(far_[2])};
            vfloat begin;
            entered.which |= bits(in_box(ray_, near, far, t_near_, limit(), begin)) << first;
            begin.store(entered.t + first);
        }
    }

    /// Intersects one ray with a mesh: the rows of the box tree are tested three at a time, eight boxes wide, and the
    /// boxes are visited in the order in which the ray enters them.
    void nearest_first(int lane) noexcept
    {
        struct Todo {
            float t;
            std::int16_t row, node;  // the row has 2^row nodes
        };
        constexpr int kMostRows = 5;
        Todo todo[kMostRows * BoxTree::kGroup];
        int size = 0;
        const BoxTree& tree = grid_.boxes;
        const int last = std::countr_zero(static_cast<unsigned>(tree.leaves));
        Entered entered;
        // Opens eight nodes of a row, or all nodes of a shorter row.
        const auto open = [&](int row, int group) {
            const int nodes = 1 << row;
            int skip = 0;  // the nodes of shorter rows share their eight slots
            if (row == last) {
                enter(tree.data + group * BoxTree::kFloats, entered);
            } else {
                const int place = tree.leaves + nodes + group * BoxTree::kGroup;
                skip = place % BoxTree::kGroup;
                enter(tree.data + place / BoxTree::kGroup * BoxTree::kFloats, entered);
            }
            const int base = size;
            unsigned which = entered.which >> skip;
            if (nodes < BoxTree::kGroup) which &= (1u << nodes) - 1;
            for (; which != 0; which &= which - 1) {
                const int i = std::countr_zero(which);
                const float t = entered.t[skip + i];
                int at = size++;
                for (; at > base && todo[at - 1].t < t; --at) todo[at] = todo[at - 1];
                todo[at] = {t, static_cast<std::int16_t>(row), static_cast<std::int16_t>(group * BoxTree::kGroup + i)};
            }
        };
        open(last == 0 ? 0 : (last - 1) % 3 + 1, 0);
        while (size > 0) {
            const Todo next = todo[--size];
            if (!(next.t <= first_lane(limit()))) continue;
            if (next.row == last) triangles_single(grid_.block_at[next.node], lane);
            else open(next.row + 3, next.node);
        }
    }

    /// Offers the hits of a packet with one micropolygon.
    void offer_lanes(const TriangleHit& hit, vmask alive, std::uint32_t id) noexcept
    {
        unsigned lanes = bits(hit.is_hit & alive & (hit.t > t_near_) & (hit.t <= limit()));
        if (lanes == 0) return;
        float t[kLanes];
        hit.t.store(t);
        for (; lanes != 0; lanes &= lanes - 1) query_.offer(std::countr_zero(lanes), t[std::countr_zero(lanes)], grid_, id);
    }
    /// Offers the hits of one ray with lanes of micropolygons; id(lane) numbers them.
    template <class Id>
    void offer_one(const TriangleHit& hit, int ray, Id&& id) noexcept
    {
        unsigned lanes = bits(hit.is_hit & (hit.t > t_near_) & (hit.t <= limit()));
        if (lanes == 0) return;
        float t[kLanes];
        hit.t.store(t);
        for (; lanes != 0; lanes &= lanes - 1)
            query_.offer(ray, t[std::countr_zero(lanes)], grid_, id(std::countr_zero(lanes)));
    }

    static std::uint32_t quad_id(const LatticeBlock& block, int column, int row, int triangle) noexcept
    {
        const int fast = block.fast + column, slow = block.slow + row;
        return block.is_transposed ? make_id(block.part, slow, fast, 1 - triangle)
                                   : make_id(block.part, fast, slow, triangle);
    }

    /// Returns a vertex as this ray, or each ray of the packet, sees it, with its coordinates along kx, ky, kz.
    OCCAM_ALWAYS_INLINE VecLanes still_vertex(std::uint32_t at) const noexcept
    {
        return {vertices_[0][at], vertices_[1][at], vertices_[2][at]};
    }
    OCCAM_ALWAYS_INLINE VecLanes blended_vertex(std::uint32_t at) const noexcept
    {
        return blend_.between({fine_[0][at], fine_[1][at], fine_[2][at]}, {coarse_[0][at], coarse_[1][at], coarse_[2][at]});
    }
    VecLanes hanging_vertex(const lod::Hanging& hanging) const noexcept
    {
        VecLanes low = blended_vertex(hanging.a), high = blended_vertex(hanging.c);
        for (int d = hanging.depth; d > 0; --d) {
            const VecLanes m = middle(low, high);
            (hanging.path >> (d - 1) & 1 ? low : high) = m;
        }
        return middle(low, high);
    }

    template <bool kBlends>
    OCCAM_NEVER_INLINE void quads_packet(const LatticeBlock& block, vmask alive) noexcept
    {
        ShearedVertex v[kRows][kColumns];
        for (std::uint32_t r = 0; r <= block.rows; ++r)
            for (std::uint32_t c = 0; c <= block.columns; ++c) {
                const std::uint32_t at = block.first + r * block.stride + c;
                // A vertex that does not move needs no weight.
                if (kBlends &&
                    (fine_[0][at] != coarse_[0][at] || fine_[1][at] != coarse_[1][at] || fine_[2][at] != coarse_[2][at]))
                    v[r][c] = shear(ray_, origin_, blended_vertex(at));
                else v[r][c] = shear(ray_, origin_, still_vertex(at));
            }
        if constexpr (kBlends)
            for (std::uint32_t h = block.hanging; h < block.hanging + block.hanging_count; ++h) {
                const BlockHanging& at = grid_.block_hanging[h];
                v[at.row][at.column] = shear(ray_, origin_, hanging_vertex(grid_.hanging[at.hanging]));
            }
        Edge across[kColumns - 1];  // the upper edges of the last row
        for (int c = 0; c < block.columns; ++c) across[c] = {v[0][c + 1], v[0][c]};
        for (int r = 0; r < block.rows; ++r) {
            Edge left(v[r][0], v[r + 1][0]);
            for (int c = 0; c < block.columns; ++c) {
                const Edge right(v[r][c + 1], v[r + 1][c + 1]), upper(v[r + 1][c + 1], v[r + 1][c]);
                intersect_quad(
                    ray_, v[r][c], v[r][c + 1], v[r + 1][c], v[r + 1][c + 1], left, right, across[c], upper,
                    [&](const TriangleHit& hit, int triangle) { offer_lanes(hit, alive, quad_id(block, c, r, triangle)); });
                left = right;
                across[c] = upper;
            }
        }
    }

    /// Holds the vertices of a block in rows, blended for one ray, with their coordinates along kx, ky, kz.
    struct OwnRows {
        float v[3][kRows][8];
    };
    OCCAM_NEVER_INLINE void blend_rows(const LatticeBlock& block, OwnRows& own) const noexcept
    {
        for (std::uint32_t r = 0; r <= block.rows; ++r)
            for (std::uint32_t c = 0; c <= block.columns; c += kLanes) {
                const std::uint32_t at = block.first + r * block.stride + c;
                const auto load = [&](const float* const* p) {
                    return VecLanes{vfloat::load(p[0] + at), vfloat::load(p[1] + at), vfloat::load(p[2] + at)};
                };
                const VecLanes p = blend_.between(load(fine_), load(coarse_));
                p.x.store(&own.v[0][r][c]);
                p.y.store(&own.v[1][r][c]);
                p.z.store(&own.v[2][r][c]);
            }
        for (std::uint32_t h = block.hanging; h < block.hanging + block.hanging_count; ++h) {
            const BlockHanging& at = grid_.block_hanging[h];
            const VecLanes p = hanging_vertex(grid_.hanging[at.hanging]);
            own.v[0][at.row][at.column] = first_lane(p.x);
            own.v[1][at.row][at.column] = first_lane(p.y);
            own.v[2][at.row][at.column] = first_lane(p.z);
        }
    }

    void quads_single(const LatticeBlock& block, int lane, bool blends) noexcept
    {
        OwnRows own;
        const float* from[3] = {vertices_[0] + block.first, vertices_[1] + block.first, vertices_[2] + block.first};
        std::ptrdiff_t stride = block.stride;
        if (blends) {
            blend_rows(block, own);
            for (int a = 0; a < 3; ++a) from[a] = own.v[a][0];
            stride = 8;
        }
        const std::ptrdiff_t upper = block.rows == 2 ? stride : 0;
        // The lanes hold four quads of the lower row, then four of the upper row.
        unsigned real = (1u << block.columns) - 1;
        if (block.rows == 2) real |= real << 4;
        for (int first = 0; first < IGrid::kBlock; first += kLanes) {
            if ((real >> first & ((1u << kLanes) - 1)) == 0) continue;
            const auto corner = [&](int dc, int dr) {
                const std::ptrdiff_t at = dr * stride + dc;
                return shear(ray_, origin_,
                             VecLanes{vfloat::load_halves(from[0] + at, from[0] + at + upper, first),
                                      vfloat::load_halves(from[1] + at, from[1] + at + upper, first),
                                      vfloat::load_halves(from[2] + at, from[2] + at + upper, first)});
            };
            const ShearedVertex v00 = corner(0, 0), v10 = corner(1, 0), v01 = corner(0, 1), v11 = corner(1, 1);
            intersect_quad(ray_, v00, v10, v01, v11, {v00, v01}, {v10, v11}, {v10, v00}, {v11, v01},
                           [&](const TriangleHit& hit, int triangle) {
                               unsigned lanes = bits(hit.is_hit & (hit.t > t_near_) & (hit.t <= limit())) & (real >> first);
                               if (lanes == 0) return;
                               float t[kLanes];
                               hit.t.store(t);
                               for (; lanes != 0; lanes &= lanes - 1) {
                                   const int k = std::countr_zero(lanes), quad = first + k;
                                   query_.offer(lane, t[k], grid_, quad_id(block, quad % 4, quad / 4, triangle));
                               }
                           });
        }
    }

    template <class Load>
    void triangle_vertices(Load&& load, ShearedVertex (&v)[3]) const noexcept
    {
        for (int p = 0; p < 3; ++p)
            v[p] = shear(ray_, origin_, {load(p * 3 + axes_[0]), load(p * 3 + axes_[1]), load(p * 3 + axes_[2])});
    }

    void triangles_packet(int block, vmask alive) noexcept
    {
        for (int k = block * IGrid::kBlock; k < (block + 1) * IGrid::kBlock; ++k) {
            if (k % IGrid::kBlock != 0 && grid_.ids[k] == grid_.ids[k - 1]) break;  // only padding copies follow
            ShearedVertex v[3];
            triangle_vertices([&](int c) { return vfloat(grid_.corners[c][k]); }, v);
            offer_lanes(intersect(ray_, v[0], v[1], v[2]), alive, grid_.ids[k]);
        }
    }

    void triangles_single(int block, int lane) noexcept
    {
        for (int first = block * IGrid::kBlock; first < (block + 1) * IGrid::kBlock; first += kLanes) {
            ShearedVertex v[3];
            triangle_vertices([&](int c) { return vfloat::load(grid_.corners[c] + first); }, v);
            offer_one(intersect(ray_, v[0], v[1], v[2]), lane, [&](int k) { return grid_.ids[first + k]; });
        }
    }

    /// Returns whether the ray may hit a triangle whose corners lie on the line from a to c. The test allows for the
    /// rounding of the midpoints of some ten halvings and of the shear, for coordinates of up to five radii (see
    /// place()).
    vmask may_be_on(const ShearedVertex& a, const ShearedVertex& c) const noexcept
    {
        const vfloat off = grid_.cage->radius * 0x1p-16f;
        const vfloat left = a.x * c.y, right = a.y * c.x;
        const vfloat slack = off * (abs(c.x - a.x) + abs(c.y - a.y)) + (abs(left) + abs(right)) * vfloat(0x1p-21f);
        return (min(a.x, c.x) <= off) & (max(a.x, c.x) >= -off) & (min(a.y, c.y) <= off) & (max(a.y, c.y) >= -off) &
               (abs(left - right) <= slack);
    }

    /// Intersects the gap triangles of T-vertices, which have no area. The float test decides no hit here: its signs
    /// are right, but its t is noise along the edge. What it lets through is tested again in double, where products of
    /// floats are exact (watertightness rule 6).
    OCCAM_NEVER_INLINE void hanging_single(int block, int lane, const RayLanes& ray, const VecLanes& origin,
                                           const VertexBlend& blend, bool blends) noexcept
    {
        for (int first = block * IGrid::kBlock; first < (block + 1) * IGrid::kBlock; first += kLanes) {
            float end[2][3][kLanes], corner[3][3][kLanes];
            ShearedVertex sheared[2];
            for (int e = 0; e < 2; ++e) {
                const auto gather = [&](const float* const* p) {
                    float lanes[3][kLanes];
                    for (int k = 0; k < kLanes; ++k) {
                        const lod::Hanging& hanging = grid_.hanging[static_cast<std::size_t>(first + k)];
                        for (int a = 0; a < 3; ++a) lanes[a][k] = p[a][e == 0 ? hanging.a : hanging.c];
                    }
                    return VecLanes{vfloat::load(lanes[0]), vfloat::load(lanes[1]), vfloat::load(lanes[2])};
                };
                const VecLanes p = blends ? blend.between(gather(fine_), gather(coarse_)) : gather(vertices_);
                p.x.store(end[e][0]);
                p.y.store(end[e][1]);
                p.z.store(end[e][2]);
                sheared[e] = shear(ray, origin, p);
            }
            if (none(may_be_on(sheared[0], sheared[1]))) continue;
            for (int k = 0; k < kLanes; ++k) {
                const lod::Hanging::Ends ends = grid_.hanging[static_cast<std::size_t>(first + k)].on(
                    {end[0][0][k], end[0][1][k], end[0][2][k]}, {end[1][0][k], end[1][1][k], end[1][2][k]});
                for (int a = 0; a < 3; ++a) {
                    corner[0][a][k] = ends.low[a];
                    corner[1][a][k] = ends.middle[a];
                    corner[2][a][k] = ends.high[a];
                }
            }
            ShearedVertex v[3];
            for (int p = 0; p < 3; ++p)
                v[p] = shear(ray, origin,
                             {vfloat::load(corner[p][0]), vfloat::load(corner[p][1]), vfloat::load(corner[p][2])});
            unsigned lanes = bits(is_inside(edge_functions(v[0], v[1], v[2])));
            if (lanes == 0) continue;
            float x[3][kLanes], y[3][kLanes], t[3][kLanes], shift[kLanes], t_near[kLanes], t_far[kLanes];
            for (int p = 0; p < 3; ++p) {
                v[p].x.store(x[p]);
                v[p].y.store(y[p]);
                v[p].t.store(t[p]);
            }
            ray.shift.store(shift);
            t_near_.store(t_near);
            for (; lanes != 0; lanes &= lanes - 1) {
                const int k = std::countr_zero(lanes);
                const auto area = [&](int p, int q) { return double(x[q][k]) * y[p][k] - double(y[q][k]) * x[p][k]; };
                const double u = area(1, 2), w_v = area(2, 0), w = area(0, 1);
                const bool inside = (u >= 0 && w_v >= 0 && w >= 0) || (u <= 0 && w_v <= 0 && w <= 0);
                const double det = u + w_v + w;
                if (!inside || det == 0) continue;
                const double exact = (u * t[0][k] + w_v * t[1][k] + w * t[2][k]) / det;
                const float found = shift[0] + static_cast<float>(exact);
                limit().store(t_far);
                if (found > t_near[lane] && found <= t_far[lane])
                    query_.offer(lane, found, grid_, kGapBit | static_cast<std::uint32_t>(first + k));
            }
        }
    }

    IGrid& grid_;
    const RayLanes& ray_;
    VecLanes origin_;       ///< along kx, ky, kz
    int axes_[3];           ///< kx, ky, kz
    const float* fine_[3];  ///< coordinates along these axes
    const float* coarse_[3];
    VertexBlend blend_;     ///< along the same axes; valid if the grid blends
    int near_[3], far_[3];  ///< rows of the planes of a box that the ray crosses first, and last
    vfloat t_near_, t_end_;
    Query& query_;
    const float* const* vertices_ = nullptr;  ///< the positions for rays that do not blend
};

}  // namespace occam::accel
