#include "verify/verify.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <sstream>

#include "accel/frame.h"
#include "accel/tracer.h"
#include "lod/dicer.h"
#include "lod/ray_levels.h"
#include "lod/topology_cache.h"
#include "scenegraph/frame_scale.h"
#include "verify/closed.h"
#include "verify/grazing.h"
#include "verify/ray_surface.h"

namespace occam {
namespace {

using Random = std::mt19937_64;
double uniform(Random& random) { return double(random() >> 11) * 0x1p-53; }
double uniform(Random& random, double low, double high) { return low + (high - low) * uniform(random); }
template <class List>
const auto& pick(const List& list, Random& random)
{
    return list[random() % list.size()];
}

Vec3d any_direction(Random& random)
{
    while (true) {
        const Vec3d d{uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)};
        if (const double l = glm::length(d); l > 0.1 && l <= 1) return d / l;
    }
}

/// Describes how a node of another scene deforms its cages.
struct Pose {
    const Node& node;
    const SkinSlot* skin;
};

/// Holds a cage diced at some pairs of levels, to find targets for rays and points inside.
class Subject {
public:
    Subject(const Cage& cage, const Mat4d& place, const TextureStore* textures, const Pose* pose)
    {
        const CageId id = scene_.add(cage);
        NodeDesc desc{.matrix = place, .cages = {id}};
        if (pose) desc.morph_weights = pose->node.morph_weights;
        if (pose && pose->skin && cage.skin.sets > 0) {
            // Joints are placed where the node has them here, whatever their parents are there.
            Skin skin;
            for (const Mat4d& mesh_pose : pose->skin->mesh_poses)
                skin.joints.push_back(
                    scene_.add_node(scene_.root(), {.matrix = place * pose->node.node_from_skin * mesh_pose}));
            desc.skin = scene_.add(std::move(skin));
        }
        const NodeId node = scene_.add_node(scene_.root(), desc);
        scene_.refit();
        const CageSlot& slot = scene_.cage(id);
        const lod::CageTables& tables = topologies_.get(slot);
        posed_.slot = &slot;
        posed_.topology = tables.topology.get();
        posed_.clusters = tables.clusters.get();
        posed_.node = &scene_.node(node);
        const SkinSlot* skin = scene_.find(posed_.node->skin);
        posed_.place(place, cage_bounds(*posed_.node, slot, skin));
        if (tables.deformed_clusters) posed_.deform(*tables.deformed_clusters, skin, pose_, deform_);
        if (textures) posed_.displace(*textures);
        for (std::uint32_t face = 0; face < posed_.topology->face_count(); ++face)
            for (std::uint32_t sub = 0; posed_.topology->is_seen(face) && sub < posed_.topology->patches_of(face); ++sub)
                patches_.push_back({{face, sub}, dicer_.scale(posed_, {face, sub})});
    }

    const Scene& scene() const noexcept { return scene_; }
    lod::TopologyCache& topologies() noexcept { return topologies_; }
    const lod::PosedCage& posed() const noexcept { return posed_; }
    bool is_empty() const noexcept { return patches_.empty(); }

    /// Returns the coarsest level at which some patch has a rate of at least `rate`.
    int level_of_rate(int rate) const
    {
        int level = lod::kFinestLevel;
        for (const Patch& p : patches_) {
            const int exponent = static_cast<int>(std::log2(rate));
            level = std::max({level, p.scale.k[0] - exponent, p.scale.k[1] - exponent});
        }
        return std::max(level, posed_.finest_level());
    }

    struct Pair {
        int level = 0;
        std::vector<lod::LevelGrid> grids, hanging;  ///< all grids, and those with T-vertices
        std::vector<Vec3f> corners;                  ///< corners of the fine mesh's triangles
    };
    Pair dice(int level)
    {
        Pair pair;
        pair.level = level;
        for (const Patch& p : patches_) {
            const lod::PatchRates rates = p.scale.rates(level);
            for (std::uint32_t j = 0; j < 1u << rates.v; j += lod::TileRef::kMaxSide)
                for (std::uint32_t i = 0; i < 1u << rates.u; i += lod::TileRef::kMaxSide) {
                    const lod::TileRef tile = lod::Dicer::tile(p.ref, p.scale, level, i, j);
                    const lod::LevelGrid grid = dicer_.dice_pair(posed_, tile, p.scale.rates(level + 1), arena_);
                    pair.grids.push_back(grid);
                    if (!grid.hanging.empty()) pair.hanging.push_back(grid);
                    for (int y = 0; y < tile.rows; ++y)
                        for (int x = 0; x < tile.columns; ++x)
                            for (const auto& [dx, dy] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}})
                                pair.corners.push_back(grid.vertex(x + dx, y + dy));
                }
        }
        return pair;
    }

