// Rays meet an igrid: a packet goes down the box tree together; a single ray tests eight boxes, then eight quads, at once.
//
// Both ways run the same operations on the same numbers for each pair of ray and triangle, so they find the same bits; which one
// runs is a matter of speed (break-even at two to three live rays, docs/performance.md).
//
// Query    vfloat limit() const            lanes' present t_far (a single ray: in all lanes)
//          void offer(lane, t, grid, id)   a hit with t in (t_near, limit]; decides ties and filters
#pragma once

#include <bit>
#include <cfloat>

#include "accel/igrid.h"
#include "accel/triangle.h"

namespace occam::accel {

/// The lanes of rays whose line is in the box between t_near and t_far, a little widened. `negative`: signs of the direction.
inline vmask in_box(const RayLanes& ray, const bool (&negative)[3], const vfloat (&lo)[3], const vfloat (&hi)[3], vfloat t_near,
                    vfloat t_far) noexcept
{
    vfloat in = ((negative[0] ? hi[0] : lo[0]) - ray.origin[0]) * ray.inverse[0];
    vfloat out = ((negative[0] ? lo[0] : hi[0]) - ray.origin[0]) * ray.inverse[0];
    for (int a = 1; a < 3; ++a) {
        in = max(in, ((negative[a] ? hi[a] : lo[a]) - ray.origin[a]) * ray.inverse[a]);
        out = min(out, ((negative[a] ? lo[a] : hi[a]) - ray.origin[a]) * ray.inverse[a]);
    }
    // Three ulps of each t, and the rounding of the shift: culling may never decide a hit.
    const vfloat slack = 4 * FLT_EPSILON;
    const vfloat pad_in = (abs(in) + abs(ray.shift)) * slack, pad_out = (abs(out) + abs(ray.shift)) * slack;
    return (in - pad_in <= out + pad_out) & (ray.shift + in - pad_in <= t_far) & (ray.shift + out + pad_out >= t_near);
}

/// One ray of a packet in all lanes.
inline RayLanes spread(const RayLanes& rays, int lane) noexcept
{
    RayLanes one = rays;
    const auto pick = [&](vfloat& x) {
        float lanes[kLanes];
        x.store(lanes);
        x = lanes[lane];
    };
    pick(one.sx);
    pick(one.sy);
    pick(one.sz);
    pick(one.shift);
    for (int a = 0; a < 3; ++a) {
        pick(one.inverse[a]);
        pick(one.origin[a]);
    }
    return one;
}

template <class Query>
class IGridTracer {
public:
    /// t_near: of the rays, in lanes (a single ray: in all).
    IGridTracer(IGrid& grid, const RayLanes& ray, const bool (&negative)[3], vfloat t_near, Query& query)
        : grid_(grid), ray_(ray), negative_(negative), t_near_(t_near), query_(query)
    {
    }

    /// Lanes are rays.
    void packet(vmask active) noexcept
    {
        int stack[32], size = 0;
        stack[size++] = 0;
        while (size > 0) {
            const int node = stack[--size];
            const vmask alive = active & in_box_at(grid_.boxes, node);
            if (none(alive)) continue;
            if (node < grid_.boxes.first_leaf()) {
                stack[size++] = 2 * node + 2;
                stack[size++] = 2 * node + 1;
                continue;
            }
            const int block = node - grid_.boxes.first_leaf();
            if (grid_.is_tile) quads_packet(block, alive);
            else triangles_packet(block, alive);
        }
        for (int block = 0; block < grid_.closer_blocks; ++block) {
            unsigned lanes = bits(active & in_box_at(grid_.closer_boxes, grid_.closer_boxes.first_leaf() + block));
            for (; lanes != 0; lanes &= lanes - 1) closers_single(block, std::countr_zero(lanes), spread(ray_, std::countr_zero(lanes)));
        }
    }

