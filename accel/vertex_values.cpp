#include "accel/vertex_values.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "base/cross_product.h"
#include "base/publish.h"
#include "base/stopwatch.h"

namespace occam::accel {
namespace {

/// Selects the vertices of a tile at which a level's values are made: every step-th one.
struct ValueLattice {
    int shift_u, shift_v, step_u, step_v, columns, rows;

    ValueLattice(const IGridPart& part, bool is_coarse) noexcept
    {
        const int shift = kCoarser + (is_coarse && part.is_halved);
        shift_u = std::min(shift, std::countr_zero(part.tile.columns));
        shift_v = std::min(shift, std::countr_zero(part.tile.rows));
        step_u = 1 << shift_u;
        step_v = 1 << shift_v;
        columns = part.tile.columns >> shift_u;
        rows = part.tile.rows >> shift_v;
    }
    int count() const noexcept { return (columns + 1) * (rows + 1); }
    int index(int i, int j) const noexcept { return j * (columns + 1) + i; }
};

// Filters are half as wide as the lattice's quads, since a bilinear lookup in a MIP level reaches two texels far and
// the values are interpolated once more (docs/performance.md gives the error of wider filters). They are no narrower
// than those of hits that see the level fully fine.
const float* make_values(const LatticeGrid& grid, IGridPart& part, bool is_coarse, const Material& material, int channels,
                         const PhaseOneTools& tools)
{
    const BuildLock lock(tools.building);
    if (part.values[is_coarse]) return part.values[is_coarse];  // another thread has made them in the meantime
    const Stopwatch watch(tools.counters.shade_seconds);
    const ValueLattice lattice(part, is_coarse);
    const int width = part.tile.columns + 1;
    const lod::LevelSettings& levels = tools.frame.levels;
    const float least = tools.frame.shading.texture_width * lod::edge_length(grid.level + is_coarse) /
                        (levels.shading_rate * lod::LevelSettings::kLongestEdge);
    constexpr std::size_t kMost = (lod::TileRef::kMaxSide + 1) * (lod::TileRef::kMaxSide + 1);
    std::array<lod::VertexToShade, kMost> vertices;
    for (int j = 0; j <= lattice.rows; ++j)
        for (int i = 0; i <= lattice.columns; ++i) {
            // The differences reach to both sides, or to one side at the tile's border.
            const int i0 = std::max(i - 1, 0) * lattice.step_u, i1 = std::min(i + 1, lattice.columns) * lattice.step_u;
            const int j0 = std::max(j - 1, 0) * lattice.step_v, j1 = std::min(j + 1, lattice.rows) * lattice.step_v;
            const int at_i = i * lattice.step_u, at_j = j * lattice.step_v;
            const auto quads = static_cast<float>(((i1 - i0) >> lattice.shift_u) * ((j1 - j0) >> lattice.shift_v));
            // Values stand still on what moves: they are filtered as is right at the middle key, or the first of two.
            const auto place = [&](int u, int v) { return grid.fine_at(part.vertex(u, v), grid.segments / 2); };
            const Vec3f along_u = place(i1, at_j) - place(i0, at_j), along_v = place(at_i, j1) - place(at_i, j0);
            const float area = area_between(along_u, along_v);
            const auto index = static_cast<std::size_t>(lattice.index(i, j));
            lod::VertexToShade& vertex = vertices[index] = {};
            for (int s = 0; s < 2; ++s) {
                const Vec2f* uv = part.attributes.uv[s];
                if (!uv) continue;
                const Vec2f u = uv[at_j * width + i1] - uv[at_j * width + i0],
                            v = uv[j1 * width + at_i] - uv[j0 * width + at_i];
                const float uv_area = std::abs(u.x * v.y - u.y * v.x);
                vertex.uv[s] = uv[at_j * width + at_i];
                vertex.uv_width[s] = std::sqrt(uv_area * std::max(0.25f / quads, area > 0 ? least * least / area : 0));
            }
        }
    const auto count = static_cast<std::size_t>(lattice.count());
    float* values = tools.arena.make_array<float>(count * static_cast<std::size_t>(channels)).data();
    tools.frame.shading.shader->shade(material, {{vertices.data(), count}, lattice.columns + 1}, values);
    tools.counters.vertices_looked_up += count;
    publish(part.values[is_coarse], static_cast<const float*>(values));
    return values;
}

/// Adds a level's values, bilinearly interpolated and multiplied by `share`.
void interpolate(const ValueLattice& lattice, const float* values, Vec2d at, float share, int channels, float* out) noexcept
{
    const double x = at.x * double(lod::edge_length(-lattice.shift_u)),
                 y = at.y * double(lod::edge_length(-lattice.shift_v));
    const int i = std::clamp(static_cast<int>(x), 0, lattice.columns - 1),
              j = std::clamp(static_cast<int>(y), 0, lattice.rows - 1);
    const auto fx = static_cast<float>(x - i), fy = static_cast<float>(y - j);
    const float* v00 = values + lattice.index(i, j) * channels;
    const float* v10 = v00 + channels;
    const float* v01 = values + lattice.index(i, j + 1) * channels;
    const float* v11 = v01 + channels;
    const float w00 = (1 - fx) * (1 - fy) * share, w10 = fx * (1 - fy) * share, w01 = (1 - fx) * fy * share,
                w11 = fx * fy * share;
    for (int c = 0; c < channels; ++c) out[c] += v00[c] * w00 + v10[c] * w10 + v01[c] * w01 + v11[c] * w11;
}

}  // namespace

void add_vertex_values(LatticeGrid& grid, std::uint32_t number, Vec2d at, const PhaseOneTools& tools, SurfaceHit& hit)
{
    IGridPart& part = grid.parts[number];
    if (part.tile.columns == 1 && part.tile.rows == 1) return;
    int channels = read_published(part.channels);
    if (channels < 0) {
        channels = tools.frame.shading.shader->channels(*hit.material);
        publish(part.channels, static_cast<std::int8_t>(channels));  // every thread publishes the same value
    }
    if (channels == 0) return;
    const float share[2] = {1 - hit.blend, hit.blend};
    std::fill_n(hit.phase_one, channels, 0.0f);
    for (int level : {0, 1}) {
        if (!(share[level] > 0)) continue;
        const float* values = read_published(part.values[level]);
        if (!values) values = make_values(grid, part, level == 1, *hit.material, channels, tools);
        interpolate(ValueLattice(part, level == 1), values, at, share[level], channels, hit.phase_one);
    }
    hit.phase_one_channels = channels;
}

}  // namespace occam::accel