private:
    struct Patch {
        lod::PatchRef ref;
        lod::PatchScale scale;
    };
    Scene scene_;
    lod::TopologyCache topologies_;
    lod::PosedCage posed_;
    lod::Dicer dicer_;
    Arena arena_, pose_;
    lod::DeformCounters deform_;
    std::vector<Patch> patches_;
};

/// Describes a point of the mesh as a function of a ray's blend.
struct Target {
    const lod::LevelGrid* grid = nullptr;
    int a = 0, c = 0;  ///< vertices; a point between them, or the T-vertex
    const lod::Hanging* hanging = nullptr;
    double share = 0;  ///< the share of c, unless the point is a T-vertex

    Vec3d at(Vec3d from, Vec3d direction, const lod::Blend<float>& blend) const
    {
        const auto blended = [&](int vertex) {
            const Vec3f fine = grid->at(vertex), coarse = grid->coarse_at(vertex);
            const float w = blend.weight(static_cast<float>(glm::dot(Vec3d(fine) - from, direction)));
            return fine + (coarse - fine) * w;
        };
        if (hanging) return Vec3d(hanging->on(blended(a), blended(c)).middle);
        return glm::mix(Vec3d(blended(a)), Vec3d(blended(c)), share);
    }
};

/// Picks a target: 30 % are T-vertices (if there are any), 15 % are vertices, and the others are points of edges and
/// diagonals.
Target any_target(const Subject::Pair& pair, Random& random)
{
    Target target;
    const double choice = uniform(random);
    if (choice < 0.3 && !pair.hanging.empty()) {
        target.grid = &pick(pair.hanging, random);
        target.hanging = &pick(target.grid->hanging, random);
        target.a = static_cast<int>(target.hanging->a);
        target.c = static_cast<int>(target.hanging->c);
        return target;
    }
    target.grid = &pick(pair.grids, random);
    const int i = static_cast<int>(random() % static_cast<unsigned>(target.grid->tile.columns));
    const int j = static_cast<int>(random() % static_cast<unsigned>(target.grid->tile.rows));
    const int to[3][2] = {{1, 0}, {0, 1}, {1, 1}};
    const int* step = to[random() % 3];
    target.a = target.grid->index(i, j);
    target.c = target.grid->index(i + step[0], j + step[1]);
    target.share = choice < 0.45 ? 0 : uniform(random);
    return target;
}

struct Start {
    Vec3d at;
    double reach;  ///< edges longer than this may put the point outside
};

class EscapeTest {
public:
    EscapeTest(const Cage& cage, const Mat4d& place, const VerifySettings& settings, const TextureStore* textures,
               const Pose* pose, VerifiedCage& report)
        : settings_(settings),
          textures_(textures),
          report_(report),
          random_(settings.seed * 0x9E3779B97F4A7C15u + 1),
          scale_(transform_box(place, cage.bounds())),
          subject_(cage, scale_.placed(place), textures, pose)
    {
    }

    void run()
    {
        if (subject_.is_empty()) {
            report_.not_testable = "it has no limit surface";
            return;
        }
        // The level is finer if the inside is thinner than the edges.
        finest_ = subject_.level_of_rate(settings_.largest_rate);
        for (int finer = 0; finer < kFiner && starts_.empty(); ++finer, --finest_) {
            pairs_.clear();
            for (int level = finest_; level < finest_ + kLevels; ++level) pairs_.push_back(subject_.dice(level));
            find_starts();
            if (!starts_.empty() || pairs_.front().corners.size() > kMostCorners) break;
        }
        report_.starts = starts_.size();
        if (starts_.empty()) {
            report_.not_testable = "no point inside was found: no winding number is 1";
            return;
        }
        lod::LevelSettings levels;
        levels.eye = subject_.posed().anchor;
        levels.pixel = {lod::edge_length(finest_), 0};
        levels.shading_rate = 1 / lod::LevelSettings::kLongestEdge;  // footprints equal edge lengths
        levels.displaced = subject_.posed().displacement.reach;
        engine_levels_ = levels;
        if (settings_.overlap_ulps > 0) {
            levels.overlap_edges = 0;
            levels.overlap_ulps = settings_.overlap_ulps;
        }
        levels_ = levels;
        const accel::Frame frame(subject_.scene(), subject_.topologies(), levels, textures_);
        accel::Tracer tracer(frame, std::size_t(1) << 30);
        std::vector<accel::Ray> rays(2048);
        std::vector<accel::SurfaceHit> hits(rays.size());
        while (report_.rays < settings_.rays) {
            for (accel::Ray& ray : rays) ray = next_ray();
            tracer.closest(rays, hits);
            for (std::size_t i = 0; i < rays.size(); ++i) judge(rays[i], hits[i]);
            report_.rays += rays.size();
        }
    }

private:
    static constexpr int kLevels = 4, kFiner = 5;
    static constexpr std::size_t kMostCorners = 2'000'000;