    /// All lanes hold ray `lane` of the query.
    void single(int lane) noexcept
    {
        for_each_block(grid_.boxes, [&](int block) {
            if (grid_.is_tile) quads_single(block, lane);
            else triangles_single(block, lane);
        });
        if (grid_.closer_blocks > 0) for_each_block(grid_.closer_boxes, [&](int block) { closers_single(block, lane, ray_); });
    }

private:
    vmask in_box_at(const BoxTree& tree, int node) const noexcept
    {
        const vfloat lo[3] = {tree.lo[0][node], tree.lo[1][node], tree.lo[2][node]};
        const vfloat hi[3] = {tree.hi[0][node], tree.hi[1][node], tree.hi[2][node]};
        return in_box(ray_, negative_, lo, hi, t_near_, query_.limit());
    }

    template <class Visit>
    void for_each_block(const BoxTree& tree, Visit&& visit) noexcept
    {
        for (int first = 0; first < tree.leaves; first += kLanes) {
            const int node = tree.first_leaf() + first;
            const vfloat lo[3] = {vfloat::load(tree.lo[0] + node), vfloat::load(tree.lo[1] + node), vfloat::load(tree.lo[2] + node)};
            const vfloat hi[3] = {vfloat::load(tree.hi[0] + node), vfloat::load(tree.hi[1] + node), vfloat::load(tree.hi[2] + node)};
            unsigned hit = bits(in_box(ray_, negative_, lo, hi, t_near_, query_.limit()));
            for (; hit != 0; hit &= hit - 1) visit(first + std::countr_zero(hit));
        }
    }

    /// Offers the hits of a packet with one micropolygon.
    void offer_lanes(const TriangleHit& hit, vmask alive, std::uint32_t id) noexcept
    {
        unsigned lanes = bits(hit.is_hit & alive & (hit.t > t_near_) & (hit.t <= query_.limit()));
        if (lanes == 0) return;
        float t[kLanes];
        hit.t.store(t);
        for (; lanes != 0; lanes &= lanes - 1) query_.offer(std::countr_zero(lanes), t[std::countr_zero(lanes)], grid_, id);
    }
    /// Offers the hits of one ray with lanes of micropolygons; id(lane) numbers them.
    template <class Id>
    void offer_one(const TriangleHit& hit, int ray, Id&& id) noexcept
    {
        unsigned lanes = bits(hit.is_hit & (hit.t > t_near_) & (hit.t <= query_.limit()));
        if (lanes == 0) return;
        float t[kLanes];
        hit.t.store(t);
        for (; lanes != 0; lanes &= lanes - 1) query_.offer(ray, t[std::countr_zero(lanes)], grid_, id(std::countr_zero(lanes)));
    }

    std::uint32_t quad_id(int fast, int slow, int triangle) const noexcept
    {
        return grid_.is_transposed ? make_id(0, slow, fast, 1 - triangle) : make_id(0, fast, slow, triangle);
    }

    void quads_packet(int block, vmask alive) noexcept
    {
        // The fifteen vertices of two strips of four quads are sheared once each. A single row of quads has two strips side by side.
        const std::uint16_t* strips = grid_.block_quads + 2 * block;
        const bool stacked = (strips[0] >> 8) == (strips[1] >> 8);
        const auto sheared = [&](int fast, int slow) {
            const int at = slow * grid_.width + fast;
            const vfloat c[3] = {grid_.rows[0][at], grid_.rows[1][at], grid_.rows[2][at]};
            return shear(ray_, c);
        };
        ShearedVertex low[5], high[5];
        for (int half = 0; half < 2; ++half) {
            const int fast = strips[half] >> 8, slow = strips[half] & 0xff;
            if (half == 1 && stacked && strips[0] == strips[1]) break;
            for (int k = 0; k < 5; ++k) {
                low[k] = half == 1 && stacked ? high[k] : sheared(fast + k, slow);
                high[k] = sheared(fast + k, slow + 1);
            }
            for (int k = 0; k < 4; ++k) {
                offer_lanes(intersect(ray_, low[k], low[k + 1], high[k + 1]), alive, quad_id(fast + k, slow, 0));
                offer_lanes(intersect(ray_, low[k], high[k + 1], high[k]), alive, quad_id(fast + k, slow, 1));
            }
        }
    }

