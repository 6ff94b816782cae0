#include "lod/posed_patch.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "lod/piece_parameter.h"

namespace occam::lod {
namespace {

// Returns the first index of a lattice t0 + i * step (step > 0) with a value of at least `border`.
int first_at(float t0, float step, float border, int begin, int end) noexcept
{
    const int i = static_cast<int>(std::ceil((double(border) - double(t0)) / double(step)));
    return std::clamp(i, begin, end);
}

}  // namespace

void PosedPatch::forget()
{
    pieces_.clear();
    is_measured_ = false;
    distance_ = Distance::Unknown;
    reach_ = -1;
    side_speed_.fill(-1);
}

// Grows the vectors if needed. They never shrink, and old content is overwritten. If there is no memory for one of them, the
// others may have grown.
void PosedPatch::make_room(std::size_t count, std::size_t moves)
{
    // z_ grows last, so it tells whether all have room.
    if (z_.size() < count)
        for (std::vector<float>* values : {&x_, &y_, &z_})
            if (values->size() < count) values->resize(count);
    count_ = count;
    point_count_ = count - moves;
}

void PosedPatch::set(const PosedCage& cage, PatchRef patch)
{
    const PatchControls& controls = cage.topology->controls(patch);
    kind_ = controls.kind;
    forget();
    make_room(controls.indices.size(), controls.move_count);
    for (std::size_t k = 0; k < count_; ++k) {
        const Vec3f p = controls.are_derived ? cage.derived[controls.indices[k]] : cage.vertex(controls.indices[k]);
        x_[k] = p.x;
        y_[k] = p.y;
        z_[k] = p.z;
    }
}

void PosedPatch::set_linear_uv(const PosedCage& cage, PatchRef patch, int uv_set)
{
    kind_ = &cage.topology->linear_class();
    forget();
    make_room(4);
    const Cage& of = cage.slot->cage;
    const UvSet& set = of.uv_sets[static_cast<std::size_t>(uv_set)];
    const std::vector<std::uint32_t>& indices = set.indices.empty() ? of.face_vertices : set.indices;
    const std::size_t first = cage.topology->first_corner(patch.face), size = cage.topology->face_size(patch.face);
    const auto at = [&](std::size_t corner) { return set.values[indices[first + corner % size]]; };
    std::array<Vec2f, 4> corners;
    if (size == 4) {
        for (std::size_t c = 0; c < 4; ++c) corners[c] = at(c);
    } else {
        glm::dvec2 sum(0);
        for (std::size_t c = 0; c < size; ++c) sum += glm::dvec2(at(c));
        const Vec2f own = at(patch.sub);
        corners = {own, (own + at(patch.sub + 1)) * 0.5f, Vec2f(sum / double(size)),
                   (own + at(patch.sub + size - 1)) * 0.5f};
    }
    for (std::size_t c = 0; c < 4; ++c) {
        x_[c] = corners[c].x;
        y_[c] = corners[c].y;
        z_[c] = 0;
    }
}

void PosedPatch::set_uv(const PosedCage& cage, PatchRef patch, int uv_set)
{
    if (cage.topology->has_linear_uv(patch.face)) return set_linear_uv(cage, patch, uv_set);
    const PatchControls& controls = cage.topology->uv_controls(patch, uv_set);
    kind_ = controls.kind;
    forget();
    make_room(controls.indices.size());
    for (std::size_t k = 0; k < count_; ++k) {
        const Vec2f st = cage.slot->cage.uv_sets[uv_set].values[controls.indices[k]];
        x_[k] = st.x;
        y_[k] = st.y;
        z_[k] = 0;
    }
}

const PieceControls* PosedPatch::find_piece(const float* weights, bool is_relative) const noexcept
{
    for (const Piece& made : pieces_)
        if (made.weights == weights && made.is_relative == is_relative) return &made.controls;
    return nullptr;
}

const PieceControls& PosedPatch::piece(const PatchClass::Node& node)
{
    if (const PieceControls* known = find_piece(node.weights.get(), false)) return *known;
    Piece& made = pieces_.emplace_back();
    made.weights = node.weights.get();
    made.is_relative = false;
    const float* values[3] = {x_.data(), y_.data(), z_.data()};
    if (node.is_plain) {
        for (int a = 0; a < 3; ++a)
            for (int i = 0; i < 16; ++i) made.controls.c[a][i] = values[a][node.order[i]];
        return made.controls;
    }
    for (int i = 0; i < 16; i += kLanes) {
        vfloat sum[3] = {0.0f, 0.0f, 0.0f};
        for (std::size_t row = 0; row < node.control_count; ++row) {
            const std::uint32_t k = node.controls[row];
            const vfloat w = vfloat::load(&node.weights[row * 16 + i]);
            for (int a = 0; a < 3; ++a) sum[a] = fma(w, values[a][k], sum[a]);
        }
        for (int a = 0; a < 3; ++a) sum[a].store(&made.controls.c[a][i]);
    }
    return made.controls;
}

bool PosedPatch::is_far()
{
    // Nearer to the origin, the rounding of the control points turns no normal by more than a fifth of a degree.
    constexpr float kFar = 32;
    if (distance_ != Distance::Unknown) return distance_ == Distance::Far;
    float extent = 0;
    for (std::size_t k = 1; k < point_count_; ++k)
        extent = std::max({extent, std::fabs(x_[k] - x_[0]), std::fabs(y_[k] - y_[0]), std::fabs(z_[k] - z_[0])});
    distance_ = reach() > kFar * extent ? Distance::Far : Distance::Near;
    return distance_ == Distance::Far;
}

bool PosedPatch::needs_differences(int depth)
{
    constexpr int kLeastDepth = 4;  // larger pieces lose little, and are all that most grids need
    return PatchClass::is_deep(depth) || (depth >= kLeastDepth && is_far());
}

// The patch's first control point is subtracted from all of them here, so that their rounding errors are small beside the
// patch. The weights of differences add up to 0, so what was subtracted cancels. Other weights add up to 1, so each control
// of a row or column lacks the first control point once. Moves are vectors, and their weights add up to neither: they stay
// as they are.
const PieceControls& PosedPatch::differences(const PatchClass::Node& node, bool along_v)
{
    const std::size_t count = node.control_count;
    const std::size_t matrix = !PatchClass::is_deep(along_v ? node.depth_v : node.depth_u) ? 0
                               : along_v && PatchClass::is_deep(node.depth_u)              ? 2
                                                                                           : 1;
    const float* weights = node.weights.get() + 16 * count * matrix;
    if (const PieceControls* known = find_piece(weights, true)) return *known;
    Piece& made = pieces_.emplace_back();
    made.weights = weights;
    made.is_relative = true;
    const Vec3f first(x_[0], y_[0], z_[0]);
    for (int i = 0; i < 16; i += kLanes) {
        vfloat sum[3] = {0.0f, 0.0f, 0.0f};
        for (std::size_t row = 0; row < count; ++row) {
            const std::uint32_t k = node.controls[row];
            const vfloat w = vfloat::load(&weights[row * 16 + i]);
            const Vec3f from = k < point_count_ ? first : Vec3f(0);
            sum[0] = fma(w, x_[k] - from.x, sum[0]);
            sum[1] = fma(w, y_[k] - from.y, sum[1]);
            sum[2] = fma(w, z_[k] - from.z, sum[2]);
        }
        for (int a = 0; a < 3; ++a) sum[a].store(&made.controls.c[a][i]);
    }
    return made.controls;
}

SurfacePoint PosedPatch::direct(const PatchClass::Node& leaf, float u, float v)
{
    const std::size_t n = count_;
    rows_.resize(3 * n);
    kind_->direct_rows(leaf, u, v, rows_.data());
    const auto apply = [&](const float* row) {
        Vec3f sum(0);
        for (std::size_t k = 0; k < n; ++k)
            sum = {fma(row[k], x_[k], sum.x), fma(row[k], y_[k], sum.y), fma(row[k], z_[k], sum.z)};
        return sum;
    };
    return {apply(&rows_[0]), apply(&rows_[n]), apply(&rows_[2 * n])};
}

template <bool kTangents>
void PosedPatch::fill_piece(const PatchClass::Node& node, const ParameterGrid& grid, const GridPart& part, const Rows& rows)
{
    const auto [i0, i1, j0, j1] = part;
    const auto [out, stride] = rows;
    constexpr int kMaxColumns = 32;
    OCCAM_DCHECK_LE(i1 - i0, kMaxColumns);
    const bool differs_u = kTangents && needs_differences(node.depth_u),
               differs_v = kTangents && needs_differences(node.depth_v);
    PieceControls in_rows, in_columns;
    if (differs_u) in_rows = differences(node, false);
    if (differs_v) in_columns = differences(node, true);
    const PieceControls& net = piece(node);
    // Derivatives grow by these factors from the piece's parameters to the patch's.
    const float scale_u = power_of_two(node.depth_u), scale_v = power_of_two(node.depth_v);
    alignas(32) float wu[4][kMaxColumns + 8], du[4][kMaxColumns + 8];
    for (int i = i0; i < i1; ++i) {
        const double t = local(grid.u0 + float(i) * grid.step_u, node.u0, node.depth_u);
        const CubicWeights w = cubic_weights(t);
        for (int k = 0; k < 4; ++k) wu[k][i - i0] = w.b[k];
        if constexpr (kTangents) {
            const CubicWeights d = cubic_derivative_weights(t);
            for (int k = 0; k < 4; ++k) du[k][i - i0] = d.b[k] * scale_u;
        }
    }
    // Lanes past the last column compute on zeros, and their results are not stored.
    for (int k = 0; k < 4; ++k)
        for (int i = i1 - i0; i < ((i1 - i0 + 7) & ~7); ++i) wu[k][i] = du[k][i] = 0;
    const auto store = [&](vfloat value, float* to, int count) {
        if (count >= kLanes) return value.store(to);
        alignas(32) float lanes[kLanes];
        value.store(lanes);
        std::copy(lanes, lanes + count, to);
    };
    for (int j = j0; j < j1; ++j) {
        const double t = local(grid.v0 + float(j) * grid.step_v, node.v0, node.depth_v);
        const CubicWeights across = cubic_weights(t);
        const CurveControls row = row_controls(net, across);
        CurveControls change, slope{};
        if constexpr (kTangents) {
            CubicWeights d = cubic_derivative_weights(t);
            for (float& b : d.b) b *= scale_v;
            slope = row_controls(differs_v ? in_columns : net, d);
            if (differs_u) change = row_controls(in_rows, across);
        }
        const CurveControls& along_u = differs_u ? change : row;
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
                    store(sum(du, along_u.c[a]), out[3 + a] + at, count);
                    store(sum(wu, slope.c[a]), out[6 + a] + at, count);
                }
            }
        }
    }
}