    void find_starts()
    {
        Box3d box;
        for (const Vec3f v : pairs_.front().corners) box.add(Vec3d(v));
        const std::size_t triangles = pairs_.front().corners.size() / 3;
        const auto most = static_cast<std::size_t>(std::clamp<double>(4e6 / double(triangles), 8, 256));
        const auto distance_to_mesh = [&](Vec3d p) {
            double nearest = box.radius();
            for (const Vec3f v : pairs_.front().corners) nearest = std::min(nearest, glm::distance(Vec3d(v), p));
            return nearest;
        };
        for (std::size_t attempt = 0; attempt < 4 * most && starts_.size() < most / 4; ++attempt) {
            // Half of the points lie anywhere, half near the surface.
            Vec3d p = box.lo + box.extent() * Vec3d(uniform(random_), uniform(random_), uniform(random_));
            if (attempt & 1)
                p = Vec3d(pick(pairs_.front().corners, random_)) +
                    any_direction(random_) * (lod::edge_length(finest_) * uniform(random_, 2, 6));
            const double reach = distance_to_mesh(p) * 0.5;
            if (reach < lod::edge_length(finest_)) continue;
            // The point must be inside the fine mesh and all coarser ones that rays from here may see, with a little
            // room on all sides.
            bool is_inside = true;
            for (const Subject::Pair& pair : pairs_) {
                if (pair.level > finest_ + 1 && lod::edge_length(pair.level) > 2 * reach) break;
                for (int k = 0; k < 7 && is_inside; ++k) {
                    Vec3d step(0);
                    if (k > 0) step[(k - 1) / 2] = (k & 1 ? 0.25 : -0.25) * reach;
                    is_inside = winding_number(pair.corners, p + step) > 0.9;
                }
            }
            if (is_inside) starts_.push_back({p, reach});
        }
    }

    accel::Ray next_ray()
    {
        const Start& start = pick(starts_, random_);
        // These are target edge lengths that rays from here may have at their hit.
        const int coarsest = std::clamp(std::ilogb(start.reach), finest_ + 1, finest_ + kLevels);
        const int level = finest_ + static_cast<int>(random_() % static_cast<unsigned>(coarsest - finest_));
        const Subject::Pair& pair = pairs_[static_cast<std::size_t>(level - finest_)];
        const Target target = any_target(pair, random_);
        const Vec3d rough = Vec3d(target.grid->at(target.a));
        const double distance = std::max(glm::distance(rough, start.at), 1e-6 * start.reach);
        const double widest = lod::edge_length(coarsest), d = lod::edge_length(level);

        // The target edge length along the ray is constant, or grows or shrinks at random, or has a transition near the
        // hit or within ulps of it.
        double a, b;
        const double kind = uniform(random_);
        if (kind < 0.2) {
            a = d * uniform(random_, 1, 1.999);
            b = 0;
        } else {
            const double at_hit = kind < 0.4 ? d * uniform(random_, 1, 1.999) : d * (random_() & 1 ? 1 : 2);
            const double offset = kind < 0.4   ? 0
                                  : kind < 0.8 ? uniform(random_, -0.5, 0.5) * d
                                               : double(int(random_() % 5) - 2) * distance * 0x1p-23;
            const double where = distance + offset;
            b = std::exp2(uniform(random_, -12, -1));
            if (random_() & 1) b = std::min(b, at_hit / std::max(where, 1e-30));
            else b = -std::min(b, std::max(0.0, (widest - at_hit) / std::max(where, 1e-30)));
            a = at_hit - b * where;
        }
        accel::Ray ray;
        ray.origin = subject_.posed().anchor + start.at;
        ray.footprint = {static_cast<float>(a), static_cast<float>(b)};

        // The target moves with the blend, which depends on the direction: a few steps make both agree.
        Vec3d direction = uniform(random_) < 0.6 ? glm::normalize(rough - start.at) : any_direction(random_);
        const float far = static_cast<float>(4 * subject_.posed().radius);
        for (int step = 0; step < 3; ++step) {
            lod::RayLevels<float> table;
            if (!table.set({ray.footprint.a, ray.footprint.b}, 0, far, far, levels_) || level < table.finest ||
                level > table.coarsest)
                break;
            table.make();
            const Vec3d to = target.at(start.at, direction, table.blend(level)) - start.at;
            if (!(glm::length(to) > 0)) break;
            direction = glm::normalize(to);
        }
        Vec3f aimed(direction);
        const auto axis = static_cast<int>(random_() % 3);
        if (random_() & 1) aimed[axis] = std::nextafterf(aimed[axis], random_() & 1 ? 2.0f : -2.0f);
        ray.direction = aimed;
        return ray;
    }

