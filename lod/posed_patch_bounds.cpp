// Measures a posed patch: its boxes, and the largest speeds of its curves.
#include <algorithm>
#include <cmath>

#include "lod/piece_parameter.h"
#include "lod/posed_patch.h"

namespace occam::lod {

PosedPatch::Points PosedPatch::points(const PatchHull& hull, std::size_t group) const
{
    const std::uint32_t first = hull.first_rows[group], end = hull.first_rows[group + 1];
    const float* w = hull.weights.data() + std::size_t(first) * 16;
    Points p{0.0f, 0.0f, 0.0f};
    for (std::uint32_t row = first; row < end; ++row, w += 16) {
        const std::uint32_t k = hull.controls[row];
        prefetch(w + PatchHull::kAhead);
        const vfloat4x4 weight = vfloat4x4::load(w);
        p.x = fma(weight, vfloat(x_[k]), p.x);
        p.y = fma(weight, vfloat(y_[k]), p.y);
        p.z = fma(weight, vfloat(z_[k]), p.z);
    }
    return p;
}

void PosedPatch::measure()
{
    if (is_measured_) return;
    is_measured_ = true;
    const PatchHull& hull = kind_->hull();
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    vfloat4x4 lo[3] = {kInfinity, kInfinity, kInfinity}, hi[3] = {-kInfinity, -kInfinity, -kInfinity};
    // These are the squares of the largest differences from column to column and from row to row.
    vfloat4x4 along = 0.0f, down = 0.0f;
    const auto squared = [](vfloat4x4 x, vfloat4x4 y, vfloat4x4 z) { return fma(x, x, fma(y, y, z * z)); };
    box_ = {};
    for (std::size_t g = 0; g < hull.squares; ++g) {
        const Points p = points(hull, g);
        const vfloat4x4 scale_u = hull.speeds[g][0] * hull.speeds[g][0], scale_v = hull.speeds[g][1] * hull.speeds[g][1];
        along = max(along, squared(p.x.next_column() - p.x, p.y.next_column() - p.y, p.z.next_column() - p.z) * scale_u);
        down = max(down, squared(p.x.next_row() - p.x, p.y.next_row() - p.y, p.z.next_row() - p.z) * scale_v);
        if (g < hull.nets) {
            const vfloat4x4 all[3] = {p.x, p.y, p.z};
            for (int a = 0; a < 3; ++a) lo[a] = min(lo[a], all[a]), hi[a] = max(hi[a], all[a]);
            continue;
        }
        const Box3f lattice{{smallest(p.x), smallest(p.y), smallest(p.z)}, {largest(p.x), largest(p.y), largest(p.z)}};
        const Vec3f growth = lattice.extent() * PatchHull::kLatticeGrowth;
        box_.add({lattice.lo - growth, lattice.hi + growth});
    }
    box_.add({{smallest(lo[0]), smallest(lo[1]), smallest(lo[2])}, {largest(hi[0]), largest(hi[1]), largest(hi[2])}});
    // The differences of the last column and the last row wrap around to the first and do not count.
    alignas(32) static constexpr float kNotLastColumn[16] = {1, 1, 1, 0, 1, 1, 1, 0, 1, 1, 1, 0, 1, 1, 1, 0};
    alignas(32) static constexpr float kNotLastRow[16] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0};
    speed_u_ = std::sqrt(largest(along * vfloat4x4::load(kNotLastColumn)));
    speed_v_ = std::sqrt(largest(down * vfloat4x4::load(kNotLastRow)));
    if (!hull.is_one_square()) return;
    float u[16], v[16];
    along.store(u);
    down.store(v);
    side_speed_ = {std::sqrt(std::max({u[0], u[1], u[2]})), std::sqrt(std::max({v[3], v[7], v[11]})),
                   std::sqrt(std::max({u[12], u[13], u[14]})), std::sqrt(std::max({v[0], v[4], v[8]}))};
}

