#include "accel/hit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <tuple>

#include "accel/hit_geometry.h"
#include "accel/packet.h"
#include "accel/ray_starts.h"
#include "accel/triangle.h"
#include "accel/vertex_values.h"
#include "base/hash.h"

namespace occam::accel {
namespace {

// Identifies the micropolygon's place in the scene, whichever igrid holds it.
auto order_of(const IGrid& grid, std::uint32_t id) noexcept
{
    if (!grid.is_lattice) return std::tuple(grid.cage->key, id, 0u, 0, 0u, 0u, 0u);
    const std::uint32_t number = number_of(grid, id);
    const lod::TileRef& tile = grid.lattice().parts[part_of(number)].tile;
    const QuadRef quad = quad_of(number);
    const std::uint32_t patch_face = tile.patch.face, kind = is_gap(id) ? 2u : quad.triangle;
    return std::tuple(grid.cage->key, patch_face, tile.patch.sub, grid.pairs.finest, tile.j0 + quad.j, tile.i0 + quad.i,
                      kind);
}

// Computes the barycentrics of the point where the ray meets the plane of a gap triangle, clamped to the triangle; in
// double, since the triangle has no area.
Vec3d barycentrics(const HitCorners& corners, std::size_t lane, Vec3d origin, Vec3d direction) noexcept
{
    const auto from_origin = [&](int corner) { return Vec3d(corners.position_of(corner, lane)) - origin; };
    const Vec3d a = from_origin(0), b = from_origin(1), c = from_origin(2);
    Vec3d w{glm::dot(direction, glm::cross(c, b)), glm::dot(direction, glm::cross(a, c)),
            glm::dot(direction, glm::cross(b, a))};
    const double sum = w.x + w.y + w.z;
    if (sum == 0) return Vec3d(1.0 / 3);
    w *= 1 / sum;
    if (w.x >= 0 && w.y >= 0 && w.z >= 0) return w;
    w = glm::max(w, Vec3d(0));
    return w / (w.x + w.y + w.z);
}

// Computes the barycentric weights of the corners at the hit, from the same edge functions that found the hit.
void shares_of(const HitCorners& corners, const RayAxes& axes, const vfloat (&way)[4], const vfloat (&origin)[4],
               vfloat (&share)[3]) noexcept
{
    vfloat shears[3];
    set_shear(axes, way, shears);
    RayLanes rays;
    rays.sx = shears[0];
    rays.sy = shears[1];
    rays.sz = shears[2];
    const VecLanes from{origin[axes.kx], origin[axes.ky], origin[axes.kz]};
    const auto corner = [&](int p) {
        const FloatLanes(&at)[3] = corners.position[p];
        return shear(rays, from, {vfloat::load(at[axes.kx]), vfloat::load(at[axes.ky]), vfloat::load(at[axes.kz])});
    };
    const EdgeFunctions edges = edge_functions(corner(0), corner(1), corner(2));
    const vfloat zero = 0.0f, det = (edges.u + edges.v) + edges.w;
    const vmask has_area = (det > zero) | (det < zero);
    const vfloat of[3] = {edges.u, edges.v, edges.w};
    for (int p = 0; p < 3; ++p) share[p] = select(has_area, max(of[p] / det, zero), 1.0f / 3);
}

// Does the same for gap triangles, which have no edge functions.
OCCAM_NEVER_INLINE void set_shares_of_gaps(unsigned gaps, const HitCorners& corners, std::span<const Ray> rays,
                                           std::span<const GridHit> met, vfloat (&share)[3]) noexcept
{
    alignas(32) FloatLanes own[3];
    for (int p = 0; p < 3; ++p) share[p].store(own[p]);
    for (unsigned left = gaps; left != 0; left &= left - 1) {
        const auto i = static_cast<std::size_t>(std::countr_zero(left));
        const Vec3d w = barycentrics(corners, i, rays[i].origin - met[i].grid->cage->anchor, Vec3d(rays[i].direction));
        for (int p = 0; p < 3; ++p) own[p][i] = static_cast<float>(w[p]);
    }
    for (int p = 0; p < 3; ++p) share[p] = vfloat::load(own[p]);
}

// Returns the set of texture coordinates that decides the axes of normal maps and brush strokes, or -1 if the material
// has neither.
int normal_map_set(const Material& m) noexcept
{
    const TextureUse& use = m.normal_texture ? m.normal_texture : m.clearcoat_normal_texture;
    if (use) return std::clamp(use.uv_set, 0, 1);
    return m.anisotropy > 0 ? std::clamp(m.anisotropy_texture.uv_set, 0, 1) : -1;
}

// For smaller values no gradient is computed: a float would not hold it.
constexpr float kLeastArea = 1e-30f;

// Stores a vector's lanes, to be read one by one.
struct Stored {
    alignas(32) FloatLanes axis[3];
    explicit Stored(const VecLanes& v) noexcept
    {
        v.x.store(axis[0]);
        v.y.store(axis[1]);
        v.z.store(axis[2]);
    }
    Vec3f operator[](std::size_t lane) const noexcept { return {axis[0][lane], axis[1][lane], axis[2][lane]}; }
};

Vec4f weighted(const Vec4f (&of)[3], Vec3f w) noexcept { return of[0] * w.x + of[1] * w.y + of[2] * w.z; }

/// to_frame   frame lengths of a world length
OCCAM_NEVER_INLINE void set_bump_gradients(const HitCorners& corners, const Triangles& tri, std::size_t lane, float to_frame,
                                           SurfaceHit& hit) noexcept
{
    const int set = std::clamp(hit.material->bump_texture.uv_set, 0, 1);
    if ((corners.has_uv[set] >> lane & 1) == 0) return;
    const Stored b(tri.gradient[0]), c(tri.gradient[1]);
    const auto change = [&](int corner, int axis) {
        return (corners.uv[set][corner][lane][axis] - corners.uv[set][0][lane][axis]) * to_frame;
    };
    hit.u_gradient = b[lane] * change(1, 0) + c[lane] * change(2, 0);
    hit.v_gradient = b[lane] * change(1, 1) + c[lane] * change(2, 1);
}

// Returns the level in this range whose edges are at most `factor` times the target edge length of the ray at its hit.
int level_at(const Ray& ray, const GridHit& met, const lod::LevelSettings& levels, float factor, PairRange range) noexcept
{
    const float target_edge = target_edge_of(ray, levels).at(met.t);
    const int level = target_edge > 0 ? std::ilogb(std::min(target_edge, FLT_MAX) * factor) : lod::kFinestLevel;
    return std::clamp(level, std::clamp(range.finest, lod::kFinestLevel, lod::kCoarsestLevel),
                      std::clamp(range.coarsest, lod::kFinestLevel, lod::kCoarsestLevel));
}

// Returns the finer level of the pair that the ray sees at the hit, of those that the igrid serves.
int seen_level_of(const Ray& ray, const GridHit& met, const lod::LevelSettings& levels) noexcept
{
    const PairRange pairs = met.grid->pairs;
    if (!met.grid->is_lattice || levels.mode == lod::LevelMode::PerInstance || pairs.coarsest <= met.grid->level)
        return met.grid->level;
    return level_at(ray, met, levels, 1, {met.grid->level, pairs.coarsest});
}

// Holds what is computed of a hit in lanes, in the order in which it is written: four floats at a time.
struct HitFloats {
    float t, self_distance, uv_width[2];
    Vec3f normal_geometric;
    float curvature;
    Vec3f normal_shading;
    float tangent_sign;
    Vec3f tangent;
    float blend;
    Vec2f uv[2];

