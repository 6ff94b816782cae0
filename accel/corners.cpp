#include "accel/corners.h"

#include <algorithm>
#include <bit>

namespace occam::accel {
namespace {

using OwnBlend = VertexBlendOf<float>;

// Returns the blend of a ray that sees one level of a pair alone.
OwnBlend blend_of_level(bool is_coarse) noexcept { return {{0, 0, 0}, is_coarse ? 1.0f : 0.0f}; }

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

// Holds a quad of a part by its number along u and v.
struct PartQuad {
    int i, j;
};
// Returns the quad of a hit. The place of a gap triangle is that of its T-vertex, which may be the last of its row or
// column: then the quad is the one before it.
PartQuad quad_at(const IGridPart& part, const MicropolygonPlace& spot) noexcept
{
    return {std::min<int>(spot.i, part.tile.columns - 1), std::min<int>(spot.j, part.tile.rows - 1)};
}

lod::Hanging::Ends ends_of(const GridHit& met, const OwnBlend& blend, const lod::Hanging& hanging,
                           float (&weight)[2]) noexcept
{
    return hanging.on(blended(met, blend, hanging.a, weight[0]), blended(met, blend, hanging.c, weight[1]));
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

template <std::size_t N>
void clear(FloatLanes (&lanes)[N]) noexcept
{
    for (FloatLanes& of : lanes) vfloat(0.0f).store(of);
}

template <class Vector, std::size_t N>
void put(FloatLanes (&to)[N], std::size_t lane, const Vector& v) noexcept
{
    for (std::size_t a = 0; a < N; ++a) to[a][lane] = static_cast<float>(v[static_cast<int>(a)]);
}

}  // namespace

HitCorners::HitCorners(std::span<const GridHit> met, const MicropolygonPlace* spots) noexcept : met_(met), spots_(spots)
{
    clear(weight);
    for (std::size_t lane = 0; lane < met.size(); ++lane)
        if (met[lane].grid) (spots[lane].part ? lattices_ : meshes_) |= 1u << lane;
    if ((lattices_ | meshes_) == (1u << kLanes) - 1) return;
    for (auto& corner : position) clear(corner);  // of lanes without a hit
}

HitCorners::Vertices::Vertices(const IGridPart& part, const MicropolygonPlace& spot) noexcept
{
    const PartQuad quad = quad_at(part, spot);
    const std::uint32_t low = part.vertex(quad.i, quad.j), along_i = part.is_transposed ? part.width : 1,
                        along_j = part.is_transposed ? 1 : part.width;
    of[0] = low;
    of[1] = low + along_i + (spot.triangle != 0 ? along_j : 0);
    of[2] = low + along_j + (spot.triangle != 0 ? 0 : along_i);
}

OCCAM_ALWAYS_INLINE void HitCorners::gather_mesh(std::size_t lane) noexcept
{
    const GridHit& m = met_[lane];
    if (m.grid->segments > 0) {
        for (int p = 0; p < 3; ++p) put(position[p], lane, m.corner_at(p));
        return;
    }
    constexpr std::uint32_t kRow = TriangleBlock::kTriangles;
    const float* const at = &m.grid->mesh().triangles.blocks[m.id / kRow].corners[0][m.id % kRow];
    for (std::size_t p = 0; p < 3; ++p)
        for (std::size_t a = 0; a < 3; ++a) position[p][a][lane] = at[(p * 3 + a) * kRow];
}

void HitCorners::set_positions(const vfloat (&direction)[3], const vfloat (&origin)[3], vfloat shift,
                               unsigned coarse_starts) noexcept
{
    for (unsigned left = meshes_; left != 0; left &= left - 1) gather_mesh(static_cast<std::size_t>(std::countr_zero(left)));
    if (lattices_ == 0) return;
    Gathered gathered;
    for (unsigned left = lattices_; left != 0; left &= left - 1)
        gather_lattice(static_cast<std::size_t>(std::countr_zero(left)), gathered);
    if (gathered.blended == 0 && gathered.special == 0) return;

    VertexBlend blend;
    blend.set({vfloat::load(gathered.ramp_start), vfloat::load(gathered.scale)}, direction, origin, shift);
    if (gathered.blended != 0) blend_positions(gathered, blend, coarse_starts);
    if (gathered.special == 0) return;
    FloatLanes d[3], k;
    for (int a = 0; a < 3; ++a) blend.d[a].store(d[a]);
    blend.k.store(k);
    for (unsigned left = gathered.special; left != 0; left &= left - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(left));
        set_special(lane, {{d[0][lane], d[1][lane], d[2][lane]}, k[lane]}, (coarse_starts >> lane & 1) != 0);
    }
}

HitCorners::Gathered::Gathered() noexcept
{
    for (auto& corner : coarse) clear(corner);
    for (FloatLanes* lanes : {&ramp_start, &scale, &blends}) vfloat(0.0f).store(*lanes);
}

void HitCorners::gather_lattice(std::size_t lane, Gathered& to) noexcept
{
    const GridHit& m = met_[lane];
    const LatticeGrid& grid = m.grid->lattice();
    const MicropolygonPlace& spot = spots_[lane];
    if (grid.blends()) {
        to.blended |= 1u << lane;
        to.ramp_start[lane] = m.blend.start;
        to.scale[lane] = m.blend.scale;
        to.blends[lane] = 1;
    }
    if (is_gap(m)) {
        for (int p = 0; p < 3; ++p) put(position[p], lane, Vec3f(0));
        to.special |= 1u << lane;
        return;
    }
    const Vertices vertices(*spot.part, spot);
    const std::uint32_t(&vertex)[3] = vertices.of;
    if (grid.segments > 0) set_moving(lane, vertices, to.coarse);
    else {
        for (int a = 0; a < 3; ++a)
            for (int p = 0; p < 3; ++p) position[p][a][lane] = grid.fine[a][vertex[p]];
        // A T-vertex that is neither blended nor moved is where it was diced.
        if (!grid.blends()) return;
        for (int a = 0; a < 3; ++a)
            for (int p = 0; p < 3; ++p) to.coarse[p][a][lane] = grid.coarse[a][vertex[p]];
    }
    if (grid.hanging_blocks == 0) return;
    for (const auto& corner : kQuadCorners[spot.triangle])
        if (hangs(spot.part->tile, spot.i + corner[0], spot.j + corner[1])) to.special |= 1u << lane;
}

void HitCorners::blend_positions(const Gathered& of, const VertexBlend& blend, unsigned coarse_starts) noexcept
{
    const vmask here = vfloat::load(of.blends) > vfloat(0.0f);
    alignas(32) FloatLanes coarse_start{};
    for (std::size_t lane = 0; lane < met_.size(); ++lane)
        if (of.blends[lane] > 0 && (coarse_starts >> lane & 1) != 0) coarse_start[lane] = 1;
    const vmask starts_coarse = vfloat::load(coarse_start) > vfloat(0.0f);
    has_start = bits(here);
    for (int p = 0; p < 3; ++p) {
        const VecLanes fine = load(position[p]), far = load(of.coarse[p]);
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
    if (is_gap(m)) {
        float at_end[2];
        const lod::Hanging::Ends ends = ends_of(m, blend, grid.lattice().hanging[m.id & ~kGapBit], at_end);
        put(position[0], lane, ends.low);
        put(position[1], lane, ends.middle);
        put(position[2], lane, ends.high);
        weight[0][lane] = weight[1][lane] = at_end[0];
        weight[2][lane] = at_end[1];
        const Corners corners = at_level(lane, starts_coarse);
        for (int p = 0; p < 3; ++p) put(start[p], lane, corners.of[p]);
    } else {
        set_hanging(position, lane, blend);
        set_hanging(start, lane, blend_of_level(starts_coarse));
    }
}

void HitCorners::set_hanging(FloatLanes (&to)[3][3], std::size_t lane, const OwnBlend& blend) noexcept
{
    const MicropolygonPlace& spot = spots_[lane];
    const GridHit& m = met_[lane];
    const PartQuad quad = quad_at(*spot.part, spot);
    for (int p = 0; p < 3; ++p) {
        const int i = quad.i + kQuadCorners[spot.triangle][p][0], j = quad.j + kQuadCorners[spot.triangle][p][1];
        const lod::Hanging* hanging = hangs(spot.part->tile, i, j)
                                          ? find_hanging(m.grid->lattice(), part_of(spot.number), i, j)
                                          : nullptr;
        float unused[2];
        if (hanging) put(to[p], lane, ends_of(m, blend, *hanging, unused).middle);
    }
}

HitCorners::Corners HitCorners::at_level(std::size_t lane, bool is_coarse) noexcept
{
    const OwnBlend blend = blend_of_level(is_coarse);
    const Vertices vertices(*spots_[lane].part, spots_[lane]);
    FloatLanes corner[3][3];
    float unused;
    for (int p = 0; p < 3; ++p) put(corner[p], lane, blended(met_[lane], blend, vertices.of[p], unused));
    set_hanging(corner, lane, blend);
    Corners found;
    for (int p = 0; p < 3; ++p) found.of[p] = {corner[p][0][lane], corner[p][1][lane], corner[p][2][lane]};
    return found;
}

void HitCorners::move_positions(std::size_t lane, const lod::AffinePose& pose) noexcept
{
    const auto move = [&](FloatLanes(&corner)[3]) {
        put(corner, lane, pose.apply({corner[0][lane], corner[1][lane], corner[2][lane]}));
    };
    for (int p = 0; p < 3; ++p) {
        move(position[p]);
        if (has_start >> lane & 1) move(start[p]);
    }
}

void HitCorners::move_normals(std::size_t lane, const lod::AffinePose& pose) noexcept
{
    // The cofactors of a map are its inverse transpose, up to a factor that is positive for all poses of a cage.
    const Vec3d &a = pose.columns[0], &b = pose.columns[1], &c = pose.columns[2];
    const Vec3d bc = glm::cross(b, c), ca = glm::cross(c, a), ab = glm::cross(a, b);
    for (auto& corner : normal) {
        float* n = corner[lane];
        const Vec3d moved = bc * double(n[0]) + ca * double(n[1]) + ab * double(n[2]);
        const double length = glm::length(moved);
        for (int axis = 0; axis < 3 && length > 0; ++axis) n[axis] = static_cast<float>(moved[axis] / length);
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
        const TriangleTree& mesh = grid.mesh().triangles;
        for (int p = 0; p < 3; ++p) moved += (mesh.corner(m.id, p, key + 1) - mesh.corner(m.id, p, key)) * share[p];
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

}  // namespace occam::accel
