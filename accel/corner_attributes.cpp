// Gathers what varies over the micropolygons that rays have hit, beside positions: normals, texture coordinates, colours.
#include <algorithm>
#include <bit>

#include "accel/corners.h"
#include "base/publish.h"
#include "lod/patch_colors.h"

namespace occam::accel {
namespace {

// Sets the values of lanes that have none to zero, if other lanes have some.
void clear_lanes_without(LaneFours (&corners)[3], unsigned has) noexcept
{
    if (has == 0) return;
    constexpr unsigned kAll = (1u << kLanes) - 1;
    for (unsigned left = kAll & ~has; left != 0; left &= left - 1)
        for (LaneFours& corner : corners) vfloat4(0.0f).store(corner[std::countr_zero(left)]);
}

}  // namespace

void HitCorners::set_attributes(const PhaseOneTools& tools)
{
    for (unsigned left = lattices_; left != 0; left &= left - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(left));
        if (!read_published(spots_[lane].part->is_shaded)) shade_part(*met_[lane].grid, *spots_[lane].part, tools);
    }
    set_attributes(*tools.frame.scene);
}

void HitCorners::set_attributes(const Scene& scene) noexcept
{
    note_attributes(scene);
    clear_lanes_without(normal, has_normals);
    for (std::size_t s = 0; s < 2; ++s) clear_lanes_without(uv[s], has_uv[s]);
    for (unsigned left = lattices_; left != 0; left &= left - 1)
        set_attributes_of_lattice(static_cast<std::size_t>(std::countr_zero(left)));
    for (unsigned left = meshes_ & (has_normals | has_uv[0] | has_uv[1] | has_color); left != 0; left &= left - 1)
        set_attributes_of_mesh(static_cast<std::size_t>(std::countr_zero(left)));
}

void HitCorners::note_attributes(const Scene& scene) noexcept
{
    const auto note = [&](std::size_t lane, bool with_normals, const bool(&with_uv)[2], bool with_colors) {
        has_normals |= unsigned(with_normals) << lane;
        for (int s = 0; s < 2; ++s) has_uv[s] |= unsigned(with_uv[s]) << lane;
        has_color |= unsigned(with_colors) << lane;
    };
    for (unsigned left = meshes_; left != 0; left &= left - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(left));
        const MeshGrid& grid = met_[lane].grid->mesh();
        material[lane] = grid.material ? grid.material : material_of(scene, *grid.cage, spots_[lane].face);
        note(lane, grid.has_normals, grid.has_uv, grid.has_colors);
    }
    for (unsigned left = lattices_; left != 0; left &= left - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(left));
        const IGridPart& part = *spots_[lane].part;
        material[lane] = part.material;
        const bool with_uv[2] = {part.attributes.uv[0] != nullptr, part.attributes.uv[1] != nullptr};
        note(lane, true, with_uv, !met_[lane].grid->cage->slot->cage.colors.empty());
    }
}

void HitCorners::set_attributes_of_lattice(std::size_t lane) noexcept
{
    const GridHit& m = met_[lane];
    const IGrid& grid = *m.grid;
    const MicropolygonPlace& spot = spots_[lane];
    const IGridPart& part = *spot.part;
    const lod::GridAttributes& made = part.attributes;
    const std::ptrdiff_t width = part.tile.columns + 1, halved = part.is_halved && grid.blends() ? 1 : 0;
    // A gap triangle has the attributes of one corner.
    const std::ptrdiff_t one = is_gap(m) ? 0 : 1, up = spot.triangle != 0 ? one : 0;
    const std::ptrdiff_t i[3] = {spot.i, spot.i + one, spot.i + one - up}, j[3] = {spot.j, spot.j + up, spot.j + one};
    const auto set = [&](LaneFours* corners, const auto* values) {
        for (int p = 0; p < 3; ++p) {
            const float w = weight[p][lane];
            const auto of = [&](std::ptrdiff_t vertex) { return vfloat4::load(&values[vertex].x); };
            // In the coarser level an odd vertex lies on an edge or a diagonal; its values blend as its position does.
            const std::ptrdiff_t at = j[p] * width + i[p], step = (j[p] & halved) * width + (i[p] & halved);
            (of(at) * (1 - w) + (of(at - step) + of(at + step)) * (0.5f * w)).store(corners[p][lane]);
        }
    };
    if (grid.segments > 0) set_moving_normals(lane, i, j, halved);
    else if (made.to_coarse == 0) set(normal, made.normal);
    else {
        for (int p = 0; p < 3; ++p) {
            const float w = weight[p][lane];
            const std::ptrdiff_t at = j[p] * width + i[p];
            (vfloat4::load(&made.normal[at].x) * (1 - w) + vfloat4::load(&made.normal[at + made.to_coarse].x) * w)
                .store(normal[p][lane]);
        }
    }
    for (std::size_t s = 0; s < 2; ++s)
        if (made.uv[s]) set(uv[s], made.uv[s]);
    if ((has_color >> lane & 1) != 0) set_colors(lane);
}

