#include "accel/hit.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>

#include "accel/hit_geometry.h"
#include "accel/hit_shares.h"
#include "accel/ray_reach.h"
#include "accel/ray_starts.h"
#include "accel/turned_over.h"
#include "accel/vertex_values.h"
#include "base/hash.h"
#include "scenegraph/map_axes.h"

namespace occam::accel {
namespace {

// For smaller values no gradient is computed: a float would not hold it.
constexpr float kLeastArea = 1e-30f;

/// to_frame   frame lengths of a world length
OCCAM_NEVER_INLINE void set_bump_gradients(const HitCorners& corners, const Triangles& tri, std::size_t lane, float to_frame,
                                           SurfaceHit& hit) noexcept
{
    const int set = coordinates_of(hit.material->bump_texture);
    if ((corners.has_uv[set] >> lane & 1) == 0) return;
    const Stored b(tri.gradient[0]), c(tri.gradient[1]);
    const auto change = [&](int corner, int axis) {
        return (corners.uv[set][corner][lane][axis] - corners.uv[set][0][lane][axis]) * to_frame;
    };
    hit.u_gradient = b[lane] * change(1, 0) + c[lane] * change(2, 0);
    hit.v_gradient = b[lane] * change(1, 1) + c[lane] * change(2, 1);
}

// Returns the nearest level in this range that a cage may have.
int in_range(int level, PairRange range) noexcept
{
    return std::clamp(level, std::clamp(range.finest, lod::kFinestLevel, lod::kCoarsestLevel),
                      std::clamp(range.coarsest, lod::kFinestLevel, lod::kCoarsestLevel));
}

// Returns the level in this range whose edges are at most `factor` times the target edge length of the ray at its hit.
int level_at(const Ray& ray, const GridHit& met, const lod::LevelSettings& levels, float factor, PairRange range) noexcept
{
    const float target_edge = target_edge_of(ray, levels).at(met.t);
    const int level = target_edge > 0 ? std::ilogb(std::min(target_edge, FLT_MAX) * factor) : lod::kFinestLevel;
    return in_range(level, range);
}

// Returns the finer level of the pair that the ray sees at the hit, of those that the igrid serves.
int seen_level_of(const Ray& ray, const GridHit& met, const lod::LevelSettings& levels) noexcept
{
    const PairRange pairs = met.grid->pairs;
    if (!met.grid->is_lattice || levels.mode == lod::LevelMode::PerInstance || pairs.coarsest <= met.grid->level)
        return met.grid->level;
    return level_at(ray, met, levels, 1, {met.grid->level, pairs.coarsest});
}

// Writes what is computed in lanes to the hits, four floats at a time. Lanes without a hit are written to where nobody
// reads.
class HitWriter {
public:
    HitWriter(std::span<const GridHit> met, SurfaceHit* const* hits) noexcept
    {
        for (std::size_t i = 0; i < kLanes; ++i) to_[i] = i < met.size() && met[i].grid ? &hits[i]->t : unused_;
    }
    struct Values {
        vfloat t, self_distance, curvature, blend;
        const NormalLanes& normal;
        const UvAtHits& uv;
    };
    void write(const Values& of) noexcept
    {
        const VecLanes &geometric = of.normal.geometric, &shading = of.normal.shading, &tangent = of.uv.tangent.along;
        write(offsetof(SurfaceHit, t), {of.t, of.self_distance, of.uv.width[0], of.uv.width[1]});
        write(offsetof(SurfaceHit, normal_geometric), {geometric.x, geometric.y, geometric.z, of.curvature});
        write(offsetof(SurfaceHit, normal_shading), {shading.x, shading.y, shading.z, of.uv.tangent.sign});
        write(offsetof(SurfaceHit, tangent), {tangent.x, tangent.y, tangent.z, of.blend});
        write(offsetof(SurfaceHit, uv), {of.uv.at[0][0], of.uv.at[0][1], of.uv.at[1][0], of.uv.at[1][1]});
        write(offsetof(SurfaceHit, start_normal), {geometric.x, geometric.y, geometric.z, 0.0f});
    }

private:
    static constexpr std::size_t kFloats = 30;
    static_assert(offsetof(SurfaceHit, t) == 0 && offsetof(SurfaceHit, uv) == 16 * sizeof(float));
    static_assert(offsetof(SurfaceHit, to_start) == offsetof(SurfaceHit, start_normal) + 3 * sizeof(float));
    static_assert(offsetof(SurfaceHit, to_start) < kFloats * sizeof(float));

    // place   of the four floats in a SurfaceHit
    void write(std::size_t place, const vfloat (&values)[4]) noexcept { store_turned(values, to_, place / sizeof(float)); }

