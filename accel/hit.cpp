#include "accel/hit.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "accel/stopwatch.h"
#include "accel/vertex_values.h"
#include "lod/patch_colors.h"
#include "scenegraph/base/hash.h"
#include "scenegraph/base/publish.h"

namespace occam::accel {
namespace {

// The micropolygon's place in the scene, whatever igrid holds it.
auto order_of(const IGrid& grid, std::uint32_t id) noexcept
{
    const bool is_closer = (id & kCloserBit) != 0;
    if (!grid.is_lattice) return std::tuple(grid.cage->key, id, 0u, 0, 0u, 0u, 0u);
    const std::uint32_t number = is_closer ? grid.hanging_quads[id & ~kCloserBit] : id;
    const lod::TileRef& tile = grid.parts[part_of(number)].tile;
    const QuadRef quad = quad_of(number);
    const std::uint32_t patch_face = tile.patch.face, kind = is_closer ? 2u : quad.triangle;
    return std::tuple(grid.cage->key, patch_face, tile.patch.sub, grid.pairs.finest, tile.j0 + quad.j, tile.i0 + quad.i, kind);
}

struct Triangle {
    Vec3f a, b, c;
};

// Barycentrics of the point where the ray meets the triangle's plane, kept inside of it; in double, since the origin may be far away.
Vec3d barycentrics(const Triangle& tri, Vec3d origin, Vec3d direction) noexcept
{
    const Vec3d a = Vec3d(tri.a) - origin, b = Vec3d(tri.b) - origin, c = Vec3d(tri.c) - origin;
    Vec3d w{glm::dot(direction, glm::cross(c, b)), glm::dot(direction, glm::cross(a, c)), glm::dot(direction, glm::cross(b, a))};
    const double sum = w.x + w.y + w.z;
    if (sum == 0) return Vec3d(1.0 / 3);
    w *= 1 / sum;
    if (w.x >= 0 && w.y >= 0 && w.z >= 0) return w;
    w = glm::max(w, Vec3d(0));
    return w / (w.x + w.y + w.z);
}

const int kCorners[2][3][2] = {{{0, 0}, {1, 0}, {1, 1}}, {{0, 0}, {1, 1}, {0, 1}}};

using OwnBlend = VertexBlendOf<float>;

// A vertex of a lattice as a ray sees it, and how coarse it is.
Vec3f blended(const IGrid& grid, const OwnBlend& blend, std::uint32_t vertex, float* weight = nullptr) noexcept
{
    const Vec3f f = grid.fine_at(vertex);
    if (!grid.blends()) return f;
    const Vec3f c = grid.coarse_at(vertex);
    const float w = blend.weight({f.x, f.y, f.z});
    if (weight) *weight = w;
    const PointOf<float> p = OwnBlend::between({f.x, f.y, f.z}, {c.x, c.y, c.z}, w);
    return {p.x, p.y, p.z};
}

// Whether a vertex of the tile is a T-vertex: on a side that has fewer than the lattice, and not one of those.
bool hangs(const lod::TileRef& tile, int i, int j) noexcept
{
    const lod::PatchRates& rates = tile.rates;
    const std::uint32_t u = tile.i0 + static_cast<std::uint32_t>(i), v = tile.j0 + static_cast<std::uint32_t>(j);
    const auto is_between = [&](std::size_t side, std::uint32_t along, int exponent) { return (along & ((1u << (exponent - rates.side[side])) - 1)) != 0; };
    return (v == 0 && is_between(0, u, rates.u)) || (u == 1u << rates.u && is_between(1, v, rates.v)) || (v == 1u << rates.v && is_between(2, u, rates.u)) ||
           (u == 0 && is_between(3, v, rates.v));
}

// The micropolygon as the ray has met it, and the weights of its vertices.
Triangle triangle_of(const IGrid& grid, std::uint32_t id, const OwnBlend& blend, float (&weight)[3]) noexcept
{
    Vec3f v[3];
    const std::uint32_t at = id & ~kCloserBit;
    if (!grid.is_lattice) {
        // Ids of meshes are faces, and are looked up by position.
        std::uint32_t k = 0;
        while (grid.ids[k] != id) ++k;
        for (int p = 0; p < 3; ++p) v[p] = {grid.corners[p * 3][k], grid.corners[p * 3 + 1][k], grid.corners[p * 3 + 2][k]};
    } else if (id & kCloserBit) {
        const lod::Hanging& hanging = grid.hanging[at];
        const lod::Hanging::Ends ends = hanging.on(blended(grid, blend, hanging.a, &weight[0]), blended(grid, blend, hanging.c, &weight[2]));
        v[0] = ends.low;
        v[1] = ends.middle;
        v[2] = ends.high;
        weight[1] = weight[0];
    } else {
        const QuadRef q = quad_of(id);
        const IGridPart& part = grid.parts[part_of(id)];
        for (int p = 0; p < 3; ++p) {
            const int i = q.i + kCorners[q.triangle][p][0], j = q.j + kCorners[q.triangle][p][1];
            v[p] = blended(grid, blend, part.vertex(i, j), &weight[p]);
            if (!grid.blends() || !hangs(part.tile, i, j)) continue;
            for (const lod::Hanging& h : grid.hanging)
                if (h.is_inside && h.i == i && h.j == j && part_of(grid.hanging_quads[&h - grid.hanging.data()]) == part_of(id)) {
                    v[p] = h.on(blended(grid, blend, h.a), blended(grid, blend, h.c)).middle;
                    break;
                }
        }
    }
    return {v[0], v[1], v[2]};
}

struct Corner {
    Vec3f normal{0};
    Vec2f uv[2]{};
    Vec4f color{1};
};

void shade(const IGrid& grid, IGridPart& part, const PhaseOneTools& tools)
{
    const MaybeLock lock(tools.building);
    if (part.is_shaded) return;  // another was here meanwhile
    const Stopwatch watch(tools.counters.shade_seconds);
    part.attributes = tools.dicer.shade(*grid.cage, part.tile, grid.blends() ? part.coarser() : part.tile.rates, tools.arena);
    publish(part.is_shaded, true);
}

void patch_corners(IGrid& grid, std::uint32_t number, bool is_closer, const float (&weight)[3], const PhaseOneTools& tools,
                   Corner (&corner)[3], bool (&has_uv)[2])
{
    IGridPart& part = grid.parts[part_of(number)];
    if (!read_published(part.is_shaded)) shade(grid, part, tools);
    const QuadRef q = quad_of(number);
    std::optional<lod::PatchColors> colors;
    if (!grid.cage->slot->cage.colors.empty()) colors.emplace(*grid.cage, part.tile.patch);
    const auto color_at = [&](int i, int j) {
        return colors->at((float(part.tile.i0) + float(i)) * part.tile.step_u(), (float(part.tile.j0) + float(j)) * part.tile.step_v());
    };
    for (int p = 0; p < 3; ++p) {
        const int i = q.i + (is_closer ? 0 : kCorners[q.triangle][p][0]), j = q.j + (is_closer ? 0 : kCorners[q.triangle][p][1]);
        const int width = part.tile.columns + 1;
        // What is odd lies, in the coarser level, on an edge or a diagonal; and blends as its position does.
        const int low = j * width + i, odd_i = part.is_halved ? i & 1 : 0, odd_j = part.is_halved ? j & 1 : 0;
        const int before = low - odd_j * width - odd_i, behind = low + odd_j * width + odd_i;
        const float w = weight[p];
        const auto blend = [&](const auto* values) {
            return w == 0 ? values[low] : values[low] * (1 - w) + (values[before] + values[behind]) * (0.5f * w);
        };
        const lod::GridAttributes& made = part.attributes;
        corner[p].normal = made.coarse_normal ? made.normal[low] * (1 - w) + made.coarse_normal[low] * w : blend(made.normal);
        for (int s = 0; s < 2; ++s) {
            has_uv[s] = part.attributes.uv[s] != nullptr;
            if (has_uv[s]) corner[p].uv[s] = blend(part.attributes.uv[s]);
        }
        if (colors)
            corner[p].color = color_at(i, j) * (1 - w) + (color_at(i - odd_i, j - odd_j) + color_at(i + odd_i, j + odd_j)) * (0.5f * w);
    }
}

void mesh_corners(const IGrid& grid, std::uint32_t face, Corner (&corner)[3], bool (&has_uv)[2])
{
    const Cage& cage = grid.cage->slot->cage;
    for (std::uint32_t p = 0; p < 3; ++p) {
        const std::size_t at = std::size_t(face) * 3 + p, v = cage.face_vertices[at];
        if (!cage.normals.empty()) corner[p].normal = grid.cage->vertex_normal(static_cast<std::uint32_t>(v));
        if (!cage.colors.empty()) corner[p].color = cage.colors[cage.color_indices.empty() ? v : cage.color_indices[at]];
        for (std::size_t s = 0; s < 2; ++s) {
            has_uv[s] = s < cage.uv_sets.size();
            if (!has_uv[s]) continue;
            const UvSet& set = cage.uv_sets[s];
            corner[p].uv[s] = set.values[set.indices.empty() ? v : set.indices[at]];
        }
    }
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

// Of what is smaller no gradient is asked for: a float would not hold it.
constexpr double kLeastArea = 1e-30;

// Gradients over the triangle of the weights of b and c; a's is what they lack to zero. Per world length.
struct WeightGradients {
    Vec3f b, c;
    WeightGradients(const Triangle& tri, Vec3f winding_normal, float per_area) noexcept
        : b(glm::cross(winding_normal, tri.a - tri.c) * per_area), c(glm::cross(winding_normal, tri.b - tri.a) * per_area)
    {
    }
};

// Half the divergence of the interpolated unit normal: the mean curvature, positive where the outside is convex.
float outward_curvature(const WeightGradients& g, const Corner (&corner)[3]) noexcept
{
    Vec3f n[3];
    for (int p = 0; p < 3; ++p) {
        const float squared = glm::dot(corner[p].normal, corner[p].normal);
        if (!(squared > 0)) return 0;
        n[p] = corner[p].normal * (1 / std::sqrt(squared));
    }
    return 0.5f * (glm::dot(n[1] - n[0], g.b) + glm::dot(n[2] - n[0], g.c));
}

// The set that decides the axes of normal maps.
int normal_map_set(const Material& m) noexcept
{
    const TextureUse& use = m.normal_texture ? m.normal_texture : m.clearcoat_normal_texture;
    return std::clamp(use.uv_set, 0, 1);
}

// Of texture coordinates over the triangle, per world length.
struct UvGradients {
    Vec3d u, v;
    UvGradients(const WeightGradients& g, const Corner (&corner)[3], int set) noexcept
    {
        const Vec2d e(corner[1].uv[set] - corner[0].uv[set]), f(corner[2].uv[set] - corner[0].uv[set]);
        u = Vec3d(g.b) * e.x + Vec3d(g.c) * f.x;
        v = Vec3d(g.b) * e.y + Vec3d(g.c) * f.y;
    }
};

// dP/du and dP/dv are the columns of the inverse of (du/dP, dv/dP): in the plane, turned by a right angle from the
// other's gradient. Their lengths do not matter here, but the sign of the gradients' area does.
void set_tangent(const WeightGradients& g, Vec3d winding_normal, const Corner (&corner)[3], int set, Vec3d outward, SurfaceHit& hit) noexcept
{
    const auto [du, dv] = UvGradients(g, corner, set);
    const double turn = glm::dot(winding_normal, glm::cross(du, dv));
    if (turn == 0) return;
    const Vec3d along_u = glm::cross(dv, winding_normal) * (turn > 0 ? 1.0 : -1.0);
    const Vec3d along_v = glm::cross(winding_normal, du) * (turn > 0 ? 1.0 : -1.0);
    const Vec3d tangent = along_u - outward * glm::dot(along_u, outward);
    const double length = glm::length(tangent);
    if (!(length > 0) || !std::isfinite(length)) return;
    hit.tangent = Vec3f(tangent / length);
    hit.tangent_sign = glm::dot(glm::cross(outward, tangent), along_v) > 0 ? -1.0f : 1.0f;
}

}  // namespace

bool comes_before(const IGrid& a, std::uint32_t a_id, const IGrid& b, std::uint32_t b_id) noexcept
{
    return order_of(a, a_id) < order_of(b, b_id);
}

void resolve(const Ray& ray, const Met& met, const PhaseOneTools& tools, SurfaceHit& hit)
{
    IGrid& grid = *met.grid;
    const std::uint32_t id = met.id;
    const lod::PosedCage& cage = *grid.cage;
    const bool is_closer = (id & kCloserBit) != 0;
    const std::uint32_t number = is_closer ? grid.hanging_quads[id & ~kCloserBit] : id;
    const Vec3d d(ray.direction);
    OwnBlend blend{};
    if (grid.blends()) {
        const PlacedOrigin at = place(ray, cage.anchor, cage.radius);
        const float direction[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
        blend.set(met.blend, direction, at.origin, at.shift);
    }
    float weight[3] = {};
    const Triangle tri = triangle_of(grid, id, blend, weight);
    const Vec3d w = barycentrics(tri, ray.origin - cage.anchor, d);
    const Vec3d local = Vec3d(tri.a) * w.x + Vec3d(tri.b) * w.y + Vec3d(tri.c) * w.z;
    const Vec3f share(w);

    Corner corner[3];
    bool has_uv[2] = {};
    if (!grid.is_lattice) mesh_corners(grid, number, corner, has_uv);
    else patch_corners(grid, number, is_closer, weight, tools, corner, has_uv);

    const Vec3d winding = glm::cross(Vec3d(tri.b - tri.a), Vec3d(tri.c - tri.a));
    const double area = glm::length(winding);  // of the parallelogram
    Vec3f geometric(winding * ((cage.is_mirrored ? -1 : 1) / area));
    Vec3f shading = corner[0].normal * share.x + corner[1].normal * share.y + corner[2].normal * share.z;
    const double length = glm::length(Vec3d(shading));  // of a mesh's normals: any
    const bool is_smooth = length > 1e-20;
    if (is_smooth) shading = Vec3f(Vec3d(shading) * (1 / length));
    // A closer has no area, and a degenerate patch corner no normal: one stands in for the other.
    if (is_closer || !(area > 0)) geometric = is_smooth ? shading : -ray.direction;
    if (!is_smooth) shading = geometric;

    hit.t = met.t;
    hit.curvature = 0;
    hit.tangent = hit.u_gradient = hit.v_gradient = Vec3f(0);
    hit.tangent_sign = 1;
    hit.phase_one_channels = 0;
    hit.position = cage.anchor + local;
    hit.back_side = glm::dot(geometric, ray.direction) > 0;
    if (hit.back_side) geometric = -geometric;
    if (glm::dot(shading, geometric) < 0) shading = -shading;
    hit.normal_geometric = geometric;
    hit.normal_shading = shading;
    const Vec3d size = glm::abs(local);
    hit.self_distance = 2 * grid.delta + 16 * FLT_EPSILON * std::max(cage.radius, static_cast<float>(std::max({size.x, size.y, size.z})));
    hit.color = corner[0].color * share.x + corner[1].color * share.y + corner[2].color * share.z;
    for (int s = 0; s < 2; ++s) {
        hit.uv[s] = Vec2f(0);
        hit.uv_width[s] = 0;
        if (!has_uv[s]) continue;
        hit.uv[s] = corner[0].uv[s] * share.x + corner[1].uv[s] * share.y + corner[2].uv[s] * share.z;
        const Vec2f e = corner[1].uv[s] - corner[0].uv[s], f = corner[2].uv[s] - corner[0].uv[s];
        const double uv_area = std::fabs(double(e.x) * f.y - double(e.y) * f.x);
        hit.uv_width[s] = area > 0 ? static_cast<float>(ray.footprint.at(met.t) * std::sqrt(uv_area / area)) : 0;
    }
    hit.face = face_of(met);
    hit.material = material_of(*tools.frame.scene, cage, hit.face);
    hit.node = cage.node_id;
    hit.lit_by = cage.lit_by;
    if (!is_closer && area > kLeastArea) {
        const double per_area = 1 / area;
        const Vec3f winding_normal(winding * per_area);
        const WeightGradients gradients(tri, winding_normal, static_cast<float>(per_area));
        const float curvature = outward_curvature(gradients, corner);
        hit.curvature = hit.back_side ? -curvature : curvature;
        const int set = normal_map_set(*hit.material);
        if (has_uv[set]) set_tangent(gradients, Vec3d(winding_normal), corner, set, Vec3d(hit.back_side ? -shading : shading), hit);
        const int bump_set = std::clamp(hit.material->bump_texture.uv_set, 0, 1);
        if (hit.material->bump_texture && has_uv[bump_set]) {
            const UvGradients uv(gradients, corner, bump_set);
            hit.u_gradient = Vec3f(uv.u);
            hit.v_gradient = Vec3f(uv.v);
        }
    }
    hit.level = grid.level;
    const lod::TileRef* tile = grid.is_lattice ? &grid.parts[part_of(number)].tile : nullptr;
    const std::uint64_t tile_number = tile ? std::uint64_t(tile->j0) << 32 | tile->i0 : 0;
    hit.blend = weight[0] * share.x + weight[1] * share.y + weight[2] * share.z;
    if (tile && tools.frame.shading.shader) {
        // A closer is a line without width: the quad beside it stands in.
        const QuadRef q = quad_of(number);
        Vec2d at(q.i, q.j);
        for (int p = 0; p < 3 && !is_closer; ++p) at += Vec2d(kCorners[q.triangle][p][0], kCorners[q.triangle][p][1]) * w[p];
        add_vertex_values(grid, part_of(number), at, tools, hit);
    }
    hit.micropolygon = static_cast<std::uint32_t>(mix_bits(cage.key ^ mix_bits(std::uint64_t(number) << 32 ^ hit.face) ^ std::uint64_t(tile_number)));
}

}  // namespace occam::accel