    void copy_to(SurfaceHit& hit) const noexcept
    {
        hit.t = t;
        hit.self_distance = self_distance;
        hit.uv_width[0] = uv_width[0];
        hit.uv_width[1] = uv_width[1];
        hit.normal_geometric = normal_geometric;
        hit.curvature = curvature;
        hit.normal_shading = normal_shading;
        hit.tangent_sign = tangent_sign;
        hit.tangent = tangent;
        hit.blend = blend;
        hit.uv[0] = uv[0];
        hit.uv[1] = uv[1];
    }
};
static_assert(sizeof(HitFloats) == 20 * sizeof(float));  // there is no padding between the floats

// Identifies the micropolygon that was hit, by number.
void set_identity(const GridHit& met, const MicropolygonPlace& spot, SurfaceHit& hit) noexcept
{
    const lod::PosedCage& cage = *met.grid->cage;
    hit.node = cage.node_id;
    hit.lit_by = cage.lit_by;
    hit.face = spot.face;
    const std::uint64_t tile = spot.part ? std::uint64_t(spot.part->tile.j0) << 32 | spot.part->tile.i0 : 0;
    hit.micropolygon = static_cast<std::uint32_t>(
        mix_bits(cage.key ^ (std::uint64_t(spot.number) << 32 ^ spot.face) ^ tile * 0x9e3779b97f4a7c15u));
}

// Returns the level at which secondary rays from a hit start: of the igrid's two levels, the one whose edges are nearer
// to the target edge length of the ray there.
int start_level_of(const Ray& ray, const GridHit& met, const lod::LevelSettings& levels) noexcept
{
    if (levels.mode == lod::LevelMode::PerInstance) return kAnyLevel;
    const PairRange pairs = met.grid->pairs;
    return level_at(ray, met, levels, 4.0f / 3, {pairs.finest, pairs.coarsest + 1});
}

// Returns the place of a hit within its part, in quads. For a gap triangle, which has no width, it is the corner of the quad
// beside it.
Vec2d place_in_part(const GridHit& met, const MicropolygonPlace& spot, Vec3f share) noexcept
{
    Vec2d at(spot.i, spot.j);
    for (int p = 0; p < 3 && !is_gap(met); ++p)
        at += Vec2d(kQuadCorners[spot.triangle][p][0], kQuadCorners[spot.triangle][p][1]) * double(share[p]);
    return at;
}

}  // namespace

bool comes_before(const IGrid& a, std::uint32_t a_id, const IGrid& b, std::uint32_t b_id) noexcept
{
    return order_of(a, a_id) < order_of(b, b_id);
}

void resolve(std::span<const Ray> rays, const RayAxes& axes, std::span<const GridHit> met, const PhaseOneTools& tools,
             SurfaceHit* const* hits)
{
    const std::size_t n = rays.size();
    // The following values are read ray by ray.
    MicropolygonPlace spots[kLanes];
    alignas(32) FloatLanes t{}, mirrored{}, set_of_map{}, radius{};
    unsigned gaps = 0, coarse_starts = 0;
    int start_level[kLanes]{};
    bool any_maps = false;
    const IGrid* someone = nullptr;
    for (std::size_t i = 0; i < n; ++i) {
        if (!met[i].grid) continue;
        const IGrid& grid = *met[i].grid;
        const lod::PosedCage& cage = *grid.cage;
        someone = &grid;
        spots[i].set(met[i]);
        t[i] = met[i].t;
        radius[i] = cage.radius;
        const bool is_mirrored = cage.segments > 0 ? cage.is_mirrored_at(met[i].time) : cage.is_mirrored;
        mirrored[i] = is_mirrored ? -1.0f : 1.0f;
        if (is_gap(met[i])) gaps |= 1u << i;
        start_level[i] = start_level_of(rays[i], met[i], tools.frame.levels);
        if (grid.blends() && start_level[i] > grid.pairs.finest) coarse_starts |= 1u << i;
    }
    if (!someone) return;
    HitCorners corners(met, spots);
    vfloat origin[4], way[4], beam[4];
    gather_four(rays.data(), n, offsetof(Ray, direction), way);
    place_all(
        rays, way, [&](std::size_t i) -> const lod::PosedCage& { return *(met[i].grid ? met[i].grid : someone)->cage; },
        origin);
    static_assert(offsetof(Ray, footprint) == offsetof(Ray, t_near) + 2 * sizeof(float));
    gather_four(rays.data(), n, offsetof(Ray, t_near), beam);
    corners.set_positions({way[0], way[1], way[2]}, {origin[0], origin[1], origin[2]}, origin[3], coarse_starts);
    corners.set_attributes(tools);
    for (std::size_t i = 0; i < n; ++i) {
        if (!met[i].grid) continue;
        const int set = normal_map_set(*corners.material[i]);
        set_of_map[i] = static_cast<float>(set);
        any_maps = any_maps || set >= 0;
    }

    vfloat share[3];
    shares_of(corners, axes, way, origin, share);
    if (gaps != 0) set_shares_of_gaps(gaps, corners, rays, met, share);

    const vfloat zero = 0.0f, one = 1.0f;
    const Triangles tri(corners);
    const auto between = [&](vfloat a, vfloat b, vfloat c) { return fma(a, share[0], fma(b, share[1], c * share[2])); };
    const VecLanes offset = tri.edge[0] * share[1] + tri.edge[1] * share[2];  // relative to corner a
    const VecLanes direction{way[0], way[1], way[2]};
    VecLanes normal[3];
    for (int p = 0; p < 3; ++p) {
        vfloat axes_of[4];
        load(corners.normal[p], axes_of);
        normal[p] = {axes_of[0], axes_of[1], axes_of[2]};
    }
    const VecLanes mixed = normal[0] * share[0] + normal[1] * share[1] + normal[2] * share[2];
    const vfloat longest = largest(mixed);
    const vmask is_smooth = longest > vfloat(1e-20f);
    const VecLanes scaled = mixed * select(is_smooth, one / longest, zero);
    VecLanes shading = scaled * select(is_smooth, one / sqrt(dot(scaled, scaled)), zero);
    // A gap triangle has no area, and a degenerate patch corner has no normal: one stands in for the other.
    alignas(32) FloatLanes is_flat{};
    for (unsigned left = gaps; left != 0; left &= left - 1) is_flat[std::countr_zero(left)] = 1;
    const vmask has_normal = andnot(tri.area > zero, vfloat::load(is_flat) > zero);
    VecLanes geometric = select(has_normal, tri.normal * vfloat::load(mirrored), select(is_smooth, shading, -direction));
    shading = select(is_smooth, shading, geometric);
    const vmask is_back = dot(geometric, direction) > zero;
    geometric = select(is_back, -geometric, geometric);
    shading = select(dot(shading, geometric) < zero, -shading, shading);

    // These are the changes of the texture coordinates over the triangle.
    const vmask has_gradients = andnot(tri.area > vfloat(kLeastArea), vfloat::load(is_flat) > zero);
    const vfloat outward = outward_curvature(tri, normal);
    const vfloat curvature = select(has_gradients, select(is_back, -outward, outward), zero);
    const vfloat width = max(beam[2] + beam[3] * vfloat::load(t), zero);
    vfloat uv_at[2][2] = {{zero, zero}, {zero, zero}}, uv_width[2] = {zero, zero};
    Tangents tangent{VecLanes{zero, zero, zero}, one};
    UvLanes of_map;  // lanes without a map or coordinates are all 0, and so is the tangent
    for (int s = 0; s < 2; ++s) {
        if (corners.has_uv[s] == 0) continue;
        const UvLanes uv(corners.uv[s]);
        for (int a = 0; a < 2; ++a) uv_at[s][a] = fma(uv.edge[0][a], share[1], fma(uv.edge[1][a], share[2], uv.at[a]));
        const vfloat uv_area = abs(difference_of_products(uv.edge[0][0], uv.edge[1][1], uv.edge[0][1], uv.edge[1][0]));
        uv_width[s] = select((tri.area > zero) & (uv_area > zero), width * sqrt(uv_area / tri.area), zero);
        if (any_maps) of_map.set_where(has_gradients & (vfloat::load(set_of_map) == vfloat(float(s))), uv);
    }
    if (any_maps) tangent = tangents(tri, of_map, select(is_back, -shading, shading));
    const vfloat farthest = max(largest(load(corners.position[0]) + offset), vfloat::load(radius));
    const vfloat self_distance = vfloat(kStartUlps * FLT_EPSILON) * farthest;
    const vfloat blend = between(vfloat::load(corners.weight[0]), vfloat::load(corners.weight[1]),
                                 vfloat::load(corners.weight[2]));

    HitFloats written[kLanes];
    const auto put = [&](const vfloat& x, const vfloat& y, const vfloat& z, const vfloat& w, std::size_t place) {
        const vfloat four[4] = {x, y, z, w};
        float* to[kLanes];
        for (std::size_t i = 0; i < kLanes; ++i) to[i] = reinterpret_cast<float*>(&written[i]);
        store_turned(four, to, place / sizeof(float));
    };
    put(vfloat::load(t), self_distance, uv_width[0], uv_width[1], offsetof(HitFloats, t));
    put(geometric.x, geometric.y, geometric.z, curvature, offsetof(HitFloats, normal_geometric));
    put(shading.x, shading.y, shading.z, tangent.sign, offsetof(HitFloats, normal_shading));
    put(tangent.along.x, tangent.along.y, tangent.along.z, blend, offsetof(HitFloats, tangent));
    put(uv_at[0][0], uv_at[0][1], uv_at[1][0], uv_at[1][1], offsetof(HitFloats, uv));

    // For most hits secondary rays start on the micropolygon that was hit.
    const vfloat least_height = vfloat(kEdgeUlps * FLT_EPSILON) * farthest;
    const vfloat nearest = min(min(share[0], share[1]), share[2]),
                 longest_edge = max(largest(tri.edge[0]), largest(tri.edge[1]));
    const vmask may_differ = nearest * tri.area < vfloat(4.0f) * least_height * longest_edge;
    const unsigned differing = corners.has_start | bits(may_differ);
    alignas(32) FloatLanes starts_differ{};
    for (std::size_t i = 0; i < n; ++i) starts_differ[i] = corners.has_start >> i & 1 ? 1.0f : 0.0f;
    std::optional<Starts> starts;
    if (differing != 0)
        starts.emplace(corners, share, vfloat::load(starts_differ) > zero, vfloat::load(is_flat) > zero, least_height);
    const VecLanes to_start = starts ? (starts->corner - load(corners.position[0])) + (starts->offset - offset) : offset;
    const Stored from_a(offset), shares({share[0], share[1], share[2]});
    const Stored ways_to_start(to_start), start_normals(starts ? starts->normal : offset);
    const unsigned back = bits(is_back), with_gradients = bits(has_gradients);
    const auto to_frame = static_cast<float>(tools.frame.scale.to_frame());
    for (std::size_t i = 0; i < n; ++i) {
        if (!met[i].grid) continue;
        SurfaceHit& hit = *hits[i];
        written[i].copy_to(hit);
        hit.position = met[i].grid->cage->anchor + (Vec3d(corners.position_of(0, i)) + Vec3d(from_a[i]));
        hit.back_side = (back >> i & 1) != 0;
        hit.start_level = static_cast<std::int8_t>(start_level[i]);
        hit.to_start = Vec3f(0);
        hit.start_normal = hit.normal_geometric;
        if (differing >> i & 1) hit.to_start = ways_to_start[i];
        if (corners.has_start >> i & 1) {
            const Vec3f unturned = start_normals[i] * mirrored[i];
            if (unturned != Vec3f(0)) hit.start_normal = hit.back_side ? -unturned : unturned;
        }
        hit.material = corners.material[i];
        hit.color = Vec4f(1);
        if (corners.has_color >> i & 1) hit.color = weighted(corners.color[i], shares[i]);
        hit.u_gradient = hit.v_gradient = Vec3f(0);
        if (hit.material->bump_texture && (with_gradients >> i & 1) != 0) set_bump_gradients(corners, tri, i, to_frame, hit);
        hit.velocity = met[i].grid->segments > 0 ? corners.velocity_of(i, shares[i]) : Vec3f(0);
        set_identity(met[i], spots[i], hit);
        const int level = seen_level_of(rays[i], met[i], tools.frame.levels);
        hit.level = met[i].grid->is_lattice ? level + tools.frame.scale.exponent() : level;
        hit.phase_one_channels = 0;
        // Values at vertices are made for one level. A ray that sees the same mesh from farther away filters more.
        if (spots[i].part && tools.frame.shading.shader && level == met[i].grid->level)
            add_vertex_values(met[i].grid->lattice(), part_of(spots[i].number), place_in_part(met[i], spots[i], shares[i]),
                              tools, hit);
    }
}

}  // namespace occam::accel