    void judge(const accel::Ray& ray, const accel::SurfaceHit& hit)
    {
        if (hit.is_hit()) {
            const Vec3d all = hit.position + Vec3d(hit.normal_geometric) + Vec3d(hit.normal_shading);
            report_.not_finite += !std::isfinite(all.x + all.y + all.z + hit.t);
            if (!hit.back_side) {
                ++report_.front_side;
                report_.worst_front = std::max(report_.worst_front, -double(glm::dot(hit.normal_geometric, ray.direction)));
            }
            return;
        }
        if (std::abs(winding_of(ray)) < 0.5) {  // the start is outside of the surface that this ray sees
            ++report_.outside;
            return;
        }
        if (is_grazing(ray)) {
            ++report_.grazing;
            return;
        }
        ++report_.escaped;
        if (report_.replay.size() >= 5) return;
        std::ostringstream out;
        out.precision(17);
        const Vec3d origin = ray.origin * scale_.to_world();
        out << "origin " << origin.x << ' ' << origin.y << ' ' << origin.z << " direction " << ray.direction.x << ' '
            << ray.direction.y << ' ' << ray.direction.z << " footprint " << double(ray.footprint.a) * scale_.to_world()
            << ' ' << ray.footprint.b;
        report_.replay.push_back(out.str());
    }

    /// Returns whether the ray passed between two levels only because they overlap less here than in the engine.
    bool is_grazing(const accel::Ray& ray)
    {
        if (!(settings_.overlap_ulps > 0)) return false;
        const auto far = static_cast<float>(4 * subject_.posed().radius);
        lod::RayLevels<float> table;
        if (!table.set({ray.footprint.a, ray.footprint.b}, 0, far, far, levels_)) return false;
        table.make();
        if (!grazing_)
            grazing_ = std::make_unique<GrazingRays>(subject_.scene(), subject_.topologies(), engine_levels_, textures_,
                                                     subject_.posed().radius);
        return grazing_->explain(ray, table);
    }

    /// Returns the winding number, about the start of the ray, of the surface that the ray sees.
    double winding_of(const accel::Ray& ray)
    {
        const auto far = static_cast<float>(4 * subject_.posed().radius);
        lod::RayLevels<float> table;
        if (!table.set({ray.footprint.a, ray.footprint.b}, 0, far, far, levels_)) return 1;
        table.make();
        return winding_number_of_ray(ray.origin - subject_.posed().anchor, glm::normalize(Vec3d(ray.direction)), table,
                                     finest_, [this](int level) -> const std::vector<lod::LevelGrid>& {
                                         auto [at, is_new] = diced_.try_emplace(level);
                                         if (is_new) at->second = subject_.dice(level).grids;
                                         return at->second;
                                     });
    }

    const VerifySettings& settings_;
    const TextureStore* textures_;
    VerifiedCage& report_;
    std::map<int, std::vector<lod::LevelGrid>> diced_;  ///< diced when rays escape
    Random random_;
    FrameScale scale_;  ///< all lengths are in its unit
    Subject subject_;
    int finest_ = 0;
    std::vector<Subject::Pair> pairs_;
    std::vector<Start> starts_;
    lod::LevelSettings levels_, engine_levels_;
    std::unique_ptr<GrazingRays> grazing_;  ///< made when the first ray hits nothing
};

VerifiedCage verify_posed(const Cage& cage, const Mat4d& world_from_object, const VerifySettings& settings,
                          const TextureStore* textures, const Pose* pose)
{
    VerifiedCage report;
    report.cage = cage.name;
    report.faces = cage.face_count();
    if (cage.scheme == Scheme::Triangles) {
        report.not_testable = "it is a triangle mesh, the same at every level";
        return report;
    }
    if (report.not_testable = why_not_closed(cage); !report.not_testable.empty()) return report;
    EscapeTest(cage, world_from_object, settings, textures, pose, report).run();
    return report;
}

}  // namespace

VerifiedCage verify(const Cage& cage, const Mat4d& world_from_object, const VerifySettings& settings,
                    const TextureStore* textures)
{
    return verify_posed(cage, world_from_object, settings, textures, nullptr);
}

std::vector<VerifiedCage> verify(Scene& scene, const VerifySettings& settings)
{
    std::vector<VerifiedCage> reports;
    scene.refit();
    TextureStore textures(std::size_t(1) << 30);
    if (scene.contents().has(Contents::Displaced)) textures.prepare(scene);
    scene.for_each_placement([&](NodeId, const Node& node, const Mat4d& world_from_node) {
        for (const CageId id : node.cages) {
            const Pose pose{node, scene.find(node.skin)};
            reports.push_back(verify_posed(scene.cage(id).cage, world_from_node, settings, &textures, &pose));
            reports.back().node = node.name;
        }
    });
    return reports;
}

}  // namespace occam
