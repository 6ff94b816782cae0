#include "lod/dicer.h"

#include <cmath>

#include "scenegraph/base/hash.h"

namespace occam::lod {
namespace {

std::size_t slot_of(const PosedCage& cage, std::uint64_t index, std::size_t size)
{
    return static_cast<std::size_t>(mix_bits(index ^ reinterpret_cast<std::uintptr_t>(&cage) << 20)) & (size - 1);
}

Vec3f middle(Vec3f a, Vec3f b) noexcept { return (a + b) * 0.5f; }

}  // namespace

Dicer::Dicer() : pool_(kPoolSize), curves_(kCurveSize) {}

void Dicer::forget()
{
    for (PoolEntry& e : pool_) e.cage = nullptr;
    for (CurveEntry& e : curves_) e.cage = nullptr;
}

PosedPatch& Dicer::posed(const PosedCage& cage, PatchRef patch)
{
    PoolEntry& entry = pool_[slot_of(cage, std::uint64_t(patch.sub) << 32 | patch.face, kPoolSize)];
    if (entry.cage != &cage || entry.patch != patch) {
        entry.cage = &cage;
        entry.patch = patch;
        entry.posed.set(cage, patch);
    }
    return entry.posed;
}

Dicer::OwnerSpan Dicer::owner_span(const Topology& topology, std::uint32_t curve, float ca, float cb) const
{
    const PatchPoint a = topology.curve_point(curve, ca), b = topology.curve_point(curve, cb);
    const bool along_v = a.u == b.u;
    const float ta = along_v ? a.v : a.u, tb = along_v ? b.v : b.u;
    const float dt = (tb - ta) / (cb - ca);
    return {a.patch, along_v, along_v ? a.u : a.v, ta - ca * dt, dt};
}

int Dicer::curve_k(const PosedCage& cage, std::uint32_t curve)
{
    CurveEntry& entry = curves_[slot_of(cage, curve, kCurveSize)];
    if (entry.cage == &cage && entry.curve == curve) return entry.exponent;
    const Topology& topology = *cage.topology;
    const auto speed = [&](float ca, float cb) {
        const OwnerSpan s = owner_span(topology, curve, ca, cb);
        return posed(cage, s.patch).curve_speed(s.along_v, s.fixed, 0, 1) * std::fabs(s.dt);
    };
    float s = speed(0.125f, 0.25f);
    if (topology.has_middle_knot(curve)) s = std::max(s, speed(0.75f, 0.875f));
    entry = {&cage, curve, ceil_log2(s)};
    return entry.exponent;
}

PatchRates Dicer::rates(const PosedCage& cage, PatchRef patch)
{
    const Topology& topology = *cage.topology;
    float speed_u, speed_v;
    posed(cage, patch).speeds(speed_u, speed_v);
    int k[2] = {ceil_log2(speed_u), ceil_log2(speed_v)}, least[2] = {0, 0};
    PatchRates rates;
    for (int side = 0; side < 4; ++side) {
        const SideCurve on = topology.side(patch, side);
        // A side that is half of a curve has one piece in two, and half of its speed.
        const int half = std::fabs(on.c1 - on.c0) == 0.5f ? 1 : 0;
        const int own = curve_k(cage, on.curve), m = topology.least_exponent(on.curve);
        rates.side[side] = curve_exponent(own, m, cage.level) - half;
        k[side & 1] = std::max(k[side & 1], own - half);
        least[side & 1] = std::max(least[side & 1], m - half);
    }
    inside_exponents(k[0], k[1], least[0], least[1], cage.level, rates.u, rates.v);
    return rates;
}

Box3f Dicer::bounds(const PosedCage& cage, const TileRef& part)
{
    PosedPatch& patch = posed(cage, part.patch);
    const float u0 = float(part.i0) * part.step_u(), v0 = float(part.j0) * part.step_v();
    const float u1 = u0 + part.columns * part.step_u(), v1 = v0 + part.rows * part.step_v();
    Box3f box = patch.bounds(u0, u1, v0, v1);
    // T-vertices lie on chords of the side's own pieces, which may reach beyond the part: their curve's hull holds them.
    for (int side = 0; side < 4; ++side) {
        const bool along_v = side & 1;
        const float fixed = side == 1 || side == 2 ? 1 : 0;
        const bool touches = along_v ? (fixed == 0 ? u0 == 0 : u1 == 1) : (fixed == 0 ? v0 == 0 : v1 == 1);
        if (!touches || part.rates.side[side] == (along_v ? part.rates.v : part.rates.u)) continue;
        const float piece = std::ldexp(1.0f, -part.rates.side[side]);
        const float t0 = std::floor((along_v ? v0 : u0) / piece) * piece, t1 = std::ceil((along_v ? v1 : u1) / piece) * piece;
        box.add(along_v ? patch.bounds(fixed, fixed, t0, t1) : patch.bounds(t0, t1, fixed, fixed));
    }
    return box;
}

Vec3f Dicer::curve_end(const PosedCage& cage, std::uint32_t curve, int end)
{
    const Topology& topology = *cage.topology;
    if (topology.is_inner(curve) && end == 0) {
        Vec3f p;
        curve_points(cage, topology.base_edge(curve), 0.5f, 1, {&p, 1});
        return p;
    }
    const PatchPoint at = topology.curve_end(curve, end);
    return posed(cage, at.patch).point(at.u, at.v);
}

void Dicer::curve_points(const PosedCage& cage, std::uint32_t curve, float c0, float dc, std::span<Vec3f> out)
{
    const Topology& topology = *cage.topology;
    const auto c_at = [&](std::size_t i) { return c0 + float(i) * dc; };
    const bool knot = topology.has_middle_knot(curve);
    for (std::size_t i = 0; i < out.size();) {
        const float c = c_at(i);
        if (c == 0 || c == 1) {
            out[i++] = curve_end(cage, curve, c == 1);
            continue;
        }
        if (knot && c == 0.5f) {
            const PatchPoint at = topology.curve_point(curve, c);
            out[i++] = posed(cage, at.patch).point(at.u, at.v);
            continue;
        }
        // The longest run on one owner's patch.
        std::size_t end = i + 1;
        while (end < out.size() && c_at(end) != 0 && c_at(end) != 1 && !(knot && ((c_at(end) < 0.5f) != (c < 0.5f) || c_at(end) == 0.5f)))
            ++end;
        const OwnerSpan s = knot && c > 0.5f ? owner_span(topology, curve, 0.75f, 0.875f) : owner_span(topology, curve, 0.125f, 0.25f);
        posed(cage, s.patch).curve(s.along_v, s.fixed, s.t0 + c * s.dt, dc * s.dt, out.subspan(i, end - i));
        i = end;
    }
}

void Dicer::dice_side(const PosedCage& cage, int side, LevelGrid& grid)
{
    const TileRef& tile = grid.tile;
    const bool along_v = side & 1;
    const int exponent = along_v ? tile.rates.v : tile.rates.u;
    const int shift = exponent - tile.rates.side[side];  // 2^shift lattice steps to an edge piece
    const int first = along_v ? tile.j0 : tile.i0, count = along_v ? tile.rows : tile.columns;
    const int fixed = side == 1 ? tile.columns : side == 2 ? tile.rows : 0;

    const int piece0 = first >> shift, piece1 = (first + count + (1 << shift) - 1) >> shift;
    side_points_.resize(piece1 - piece0 + 1);
    const SideCurve on = cage.topology->side(tile.patch, side);
    const float step = (on.c1 - on.c0) * std::ldexp(1.0f, -tile.rates.side[side]);
    curve_points(cage, on.curve, on.c0 + float(piece0) * step, step, side_points_);

    const auto place = [&](int index, Vec3f p) {
        const int n = index - first, at = (along_v ? n : fixed) * grid.width() + (along_v ? fixed : n);
        grid.x[at] = p.x;
        grid.y[at] = p.y;
        grid.z[at] = p.z;
    };
    // Halves a piece down to single steps. A tile closes every gap along its part of the side: so it keeps the closers of all
    // halvings that reach into it, also of T-vertices outside.
    const auto halve = [&](const auto& self, int low, int high, Vec3f a, Vec3f c) -> void {
        if (high - low < 2 || low >= first + count || high <= first) return;
        const int mid = (low + high) / 2;
        const Vec3f p = middle(a, c);
        const int inside = std::clamp(mid - first, 0, count);
        if (mid == first + inside) place(mid, p);
        closers_.push_back({a, p, c, static_cast<std::uint16_t>(along_v ? fixed : inside), static_cast<std::uint16_t>(along_v ? inside : fixed)});
        self(self, low, mid, a, p);
        self(self, mid, high, p, c);
    };
    for (int piece = piece0; piece <= piece1; ++piece) {
        const int index = piece << shift;
        if (index >= first && index <= first + count) place(index, side_points_[piece - piece0]);
        if (piece < piece1) halve(halve, index, index + (1 << shift), side_points_[piece - piece0], side_points_[piece - piece0 + 1]);
    }
}

LevelGrid Dicer::dice(const PosedCage& cage, const TileRef& tile, Arena& arena)
{
    LevelGrid grid;
    grid.tile = tile;
    const std::size_t count = std::size_t(grid.width()) * grid.height();
    vertices_diced += count;
    // One array for all three: and eight floats more, since lanes are loaded four at a time.
    float* data = arena.make_array<float>(3 * count + 8).data();
    grid.x = data;
    grid.y = data + count;
    grid.z = data + 2 * count;

    const bool left = tile.i0 == 0, bottom = tile.j0 == 0;
    const bool right = tile.i0 + tile.columns == 1 << tile.rates.u, top = tile.j0 + tile.rows == 1 << tile.rates.v;
    // Borders of the patch come from their owners below; the rest is the patch's own.
    const int i0 = left, i1 = grid.width() - right, j0 = bottom, j1 = grid.height() - top;
    if (i0 < i1 && j0 < j1) {
        const ParameterGrid inside{float(tile.i0 + i0) * tile.step_u(), float(tile.j0 + j0) * tile.step_v(), tile.step_u(), tile.step_v(),
                                   i1 - i0, j1 - j0};
        const int at = j0 * grid.width() + i0;
        posed(cage, tile.patch).points(inside, grid.x + at, grid.y + at, grid.z + at, grid.width());
    }
    closers_.clear();
    if (bottom) dice_side(cage, 0, grid);
    if (right) dice_side(cage, 1, grid);
    if (top) dice_side(cage, 2, grid);
    if (left) dice_side(cage, 3, grid);
    if (!closers_.empty()) {
        const std::span<Closer> kept = arena.make_array<Closer>(closers_.size());
        std::copy(closers_.begin(), closers_.end(), kept.begin());
        grid.closers = kept;
    }
    return grid;
}

GridAttributes Dicer::shade(const PosedCage& cage, const TileRef& tile, Arena& arena)
{
    const int width = tile.columns + 1, height = tile.rows + 1;
    const std::size_t count = std::size_t(width) * height;
    vertices_shaded += count;
    const ParameterGrid grid{float(tile.i0) * tile.step_u(), float(tile.j0) * tile.step_v(), tile.step_u(), tile.step_v(), width, height};
    tangents_.resize(9 * count);
    float* out[9];
    for (int a = 0; a < 9; ++a) out[a] = &tangents_[a * count];

    GridAttributes made;
    posed(cage, tile.patch).points_and_tangents(grid, out, width);
    made.normal = arena.make_array<Vec3f>(count).data();
    for (std::size_t k = 0; k < count; ++k) {
        const Vec3f n = glm::cross(Vec3f{out[3][k], out[4][k], out[5][k]}, Vec3f{out[6][k], out[7][k], out[8][k]});
        const float length = glm::length(n);
        // Degenerate tangents (a corner where both sides run alike) leave the choice to the geometric normal: see Tracer.
        made.normal[k] = length > 0 ? n * ((cage.is_mirrored ? -1.0f : 1.0f) / length) : Vec3f(0);
    }
    for (int set = 0; set < std::min(2, cage.topology->uv_set_count()); ++set) {
        uv_patch_.set_uv(cage, tile.patch, set);
        made.uv[set] = arena.make_array<Vec2f>(count).data();
        uv_patch_.points(grid, out[0], out[1], out[2], width);
        for (std::size_t k = 0; k < count; ++k) made.uv[set][k] = {out[0][k], out[1][k]};
    }
    return made;
}

}  // namespace occam::lod
