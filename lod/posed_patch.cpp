#include "lod/posed_patch.h"

#include <algorithm>
#include <cmath>

#include "scenegraph/base/check.h"
#include "scenegraph/base/power_of_two.h"

namespace occam::lod {
namespace {

// Local parameter of a piece, exact: all are dyadic.
double local(float t, float t0, int depth) noexcept { return (double(t) - double(t0)) * power_of_two_double(depth); }

// First index of a lattice t0 + i * step (step > 0) with a value of at least `border`.
int first_at(float t0, float step, float border, int begin, int end) noexcept
{
    const int i = static_cast<int>(std::ceil((double(border) - double(t0)) / double(step)));
    return std::clamp(i, begin, end);
}

}  // namespace

void PosedPatch::set(const PosedCage& cage, PatchRef patch)
{
    const PatchControls& controls = cage.topology->controls(patch);
    kind_ = controls.kind;
    pieces_.clear();
    const std::size_t n = controls.indices.size();
    x_.resize(n);
    y_.resize(n);
    z_.resize(n);
    for (std::size_t k = 0; k < n; ++k) {
        const Vec3f p = cage.vertex(controls.indices[k]);
        x_[k] = p.x;
        y_[k] = p.y;
        z_[k] = p.z;
    }
}

void PosedPatch::set_uv(const PosedCage& cage, PatchRef patch, int uv_set)
{
    const PatchControls& controls = cage.topology->uv_controls(patch, uv_set);
    kind_ = controls.kind;
    pieces_.clear();
    const std::size_t n = controls.indices.size();
    x_.resize(n);
    y_.resize(n);
    z_.assign(n, 0);
    for (std::size_t k = 0; k < n; ++k) {
        const Vec2f st = cage.slot->cage.uv_sets[uv_set].values[controls.indices[k]];
        x_[k] = st.x;
        y_[k] = st.y;
    }
}

const PieceControls& PosedPatch::piece(const PatchClass::Node& node)
{
    for (const Piece& made : pieces_)
        if (made.node == &node) return made.controls;
    Piece& made = pieces_.emplace_back();
    made.node = &node;
    const float* values[3] = {x_.data(), y_.data(), z_.data()};
    if (node.is_plain) {
        for (int a = 0; a < 3; ++a)
            for (int i = 0; i < 16; ++i) made.controls.c[a][i] = values[a][node.order[i]];
        return made.controls;
    }
    const std::size_t n = x_.size();
    for (int i = 0; i < 16; i += kLanes) {
        vfloat sum[3] = {0.0f, 0.0f, 0.0f};
        for (std::size_t k = 0; k < n; ++k) {
            const vfloat w = vfloat::load(&node.weights[k * 16 + i]);
            for (int a = 0; a < 3; ++a) sum[a] = fma(w, values[a][k], sum[a]);
        }
        for (int a = 0; a < 3; ++a) sum[a].store(&made.controls.c[a][i]);
    }
    return made.controls;
}

SurfacePoint PosedPatch::direct(const PatchClass::Node& leaf, float u, float v)
{
    const std::size_t n = x_.size();
    rows_.resize(3 * n);
    kind_->direct_rows(leaf, u, v, rows_.data());
    const auto apply = [&](const float* row) {
        Vec3f sum(0);
        for (std::size_t k = 0; k < n; ++k) sum = {fma(row[k], x_[k], sum.x), fma(row[k], y_[k], sum.y), fma(row[k], z_[k], sum.z)};
        return sum;
    };
    return {apply(&rows_[0]), apply(&rows_[n]), apply(&rows_[2 * n])};
}

template <bool kTangents>
void PosedPatch::fill_piece(const PatchClass::Node& node, const ParameterGrid& grid, int i0, int i1, int j0, int j1, float* const* out,
                            int stride)
{
    constexpr int kMaxColumns = 32;
    OCCAM_DCHECK_LE(i1 - i0, kMaxColumns);
    const PieceControls& net = piece(node);
    const float scale = power_of_two(node.depth);  // of derivatives, from the piece's parameter to the patch's
    alignas(32) float wu[4][kMaxColumns + 8], du[4][kMaxColumns + 8];
    for (int i = i0; i < i1; ++i) {
        const double t = local(grid.u0 + float(i) * grid.step_u, node.u0, node.depth);
        const CubicWeights w = cubic_weights(t);
        for (int k = 0; k < 4; ++k) wu[k][i - i0] = w.b[k];
        if constexpr (kTangents) {
            const CubicWeights d = cubic_derivative_weights(t);
            for (int k = 0; k < 4; ++k) du[k][i - i0] = d.b[k] * scale;
        }
    }
    // Lanes past the last column compute on what is there and are not stored.
    for (int k = 0; k < 4; ++k)
        for (int i = i1 - i0; i < ((i1 - i0 + 7) & ~7); ++i) wu[k][i] = du[k][i] = 0;
    const auto store = [&](vfloat value, float* to, int count) {
        if (count >= kLanes) return value.store(to);
        alignas(32) float lanes[kLanes];
        value.store(lanes);
        std::copy(lanes, lanes + count, to);
    };
    for (int j = j0; j < j1; ++j) {
        const double t = local(grid.v0 + float(j) * grid.step_v, node.v0, node.depth);
        const CurveControls row = row_controls(net, cubic_weights(t));
        CurveControls slope{};
        if constexpr (kTangents) {
            CubicWeights d = cubic_derivative_weights(t);
            for (float& b : d.b) b *= scale;
            slope = row_controls(net, d);
        }
        for (int i = i0; i < i1; i += kLanes) {
            const int at = j * stride + i, count = std::min(kLanes, i1 - i), c = i - i0;
            const auto sum = [&](const float(*w)[kMaxColumns + 8], const float* q) {
                vfloat s = vfloat::load(&w[0][c]) * vfloat(q[0]);
                s = fma(vfloat::load(&w[1][c]), q[1], s);
                s = fma(vfloat::load(&w[2][c]), q[2], s);
                return fma(vfloat::load(&w[3][c]), q[3], s);
            };
            for (int a = 0; a < 3; ++a) {
                store(sum(wu, row.c[a]), out[a] + at, count);
                if constexpr (kTangents) {
                    store(sum(du, row.c[a]), out[3 + a] + at, count);
                    store(sum(wu, slope.c[a]), out[6 + a] + at, count);
                }
            }
        }
    }
}

template <bool kTangents>
void PosedPatch::fill(const PatchClass::Node& node, const ParameterGrid& grid, int i0, int i1, int j0, int j1, float* const* out, int stride)
{
    if (i0 == i1 || j0 == j1) return;
    kind_->resolve(node);
    switch (node.kind.load(std::memory_order_relaxed)) {
        case PatchClass::Node::Bicubic: fill_piece<kTangents>(node, grid, i0, i1, j0, j1, out, stride); break;
        case PatchClass::Node::Split: {
            const float half = node.size() * 0.5f;
            const int im = first_at(grid.u0, grid.step_u, node.u0 + half, i0, i1);
            const int jm = first_at(grid.v0, grid.step_v, node.v0 + half, j0, j1);
            fill<kTangents>(node.children[0], grid, i0, im, j0, jm, out, stride);
            fill<kTangents>(node.children[1], grid, im, i1, j0, jm, out, stride);
            fill<kTangents>(node.children[2], grid, i0, im, jm, j1, out, stride);
            fill<kTangents>(node.children[3], grid, im, i1, jm, j1, out, stride);
            break;
        }
        default:
            for (int j = j0; j < j1; ++j)
                for (int i = i0; i < i1; ++i) {
                    const SurfacePoint s = direct(node, grid.u0 + float(i) * grid.step_u, grid.v0 + float(j) * grid.step_v);
                    const Vec3f* parts[3] = {&s.p, &s.du, &s.dv};
                    for (int d = 0; d < (kTangents ? 3 : 1); ++d)
                        for (int a = 0; a < 3; ++a) out[d * 3 + a][j * stride + i] = (*parts[d])[a];
                }
    }
}

void PosedPatch::points(const ParameterGrid& grid, float* x, float* y, float* z, int stride)
{
    float* const out[3] = {x, y, z};
    fill<false>(kind_->root(), grid, 0, grid.columns, 0, grid.rows, out, stride);
}

void PosedPatch::points_and_tangents(const ParameterGrid& grid, float* const out[9], int stride)
{
    fill<true>(kind_->root(), grid, 0, grid.columns, 0, grid.rows, out, stride);
}

void PosedPatch::fill_curve(const PatchClass::Node& node, bool along_v, float fixed, float t0, float step, int i0, int i1, Vec3f* out)
{
    if (i0 == i1) return;
    kind_->resolve(node);
    const auto kind = node.kind.load(std::memory_order_relaxed);
    const float from = along_v ? node.v0 : node.u0, across = along_v ? node.u0 : node.v0;
    if (kind == PatchClass::Node::Split) {
        const float half = node.size() * 0.5f;
        const int side = fixed >= across + half;
        const int low = along_v ? side : side * 2, high = low + (along_v ? 2 : 1);
        int im = first_at(t0, step, from + half, i0, i1);
        if (step < 0) {
            im = i0;
            while (im < i1 && t0 + float(im) * step >= from + half) ++im;
            fill_curve(node.children[high], along_v, fixed, t0, step, i0, im, out);
            return fill_curve(node.children[low], along_v, fixed, t0, step, im, i1, out);
        }
        fill_curve(node.children[low], along_v, fixed, t0, step, i0, im, out);
        return fill_curve(node.children[high], along_v, fixed, t0, step, im, i1, out);
    }
    if (kind == PatchClass::Node::Direct) {
        for (int i = i0; i < i1; ++i) {
            const float t = t0 + float(i) * step;
            out[i] = along_v ? direct(node, fixed, t).p : direct(node, t, fixed).p;
        }
        return;
    }
    const CubicWeights w = cubic_weights(local(fixed, across, node.depth));
    const CurveControls q = along_v ? column_controls(piece(node), w) : row_controls(piece(node), w);
    for (int i = i0; i < i1; ++i) out[i] = lod::curve_point(q, cubic_weights(local(t0 + float(i) * step, from, node.depth)));
}

void PosedPatch::curve(bool along_v, float fixed, float t0, float step, std::span<Vec3f> out)
{
    fill_curve(kind_->root(), along_v, fixed, t0, step, 0, static_cast<int>(out.size()), out.data());
}

Vec3f PosedPatch::point(float u, float v)
{
    Vec3f p;
    curve(false, v, u, 1, {&p, 1});
    return p;
}

template <class Use>
void PosedPatch::for_results(const WeightRows& rows, Use&& use) const
{
    // A whole group at once: sums that wait for one another leave room for others.
    constexpr std::size_t kVectors = WeightRows::kGroup / kLanes;
    const std::size_t n = x_.size();
    for (std::size_t g = 0; g < rows.group_count(); ++g) {
        const float* w = rows.group(g);
        vfloat x[kVectors], y[kVectors], z[kVectors];
        for (std::size_t i = 0; i < kVectors; ++i) x[i] = y[i] = z[i] = 0.0f;
        for (std::size_t k = 0; k < n; ++k)
            for (std::size_t i = 0; i < kVectors; ++i, w += kLanes) {
                const vfloat weight = vfloat::load(w);
                x[i] = fma(weight, x_[k], x[i]);
                y[i] = fma(weight, y_[k], y[i]);
                z[i] = fma(weight, z_[k], z[i]);
            }
        for (std::size_t i = 0; i < kVectors; ++i) use(x[i], y[i], z[i]);
    }
}

float PosedPatch::largest_length(const WeightRows& rows) const
{
    vfloat largest = 0.0f;
    for_results(rows, [&](vfloat x, vfloat y, vfloat z) { largest = max(largest, fma(x, x, fma(y, y, z * z))); });
    float lanes[kLanes];
    largest.store(lanes);
    return std::sqrt(*std::max_element(lanes, lanes + kLanes));
}

float PosedPatch::side_speed(int side) const { return largest_length(kind_->hull().side_speed[std::size_t(side)]); }

void PosedPatch::speeds(float& along_u, float& along_v) const
{
    along_u = largest_length(kind_->hull().speed_u);
    along_v = largest_length(kind_->hull().speed_v);
}

Box3f PosedPatch::whole_bounds() const
{
    const PatchHull& hull = kind_->hull();
    vfloat lo[3], hi[3];
    for (int a = 0; a < 3; ++a) lo[a] = std::numeric_limits<float>::infinity(), hi[a] = -std::numeric_limits<float>::infinity();
    for_results(hull.points, [&](vfloat x, vfloat y, vfloat z) {
        const vfloat p[3] = {x, y, z};
        for (int a = 0; a < 3; ++a) lo[a] = min(lo[a], p[a]), hi[a] = max(hi[a], p[a]);
    });
    Box3f box;
    for (int a = 0; a < 3; ++a) {
        float lanes[kLanes];
        lo[a].store(lanes);
        box.lo[a] = *std::min_element(lanes, lanes + kLanes);
        hi[a].store(lanes);
        box.hi[a] = *std::max_element(lanes, lanes + kLanes);
    }
    float p[3][WeightRows::kGroup];
    std::size_t made = 0;
    for_results(hull.corners, [&](vfloat x, vfloat y, vfloat z) {
        x.store(p[0] + made);
        y.store(p[1] + made);
        z.store(p[2] + made);
        made += kLanes;
        if (made < WeightRows::kGroup) return;
        made = 0;
        for (std::size_t square = 0; square < WeightRows::kGroup; square += 4) {
            Box3f corners;
            for (std::size_t c = square; c < square + 4; ++c) corners.add(Vec3f(p[0][c], p[1][c], p[2][c]));
            box.add({corners.lo - corners.extent(), corners.hi + corners.extent()});
        }
    });
    return box;
}

void PosedPatch::bounds_below(const PatchClass::Node& node, float u0, float u1, float v0, float v1, Box3f& box)
{
    const float size = node.size();
    if (node.u0 > u1 || node.u0 + size < u0 || node.v0 > v1 || node.v0 + size < v0) return;
    kind_->resolve(node);
    const auto kind = node.kind.load(std::memory_order_relaxed);
    if (kind == PatchClass::Node::Split) {
        for (int c = 0; c < 4; ++c) bounds_below(node.children[c], u0, u1, v0, v1, box);
        return;
    }
    if (kind == PatchClass::Node::Direct) {
        Box3f corners;
        for (int c = 0; c < 4; ++c) corners.add(direct(node, node.u0 + (c & 1 ? size : 0), node.v0 + (c & 2 ? size : 0)).p);
        box.add({corners.lo - corners.extent(), corners.hi + corners.extent()});
        return;
    }
    const auto clip = [&](float t, float t0) { return std::clamp(local(t, t0, node.depth), 0.0, 1.0); };
    const BezierWeights along = bezier_weights(clip(u0, node.u0), clip(u1, node.u0));
    const BezierWeights across = bezier_weights(clip(v0, node.v0), clip(v1, node.v0));
    const PieceControls& net = piece(node);
    for (int j = 0; j < 4; ++j) {
        const CurveControls row = row_controls(net, across.row[j]);
        for (int i = 0; i < 4; ++i) box.add(lod::curve_point(row, along.row[i]));
    }
}

Box3f PosedPatch::bounds(float u0, float u1, float v0, float v1)
{
    Box3f box;
    if (u0 == 0 && u1 == 1 && v0 == 0 && v1 == 1) box = whole_bounds();
    else bounds_below(kind_->root(), u0, u1, v0, v1, box);
    // Owners' points differ from the patch's own by rounding, and so do those of a hull's rows, one sum of all control points.
    const Vec3f pad(box.largest_coordinate() * 64 * std::numeric_limits<float>::epsilon());
    return {box.lo - pad, box.hi + pad};
}

}  // namespace occam::lod