float PosedPatch::side_speed(int side)
{
    const auto s = static_cast<std::size_t>(side);
    if (side_speed_[s] >= 0) return side_speed_[s];
    const PatchHull& hull = kind_->hull();
    if (hull.is_one_square()) {
        measure();
        return side_speed_[s];
    }
    const PatchHull::Side& at = hull.sides[s];
    float most = 0;
    for (std::size_t g = at.first; g < std::size_t(at.first) + at.count; ++g) {
        const Points p = points(hull, g);
        const vfloat4x4 x = p.x.next_column() - p.x, y = p.y.next_column() - p.y, z = p.z.next_column() - p.z;
        float squared[16];
        fma(x, x, fma(y, y, z * z)).store(squared);
        for (std::size_t row = at.first_row; row < at.row_end; ++row) {
            const float* d = squared + row * 4;
            most = std::max(most, std::sqrt(std::max({d[0], d[1], d[2]})) * hull.speeds[g][row]);
        }
    }
    return side_speed_[s] = most;
}

void PosedPatch::speeds(float& along_u, float& along_v)
{
    measure();
    along_u = speed_u_;
    along_v = speed_v_;
}

float PosedPatch::reach()
{
    if (reach_ >= 0) return reach_;
    reach_ = 0;
    for (std::size_t k = 0; k < count_; ++k)
        reach_ = std::max({reach_, std::fabs(x_[k]), std::fabs(y_[k]), std::fabs(z_[k])});
    return reach_;
}

void PosedPatch::bounds_below(const PatchClass::Node& node, float u0, float u1, float v0, float v1, Box3f& box)
{
    const float size_u = node.size_u(), size_v = node.size_v();
    if (node.u0 > u1 || node.u0 + size_u < u0 || node.v0 > v1 || node.v0 + size_v < v0) return;
    kind_->resolve(node);
    const auto kind = node.kind.load(std::memory_order_relaxed);
    if (kind == PatchClass::Node::Split) {
        for (int c = 0; c < node.child_count(); ++c) bounds_below(node.children[c], u0, u1, v0, v1, box);
        return;
    }
    if (kind == PatchClass::Node::Direct) {
        // Next to an extraordinary vertex the surface is no quadratic, so the box of the points is grown by more than
        // PatchHull::kLatticeGrowth.
        const float from_u = std::max(u0, node.u0), half_u = 0.5f * (std::min(u1, node.u0 + size_u) - from_u),
                    from_v = std::max(v0, node.v0), half_v = 0.5f * (std::min(v1, node.v0 + size_v) - from_v);
        Box3f lattice;
        for (int k = 0; k < 9; ++k)
            lattice.add(direct(node, from_u + half_u * float(k % 3), from_v + half_v * float(k / 3)).p);
        box.add({lattice.lo - lattice.extent(), lattice.hi + lattice.extent()});
        return;
    }
    const auto clip = [](float t, float t0, int depth) { return std::clamp(local(t, t0, depth), 0.0, 1.0); };
    const BezierWeights along = bezier_weights(clip(u0, node.u0, node.depth_u), clip(u1, node.u0, node.depth_u));
    const BezierWeights across = bezier_weights(clip(v0, node.v0, node.depth_v), clip(v1, node.v0, node.depth_v));
    const PieceControls& net = piece(node);
    for (int j = 0; j < 4; ++j) {
        const CurveControls row = row_controls(net, across.row[j]);
        for (int i = 0; i < 4; ++i) box.add(lod::curve_point(row, along.row[i]));
    }
}

Box3f PosedPatch::bounds(float u0, float u1, float v0, float v1)
{
    Box3f box;
    if (u0 == 0 && u1 == 1 && v0 == 0 && v1 == 1) {
        measure();
        box = box_;
    } else {
        bounds_below(kind_->root(), u0, u1, v0, v1, box);
    }
    // Vertices and hulls are sums of all n control points, so each may be off by n / 2 ulps of the largest one. Around a
    // pole, where many weights are equal, rounding errors do add up to this. Points of owners differ from the patch's own by
    // as much.
    const Vec3f pad(reach() * (48 + float(count_)) * std::numeric_limits<float>::epsilon());
    return {box.lo - pad, box.hi + pad};
}

}  // namespace occam::lod