template <bool kTangents>
void PosedPatch::fill(const PatchClass::Node& node, const ParameterGrid& grid, const GridPart& part, const Rows& rows)
{
    const auto [i0, i1, j0, j1] = part;
    if (i0 == i1 || j0 == j1) return;
    kind_->resolve(node);
    switch (node.kind.load(std::memory_order_relaxed)) {
        case PatchClass::Node::Bicubic:
            fill_piece<kTangents>(node, grid, part, rows);
            break;
        case PatchClass::Node::Split: {
            const int im = node.halves_u ? first_at(grid.u0, grid.step_u, node.u0 + node.size_u() * 0.5f, i0, i1) : i1;
            const int jm = node.halves_v ? first_at(grid.v0, grid.step_v, node.v0 + node.size_v() * 0.5f, j0, j1) : j1;
            fill<kTangents>(node.child(0, 0), grid, {i0, im, j0, jm}, rows);
            fill<kTangents>(node.child(1, 0), grid, {im, i1, j0, jm}, rows);
            fill<kTangents>(node.child(0, 1), grid, {i0, im, jm, j1}, rows);
            fill<kTangents>(node.child(1, 1), grid, {im, i1, jm, j1}, rows);
            break;
        }
        case PatchClass::Node::Unknown:  // resolve() leaves none
        case PatchClass::Node::Direct:
            for (int j = j0; j < j1; ++j)
                for (int i = i0; i < i1; ++i) {
                    const SurfacePoint s = direct(node, grid.u0 + float(i) * grid.step_u, grid.v0 + float(j) * grid.step_v);
                    const Vec3f* parts[3] = {&s.p, &s.du, &s.dv};
                    for (int d = 0; d < (kTangents ? 3 : 1); ++d)
                        for (int a = 0; a < 3; ++a) rows.out[d * 3 + a][j * rows.stride + i] = (*parts[d])[a];
                }
    }
}

