#include "accel/hit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <tuple>

#include "accel/hit_geometry.h"
#include "accel/packet.h"
#include "accel/triangle.h"
#include "accel/vertex_values.h"
#include "scenegraph/base/hash.h"

namespace occam::accel {
namespace {

// The micropolygon's place in the scene, whatever igrid holds it.
auto order_of(const IGrid& grid, std::uint32_t id) noexcept
{
    if (!grid.is_lattice) return std::tuple(grid.cage->key, id, 0u, 0, 0u, 0u, 0u);
    const std::uint32_t number = number_of(grid, id);
    const lod::TileRef& tile = grid.parts[part_of(number)].tile;
    const QuadRef quad = quad_of(number);
    const std::uint32_t patch_face = tile.patch.face, kind = is_closer(id) ? 2u : quad.triangle;
    return std::tuple(grid.cage->key, patch_face, tile.patch.sub, grid.pairs.finest, tile.j0 + quad.j, tile.i0 + quad.i, kind);
}

// Barycentrics of the point where the ray meets the plane of a T-vertex's triangle, kept inside of it; in double, since it has no area.
Vec3d barycentrics(const Corners& corners, std::size_t lane, Vec3d origin, Vec3d direction) noexcept
{
    const auto from_origin = [&](int corner) { return Vec3d(corners.position_of(corner, lane)) - origin; };
    const Vec3d a = from_origin(0), b = from_origin(1), c = from_origin(2);
    Vec3d w{glm::dot(direction, glm::cross(c, b)), glm::dot(direction, glm::cross(a, c)), glm::dot(direction, glm::cross(b, a))};
    const double sum = w.x + w.y + w.z;
    if (sum == 0) return Vec3d(1.0 / 3);
    w *= 1 / sum;
    if (w.x >= 0 && w.y >= 0 && w.z >= 0) return w;
    w = glm::max(w, Vec3d(0));
    return w / (w.x + w.y + w.z);
}

// Shares of the corners at the hit: the triangle's edge functions, as when it was met.
void shares_of(const Corners& corners, const vfloat (&shears)[4], const RayAxes& axes, const vfloat (&origin)[4], vfloat (&share)[3]) noexcept
{
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

const Material* material_of(const Scene& scene, const lod::PosedCage& cage, std::uint32_t face) noexcept
{
    static const Material plain;
    const Cage& source = cage.slot->cage;
    const std::size_t slot = source.face_slots.empty() ? 0 : source.face_slots[face];
    const auto& from = cage.node->materials.empty() ? source.materials : cage.node->materials;
    const Material* found = slot < from.size() ? scene.find(from[slot]) : nullptr;
    return found ? found : &plain;
}

// The set that decides the axes of normal maps.
int normal_map_set(const Material& m) noexcept
{
    const TextureUse& use = m.normal_texture ? m.normal_texture : m.clearcoat_normal_texture;
    return std::clamp(use.uv_set, 0, 1);
}

// Of what is smaller no gradient is asked for: a float would not hold it.
constexpr float kLeastArea = 1e-30f;

// A vector's lanes, to be read one by one.
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
struct StoredFloats {
    alignas(32) FloatLanes lanes;
    explicit StoredFloats(vfloat x) noexcept { x.store(lanes); }
    float operator[](std::size_t lane) const noexcept { return lanes[lane]; }
};

}  // namespace

bool comes_before(const IGrid& a, std::uint32_t a_id, const IGrid& b, std::uint32_t b_id) noexcept
{
    return order_of(a, a_id) < order_of(b, b_id);
}

void resolve(std::span<const Ray> rays, const RayAxes* axes, std::span<const Met> met, const PhaseOneTools& tools, SurfaceHit* const* hits)
{
    const std::size_t n = rays.size();
    // What is read ray by ray.
    PlacedOrigin placed[kLanes]{};
    const Material* material[kLanes]{};
    Corners corners;
    alignas(32) FloatLanes mirrored{}, width{}, second_set{};
    unsigned closers = 0;
    for (std::size_t i = 0; i < n; ++i)
        if (met[i].grid) placed[i] = place(rays[i], met[i].grid->cage->anchor, met[i].grid->cage->radius);
    vfloat origin[4], way[4], shear_of[4];
    gather_four(placed, n, 0, origin);
    gather_four(rays.data(), n, offsetof(Ray, direction), way);
    gather_four(axes, n, offsetof(RayAxes, shear), shear_of);
    corners.set_positions(met, {way[0], way[1], way[2]}, {origin[0], origin[1], origin[2]}, origin[3]);
    for (std::size_t i = 0; i < n; ++i) {
        if (!met[i].grid) continue;
        corners.set_attributes(i, met[i], tools);
        const lod::PosedCage& cage = *met[i].grid->cage;
        material[i] = material_of(*tools.frame.scene, cage, face_of(met[i]));
        mirrored[i] = cage.is_mirrored ? -1.0f : 1.0f;
        width[i] = rays[i].footprint.at(met[i].t);
        second_set[i] = static_cast<float>(normal_map_set(*material[i]));
        if (is_closer(met[i])) closers |= 1u << i;
    }

    vfloat share[3];
    shares_of(corners, shear_of, axes[0], origin, share);
    if (closers != 0) {
        alignas(32) FloatLanes own[3];
        for (int p = 0; p < 3; ++p) share[p].store(own[p]);
        for (unsigned left = closers; left != 0; left &= left - 1) {
            const auto i = static_cast<std::size_t>(std::countr_zero(left));
            const Vec3d w = barycentrics(corners, i, rays[i].origin - met[i].grid->cage->anchor, Vec3d(rays[i].direction));
            for (int p = 0; p < 3; ++p) own[p][i] = static_cast<float>(w[p]);
        }
        for (int p = 0; p < 3; ++p) share[p] = vfloat::load(own[p]);
    }

    const vfloat zero = 0.0f, one = 1.0f;
    const Triangles tri(corners);
    const auto between = [&](vfloat a, vfloat b, vfloat c) { return fma(a, share[0], fma(b, share[1], c * share[2])); };
    const VecLanes offset = tri.edge[0] * share[1] + tri.edge[1] * share[2];  // from a
    const VecLanes direction{way[0], way[1], way[2]};
    const VecLanes normal[3] = {load(corners.normal[0]), load(corners.normal[1]), load(corners.normal[2])};
    const VecLanes mixed = normal[0] * share[0] + normal[1] * share[1] + normal[2] * share[2];
    const vfloat longest = largest(mixed);
    const vmask is_smooth = longest > vfloat(1e-20f);
    const VecLanes scaled = mixed * select(is_smooth, one / longest, zero);
    VecLanes shading = scaled * select(is_smooth, one / sqrt(dot(scaled, scaled)), zero);
    // A closer has no area, and a degenerate patch corner no normal: one stands in for the other.
    alignas(32) FloatLanes is_flat{};
    for (unsigned left = closers; left != 0; left &= left - 1) is_flat[std::countr_zero(left)] = 1;
    const vmask has_normal = andnot(tri.area > zero, vfloat::load(is_flat) > zero);
    VecLanes geometric = select(has_normal, tri.normal * vfloat::load(mirrored), select(is_smooth, shading, -direction));
    shading = select(is_smooth, shading, geometric);
    const vmask is_back = dot(geometric, direction) > zero;
    geometric = select(is_back, -geometric, geometric);
    shading = select(dot(shading, geometric) < zero, -shading, shading);

    // How coordinates change over the triangle.
    const vmask has_gradients = andnot(tri.area > vfloat(kLeastArea), vfloat::load(is_flat) > zero);
    const vfloat outward = outward_curvature(tri, normal);
    const StoredFloats curvature(select(has_gradients, select(is_back, -outward, outward), zero));
    const unsigned with_gradients = bits(has_gradients);
    const UvLanes uv[2] = {UvLanes(corners.uv[0]), UvLanes(corners.uv[1])};
    Tangents tangent{VecLanes{0.0f, 0.0f, 0.0f}, 1.0f};
    if ((corners.has_uv[0] | corners.has_uv[1]) != 0) {
        const vmask is_second = vfloat::load(second_set) > zero;
        UvLanes chosen;
        for (int p = 0; p < 2; ++p)
            for (int a = 0; a < 2; ++a) chosen.edge[p][a] = select(is_second, uv[1].edge[p][a], uv[0].edge[p][a]);
        tangent = tangents(tri, chosen, select(is_back, -shading, shading));
    }
    const Stored tangent_along(tangent.along);
    const StoredFloats tangent_sign(tangent.sign);
    alignas(32) FloatLanes uv_at[2][2], uv_width[2];
    for (int s = 0; s < 2; ++s) {
        for (int a = 0; a < 2; ++a) fma(uv[s].edge[0][a], share[1], fma(uv[s].edge[1][a], share[2], uv[s].at[a])).store(uv_at[s][a]);
        const vfloat uv_area = abs(difference_of_products(uv[s].edge[0][0], uv[s].edge[1][1], uv[s].edge[0][1], uv[s].edge[1][0]));
        select(tri.area > zero, vfloat::load(width) * sqrt(uv_area / tri.area), zero).store(uv_width[s]);
    }

    const Stored from_a(offset), shading_at(shading), geometric_at(geometric), shares({share[0], share[1], share[2]});
    const StoredFloats farthest(largest(load(corners.position[0]) + offset));
    const StoredFloats blend(between(vfloat::load(corners.weight[0]), vfloat::load(corners.weight[1]), vfloat::load(corners.weight[2])));
    const unsigned back = bits(is_back);
    for (std::size_t i = 0; i < n; ++i) {
        if (!met[i].grid) continue;
        IGrid& grid = *met[i].grid;
        const lod::PosedCage& cage = *grid.cage;
        const std::uint32_t number = number_of(met[i]);
        const Vec3f w = shares[i];
        SurfaceHit& hit = *hits[i];
        hit.t = met[i].t;
        hit.position = cage.anchor + (Vec3d(corners.position_of(0, i)) + Vec3d(from_a[i]));
        hit.self_distance = 2 * grid.delta + 16 * FLT_EPSILON * std::max(cage.radius, farthest[i]);
        hit.normal_geometric = geometric_at[i];
        hit.normal_shading = shading_at[i];
        hit.back_side = (back >> i & 1) != 0;
        hit.curvature = curvature[i];
        hit.material = material[i];
        const bool is_known = (with_gradients >> i & 1) != 0;
        const bool has_tangent = is_known && (corners.has_uv[static_cast<int>(second_set[i])] >> i & 1) != 0;
        hit.tangent = has_tangent ? tangent_along[i] : Vec3f(0);
        hit.tangent_sign = has_tangent ? tangent_sign[i] : 1;
        hit.u_gradient = hit.v_gradient = Vec3f(0);
        const int bump_set = std::clamp(material[i]->bump_texture.uv_set, 0, 1);
        if (material[i]->bump_texture && is_known && (corners.has_uv[bump_set] >> i & 1) != 0) {
            const Stored b(tri.gradient[0]), c(tri.gradient[1]);
            const auto change = [&](int corner, int axis) { return corners.uv[bump_set][corner][axis][i] - corners.uv[bump_set][0][axis][i]; };
            hit.u_gradient = b[i] * change(1, 0) + c[i] * change(2, 0);
            hit.v_gradient = b[i] * change(1, 1) + c[i] * change(2, 1);
        }
        for (int s = 0; s < 2; ++s) {
            const bool has_uv = (corners.has_uv[s] >> i & 1) != 0;
            hit.uv[s] = has_uv ? Vec2f(uv_at[s][0][i], uv_at[s][1][i]) : Vec2f(0);
            hit.uv_width[s] = has_uv ? uv_width[s][i] : 0;
        }
        hit.color = Vec4f(1);
        if (corners.has_color >> i & 1) hit.color = corners.color[i][0] * w.x + corners.color[i][1] * w.y + corners.color[i][2] * w.z;
        hit.node = cage.node_id;
        hit.lit_by = cage.lit_by;
        hit.face = face_of(met[i]);
        hit.level = grid.level;
        hit.blend = blend[i];
        hit.phase_one_channels = 0;
        const lod::TileRef* tile = grid.is_lattice ? &grid.parts[part_of(number)].tile : nullptr;
        if (tile && tools.frame.shading.shader) {
            // A closer is a line without width: the quad beside it stands in.
            const QuadRef q = quad_of(number);
            Vec2d at(q.i, q.j);
            for (int p = 0; p < 3 && !is_closer(met[i]); ++p) at += Vec2d(kQuadCorners[q.triangle][p][0], kQuadCorners[q.triangle][p][1]) * double(w[p]);
            add_vertex_values(grid, part_of(number), at, tools, hit);
        }
        const std::uint64_t tile_number = tile ? std::uint64_t(tile->j0) << 32 | tile->i0 : 0;
        hit.micropolygon = static_cast<std::uint32_t>(mix_bits(cage.key ^ mix_bits(std::uint64_t(number) << 32 ^ hit.face) ^ tile_number));
    }
}

}  // namespace occam::accel
