#include "lod/owned_curves.h"

#include <algorithm>
#include <cmath>

namespace occam::lod {
namespace {

// Says where the owner of a part of a curve has it: its parameter is t0 + c * dt.
struct OwnerSpan {
    PatchRef patch;
    bool along_v;
    float fixed, t0, dt;
};

// Returns the owner's span of the part of the curve in which ca and cb lie.
OwnerSpan owner_span(const Topology& topology, std::uint32_t curve, float ca, float cb)
{
    const PatchPoint a = topology.curve_point(curve, ca), b = topology.curve_point(curve, cb);
    const bool along_v = a.u == b.u;
    const float ta = along_v ? a.v : a.u, tb = along_v ? b.v : b.u;
    const float dt = (tb - ta) / (cb - ca);
    return {a.patch, along_v, along_v ? a.u : a.v, ta - ca * dt, dt};
}

}  // namespace

void OwnedCurves::forget() noexcept
{
    curves_.forget();
    corners_.forget();
}

OwnedCurves::Known& OwnedCurves::known(const PosedCage& cage, std::uint32_t curve)
{
    auto& entry = curves_.entry(cage, curve);
    if (!entry.holds(cage, curve)) entry = {&cage, curve, {}};
    return entry.value;
}

int OwnedCurves::k(const PosedCage& cage, std::uint32_t curve)
{
    if (const int found = known(cage, curve).k; found != Known::kUnknown) return found;
    const Topology& topology = *cage.topology;
    const bool is_halves = topology.has_middle_knot(curve);  // each half is then a side of its own patch
    const auto speed = [&](float c) {
        const PatchPoint at = topology.curve_point(curve, c);
        const int side = at.v == 0 ? 0 : at.u == 1 ? 1 : at.v == 1 ? 2 : 3;
        return surface_.posed(cage, at.patch).side_speed(side) * (is_halves ? 2.0f : 1.0f);
    };
    float s = speed(0.25f);
    if (is_halves) s = std::max(s, speed(0.75f));
    if (cage.is_displaced()) s = displaced_speed(cage, curve, s);
    return known(cage, curve).k = std::min(ceil_log2(s), kLargestK);
}

float OwnedCurves::displaced_speed(const PosedCage& cage, std::uint32_t curve, float undisplaced)
{
    constexpr int kPieces = DisplacedPatches::kSpeedPieces;
    std::array<Vec3f, kPieces + 1> at;
    points(cage, curve, DisplacedPatches::level_of_pieces(undisplaced), 0, 1.0f / kPieces, at);
    float longest = 0;
    for (std::size_t i = 0; i < kPieces; ++i) longest = std::max(longest, glm::distance(at[i], at[i + 1]));
    return DisplacedPatches::diced_speed(longest * kPieces, undisplaced);
}

Vec3f OwnedCurves::vertex_point(const PosedCage& cage, std::uint32_t vertex, int filter)
{
    const Corner corner{vertex, cage.is_displaced() ? filter : 0};
    // The curves along u often ask for another level than those along v, by turns.
    auto& entry = corners_.entry(cage, vertex + (static_cast<std::uint32_t>(corner.filter) & 1) * (kCorners / 2));
    if (entry.holds(cage, corner)) return entry.value;
    const Vec3f p = cage.is_displaced() ? surface_.point(cage, cage.topology->vertex_point(vertex), filter)
                                        : undisplaced_vertex_point(cage, vertex);
    entry = {&cage, corner, p};
    return p;
}

Vec3f OwnedCurves::undisplaced_vertex_point(const PosedCage& cage, std::uint32_t vertex)
{
    const PatchPoint at = cage.topology->vertex_point(vertex);
    const PatchControls& controls = cage.topology->controls(at.patch);
    const PointStencil& stencil = controls.kind->corner(int(at.u == 1) + 2 * int(at.v == 1));
    Vec3f sum(0);
    for (std::size_t i = 0; i < stencil.controls.size(); ++i) {
        const std::uint32_t control = controls.indices[stencil.controls[i]];
        const Vec3f p = controls.are_derived ? cage.derived[control] : cage.vertex(control);
        const float w = stencil.weights[i];
        sum = {fma(w, p.x, sum.x), fma(w, p.y, sum.y), fma(w, p.z, sum.z)};
    }
    return sum;
}

Vec3f OwnedCurves::end_point(const PosedCage& cage, std::uint32_t curve, int filter, int end)
{
    const Topology& topology = *cage.topology;
    if (!topology.is_inner(curve)) return vertex_point(cage, topology.end_vertex(curve, end), filter);
    if (end == 1) return surface_.point(cage, {{topology.curve_point(curve, 1).patch.face, 0}, 1, 1}, filter);
    Vec3f p;
    points(cage, topology.base_edge(curve), filter, 0.5f, 1, {&p, 1});
    return p;
}

void OwnedCurves::points_of_owner(const PosedCage& cage, std::uint32_t curve, int filter, float c0, float dc,
                                  std::span<Vec3f> out)
{
    // A few points are kept, since the patch on the other side and coarser pairs need them again.
    const bool is_middle = c0 == 0.5f && out.size() == 1,
               is_kept = !cage.is_displaced() && (is_middle || (std::fabs(dc) == 0.25f && out.size() == 3));
    if (is_kept) {
        const Known& of = known(cage, curve);
        if (is_middle && of.has_middle) {
            out[0] = of.p[1];
            return;
        }
        if (!is_middle && of.has_quarters) {
            for (std::size_t i = 0; i < 3; ++i) out[i] = of.p[dc > 0 ? i : 2 - i];
            return;
        }
    }
    const Topology& topology = *cage.topology;
    const OwnerSpan s = topology.has_middle_knot(curve) && c0 > 0.5f ? owner_span(topology, curve, 0.75f, 0.875f)
                                                                     : owner_span(topology, curve, 0.125f, 0.25f);
    surface_.curve({cage, s.patch, filter}, {s.along_v, s.fixed, s.t0 + c0 * s.dt, dc * s.dt}, out);
    if (!is_kept) return;
    Known& of = known(cage, curve);
    of.has_middle = true;
    of.has_quarters |= !is_middle;
    if (is_middle) of.p[1] = out[0];
    for (std::size_t i = 0; i < 3 && !is_middle; ++i) of.p[i] = out[dc > 0 ? i : 2 - i];
}

void OwnedCurves::points(const PosedCage& cage, std::uint32_t curve, int filter, float c0, float dc, std::span<Vec3f> out)
{
    const Topology& topology = *cage.topology;
    const auto c_at = [&](std::size_t i) { return c0 + float(i) * dc; };
    const bool knot = topology.has_middle_knot(curve);
    for (std::size_t i = 0; i < out.size();) {
        const float c = c_at(i);
        if (c == 0 || c == 1) {
            out[i++] = end_point(cage, curve, filter, c == 1);
            continue;
        }
        if (knot && c == 0.5f) {
            out[i++] = surface_.point(cage, topology.curve_point(curve, c), filter);
            continue;
        }
        // Finds the longest run on one owner's patch.
        std::size_t end = i + 1;
        while (end < out.size() && c_at(end) != 0 && c_at(end) != 1 &&
               !(knot && ((c_at(end) < 0.5f) != (c < 0.5f) || c_at(end) == 0.5f)))
            ++end;
        points_of_owner(cage, curve, filter, c, dc, out.subspan(i, end - i));
        i = end;
    }
}

void OwnedCurves::points_of_side(const PosedCage& cage, const TileRef& tile, int side, int first, std::span<Vec3f> out)
{
    const SideCurve on = cage.topology->side(tile.patch, side);
    const float step = (on.c1 - on.c0) * power_of_two(-tile.rates.side[side]);
    points(cage, on.curve, tile.rates.filter, on.c0 + float(first) * step, step, out);
}

}  // namespace occam::lod
