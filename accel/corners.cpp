#include "accel/corners.h"

#include <algorithm>
#include <bit>

#include "accel/stopwatch.h"
#include "base/publish.h"
#include "lod/patch_colors.h"

namespace occam::accel {
namespace {

using OwnBlend = VertexBlendOf<float>;

// Returns a vertex of a lattice as a ray sees it, and sets `weight` to its share of the coarse position.
Vec3f blended(const GridHit& met, const OwnBlend& blend, std::uint32_t vertex, float& weight) noexcept
{
    const Vec3f f = met.fine_at(vertex);
    weight = 0;
    if (!met.grid->blends()) return f;
    const Vec3f c = met.coarse_at(vertex);
    weight = blend.weight({f.x, f.y, f.z});
    const VecOf<float> p = OwnBlend::between({f.x, f.y, f.z}, {c.x, c.y, c.z}, weight);
    return {p.x, p.y, p.z};
}

// Returns whether a vertex of the tile is a T-vertex: it lies on a side that has fewer vertices than the lattice, and
// is not one of the side's own.
bool hangs(const lod::TileRef& tile, int i, int j) noexcept
{
    const lod::PatchRates& rates = tile.rates;
    const std::uint32_t u = tile.i0 + static_cast<std::uint32_t>(i), v = tile.j0 + static_cast<std::uint32_t>(j);
    const auto is_between = [&](std::size_t side, std::uint32_t along, int exponent) {
        return (along & ((1u << (exponent - rates.side[side])) - 1)) != 0;
    };
    return (v == 0 && is_between(0, u, rates.u)) || (u == 1u << rates.u && is_between(1, v, rates.v)) ||
           (v == 1u << rates.v && is_between(2, u, rates.u)) || (u == 0 && is_between(3, v, rates.v));
}

lod::Hanging::Ends ends_of(const GridHit& met, const OwnBlend& blend, const lod::Hanging& hanging,
                           float (&weight)[2]) noexcept
{
    return hanging.on(blended(met, blend, hanging.a, weight[0]), blended(met, blend, hanging.c, weight[1]));
}

// Returns the place of a face's corners in the arrays of a mesh.
std::size_t place_of(const MeshGrid& mesh, std::uint32_t id) noexcept
{
    std::size_t k = 0;
    while (mesh.ids[k] != id) ++k;
    return k;
}

Vec3f corner_of_mesh(const MeshGrid& mesh, std::size_t corner, std::size_t place, int key) noexcept
{
    const auto at = static_cast<std::ptrdiff_t>(place) + key * mesh.floats_of_a_key;
    return {mesh.corners[corner * 3][at], mesh.corners[corner * 3 + 1][at], mesh.corners[corner * 3 + 2][at]};
}

// Returns the T-vertex inside a quad's side, or null if it has no gap triangle in this igrid.
const lod::Hanging* find_hanging(const LatticeGrid& grid, std::uint32_t part, int i, int j) noexcept
{
    for (std::size_t k = 0; k < grid.hanging.size(); ++k) {
        const lod::Hanging& h = grid.hanging[k];
        if (h.is_inside && h.i == i && h.j == j && part_of(grid.hanging_quads[k]) == part) return &h;
    }
    return nullptr;
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

// This is kept out of line because it is rare.
OCCAM_NEVER_INLINE void shade(const IGrid& grid, IGridPart& part, const PhaseOneTools& tools)
{
    const MaybeLock lock(tools.building);
    if (part.is_shaded) return;  // another thread has shaded it in the meantime
    const Stopwatch watch(tools.counters.shade_seconds);
    part.attributes = tools.dicer.shade(*grid.cage, part.tile, grid.blends() ? part.coarser() : part.tile.rates,
                                        tools.arena);
    part.material = material_of(*tools.frame.scene, *grid.cage, part.tile.patch.face);
    publish(part.is_shaded, true);
}

template <std::size_t N>
void clear(FloatLanes (&lanes)[N]) noexcept
{
    for (FloatLanes& of : lanes) vfloat(0.0f).store(of);
}

template <class Vector, std::size_t N>
void put(FloatLanes (&to)[N], std::size_t lane, const Vector& v) noexcept
{
    for (std::size_t a = 0; a < N; ++a) to[a][lane] = v[static_cast<int>(a)];
}

}  // namespace

HitCorners::HitCorners(std::span<const GridHit> met, const MicropolygonPlace* spots) noexcept : met_(met), spots_(spots)
{
    clear(weight);
    std::size_t hits = 0;
    for (const GridHit& m : met) hits += m.grid != nullptr;
    if (hits == kLanes) return;
    // Lanes without a hit are cleared.
    for (int p = 0; p < 3; ++p) {
        clear(position[p]);
        for (LaneFours* fours : {&normal[p], &uv[0][p], &uv[1][p]})
            for (auto& lane : *fours) vfloat4(0.0f).store(lane);
    }
}

HitCorners::Vertices::Vertices(const IGridPart& part, const MicropolygonPlace& spot) noexcept
{
    const std::uint32_t low = part.vertex(spot.i, spot.j), along_i = part.is_transposed ? part.width : 1,
                        along_j = part.is_transposed ? 1 : part.width;
    of[0] = low;
    of[1] = low + along_i + (spot.triangle != 0 ? along_j : 0);
    of[2] = low + along_j + (spot.triangle != 0 ? 0 : along_i);
}

void HitCorners::set_positions(const vfloat (&direction)[3], const vfloat (&origin)[3], vfloat shift,
                               unsigned coarse_starts) noexcept
{
    alignas(32) FloatLanes coarse[3][3], ramp_start, scale, blends;
    for (auto& corner : coarse) clear(corner);
    for (FloatLanes* lanes : {&ramp_start, &scale, &blends}) vfloat(0.0f).store(*lanes);
    unsigned special = 0;  // lanes with a T-vertex
    bool any_blends = false;
    for (std::size_t lane = 0; lane < met_.size(); ++lane) {
        const GridHit& m = met_[lane];
        if (!m.grid) continue;
        const IGrid& grid = *m.grid;
        const MicropolygonPlace& spot = spots_[lane];
        if (!spot.part) {
            // The ids of meshes are faces, and are looked up by position.
            const MeshGrid& mesh = grid.mesh();
            const std::size_t k = place_of(mesh, m.id);
            if (grid.segments > 0) {
                for (std::size_t p = 0; p < 3; ++p) {
                    const Vec3f at = m.between(corner_of_mesh(mesh, p, k, m.time.key),
                                               corner_of_mesh(mesh, p, k, m.time.key + 1));
                    put(position[p], lane, at);
                    put(coarse[p], lane, at);
                }
                continue;
            }
            for (int p = 0; p < 3; ++p)
                for (int a = 0; a < 3; ++a) position[p][a][lane] = coarse[p][a][lane] = mesh.corners[p * 3 + a][k];
            continue;
        }
        const bool is_blended = grid.blends();
        if (is_blended) {
            any_blends = true;
            ramp_start[lane] = m.blend.start;
            scale[lane] = m.blend.scale;
            blends[lane] = 1;
        }
        if (is_gap(m)) {
            for (int p = 0; p < 3; ++p) put(position[p], lane, Vec3f(0));
            special |= 1u << lane;
            continue;
        }
        const IGridPart& part = *spot.part;
        const Vertices vertices(part, spot);
        const std::uint32_t(&vertex)[3] = vertices.of;
        const LatticeGrid& lattice = grid.lattice();
        const bool moves = grid.segments > 0;
        if (moves) set_moving(lane, vertices, coarse);
        else {
            for (int a = 0; a < 3; ++a)
                for (int p = 0; p < 3; ++p) position[p][a][lane] = lattice.fine[a][vertex[p]];
            if (!is_blended) continue;
            for (int a = 0; a < 3; ++a)
                for (int p = 0; p < 3; ++p) coarse[p][a][lane] = lattice.coarse[a][vertex[p]];
        }
        if (lattice.hanging_blocks == 0) continue;
        for (const auto& corner : kQuadCorners[spot.triangle])
            if (hangs(part.tile, spot.i + corner[0], spot.j + corner[1])) special |= 1u << lane;
    }
    if (!any_blends && special == 0) return;

    VertexBlend blend;
    blend.set({vfloat::load(ramp_start), vfloat::load(scale)}, direction, origin, shift);
    if (any_blends) {
        const vmask here = vfloat::load(blends) > vfloat(0.0f);
        FloatLanes coarse_start{};
        for (std::size_t lane = 0; lane < met_.size(); ++lane)
            if (blends[lane] > 0 && (coarse_starts >> lane & 1) != 0) coarse_start[lane] = 1;
        const vmask starts_coarse = vfloat::load(coarse_start) > vfloat(0.0f);
        has_start = bits(here);
        for (int p = 0; p < 3; ++p) {
            const VecLanes fine = load(position[p]), far = load(coarse[p]);
            const vfloat w = select(here, blend.weight(fine), 0.0f);
            const VecLanes seen = VertexBlend::between(fine, far, w);
            select(starts_coarse, far.x, fine.x).store(start[p][0]);
            select(starts_coarse, far.y, fine.y).store(start[p][1]);
            select(starts_coarse, far.z, fine.z).store(start[p][2]);
            w.store(weight[p]);
            seen.x.store(position[p][0]);
            seen.y.store(position[p][1]);
            seen.z.store(position[p][2]);
        }
    }
    if (special == 0) return;
    FloatLanes d[3], k;
    for (int a = 0; a < 3; ++a) blend.d[a].store(d[a]);
    blend.k.store(k);
    for (; special != 0; special &= special - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(special));
        set_special(lane, {{d[0][lane], d[1][lane], d[2][lane]}, k[lane]}, (coarse_starts >> lane & 1) != 0);
    }
}

void HitCorners::set_moving(std::size_t lane, const Vertices& vertices, FloatLanes (&coarse)[3][3]) noexcept
{
    for (std::size_t p = 0; p < 3; ++p) {
        put(position[p], lane, met_[lane].fine_at(vertices.of[p]));
        if (met_[lane].grid->blends()) put(coarse[p], lane, met_[lane].coarse_at(vertices.of[p]));
    }
}

void HitCorners::set_special(std::size_t lane, const OwnBlend& blend, bool starts_coarse) noexcept
{
    const GridHit& m = met_[lane];
    const IGrid& grid = *m.grid;
    if (!grid.blends() && !is_gap(m)) {
        set_hanging(position, lane, blend);
        return;
    }
    has_start |= 1u << lane;
    const OwnBlend of_start{{0, 0, 0}, starts_coarse ? 1.0f : 0.0f};
    if (is_gap(m)) {
        float at_end[2];
        const lod::Hanging::Ends ends = ends_of(m, blend, grid.lattice().hanging[m.id & ~kGapBit], at_end);
        put(position[0], lane, ends.low);
        put(position[1], lane, ends.middle);
        put(position[2], lane, ends.high);
        weight[0][lane] = weight[1][lane] = at_end[0];
        weight[2][lane] = at_end[1];
        const Vertices vertices(*spots_[lane].part, spots_[lane]);
        float unused;
        for (int p = 0; p < 3; ++p) put(start[p], lane, blended(m, of_start, vertices.of[p], unused));
    } else {
        set_hanging(position, lane, blend);
    }
    set_hanging(start, lane, of_start);
}

void HitCorners::set_hanging(FloatLanes (&to)[3][3], std::size_t lane, const OwnBlend& blend) noexcept
{
    const MicropolygonPlace& spot = spots_[lane];
    const GridHit& m = met_[lane];
    for (int p = 0; p < 3; ++p) {
        const int i = spot.i + kQuadCorners[spot.triangle][p][0], j = spot.j + kQuadCorners[spot.triangle][p][1];
        const lod::Hanging* hanging = hangs(spot.part->tile, i, j)
                                          ? find_hanging(m.grid->lattice(), part_of(spot.number), i, j)
                                          : nullptr;
        float unused[2];
        if (hanging) put(to[p], lane, ends_of(m, blend, *hanging, unused).middle);
    }
}

void HitCorners::set_attributes(const PhaseOneTools& tools)
{
    for (std::size_t lane = 0; lane < met_.size(); ++lane) {
        const GridHit& m = met_[lane];
        if (!m.grid) continue;
        const IGrid& grid = *m.grid;
        const MicropolygonPlace& spot = spots_[lane];
        if (!spot.part) {
            set_attributes_of_mesh(lane, *tools.frame.scene);
            continue;
        }
        IGridPart& part = *spot.part;
        if (!read_published(part.is_shaded)) shade(grid, part, tools);
        material[lane] = part.material;
        const lod::GridAttributes& made = part.attributes;
        const std::ptrdiff_t width = part.tile.columns + 1, halved = part.is_halved && grid.blends() ? 1 : 0;
        // A gap triangle has the attributes of one corner.
        const std::ptrdiff_t one = is_gap(m) ? 0 : 1, up = spot.triangle != 0 ? one : 0;
        const std::ptrdiff_t i[3] = {spot.i, spot.i + one, spot.i + one - up}, j[3] = {spot.j, spot.j + up, spot.j + one};
        const auto set = [&](LaneFours* corners, const auto* values) {
            for (int p = 0; p < 3; ++p) {
                const float w = weight[p][lane];
                const auto of = [&](std::ptrdiff_t vertex) { return vfloat4::load(&values[vertex].x); };
                // In the coarser level an odd vertex lies on an edge or a diagonal; its values blend as its position
                // does.
                const std::ptrdiff_t at = j[p] * width + i[p], step = (j[p] & halved) * width + (i[p] & halved);
                (of(at) * (1 - w) + (of(at - step) + of(at + step)) * (0.5f * w)).store(corners[p][lane]);
            }
        };
        if (grid.segments > 0) set_moving_normals(lane, i, j, halved);
        else if (!made.coarse_normal) set(normal, made.normal);
        else {
            for (int p = 0; p < 3; ++p) {
                const float w = weight[p][lane];
                const std::ptrdiff_t at = j[p] * width + i[p];
                (vfloat4::load(&made.normal[at].x) * (1 - w) + vfloat4::load(&made.coarse_normal[at].x) * w)
                    .store(normal[p][lane]);
            }
        }
        for (std::size_t s = 0; s < 2; ++s) {
            if (made.uv[s]) set(uv[s], made.uv[s]);
            else
                for (auto& corner : uv[s]) vfloat4(0.0f).store(corner[lane]);
        }
        for (std::size_t s = 0; s < 2; ++s) has_uv[s] |= made.uv[s] ? 1u << lane : 0;
        if (!grid.cage->slot->cage.colors.empty()) set_colors(lane);
    }
}

void HitCorners::set_moving_normals(std::size_t lane, const std::ptrdiff_t (&i)[3], const std::ptrdiff_t (&j)[3],
                                    std::ptrdiff_t halved) noexcept
{
    const GridHit& m = met_[lane];
    const IGridPart& part = *spots_[lane].part;
    const lod::GridAttributes& made = part.attributes;
    const std::ptrdiff_t width = part.tile.columns + 1;
    const Vec3f* first = made.normal + static_cast<std::size_t>(m.time.key) * made.normals_of_a_key;
    const auto at_time = [&](const Vec3f* n) { return m.between(n[0], n[made.normals_of_a_key]); };
    for (int p = 0; p < 3; ++p) {
        const float w = weight[p][lane];
        const std::ptrdiff_t at = j[p] * width + i[p], step = (j[p] & halved) * width + (i[p] & halved);
        const Vec3f fine = at_time(first + at);
        const Vec3f coarse = made.coarse_normal ? at_time(first + (made.coarse_normal - made.normal) + at)
                                                : (at_time(first + at - step) + at_time(first + at + step)) * 0.5f;
        const Vec3f mixed = fine * (1 - w) + coarse * w;
        vfloat4(0.0f).store(normal[p][lane]);
        for (int a = 0; a < 3; ++a) normal[p][lane][a] = mixed[a];
    }
}

Vec3f HitCorners::velocity_of(std::size_t lane, Vec3f share) const noexcept
{
    const GridHit& m = met_[lane];
    const IGrid& grid = *m.grid;
    const MicropolygonPlace& spot = spots_[lane];
    const int key = m.time.key;
    Vec3f moved(0);
    if (!spot.part) {
        const MeshGrid& mesh = grid.mesh();
        const std::size_t k = place_of(mesh, m.id);
        for (std::size_t p = 0; p < 3; ++p)
            moved += (corner_of_mesh(mesh, p, k, key + 1) - corner_of_mesh(mesh, p, k, key)) * share[static_cast<int>(p)];
    } else {
        const LatticeGrid& lattice = grid.lattice();
        const Vertices vertices(*spot.part, spot);
        for (int p = 0; p < 3; ++p) {
            const std::uint32_t v = vertices.of[p];
            const Vec3f fine = lattice.fine_at(v, key + 1) - lattice.fine_at(v, key);
            const Vec3f coarse = lattice.coarse_at(v, key + 1) - lattice.coarse_at(v, key);
            moved += (fine + (coarse - fine) * weight[p][lane]) * share[p];
        }
    }
    return moved * static_cast<float>(grid.segments);
}

void HitCorners::set_colors(std::size_t lane) noexcept
{
    const MicropolygonPlace& spot = spots_[lane];
    const IGridPart& part = *spot.part;
    const lod::PatchColors colors(*met_[lane].grid->cage, part.tile.patch);
    const auto color_at = [&](int i, int j) {
        return colors.at((float(part.tile.i0) + float(i)) * part.tile.step_u(),
                         (float(part.tile.j0) + float(j)) * part.tile.step_v());
    };
    has_color |= 1u << lane;
    for (int p = 0; p < 3; ++p) {
        const int* of_quad = kQuadCorners[spot.triangle][is_gap(met_[lane]) ? 0 : p];
        const int i = spot.i + of_quad[0], j = spot.j + of_quad[1], odd_i = part.is_halved ? i & 1 : 0,
                  odd_j = part.is_halved ? j & 1 : 0;
        const float w = weight[p][lane];
        color[lane][p] = color_at(i, j) * (1 - w) +
                         (color_at(i - odd_i, j - odd_j) + color_at(i + odd_i, j + odd_j)) * (0.5f * w);
    }
}

void HitCorners::set_attributes_of_mesh(std::size_t lane, const Scene& scene) noexcept
{
    const lod::PosedCage& posed = *met_[lane].grid->cage;
    const Cage& cage = posed.slot->cage;
    const MicropolygonPlace& spot = spots_[lane];
    const std::size_t sets = std::min<std::size_t>(2, cage.uv_sets.size());
    const auto put_four = [lane](LaneFours& to, auto v) {
        vfloat4(0.0f).store(to[lane]);
        for (int a = 0; a < v.length(); ++a) to[lane][a] = v[a];
    };
    for (std::uint32_t p = 0; p < 3; ++p) {
        const std::size_t at = std::size_t(spot.number) * 3 + p, v = cage.face_vertices[at];
        const auto normal_at = [&](const lod::PosedCage& of) { return of.vertex_normal(static_cast<std::uint32_t>(v)); };
        const GridHit& m = met_[lane];
        if (cage.normals.empty()) put_four(normal[p], Vec3f(0));
        else if (posed.segments == 0) put_four(normal[p], normal_at(posed));
        else put_four(normal[p], m.between(normal_at(posed.keys[m.time.key]), normal_at(posed.keys[m.time.key + 1])));
        if (!cage.colors.empty()) color[lane][p] = cage.colors[cage.color_indices.empty() ? v : cage.color_indices[at]];
        for (std::size_t s = 0; s < 2; ++s) {
            const auto value = [&] {
                return cage.uv_sets[s].values[cage.uv_sets[s].indices.empty() ? v : cage.uv_sets[s].indices[at]];
            };
            put_four(uv[s][p], s < sets ? value() : Vec2f(0));
        }
    }
    if (!cage.colors.empty()) has_color |= 1u << lane;
    for (std::size_t s = 0; s < sets; ++s) has_uv[s] |= 1u << lane;
    material[lane] = material_of(scene, posed, spot.face);
}

}  // namespace occam::accel
