#include "accel/narration.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "accel/corners.h"
#include "accel/print.h"
#include "accel/triangle.h"
#include "base/printable.h"

namespace occam::accel {
namespace {

/// The number of triangles of an igrid that are listed although the ray misses them.
constexpr std::size_t kListedMisses = 3;

struct TestedTriangle {
    std::uint32_t id;
    MicropolygonPlace place;
    float u, v, w, t;
    bool is_inside;
    float outside;  ///< how far the ray passes outside of the triangle, as a share of it; negative inside
};

// Returns the ids of all triangles of an igrid, gap triangles included: one for each, even if it has several.
std::vector<std::uint32_t> ids_of(const IGrid& grid)
{
    std::vector<std::uint32_t> ids;
    if (!grid.is_lattice) {
        const TriangleTree& mesh = grid.mesh().triangles;
        for (std::uint32_t k = 0; k < mesh.block_count * std::uint32_t(TriangleBlock::kTriangles); ++k)
            if (!mesh.is_spare(k)) ids.push_back(k);
        std::stable_sort(ids.begin(), ids.end(),
                         [&](std::uint32_t a, std::uint32_t b) { return mesh.faces[a] < mesh.faces[b]; });
        const auto is_same = [&](std::uint32_t a, std::uint32_t b) { return are_same(grid, a, b); };
        ids.erase(std::unique(ids.begin(), ids.end(), is_same), ids.end());
        return ids;
    }
    for (std::uint32_t part = 0; part < grid.lattice().parts.size(); ++part) {
        const lod::TileRef& tile = grid.lattice().parts[part].tile;
        for (int j = 0; j < tile.rows; ++j)
            for (int i = 0; i < tile.columns; ++i)
                for (const int triangle : {0, 1}) ids.push_back(make_id(part, i, j, triangle));
    }
    for (std::uint32_t k = 0; k < grid.lattice().hanging.size(); ++k) ids.push_back(kGapBit | k);
    return ids;
}

float lane_of(vfloat x, std::size_t lane) noexcept
{
    alignas(32) FloatLanes lanes;
    x.store(lanes);
    return lanes[lane];
}

// Tests up to kLanes triangles of an igrid against the ray by the functions of accel/triangle.h.
void test(std::span<const std::uint32_t> ids, const RayAtGrid& at, std::vector<TestedTriangle>& out)
{
    std::array<GridHit, kLanes> hits;
    std::array<MicropolygonPlace, kLanes> places;
    for (std::size_t k = 0; k < ids.size(); ++k) {
        hits[k] = at.like;
        hits[k].id = ids[k];
        places[k].set(hits[k]);
    }
    const RayLanes& ray = at.ray;
    HitCorners corners(std::span<const GridHit>(hits).first(ids.size()), places.data());
    corners.set_positions(at.direction, ray.origin, ray.shift, 0);
    const VecLanes origin{ray.origin[ray.kx], ray.origin[ray.ky], ray.origin[ray.kz]};
    const auto corner = [&](int p) {
        const FloatLanes(&of)[3] = corners.position[p];
        return VecLanes{vfloat::load(of[ray.kx]), vfloat::load(of[ray.ky]), vfloat::load(of[ray.kz])};
    };
    const auto sheared = [&](int p) { return shear(ray, origin, corner(p)); };
    const ShearedVertex a = sheared(0), b = sheared(1), c = sheared(2);
    const EdgeFunctions e = edge_functions(a, b, c);
    TriangleHit found = hit_inside(ray, e, is_inside(e), a, b, c);
    found.t = narrowed(ray, origin, found, corner);
    const unsigned inside = bits(found.is_hit & (found.t > vfloat(kNoT)));
    for (std::size_t k = 0; k < ids.size(); ++k) {
        TestedTriangle one{ids[k],          places[k],           lane_of(e.u, k), lane_of(e.v, k),
                           lane_of(e.w, k), lane_of(found.t, k), false,           0};
        one.is_inside = (inside >> k & 1) != 0;
        const float det = (one.u + one.v) + one.w;
        const float extreme = det > 0 ? std::min({one.u, one.v, one.w}) : std::max({one.u, one.v, one.w});
        const float share = -extreme / det;
        one.outside = std::isfinite(share) ? share : INFINITY;
        out.push_back(one);
    }
}

void write_place(std::ostream& out, const TestedTriangle& one, const IGrid& grid)
{
    if (is_gap(one.id)) out << "gap triangle " << (one.id & ~kGapBit) << " beside face " << one.place.face;
    else if (!grid.is_lattice) out << "triangle " << one.place.face;
    else
        out << "triangle " << one.place.triangle << " of quad (" << one.place.i << ", " << one.place.j << ") of "
            << grid.lattice().parts[part_of(one.place.number)].tile.patch;
}

}  // namespace

Narration::Narration(std::ostream& out, const FrameState& frame)
    : out_(out), digits_(out, 9), to_world_(frame.scale.to_world()), exponent_(frame.scale.exponent()), anchor_(frame.anchor)
{
}

// What is beyond RayLevels::kFar stands for infinity.
double Narration::world(float frame_length) const noexcept
{
    if (std::fabs(frame_length) >= lod::RayLevels<float>::kFar) return std::copysign(INFINITY, double(frame_length));
    return double(frame_length) * to_world_;
}

int Narration::number_of(std::uint64_t node)
{
    return numbers_.try_emplace(node, static_cast<int>(numbers_.size()) + 1).first->second;
}

void Narration::name(const IGrid& grid)
{
    const Cage& cage = grid.cage->slot->cage;
    out_ << "igrid of node " << grid.cage->node_id;
    if (grid.cage->node && !grid.cage->node->name.empty()) out_ << " '" << printable_line(grid.cage->node->name) << '\'';
    if (!cage.name.empty()) out_ << ", " << (grid.is_lattice ? "cage '" : "mesh '") << printable_line(cage.name) << '\'';
}

void Narration::scene_missed() { out_ << "  The ray misses the box around the scene.\n"; }
void Narration::one_level_for_all() { out_ << "  levels: all rays of the frame see the same mesh of each cage\n"; }

void Narration::levels(lod::RayLevels<float>& levels)
{
    levels.make();
    for (int pair = levels.finest; pair <= levels.coarsest; ++pair) {
        out_ << "  levels " << pair + exponent_ << " and " << pair + exponent_ + 1 << " (edges of "
             << world(lod::edge_length(pair)) << " and " << world(lod::edge_length(pair + 1)) << "): ";
        const float begin = levels.begin(pair), end = levels.end(pair);
        if (!(begin <= end)) {
            out_ << "not seen\n";
            continue;
        }
        const lod::Blend<float> blend = levels.blend(pair);
        const double from = world(blend.start), to = world(blend.start + 1 / blend.scale);
        out_ << "t from " << world(begin) << " to " << world(end) << ", blended from fine at " << from << " to coarse at "
             << to << '\n';
    }
}

void Narration::node(std::uint64_t node, bool is_interior, float in, float out)
{
    out_ << "  " << (is_interior ? "node " : "leaf ") << number_of(node) << ": t from " << ray_t(in) << " to " << ray_t(out)
         << '\n';
}

void Narration::box(const TreeLeaf::Entry& entry, const Box3f& box, float in, float out, bool crosses_slab)
{
    const auto in_world = [&](Vec3f p) { return (Vec3d(p) + anchor_) * to_world_; };
    out_ << "    item " << entry.item << ", box " << Box3d{in_world(box.lo), in_world(box.hi)};
    if (read_published(entry.grid)) out_ << " of its igrid";
    if (!(in <= out)) out_ << ": missed\n";
    else if (!crosses_slab) out_ << ": entered at t " << ray_t(in) << ", but outside of its slab\n";
    else out_ << ": entered at t " << ray_t(in) << '\n';
}

void Narration::tested_before(const IGrid& grid)
{
    out_ << "    ";
    name(grid);
    out_ << ": tested before\n";
}

void Narration::hidden(const IGrid& grid)
{
    out_ << "    ";
    name(grid);
    out_ << ": hidden from rays of this kind or time\n";
}

void Narration::igrid(const RayAtGrid& at, std::span<const OfferedHit> offered, float nearest)
{
    const IGrid& grid = *at.like.grid;
    const std::vector<std::uint32_t> ids = ids_of(grid);
    out_ << "    ";
    name(grid);
    out_ << ": " << ids.size() << " triangles";
    if (grid.is_lattice) out_ << ", level " << grid.level + exponent_ << (grid.blends() ? ", blended with the next" : "");
    out_ << ", t from " << world(at.t_near) << " to " << world(at.t_end) << '\n';

    std::vector<TestedTriangle> all;
    for (std::size_t first = 0; first < ids.size(); first += kLanes)
        test(std::span(ids).subspan(first, std::min<std::size_t>(kLanes, ids.size() - first)), at, all);
    const auto hit_of = [&](const TestedTriangle& one) {
        return std::find_if(offered.begin(), offered.end(),
                            [&](const OfferedHit& hit) { return are_same(grid, hit.id, one.id); });
    };
    const auto is_told = [&](const TestedTriangle& one) { return one.is_inside || hit_of(one) != offered.end(); };
    const auto misses = std::stable_partition(all.begin(), all.end(), is_told);
    std::stable_sort(misses, all.end(), [](const auto& a, const auto& b) { return a.outside < b.outside; });
    const std::size_t listed = std::min(all.size(), static_cast<std::size_t>(misses - all.begin()) + kListedMisses);
    const double area = to_world_ * to_world_;
    for (const TestedTriangle& one : std::span(all).first(listed)) {
        out_ << "      ";
        write_place(out_, one, grid);
        out_ << ": U " << one.u * area << ", V " << one.v * area << ", W " << one.w * area;
        const auto hit = hit_of(one);
        if (hit != offered.end())
            out_ << (hit->is_hole   ? ": a hole at t "
                     : hit->is_back ? ": a hidden back at t "
                                    : ": hit at t ")
                 << world(hit->t) << '\n';
        else if (!one.is_inside) out_ << ((one.u + one.v) + one.w == 0 ? ": edge-on, no hit\n" : ": missed\n");
        else if (is_gap(one.id)) out_ << ": no hit in double precision\n";
        else if (!(one.t > at.t_near && one.t <= at.t_end))
            out_ << ": t " << world(one.t) << " is outside of that interval\n";
        else if (one.t > nearest) out_ << ": t " << world(one.t) << " is behind the nearest hit\n";
        else out_ << ": t " << world(one.t) << " WAS NOT TESTED, since the boxes over it are missed\n";
    }
}

}  // namespace occam::accel