void HitCorners::set_moving_normals(std::size_t lane, const std::ptrdiff_t (&i)[3], const std::ptrdiff_t (&j)[3],
                                    std::ptrdiff_t halved) noexcept
{
    const GridHit& m = met_[lane];
    const IGridPart& part = *spots_[lane].part;
    const lod::GridAttributes& made = part.attributes;
    const std::ptrdiff_t width = part.tile.columns + 1;
    const lod::PosedCage& posed = *m.grid->cage;
    const bool follows = posed.normal_key >= 0;  // from the normals of one key
    const int key = follows ? posed.normal_key : m.time.key;
    const lod::ShortNormal* first = made.at_keys + static_cast<std::size_t>(key) * made.normals_of_a_key;
    const auto at_time = [&](const lod::ShortNormal* n) {
        return follows ? n->get() : m.between(n[0].get(), n[made.normals_of_a_key].get());
    };
    for (int p = 0; p < 3; ++p) {
        const float w = weight[p][lane];
        const std::ptrdiff_t at = j[p] * width + i[p], step = (j[p] & halved) * width + (i[p] & halved);
        const Vec3f fine = at_time(first + at);
        const Vec3f coarse = made.to_coarse != 0 ? at_time(first + made.to_coarse + at)
                                                 : (at_time(first + at - step) + at_time(first + at + step)) * 0.5f;
        Vec3f mixed = fine * (1 - w) + coarse * w;
        if (follows) mixed = posed.moved_normal(mixed, m.time);
        vfloat4(0.0f).store(normal[p][lane]);
        for (int a = 0; a < 3; ++a) normal[p][lane][a] = mixed[a];
    }
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
    for (int p = 0; p < 3; ++p) {
        const int* of_quad = kQuadCorners[spot.triangle][is_gap(met_[lane]) ? 0 : p];
        const int i = spot.i + of_quad[0], j = spot.j + of_quad[1], odd_i = part.is_halved ? i & 1 : 0,
                  odd_j = part.is_halved ? j & 1 : 0;
        const float w = weight[p][lane];
        color[lane][p] = color_at(i, j) * (1 - w) +
                         (color_at(i - odd_i, j - odd_j) + color_at(i + odd_i, j + odd_j)) * (0.5f * w);
    }
}

void HitCorners::set_attributes_of_mesh(std::size_t lane) noexcept
{
    const Cage& cage = met_[lane].grid->cage->slot->cage;
    const std::size_t first = std::size_t(spots_[lane].number) * 3, sets = std::min<std::size_t>(2, cage.uv_sets.size());
    if (!cage.normals.empty()) set_normals_of_mesh(lane);
    for (std::size_t s = 0; s < sets; ++s) {
        const auto& values = cage.uv_sets[s].values;
        const auto& indices = cage.uv_sets[s].indices;
        const std::uint32_t* at = indices.empty() ? &cage.face_vertices[first] : &indices[first];
        for (std::size_t p = 0; p < 3; ++p) {
            vfloat4(0.0f).store(uv[s][p][lane]);
            for (int a = 0; a < 2; ++a) uv[s][p][lane][a] = values[at[p]][a];
        }
    }
    if (!cage.colors.empty()) {
        const std::uint32_t* at = cage.color_indices.empty() ? &cage.face_vertices[first] : &cage.color_indices[first];
        for (std::size_t p = 0; p < 3; ++p) color[lane][p] = cage.colors[at[p]];
    }
}

void HitCorners::set_normals_of_mesh(std::size_t lane) noexcept
{
    const GridHit& m = met_[lane];
    const lod::PosedCage& posed = *m.grid->cage;
    for (std::size_t p = 0; p < 3; ++p) {
        const std::uint32_t v = posed.slot->cage.face_vertices[std::size_t(spots_[lane].number) * 3 + p];
        const auto normal_at = [&](const lod::PosedCage& of) { return of.vertex_normal(v); };
        const auto normal_at_time = [&] {
            if (posed.segments == 0) return normal_at(posed);
            if (posed.normal_key >= 0) return posed.moved_normal(normal_at(posed.keys[posed.normal_key]), m.time);
            return m.between(normal_at(posed.keys[m.time.key]), normal_at(posed.keys[m.time.key + 1]));
        };
        const Vec3f n = normal_at_time();
        vfloat4(0.0f).store(normal[p][lane]);
        for (int a = 0; a < 3; ++a) normal[p][lane][a] = n[a];
    }
}

}  // namespace occam::accel
