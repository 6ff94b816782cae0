#include "accel/corners.h"

#include <optional>

#include "accel/stopwatch.h"
#include "lod/patch_colors.h"
#include "scenegraph/base/publish.h"

namespace occam::accel {
namespace {

using OwnBlend = VertexBlendOf<float>;

// A vertex of a lattice as a ray sees it, and how coarse it is.
Vec3f blended(const IGrid& grid, const OwnBlend& blend, std::uint32_t vertex, float& weight) noexcept
{
    const Vec3f f = grid.fine_at(vertex);
    weight = 0;
    if (!grid.blends()) return f;
    const Vec3f c = grid.coarse_at(vertex);
    weight = blend.weight({f.x, f.y, f.z});
    const VecOf<float> p = OwnBlend::between({f.x, f.y, f.z}, {c.x, c.y, c.z}, weight);
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

lod::Hanging::Ends ends_of(const IGrid& grid, const OwnBlend& blend, const lod::Hanging& hanging, float (&weight)[2]) noexcept
{
    return hanging.on(blended(grid, blend, hanging.a, weight[0]), blended(grid, blend, hanging.c, weight[1]));
}

// The T-vertex inside of a quad's side; null: it has no triangle in this igrid.
const lod::Hanging* find_hanging(const IGrid& grid, std::uint32_t part, int i, int j) noexcept
{
    for (std::size_t k = 0; k < grid.hanging.size(); ++k) {
        const lod::Hanging& h = grid.hanging[k];
        if (h.is_inside && h.i == i && h.j == j && part_of(grid.hanging_quads[k]) == part) return &h;
    }
    return nullptr;
}

void shade(const IGrid& grid, IGridPart& part, const PhaseOneTools& tools)
{
    const MaybeLock lock(tools.building);
    if (part.is_shaded) return;  // another was here meanwhile
    const Stopwatch watch(tools.counters.shade_seconds);
    part.attributes = tools.dicer.shade(*grid.cage, part.tile, grid.blends() ? part.coarser() : part.tile.rates, tools.arena);
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

Corners::Corners() noexcept
{
    clear(weight);
    for (int p = 0; p < 3; ++p) {
        clear(position[p]);
        clear(normal[p]);
        clear(uv[0][p]);
        clear(uv[1][p]);
    }
}

void Corners::set_positions(std::span<const Met> met, const vfloat (&direction)[3], const vfloat (&origin)[3], vfloat shift) noexcept
{
    FloatLanes coarse[3][3], start, scale, blends;
    for (auto& corner : coarse) clear(corner);
    for (FloatLanes* lanes : {&start, &scale, &blends}) vfloat(0.0f).store(*lanes);
    unsigned special = 0;  // lanes with a T-vertex
    bool any_blends = false;
    for (std::size_t lane = 0; lane < met.size(); ++lane) {
        const Met& m = met[lane];
        if (!m.grid) continue;
        const IGrid& grid = *m.grid;
        if (!grid.is_lattice) {
            // Ids of meshes are faces, and are looked up by position.
            std::uint32_t k = 0;
            while (grid.ids[k] != m.id) ++k;
            for (int p = 0; p < 3; ++p)
                for (int a = 0; a < 3; ++a) position[p][a][lane] = coarse[p][a][lane] = grid.corners[p * 3 + a][k];
            continue;
        }
        if (grid.blends()) {
            any_blends = true;
            start[lane] = m.blend.start;
            scale[lane] = m.blend.scale;
            blends[lane] = 1;
        }
        if (is_closer(m)) {
            special |= 1u << lane;
            continue;
        }
        const QuadRef q = quad_of(m.id);
        const IGridPart& part = grid.parts[part_of(m.id)];
        for (int p = 0; p < 3; ++p) {
            const int i = q.i + kQuadCorners[q.triangle][p][0], j = q.j + kQuadCorners[q.triangle][p][1];
            const std::uint32_t vertex = part.vertex(i, j);
            for (int a = 0; a < 3; ++a) {
                position[p][a][lane] = grid.fine[a][vertex];
                coarse[p][a][lane] = grid.coarse[a][vertex];
            }
            if (grid.blends() && hangs(part.tile, i, j)) special |= 1u << lane;
        }
    }
    if (!any_blends && special == 0) return;

    VertexBlend blend;
    blend.set({vfloat::load(start), vfloat::load(scale)}, direction, origin, shift);
    if (any_blends) {
        const vmask here = vfloat::load(blends) > vfloat(0.0f);
        for (int p = 0; p < 3; ++p) {
            const VecLanes fine = load(position[p]);
            const vfloat w = select(here, blend.weight(fine), 0.0f);
            const VecLanes seen = VertexBlend::between(fine, load(coarse[p]), w);
            w.store(weight[p]);
            seen.x.store(position[p][0]);
            seen.y.store(position[p][1]);
            seen.z.store(position[p][2]);
        }
    }
    FloatLanes d[3], k;
    for (int a = 0; a < 3; ++a) blend.d[a].store(d[a]);
    blend.k.store(k);
    for (; special != 0; special &= special - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(special));
        const Met& m = met[lane];
        const IGrid& grid = *m.grid;
        const OwnBlend own{{d[0][lane], d[1][lane], d[2][lane]}, k[lane]};
        if (is_closer(m)) {
            float at_end[2];
            const lod::Hanging::Ends ends = ends_of(grid, own, grid.hanging[m.id & ~kCloserBit], at_end);
            put(position[0], lane, ends.low);
            put(position[1], lane, ends.middle);
            put(position[2], lane, ends.high);
            weight[0][lane] = weight[1][lane] = at_end[0];
            weight[2][lane] = at_end[1];
            continue;
        }
        const QuadRef q = quad_of(m.id);
        const IGridPart& part = grid.parts[part_of(m.id)];
        for (int p = 0; p < 3; ++p) {
            const int i = q.i + kQuadCorners[q.triangle][p][0], j = q.j + kQuadCorners[q.triangle][p][1];
            const lod::Hanging* hanging = hangs(part.tile, i, j) ? find_hanging(grid, part_of(m.id), i, j) : nullptr;
            float unused[2];
            if (hanging) put(position[p], lane, ends_of(grid, own, *hanging, unused).middle);
        }
    }
}

void Corners::set_attributes(std::size_t lane, const Met& met, const PhaseOneTools& tools)
{
    const IGrid& grid = *met.grid;
    const std::uint32_t number = number_of(met), bit = 1u << lane;
    const Cage& cage = grid.cage->slot->cage;
    if (!grid.is_lattice) {
        const std::size_t sets = std::min<std::size_t>(2, cage.uv_sets.size());
        for (std::uint32_t p = 0; p < 3; ++p) {
            const std::size_t at = std::size_t(number) * 3 + p, v = cage.face_vertices[at];
            if (!cage.normals.empty()) put(normal[p], lane, grid.cage->vertex_normal(static_cast<std::uint32_t>(v)));
            if (!cage.colors.empty()) color[lane][p] = cage.colors[cage.color_indices.empty() ? v : cage.color_indices[at]];
            for (std::size_t s = 0; s < sets; ++s) {
                const UvSet& set = cage.uv_sets[s];
                put(uv[s][p], lane, set.values[set.indices.empty() ? v : set.indices[at]]);
            }
        }
        if (!cage.colors.empty()) has_color |= bit;
        for (std::size_t s = 0; s < sets; ++s) has_uv[s] |= bit;
        return;
    }
    IGridPart& part = met.grid->parts[part_of(number)];
    if (!read_published(part.is_shaded)) shade(grid, part, tools);
    const lod::GridAttributes& made = part.attributes;
    const QuadRef q = quad_of(number);
    std::optional<lod::PatchColors> colors;
    if (!cage.colors.empty()) {
        colors.emplace(*grid.cage, part.tile.patch);
        has_color |= bit;
    }
    const auto color_at = [&](int i, int j) {
        return colors->at((float(part.tile.i0) + float(i)) * part.tile.step_u(), (float(part.tile.j0) + float(j)) * part.tile.step_v());
    };
    const bool alone = is_closer(met);
    for (int p = 0; p < 3; ++p) {
        const int i = q.i + (alone ? 0 : kQuadCorners[q.triangle][p][0]), j = q.j + (alone ? 0 : kQuadCorners[q.triangle][p][1]);
        const int width = part.tile.columns + 1;
        // What is odd lies, in the coarser level, on an edge or a diagonal; and blends as its position does.
        const int low = j * width + i, odd_i = part.is_halved ? i & 1 : 0, odd_j = part.is_halved ? j & 1 : 0;
        const int before = low - odd_j * width - odd_i, behind = low + odd_j * width + odd_i;
        const float w = weight[p][lane];
        const auto blend = [&](const auto* values) {
            return w == 0 ? values[low] : values[low] * (1 - w) + (values[before] + values[behind]) * (0.5f * w);
        };
        put(normal[p], lane, made.coarse_normal ? made.normal[low] * (1 - w) + made.coarse_normal[low] * w : blend(made.normal));
        for (std::size_t s = 0; s < 2; ++s)
            if (made.uv[s]) put(uv[s][p], lane, blend(made.uv[s]));
        if (colors) color[lane][p] = color_at(i, j) * (1 - w) + (color_at(i - odd_i, j - odd_j) + color_at(i + odd_i, j + odd_j)) * (0.5f * w);
    }
    for (std::size_t s = 0; s < 2; ++s)
        if (made.uv[s]) has_uv[s] |= bit;
}

}  // namespace occam::accel
