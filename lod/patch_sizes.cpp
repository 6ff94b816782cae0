#include "lod/patch_sizes.h"

#include <cmath>

#include "base/power_of_two.h"

namespace occam::lod {

PatchScale PatchSizes::scale(const PosedCage& cage, PatchRef patch)
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

PatchScale PatchSizes::scale_at_key(const PosedCage& cage, PatchRef patch)
{
    const Topology& topology = *cage.topology;
    float speed_u, speed_v;
    surface_.speeds(cage, patch, speed_u, speed_v);
    PatchScale scale;
    if (cage.is_displaced()) scale.filter_stops = cage.displacement.stops;
    scale.k = {std::min(ceil_log2(speed_u), kLargestK), std::min(ceil_log2(speed_v), kLargestK)};
    for (int side = 0; side < 4; ++side) {
        const SideCurve on = topology.side(patch, side);
        // A side that is half of a curve has half of its pieces, and half of its speed.
        const int half = std::fabs(on.c1 - on.c0) == 0.5f ? 1 : 0;
        scale.side_k[side] = curves_.k(cage, on.curve) - half;
        scale.side_least[side] = topology.least_exponent(on.curve) - half;
        scale.k[side & 1] = std::max(scale.k[side & 1], scale.side_k[side]);
        scale.least[side & 1] = std::max(scale.least[side & 1], scale.side_least[side]);
    }
    scale.limit_aspect();
    return scale;
}

Box3f PatchSizes::bounds(const PosedCage& cage, const PatchScale& scale, const PatchRegion& region, int coarsest)
{
    PosedPatch& patch = surface_.posed(cage, region.patch);
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

}  // namespace occam::lod