    float* to_[kLanes];
    float unused_[kFloats];
};

// Identifies the micropolygon that was hit, by number. It is kept out of line: inlined, its values are spilled in halves
// and wait for all stores before them.
OCCAM_NEVER_INLINE void set_identity(const GridHit& met, const MicropolygonPlace& spot, SurfaceHit& hit) noexcept
{
    const lod::PosedCage& cage = *met.grid->cage;
    hit.node = cage.node_id;
    hit.instance = cage.instance;
    hit.cage = cage.cage_id;
    hit.lit_by = cage.lit_by;
    hit.face = spot.face;
    const std::uint64_t tile = spot.part ? std::uint64_t(spot.part->tile.j0) << 32 | spot.part->tile.i0 : 0;
    hit.micropolygon = static_cast<std::uint32_t>(
        mix_bits(cage.path.hash ^ (std::uint64_t(spot.number) << 32 ^ spot.face) ^ tile * 0x9e3779b97f4a7c15u));
}

// Returns the level at which secondary rays from a hit start: of the igrid's two levels, the one to which the surface is
// nearer at the hit, so that the start moves by little. Where both are the same, it is the level that the ray sees there:
// then the surfaces around the start, which may cross this one, are where they were for the ray. On a mesh beside everything
// that is diced it is the level whose edges are nearer to the target edge length of the ray.
int start_level_of(const Ray& ray, const GridHit& met, const FrameState& frame) noexcept
{
    if (!frame.has_levels) return kAnyLevel;
    const PairRange pairs = met.grid->pairs;
    if (met.grid->blends()) return pairs.finest + (met.blend.weight(met.t) >= 0.5f);
    const PairRange range{pairs.finest, pairs.coarsest + 1};
    return met.level == kAnyLevel ? level_at(ray, met, frame.levels, 4.0f / 3, range) : in_range(met.level, range);
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

// Holds what is read of rays and hits one by one.
struct HitsRead {
    MicropolygonPlace spots[kLanes];
    alignas(32) FloatLanes t{}, radius{};
    alignas(32) FloatLanes mirrored{};  // 1, or -1 if the cage's placement reverses the orientation of faces
    alignas(32) FloatLanes is_flat{};   // 1 for gap triangles
    unsigned gaps = 0, coarse_starts = 0, in_still = 0;
    int start_level[kLanes]{};
    const IGrid* any = nullptr;  // null if no ray hit anything

    HitsRead(std::span<const Ray> rays, std::span<const GridHit> met, const FrameState& frame) noexcept
    {
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (!met[i].grid) continue;
            const IGrid& grid = *met[i].grid;
            const lod::PosedCage& cage = *grid.cage;
            any = &grid;
            spots[i].set(met[i]);
            t[i] = met[i].t;
            radius[i] = cage.radius;
            in_still |= unsigned(cage.affine != nullptr) << i;
            const bool is_mirrored = cage.segments > 0 ? cage.is_mirrored_at(met[i].time) : cage.is_mirrored;
            mirrored[i] = is_mirrored ? -1.0f : 1.0f;
            if (is_gap(met[i])) {
                gaps |= 1u << i;
                is_flat[i] = 1;
            }
            start_level[i] = start_level_of(rays[i], met[i], frame);
            if (grid.blends() && start_level[i] > grid.pairs.finest) coarse_starts |= 1u << i;
        }
    }
};

// Holds the set of texture coordinates of each lane's normal map, or -1, and what maps there are.
struct MapSets {
    vfloat of;
    bool any = false, any_bump = false, any_rotated = false, any_other = false;

