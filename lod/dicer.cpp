#include "lod/dicer.h"

#include <cmath>

#include "base/hash.h"
#include "base/power_of_two.h"

namespace occam::lod {
namespace {

// The largest PatchScale::k. With it a patch is one tile at the coarsest level, whatever its size: so the division of its
// regions ends there. A curve is clamped as a whole, so the patches on both sides of it agree.
constexpr int kLargestK = kCoarsestLevel + TileRef::kSideExponent;

// Returns the slot of a patch, curve or vertex. Consecutive ones get consecutive slots, so that neighbours do not replace
// each other and are close in memory.
std::size_t slot_of(const PosedCage& cage, std::uint64_t index, std::size_t size)
{
    return static_cast<std::size_t>(mix_bits(reinterpret_cast<std::uintptr_t>(&cage)) + index) & (size - 1);
}

// The parameters of a tile's vertices.
ParameterGrid parameters_of(const TileRef& tile)
{
    return {float(tile.i0) * tile.step_u(),
            float(tile.j0) * tile.step_v(),
            tile.step_u(),
            tile.step_v(),
            tile.columns + 1,
            tile.rows + 1};
}

}  // namespace

Dicer::Dicer() : pool_(kPoolSize), curves_(kCurveSize), corners_(kCornerSize) {}

void Dicer::forget()
{
    for (PoolEntry& e : pool_) e.cage = nullptr;
    for (CurveEntry& e : curves_) e.cage = nullptr;
    for (CornerEntry& e : corners_) e.cage = nullptr;
    uv_.cage = rest_.cage = nullptr;
}

PosedPatch& Dicer::posed(const PosedCage& cage, PatchRef patch)
{
    PoolEntry& entry = pool_[slot_of(cage, patch.face + 61 * patch.sub, kPoolSize)];
    if (entry.cage != &cage || entry.patch != patch) {
        entry.cage = nullptr;  // set() may be cancelled
        entry.posed.set(cage, patch);
        entry.cage = &cage;
        entry.patch = patch;
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

Dicer::CurveEntry& Dicer::curve_entry(const PosedCage& cage, std::uint32_t curve)
{
    CurveEntry& entry = curves_[slot_of(cage, curve, kCurveSize)];
    if (entry.cage != &cage || entry.curve != curve) entry = {&cage, curve};
    return entry;
}

int Dicer::curve_k(const PosedCage& cage, std::uint32_t curve)
{
    if (const int known = curve_entry(cage, curve).k; known != CurveEntry::kUnknown) return known;
    const Topology& topology = *cage.topology;
    const bool is_halves = topology.has_middle_knot(curve);  // each half is then a side of its own patch
    const auto speed = [&](float c) {
        const PatchPoint at = topology.curve_point(curve, c);
        const int side = at.v == 0 ? 0 : at.u == 1 ? 1 : at.v == 1 ? 2 : 3;
        return posed(cage, at.patch).side_speed(side) * (is_halves ? 2.0f : 1.0f);
    };
    float s = speed(0.25f);
    if (is_halves) s = std::max(s, speed(0.75f));
    if (cage.is_displaced()) s = displaced_speed(cage, curve, s);
    return curve_entry(cage, curve).k = std::min(ceil_log2(s), kLargestK);
}

void Dicer::ask_for(const PosedCage& cage, PatchRef patch) { cage.topology->controls(patch).kind->hull().ask_for_first(); }

PatchScale Dicer::scale(const PosedCage& cage, PatchRef patch)
{
    PatchScale scale = scale_at_key(cage, patch);
    for (int key = 1; key <= cage.segments; ++key) {
        const PatchScale other = scale_at_key(cage.keys[key], patch);
        for (std::size_t axis : {0, 1}) scale.k[axis] = std::max(scale.k[axis], other.k[axis]);
        for (std::size_t side = 0; side < 4; ++side) scale.side_k[side] = std::max(scale.side_k[side], other.side_k[side]);
    }
    if (cage.segments > 0) scale.limit_aspect();
    return scale;
}

PatchScale Dicer::scale_at_key(const PosedCage& cage, PatchRef patch)
{
    const Topology& topology = *cage.topology;
    float speed_u, speed_v;
    posed(cage, patch).speeds(speed_u, speed_v);
    PatchScale scale;
    if (cage.is_displaced()) {
        scale.filter_stops = cage.displacement.stops;
        displaced_speeds(cage, patch, speed_u, speed_v);
    }
    scale.k = {std::min(ceil_log2(speed_u), kLargestK), std::min(ceil_log2(speed_v), kLargestK)};
    for (int side = 0; side < 4; ++side) {
        const SideCurve on = topology.side(patch, side);
        // A side that is half of a curve has half of its pieces, and half of its speed.
        const int half = std::fabs(on.c1 - on.c0) == 0.5f ? 1 : 0;
        scale.side_k[side] = curve_k(cage, on.curve) - half;
        scale.side_least[side] = topology.least_exponent(on.curve) - half;
        scale.k[side & 1] = std::max(scale.k[side & 1], scale.side_k[side]);
        scale.least[side & 1] = std::max(scale.least[side & 1], scale.side_least[side]);
    }
    scale.limit_aspect();
    return scale;
}

Box3f Dicer::bounds(const PosedCage& cage, const PatchScale& scale, const PatchRegion& region, int coarsest)
{
    PosedPatch& patch = posed(cage, region.patch);
    const float size_u = power_of_two(-region.du), size_v = power_of_two(-region.dv);
    const float u0 = float(region.iu) * size_u, v0 = float(region.iv) * size_v, u1 = u0 + size_u, v1 = v0 + size_v;
    Box3f box = patch.bounds(u0, u1, v0, v1);
    // T-vertices lie on chords of the side's own pieces, which may reach beyond the region; the hull of their curve holds
    // them.
    for (int side = 0; side < 4; ++side) {
        const bool along_v = side & 1;
        const float fixed = side == 1 || side == 2 ? 1 : 0;
        const bool touches = along_v ? (fixed == 0 ? u0 == 0 : u1 == 1) : (fixed == 0 ? v0 == 0 : v1 == 1);
        const int exponent = curve_exponent(scale.side_k[side], scale.side_least[side], coarsest);
        if (!touches || exponent >= (along_v ? region.dv : region.du)) continue;
        const float piece = power_of_two(-exponent);
        const float t0 = std::floor((along_v ? v0 : u0) / piece) * piece, t1 = t0 + piece;
        box.add(along_v ? patch.bounds(fixed, fixed, t0, t1) : patch.bounds(t0, t1, fixed, fixed));
    }
    return {box.lo - cage.displacement.reach, box.hi + cage.displacement.reach};
}

TileRef Dicer::tile(PatchRef patch, const PatchScale& scale, int level, std::uint32_t i, std::uint32_t j)
{
    TileRef tile{patch, scale.rates(level), i & ~(TileRef::kMaxSide - 1u), j & ~(TileRef::kMaxSide - 1u), 1, 1};
    tile.columns = static_cast<std::uint16_t>(1 << std::min(tile.rates.u, TileRef::kSideExponent));
    tile.rows = static_cast<std::uint16_t>(1 << std::min(tile.rates.v, TileRef::kSideExponent));
    return tile;
}

void Dicer::patch_curve(const PosedCage& cage, PatchRef patch, int filter, bool along_v, float fixed, float t0, float step,
                        std::span<Vec3f> out)
{
    if (cage.is_displaced()) displaced_curve(cage, patch, filter, along_v, fixed, t0, step, out);
    else posed(cage, patch).curve(along_v, fixed, t0, step, out);
}

Vec3f Dicer::patch_point(const PosedCage& cage, PatchPoint at, int filter)
{
    Vec3f p;
    patch_curve(cage, at.patch, filter, false, at.v, at.u, 1, {&p, 1});
    return p;
}

Vec3f Dicer::vertex_point(const PosedCage& cage, std::uint32_t vertex, int filter)
{
    if (cage.is_displaced()) return patch_point(cage, cage.topology->vertex_point(vertex), filter);
    CornerEntry& entry = corners_[slot_of(cage, vertex, kCornerSize)];
    if (entry.cage == &cage && entry.vertex == vertex) return entry.p;
    const PatchPoint at = cage.topology->vertex_point(vertex);
    const PatchControls& controls = cage.topology->controls(at.patch);
    const PointStencil& stencil = controls.kind->corner(int(at.u == 1) + 2 * int(at.v == 1));
    Vec3f sum(0);
    for (std::size_t k = 0; k < stencil.controls.size(); ++k) {
        const Vec3f p = cage.vertex(controls.indices[stencil.controls[k]]);
        const float w = stencil.weights[k];
        sum = {fma(w, p.x, sum.x), fma(w, p.y, sum.y), fma(w, p.z, sum.z)};
    }
    entry = {&cage, vertex, sum};
    return sum;
}

Vec3f Dicer::curve_end(const PosedCage& cage, std::uint32_t curve, int filter, int end)
{
    const Topology& topology = *cage.topology;
    if (!topology.is_inner(curve)) return vertex_point(cage, topology.end_vertex(curve, end), filter);
    if (end == 1) return patch_point(cage, {{topology.curve_point(curve, 1).patch.face, 0}, 1, 1}, filter);
    Vec3f p;
    curve_points(cage, topology.base_edge(curve), filter, 0.5f, 1, {&p, 1});
    return p;
}

void Dicer::owned_points(const PosedCage& cage, std::uint32_t curve, int filter, float c0, float dc, std::span<Vec3f> out)
{
    // A few points are kept, since the patch on the other side and coarser pairs need them again.
    const bool is_middle = c0 == 0.5f && out.size() == 1,
               is_kept = !cage.is_displaced() && (is_middle || (std::fabs(dc) == 0.25f && out.size() == 3));
    if (is_kept) {
        const CurveEntry& entry = curve_entry(cage, curve);
        if (is_middle && entry.has_middle) {
            out[0] = entry.p[1];
            return;
        }
        if (!is_middle && entry.has_quarters) {
            for (std::size_t i = 0; i < 3; ++i) out[i] = entry.p[dc > 0 ? i : 2 - i];
            return;
        }
    }
    const Topology& topology = *cage.topology;
    const OwnerSpan s = topology.has_middle_knot(curve) && c0 > 0.5f ? owner_span(topology, curve, 0.75f, 0.875f)
                                                                     : owner_span(topology, curve, 0.125f, 0.25f);
    patch_curve(cage, s.patch, filter, s.along_v, s.fixed, s.t0 + c0 * s.dt, dc * s.dt, out);
    if (!is_kept) return;
    CurveEntry& entry = curve_entry(cage, curve);
    entry.has_middle = true;
    entry.has_quarters |= !is_middle;
    if (is_middle) entry.p[1] = out[0];
    for (std::size_t i = 0; i < 3 && !is_middle; ++i) entry.p[i] = out[dc > 0 ? i : 2 - i];
}

void Dicer::curve_points(const PosedCage& cage, std::uint32_t curve, int filter, float c0, float dc, std::span<Vec3f> out)
{
    const Topology& topology = *cage.topology;
    const auto c_at = [&](std::size_t i) { return c0 + float(i) * dc; };
    const bool knot = topology.has_middle_knot(curve);
    for (std::size_t i = 0; i < out.size();) {
        const float c = c_at(i);
        if (c == 0 || c == 1) {
            out[i++] = curve_end(cage, curve, filter, c == 1);
            continue;
        }
        if (knot && c == 0.5f) {
            out[i++] = patch_point(cage, topology.curve_point(curve, c), filter);
            continue;
        }
        // Finds the longest run on one owner's patch.
        std::size_t end = i + 1;
        while (end < out.size() && c_at(end) != 0 && c_at(end) != 1 &&
               !(knot && ((c_at(end) < 0.5f) != (c < 0.5f) || c_at(end) == 0.5f)))
            ++end;
        owned_points(cage, curve, filter, c, dc, out.subspan(i, end - i));
        i = end;
    }
}

void Dicer::side_points(const PosedCage& cage, const TileRef& tile, int side, int first, std::span<Vec3f> out)
{
    const SideCurve on = cage.topology->side(tile.patch, side);
    const float step = (on.c1 - on.c0) * power_of_two(-tile.rates.side[side]);
    curve_points(cage, on.curve, tile.rates.filter, on.c0 + float(first) * step, step, out);
}

void Dicer::dice_side(const PosedCage& cage, int side, LevelGrid& grid)
{
    const TileRef& tile = grid.tile;
    const bool along_v = side & 1;
    const int exponent = along_v ? tile.rates.v : tile.rates.u;
    const int shift = exponent - tile.rates.side[side];  // 2^shift lattice steps to an edge piece
    const int first = static_cast<int>(along_v ? tile.j0 : tile.i0), count = along_v ? tile.rows : tile.columns;
    const int fixed = side == 1 ? tile.columns : side == 2 ? tile.rows : 0;

    const int piece0 = first >> shift, piece1 = (first + count + (1 << shift) - 1) >> shift;
    side_points_.resize(static_cast<std::size_t>(piece1 - piece0 + 1));
    side_points(cage, tile, side, piece0, side_points_);

    const auto write = [&](int at, Vec3f p) {
        for (int a = 0; a < 3; ++a) grid.fine[a][at] = p[a];
    };
    const auto lattice = [&](int n) { return along_v ? grid.index(fixed, n) : grid.index(n, fixed); };
    // Returns the vertex at lattice step `index` of the side, which ends a piece.
    const auto place_end = [&](int index, Vec3f p) {
        const int n = index - first;
        const bool is_inside = n >= 0 && n <= count;
        const int at = is_inside ? lattice(n) : grid.vertex_count++;
        if (!is_inside) extras_.push_back({side, index >> shift});
        write(at, p);
        return static_cast<std::uint32_t>(at);
    };
    // Halves a piece down to single steps. A tile closes every gap along its part of the side, so it keeps the gap triangles
    // of all halvings that reach into it, even if the T-vertex itself lies outside.
    Hanging next;
    const auto halve = [&](const auto& self, int low, int high, Vec3f a, Vec3f c, std::uint32_t path, int depth) -> void {
        if (high - low < 2 || low >= first + count || high <= first) return;
        const int mid = (low + high) / 2;
        const Vec3f p = (a + c) * 0.5f;
        const int inside = std::clamp(mid - first, 0, count);
        next.path = path;
        next.depth = static_cast<std::uint8_t>(depth);
        next.is_inside = mid == first + inside;
        next.i = static_cast<std::uint8_t>(along_v ? fixed : inside);
        next.j = static_cast<std::uint8_t>(along_v ? inside : fixed);
        if (next.is_inside) write(lattice(inside), p);
        hanging_.push_back(next);
        self(self, low, mid, a, p, path << 1, depth + 1);
        self(self, mid, high, p, c, path << 1 | 1, depth + 1);
    };
    std::uint32_t end = place_end(piece0 << shift, side_points_[0]);
    for (int piece = piece0; piece < piece1; ++piece) {
        const Vec3f a = side_points_[static_cast<std::size_t>(piece - piece0)],
                    c = side_points_[static_cast<std::size_t>(piece - piece0 + 1)];
        next.a = end;
        next.c = end = place_end((piece + 1) << shift, c);
        halve(halve, piece << shift, (piece + 1) << shift, a, c, 0, 0);
    }
}

LevelGrid Dicer::dice_vertices(const PosedCage& cage, const TileRef& tile, Arena& arena)
{
    LevelGrid grid;
    grid.tile = tile;
    grid.vertex_count = grid.width() * grid.height();
    vertices_diced += static_cast<std::uint64_t>(grid.vertex_count);
    hanging_.clear();
    extras_.clear();
    bool hangs = false;
    for (int side = 0; side < 4; ++side) hangs |= tile.rates.side[side] != (side & 1 ? tile.rates.v : tile.rates.u);
    // One array holds all three coordinates, and eight more floats, since lanes are loaded eight at a time.
    const std::size_t room = static_cast<std::size_t>(grid.vertex_count + (hangs ? LevelGrid::kMaxExtra : 0));
    float* data = arena.make_array<float>(3 * room + 8).data();
    for (std::size_t a = 0; a < 3; ++a) grid.fine[a] = grid.coarse[a] = data + a * room;

    const bool left = tile.i0 == 0, bottom = tile.j0 == 0;
    const bool right = tile.i0 + tile.columns == 1u << tile.rates.u, top = tile.j0 + tile.rows == 1u << tile.rates.v;
    // The patch itself gives the inner points; those on its borders come from their owners below.
    const int i0 = left, i1 = grid.width() - right, j0 = bottom, j1 = grid.height() - top;
    if (i0 < i1 && j0 < j1) {
        const ParameterGrid inside{float(tile.i0 + i0) * tile.step_u(),
                                   float(tile.j0 + j0) * tile.step_v(),
                                   tile.step_u(),
                                   tile.step_v(),
                                   i1 - i0,
                                   j1 - j0};
        const int at = grid.index(i0, j0);
        float* const out[3] = {grid.fine[0] + at, grid.fine[1] + at, grid.fine[2] + at};
        if (cage.is_displaced()) displaced_points(cage, tile.patch, tile.rates.filter, inside, out, grid.width());
        else posed(cage, tile.patch).points(inside, out[0], out[1], out[2], grid.width());
    }
    // A side of one step consists of corners that the other sides have as well.
    const bool is_low = tile.rates.v == 0, is_narrow = tile.rates.u == 0;
    if (is_low && is_narrow && cage.topology->face_size(tile.patch.face) == 4) {
        const std::array<std::uint32_t, 4> quad = cage.topology->quad_vertices(tile.patch.face);
        constexpr int kPlace[4] = {0, 1, 3, 2};
        for (std::size_t c = 0; c < 4; ++c) {
            const Vec3f p = vertex_point(cage, quad[c], tile.rates.filter);
            for (int a = 0; a < 3; ++a) grid.fine[a][kPlace[c]] = p[a];
        }
        return grid;
    }
    if (is_low || !is_narrow) {
        if (bottom) dice_side(cage, 0, grid);
        if (top) dice_side(cage, 2, grid);
    }
    if (!is_low) {
        if (right) dice_side(cage, 1, grid);
        if (left) dice_side(cage, 3, grid);
    }
    return grid;
}

LevelGrid Dicer::dice(const PosedCage& cage, const TileRef& tile, Arena& arena)
{
    LevelGrid grid = dice_vertices(cage, tile, arena);
    if (!hanging_.empty()) {
        const std::span<Hanging> kept = arena.make_array<Hanging>(hanging_.size());
        std::copy(hanging_.begin(), hanging_.end(), kept.begin());
        grid.hanging = kept;
    }
    return grid;
}

LevelGrid Dicer::dice_pair(const PosedCage& cage, const TileRef& tile, const PatchRates& coarser, Arena& arena)
{
    if (coarser == tile.rates) return dice(cage, tile, arena);
    LevelGrid grid = dice(cage, tile, arena);
    const std::vector<Extra> extras = extras_;
    const std::size_t room = static_cast<std::size_t>(grid.vertex_count);
    float* data = arena.make_array<float>(3 * room + 8).data();
    for (std::size_t a = 0; a < 3; ++a) grid.coarse[a] = data + a * room;
    const auto write = [&](int at, Vec3f p) {
        for (int a = 0; a < 3; ++a) grid.coarse[a][at] = p[a];
    };

    const bool halved = grid.is_halved = coarser.u != tile.rates.u || coarser.v != tile.rates.v;
    TileRef half = tile;
    half.rates = coarser;
    if (halved) {
        half.i0 /= 2;
        half.j0 /= 2;
        half.columns /= 2;
        half.rows /= 2;
    }
    scratch_.reset();
    const LevelGrid below = dice_vertices(cage, half, scratch_);
    for (int j = 0; j <= tile.rows; ++j)
        for (int i = 0; i <= tile.columns; ++i) {
            const int at = grid.index(i, j);
            if (!halved) {
                write(at, below.vertex(i, j));
                continue;
            }
            // Odd vertices lie on an edge of the coarse mesh, or on its diagonal.
            const Vec3f low = below.vertex(i / 2, j / 2);
            write(at, (i | j) & 1 ? (low + below.vertex((i + 1) / 2, (j + 1) / 2)) * 0.5f : low);
        }
    for (std::size_t e = 0; e < extras.size(); ++e) {
        const int at = grid.width() * grid.height() + static_cast<int>(e);
        const auto side = static_cast<std::size_t>(extras[e].side);
        const bool side_halves = coarser.side[side] != tile.rates.side[side];
        Vec3f around[2] = {grid.at(at)};
        if (side_halves && (extras[e].piece & 1)) {
            side_points(cage, half, extras[e].side, extras[e].piece / 2, around);
            around[0] = (around[0] + around[1]) * 0.5f;
        } else if (cage.is_displaced()) {
            side_points(cage, half, extras[e].side, side_halves ? extras[e].piece / 2 : extras[e].piece, {around, 1});
        }
        write(at, around[0]);
    }
    return grid;
}

void Dicer::shade_normals(const PosedCage& cage, const TileRef& tile, const PatchRates& coarser, Vec3f* normal,
                          Vec3f* coarse_normal)
{
    const int width = tile.columns + 1, height = tile.rows + 1;
    const std::size_t count = std::size_t(width) * height;
    const ParameterGrid grid = parameters_of(tile);
    if (cage.is_displaced()) {
        displaced_normals(cage, tile.patch, tile.rates.filter, grid, normal);
        if (coarse_normal) displaced_coarse_normals(cage, tile, coarser, coarse_normal);
        return;
    }
    tangents_.resize(9 * count);
    float* out[9];
    for (int a = 0; a < 9; ++a) out[a] = &tangents_[a * count];
    posed(cage, tile.patch).points_and_tangents(grid, out, width);
    for (std::size_t k = 0; k < count; ++k) {
        const Vec3f n = glm::cross(Vec3f{out[3][k], out[4][k], out[5][k]}, Vec3f{out[6][k], out[7][k], out[8][k]});
        const float length = glm::length(n);
        // Where the tangents are parallel, as in a corner whose sides have one direction, there is no normal, and hits take
        // the geometric one (accel/hit.cpp).
        normal[k] = length > 0 ? n * ((cage.is_mirrored ? -1.0f : 1.0f) / length) : Vec3f(0);
    }
}

GridAttributes Dicer::shade(const PosedCage& cage, const TileRef& tile, const PatchRates& coarser, Arena& arena)
{
    const int width = tile.columns + 1, height = tile.rows + 1;
    const std::size_t count = std::size_t(width) * height;
    const auto keys = static_cast<std::size_t>(cage.segments) + 1;
    vertices_shaded += count * keys;

    GridAttributes made;
    const bool has_coarse = cage.is_displaced() && coarser != tile.rates;
    const std::size_t of_a_key = has_coarse ? 2 * count : count;
    made.normal = arena.make_array<Vec3f>(keys * of_a_key + 1).data();
    if (has_coarse) made.coarse_normal = made.normal + count;
    made.normals_of_a_key = of_a_key;
    for (std::size_t k = 0; k < keys; ++k)
        shade_normals(cage.at_key(static_cast<int>(k)), tile, coarser, made.normal + k * of_a_key,
                      has_coarse ? made.coarse_normal + k * of_a_key : nullptr);
    tangents_.resize(9 * count);
    float* const out[3] = {&tangents_[0], &tangents_[count], &tangents_[2 * count]};
    for (int set = 0; set < std::min(2, cage.topology->uv_set_count()); ++set) {
        made.uv[set] = arena.make_array<Vec2f>(count + 1).data();
        uv_patch(cage, tile.patch, set).points(parameters_of(tile), out[0], out[1], out[2], width);
        for (std::size_t k = 0; k < count; ++k) made.uv[set][k] = {out[0][k], out[1][k]};
    }
    return made;
}

PosedPatch& Dicer::uv_patch(const PosedCage& cage, PatchRef patch, int set)
{
    if (uv_.cage != &cage || uv_.patch != patch || uv_set_ != set) {
        uv_.cage = nullptr;  // set_uv() may be cancelled
        uv_.posed.set_uv(cage, patch, set);
        uv_.cage = &cage;
        uv_.patch = patch;
        uv_set_ = set;
    }
    return uv_.posed;
}

}  // namespace occam::lod