void PosedPatch::points(const ParameterGrid& grid, float* x, float* y, float* z, int stride)
{
    float* const out[3] = {x, y, z};
    fill<false>(kind_->root(), grid, {0, grid.columns, 0, grid.rows}, {out, stride});
}

void PosedPatch::points_and_tangents(const ParameterGrid& grid, float* const out[9], int stride)
{
    fill<true>(kind_->root(), grid, {0, grid.columns, 0, grid.rows}, {out, stride});
}

void PosedPatch::fill_curve(const PatchClass::Node& node, const CurvePoints& curve, int i0, int i1)
{
    if (i0 == i1) return;
    const auto [along_v, fixed, t0, step, out] = curve;
    kind_->resolve(node);
    const auto kind = node.kind.load(std::memory_order_relaxed);
    const float from = along_v ? node.v0 : node.u0, across = along_v ? node.u0 : node.v0;
    const int depth_along = along_v ? node.depth_v : node.depth_u, depth_across = along_v ? node.depth_u : node.depth_v;
    if (kind == PatchClass::Node::Split) {
        const float half = (along_v ? node.size_v() : node.size_u()) * 0.5f;
        const int side = fixed >= across + (along_v ? node.size_u() : node.size_v()) * 0.5f;
        const PatchClass::Node& low = along_v ? node.child(side, 0) : node.child(0, side);
        const PatchClass::Node& high = along_v ? node.child(side, 1) : node.child(1, side);
        if (&low == &high) return fill_curve(low, curve, i0, i1);
        int im = first_at(t0, step, from + half, i0, i1);
        if (step < 0) {
            im = i0;
            while (im < i1 && t0 + float(im) * step >= from + half) ++im;
            fill_curve(high, curve, i0, im);
            return fill_curve(low, curve, im, i1);
        }
        fill_curve(low, curve, i0, im);
        return fill_curve(high, curve, im, i1);
    }
    if (kind == PatchClass::Node::Direct) {
        for (int i = i0; i < i1; ++i) {
            const float t = t0 + float(i) * step;
            out[i] = along_v ? direct(node, fixed, t).p : direct(node, t, fixed).p;
        }
        return;
    }
    const CubicWeights w = cubic_weights(local(fixed, across, depth_across));
    const CurveControls q = along_v ? column_controls(piece(node), w) : row_controls(piece(node), w);
    for (int i = i0; i < i1; ++i)
        out[i] = lod::curve_point(q, cubic_weights(local(t0 + float(i) * step, from, depth_along)));
}

void PosedPatch::curve(bool along_v, float fixed, float t0, float step, std::span<Vec3f> out)
{
    fill_curve(kind_->root(), {along_v, fixed, t0, step, out.data()}, 0, static_cast<int>(out.size()));
}

Vec3f PosedPatch::point(float u, float v)
{
    Vec3f p;
    curve(false, v, u, 1, {&p, 1});
    return p;
}

}  // namespace occam::lod