    MapSets(std::span<const GridHit> met, const HitCorners& corners) noexcept
    {
        alignas(32) FloatLanes set{};
        const Material* last = nullptr;  // neighbours often have one material
        float of_last = -1;
        for (std::size_t i = 0; i < met.size(); ++i) {
            if (!met[i].grid) continue;
            if (corners.material[i] != last) {
                last = corners.material[i];
                of_last = static_cast<float>(axes_set_of(*last));
                any = any || of_last >= 0;
                any_bump = any_bump || last->bump_texture;
                any_rotated = any_rotated || turns_axes(*last);
                any_other = any_other || any_has_other_axes(*last);
            }
            set[i] = of_last;
        }
        of = vfloat::load(set);
    }
};

// Holds what was computed in lanes, to be read lane by lane.
struct FilledLanes {
    const HitCorners& corners;
    const HitRays& placed;
    const Triangles& tri;
    Stored from_corner, share, to_start, start_normal;
    unsigned starts_beside, starts_on_ray, is_back, has_gradients;  // bit masks of lanes
    const FloatLanes& mirrored;
    const MapSets& maps;
    const Tangents &tangent, &other_tangent;
};

// Returns the lanes whose patch overlaps others of its face in a plane (lod::GridAttributes).
unsigned overlapping_lanes(const HitsRead& read, const HitCorners& corners) noexcept
{
    unsigned found = 0;
    for (unsigned left = corners.has_start & ~read.gaps; left != 0; left &= left - 1) {
        const int lane = std::countr_zero(left);
        found |= unsigned(read.spots[lane].part && read.spots[lane].part->attributes.overlaps_in_plane) << lane;
    }
    return found;
}

// Fills in what is computed hit by hit, after what is written in lanes.
void fill(const FilledLanes& of, std::size_t i, const GridHit& met, const Ray& ray, const PhaseOneTools& tools,
          SurfaceHit& hit) noexcept
{
    const HitCorners& corners = of.corners;
    const Vec3d place = Vec3d(corners.position_of(0, i)) + Vec3d(of.from_corner[i]);
    hit.position = of.placed.anchor_of(i) + place;
    hit.back_side = (of.is_back >> i & 1) != 0;
    hit.side = side_name(met.grid->cage->path.hash, hit.back_side);
    hit.to_start = hit.u_gradient = hit.v_gradient = hit.velocity = Vec3f(0);
    hit.v_axis = Vec2f(0);
    hit.color = Vec4f(1);
    hit.material = corners.material[i];
    // For most hits secondary rays start on the micropolygon that was hit. Where patches overlap, the same place of the mesh
    // that they see may be beyond the face's border, or turned over: they start on the parent's ray, a little before its
    // end, and so in the room where that ray was.
    if (of.starts_beside >> i & 1) hit.to_start = of.to_start[i];
    if (of.starts_on_ray >> i & 1) hit.to_start = ray.direction * (hit.self_distance * -(kEdgeUlps / kStartUlps));
    if (corners.has_start >> i & 1) {
        const Vec3f unturned = of.start_normal[i] * of.mirrored[i];
        if (unturned != Vec3f(0)) hit.start_normal = hit.back_side ? -unturned : unturned;
    }
    if (corners.has_color >> i & 1) hit.color = weighted(corners.color[i], of.share[i]);
    if (of.maps.any_bump && hit.material->bump_texture && (of.has_gradients >> i & 1) != 0)
        set_bump_gradients(corners, of.tri, i, static_cast<float>(tools.frame.scale.to_frame()), hit);
    if (of.maps.any_rotated && turns_axes(*hit.material))
        hit.v_axis = Vec2f(Stored({of.tangent.v_axis[0], of.tangent.v_axis[1], 0.0f})[i]);
    if (of.maps.any_other && any_has_other_axes(*hit.material)) {
        const Vec3f rest = Stored({of.other_tangent.sign, of.other_tangent.v_axis[0], of.other_tangent.v_axis[1]})[i];
        hit.other_axes = {Stored(of.other_tangent.along)[i], rest.x, {rest.y, rest.z}};
    }
    if (met.grid->segments > 0) hit.velocity = corners.velocity_of(i, of.share[i]);
    else if (met.grid->cage->affine) hit.velocity = of.placed.velocity_of(i, *met.grid->cage, ray.time, place);
}

// Returns the weight of the coarser level at the hits.
vfloat weight_at(const HitCorners& corners, const vfloat (&share)[3]) noexcept
{
    return fma(vfloat::load(corners.weight[0]), share[0],
               fma(vfloat::load(corners.weight[1]), share[1], vfloat::load(corners.weight[2]) * share[2]));
}

// Returns the width of the rays' beams at their hits.
vfloat beam_width(std::span<const Ray> rays, vfloat t) noexcept
{
    vfloat beam[4];
    static_assert(offsetof(Ray, footprint) == offsetof(Ray, t_near) + 2 * sizeof(float));
    gather_four(rays.data(), rays.size(), offsetof(Ray, t_near), beam);
    return max(beam[2] + beam[3] * t, vfloat(0.0f));
}

// Sets the level that the ray sees, and the values that phase one has made for it.
void set_level(const Ray& ray, const GridHit& met, const MicropolygonPlace& spot, Vec3f share, const PhaseOneTools& tools,
               SurfaceHit& hit)
{
    const int level = seen_level_of(ray, met, tools.frame.levels);
    hit.level = met.grid->is_lattice ? level + tools.frame.scale.exponent() : level;
    hit.phase_one_channels = 0;
    // Values at vertices are made for one level. A ray that sees the same mesh from farther away filters more.
    if (spot.part && tools.frame.shading.shader && level == met.grid->level)
        add_vertex_values(met.grid->lattice(), part_of(spot.number), place_in_part(met, spot, share), tools, hit);
}

}  // namespace

void resolve(std::span<const Ray> rays, const RayAxes& axes, std::span<const GridHit> met, const PhaseOneTools& tools,
             SurfaceHit* const* hits, bool are_first)
{
    const HitsRead read(rays, met, tools.frame);
    if (!read.any) return;
    HitCorners corners(met, read.spots);
    HitRays placed(rays, met, *read.any, read.in_still);
    const vfloat(&way)[4] = placed.way;
    placed.set_positions(corners, read.coarse_starts);
    corners.set_attributes(tools);
    if (placed.in_still != 0 && corners.has_normals != 0) placed.move_normals(corners);
    vfloat share[3];
    shares_of(corners, {axes, rays, placed, read.gaps}, share);

    const vfloat zero = 0.0f, t = vfloat::load(read.t);
    const vmask is_flat = vfloat::load(read.is_flat) > zero;
    const Triangles tri(corners);
    const VecLanes offset = tri.edge[0] * share[1] + tri.edge[1] * share[2];  // relative to corner a
    const vfloat farthest = max(largest(load(corners.position[0]) + offset), placed.radius(read.radius));
    const unsigned on_ray = overlapping_lanes(read, corners);
    corners.has_start &= ~on_ray;
    const StartsBesideHits beside(corners, tri, share, is_flat, farthest);
    FloatLanes orientation;
    vfloat::load(read.mirrored).store(orientation);
    if (beside.starts && are_first)
        TurnedOver{corners, placed, read.gaps, read.coarse_starts, tri.normal}.orient(rays, met, beside.starts->normal,
                                                                                      orientation);
    const NormalLanes normal(corners, tri, share, vfloat::load(orientation), is_flat, {way[0], way[1], way[2]});
    const vmask has_gradients = andnot(tri.area > vfloat(kLeastArea), is_flat);
    const vfloat outward = corners.has_normals != 0 ? outward_curvature(tri, normal.corner) : zero;
    const vfloat curvature = select(has_gradients, select(normal.is_back, -outward, outward), zero);
    const MapSets map_sets(met, corners);
    const UvAtHits uv(corners, tri, share, beam_width(rays, t),
                      {select(has_gradients, map_sets.of, -1.0f), map_sets.any, map_sets.any_other},
                      select(normal.is_back, -normal.shading, normal.shading));

    HitWriter(met, hits).write(
        {t, vfloat(kStartUlps * FLT_EPSILON) * farthest, curvature, weight_at(corners, share), normal, uv});
    const FilledLanes lanes{corners,
                            placed,
                            tri,
                            Stored(offset),
                            Stored({share[0], share[1], share[2]}),
                            Stored(beside.from_hits(corners, offset)),
                            Stored(beside.starts ? beside.starts->normal : offset),
                            beside.which,
                            on_ray,
                            bits(normal.is_back),
                            bits(has_gradients),
                            read.mirrored,
                            map_sets,
                            uv.tangent,
                            uv.other_tangent};
    for (std::size_t i = 0; i < rays.size(); ++i) {
        if (!met[i].grid) continue;
        hits[i]->start_level = static_cast<std::int8_t>(read.start_level[i]);
        fill(lanes, i, met[i], rays[i], tools, *hits[i]);
        set_identity(met[i], read.spots[i], *hits[i]);
        set_level(rays[i], met[i], read.spots[i], lanes.share[i], tools, *hits[i]);
    }
}

bool is_back_side(const Ray& ray, const RayAxes& axes, const GridHit& met, const FrameState& frame) noexcept
{
    const std::span<const Ray> rays(&ray, 1);
    const std::span<const GridHit> hits(&met, 1);
    const HitsRead read(rays, hits, frame);
    HitCorners corners(hits, read.spots);
    HitRays placed(rays, hits, *met.grid, read.in_still);
    placed.set_positions(corners, read.coarse_starts);
    const vfloat zero = 0.0f;
    const vmask is_flat = vfloat::load(read.is_flat) > zero;
    const Triangles tri(corners);
    vfloat share[3] = {1.0f, zero, zero};
    // Normals at the corners count only where the micropolygon has none.
    if (read.gaps != 0 || !(first_lane(tri.area) > 0)) {
        corners.set_attributes(*frame.scene);
        if (placed.in_still != 0 && corners.has_normals != 0) placed.move_normals(corners);
        shares_of(corners, {axes, rays, placed, read.gaps}, share);
    }
    FloatLanes orientation;
    vfloat::load(read.mirrored).store(orientation);
    corners.has_start &= ~overlapping_lanes(read, corners);
    if (corners.has_start != 0) {
        alignas(32) FloatLanes has_start{1};
        const Starts starts(corners, share, vfloat::load(has_start) > zero, is_flat, zero);
        TurnedOver{corners, placed, read.gaps, read.coarse_starts, tri.normal}.orient(rays, hits, starts.normal,
                                                                                      orientation);
    }
    const NormalLanes normal(corners, tri, share, vfloat::load(orientation), is_flat,
                             {placed.way[0], placed.way[1], placed.way[2]});
    return (bits(normal.is_back) & 1) != 0;
}

}  // namespace occam::accel
