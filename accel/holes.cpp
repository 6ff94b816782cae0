#include "accel/holes.h"

#include "accel/hit_geometry.h"
#include "accel/hit_shares.h"
#include "accel/packet.h"

namespace occam::accel {
namespace {

// Holds what a filter is asked about a point.
struct Place {
    lod::VertexToShade texture;
    Vec4f color{1};
};

// Returns what resolve() would find there, without the widths of filters.
Place place_of(const Holes& holes, const Ray& ray, const GridHit& met, const MicropolygonPlace& spot) noexcept
{
    const std::span<const Ray> rays(&ray, 1);
    HitCorners corners({&met, 1}, &spot);
    vfloat share[3];
    HitRays placed(rays, {&met, 1}, *met.grid, met.grid->cage->affine ? 1u : 0u);
    placed.set_positions(corners, 0);
    corners.set_attributes(*holes.frame.scene);
    shares_of(corners, {holes.axes, rays, placed, is_gap(met) ? 1u : 0u}, share);
    Place place;
    for (int s = 0; s < 2; ++s) {
        if (corners.has_uv[s] == 0) continue;
        const UvLanes uv(corners.uv[s]);
        for (int a = 0; a < 2; ++a) place.texture.uv[s][a] = first_lane(uv.at_share(a, share));
    }
    if (corners.has_color != 0)
        place.color = weighted(corners.color[0], {first_lane(share[0]), first_lane(share[1]), first_lane(share[2])});
    return place;
}

// Returns the hit of a ray in an igrid, as it would be if it counted.
GridHit hit_of(const Holes& holes, int lane, float t, IGrid& on, std::uint32_t number) noexcept
{
    GridHit met{t, &on, number, {}, {}, 0};
    if (on.blends()) met.blend = holes.blend(holes.levels, on.pairs.finest, static_cast<std::size_t>(lane));
    if (on.segments > 0) met.time = lod::key_time(holes.rays[static_cast<std::size_t>(lane)].time, on.segments);
    return met;
}

}  // namespace

bool passes_back(const Holes& holes, int lane, float t, IGrid& on, std::uint32_t number) noexcept
{
    MicropolygonPlace spot;
    spot.set({t, &on, number, {}, {}, 0});
    return holes.frame.shading.filter->hides_back(*material_of(*holes.frame.scene, *on.cage, spot.face)) &&
           is_back_side(holes.rays[static_cast<std::size_t>(lane)], holes.axes, hit_of(holes, lane, t, on, number),
                        holes.frame);
}

bool passes_hole(const Holes& holes, int lane, float t, IGrid& on, std::uint32_t number) noexcept
{
    if (passes_back(holes, lane, t, on, number)) return true;
    MicropolygonPlace spot;
    spot.set({t, &on, number, {}, {}, 0});
    const Material& material = *material_of(*holes.frame.scene, *on.cage, spot.face);
    if (material.alpha_mode != AlphaMode::Mask) return false;
    const lod::HitFilter& filter = *holes.frame.shading.filter;
    const bool is_even = !material.base_color_texture && !material.alpha_texture && on.cage->slot->cage.colors.empty();
    if (is_even) return filter.is_hole(material, {}, Vec4f(1));
    const Place place = place_of(holes, holes.rays[static_cast<std::size_t>(lane)], hit_of(holes, lane, t, on, number),
                                 spot);
    return filter.is_hole(material, place.texture, place.color);
}

}  // namespace occam::accel