    void quads_single(int block, int lane) noexcept
    {
        const std::uint16_t* strips = grid_.block_quads + 2 * block;
        const int at[2] = {(strips[0] & 0xff) * grid_.width + (strips[0] >> 8), (strips[1] & 0xff) * grid_.width + (strips[1] >> 8)};
        for (int first = 0; first < IGrid::kBlock; first += kLanes) {
            const auto corner = [&](int df, int ds) {
                const int step = ds * grid_.width + df;
                const vfloat c[3] = {vfloat::load_halves(grid_.rows[0] + at[0] + step, grid_.rows[0] + at[1] + step, first),
                                     vfloat::load_halves(grid_.rows[1] + at[0] + step, grid_.rows[1] + at[1] + step, first),
                                     vfloat::load_halves(grid_.rows[2] + at[0] + step, grid_.rows[2] + at[1] + step, first)};
                return shear(ray_, c);
            };
            const ShearedVertex v00 = corner(0, 0), v10 = corner(1, 0), v01 = corner(0, 1), v11 = corner(1, 1);
            const auto id = [&](int k, int triangle) {
                const std::uint16_t strip = strips[(first + k) / 4];
                return quad_id((strip >> 8) + (first + k) % 4, strip & 0xff, triangle);
            };
            offer_one(intersect(ray_, v00, v10, v11), lane, [&](int k) { return id(k, 0); });
            offer_one(intersect(ray_, v00, v11, v01), lane, [&](int k) { return id(k, 1); });
        }
    }

    template <class Load>
    void triangle_vertices(Load&& load, ShearedVertex (&v)[3]) const noexcept
    {
        for (int p = 0; p < 3; ++p) {
            const vfloat c[3] = {load(p * 3), load(p * 3 + 1), load(p * 3 + 2)};
            v[p] = shear(ray_, c);
        }
    }

    void triangles_packet(int block, vmask alive) noexcept
    {
        for (int k = block * IGrid::kBlock; k < (block + 1) * IGrid::kBlock; ++k) {
            if (k % IGrid::kBlock != 0 && grid_.ids[k] == grid_.ids[k - 1]) break;  // only copies follow
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

    /// The float test decides nothing here: its signs are right, but in a triangle without area t is noise along the edge. What
    /// it lets through is done again in double, where the products of floats are exact (watertightness rule 6).
    void closers_single(int block, int lane, const RayLanes& ray) noexcept
    {
        for (int first = block * IGrid::kBlock; first < (block + 1) * IGrid::kBlock; first += kLanes) {
            ShearedVertex v[3];
            for (int p = 0; p < 3; ++p) {
                const vfloat c[3] = {vfloat::load(grid_.closer_corners[p * 3] + first), vfloat::load(grid_.closer_corners[p * 3 + 1] + first),
                                     vfloat::load(grid_.closer_corners[p * 3 + 2] + first)};
                v[p] = shear(ray, c);
            }
            unsigned lanes = bits(is_inside(edge_functions(v[0], v[1], v[2])));
            if (lanes == 0) continue;
            float x[3][kLanes], y[3][kLanes], t[3][kLanes], shift[kLanes], t_near[kLanes], limit[kLanes];
            for (int p = 0; p < 3; ++p) {
                v[p].x.store(x[p]);
                v[p].y.store(y[p]);
                v[p].t.store(t[p]);
            }
            ray.shift.store(shift);
            t_near_.store(t_near);
            query_.limit().store(limit);
            for (; lanes != 0; lanes &= lanes - 1) {
                const int k = std::countr_zero(lanes);
                const auto area = [&](int p, int q) { return double(x[q][k]) * y[p][k] - double(y[q][k]) * x[p][k]; };
                const double u = area(1, 2), w_v = area(2, 0), w = area(0, 1);
                const bool inside = (u >= 0 && w_v >= 0 && w >= 0) || (u <= 0 && w_v <= 0 && w <= 0);
                const double det = u + w_v + w;
                if (!inside || det == 0) continue;
                const double exact = (u * t[0][k] + w_v * t[1][k] + w * t[2][k]) / det;
                const float found = shift[0] + static_cast<float>(exact);
                if (found > t_near[lane] && found <= limit[lane])
                    query_.offer(lane, found, grid_, kCloserBit | static_cast<std::uint32_t>(first + k));
            }
        }
    }

    IGrid& grid_;
    const RayLanes& ray_;
    const bool (&negative_)[3];
    vfloat t_near_;
    Query& query_;
};

}  // namespace occam::accel
