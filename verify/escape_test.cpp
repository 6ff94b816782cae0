#include "verify/escape_test.h"

#include <algorithm>
#include <cmath>

#include "accel/frame.h"
#include "accel/print.h"
#include "base/error_without_file.h"
#include "base/printable.h"
#include "lod/ray_levels.h"
#include "verify/closed.h"
#include "verify/mesh_pieces.h"
#include "verify/ray_surface.h"

namespace occam {
namespace {

/// Returns the unit in which all lengths of the test are: that of a frame that shows the cage alone.
FrameScale scale_of(const ShownCage& shown)
{
    Box3d world;
    for (const Mat4d& matrix : shown.world_from_object) world.add(transform_box(matrix, shown.slot.cage.bounds()));
    return FrameScale(world);
}

std::vector<Mat4d> placed_by(const FrameScale& scale, std::span<const Mat4d> world_from_object)
{
    std::vector<Mat4d> placed;
    for (const Mat4d& matrix : world_from_object) placed.push_back(scale.placed(matrix));
    return placed;
}

// Returns the length of the longest edge of the pair's fine mesh. It may be far shorter than the edges of its level are
// allowed to be, where a patch needs many pieces whatever the level, or its rate follows from a few fast ones.
double longest_edge(const Subject::Pair& pair)
{
    float squared = 0;
    for (std::size_t i = 0; i < pair.corners.size(); i += 3)
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3f edge = pair.corners[i + k] - pair.corners[i + (k + 1) % 3];
            squared = std::max(squared, glm::dot(edge, edge));
        }
    return std::min(std::sqrt(double(squared)), double(lod::edge_length(pair.level)));
}

// Returns whether a point is inside of the fine mesh, and of all coarser ones that rays from there may see, with a little
// room on all sides.
//
// pairs   of each level from the finest on
//
// reach   edges longer than twice that are not seen from there
//
// turn    -1 if the meshes are mirrored, and so wind the other way around, else 1
bool is_inside_at(const std::vector<Subject::Pair>& pairs, Vec3d p, double reach, int turn)
{
    for (const Subject::Pair& pair : pairs) {
        if (pair.level > pairs.front().level + 1 && lod::edge_length(pair.level) > 2 * reach) break;
        for (int k = 0; k < 7; ++k) {
            Vec3d step(0);
            if (k > 0) step[(k - 1) / 2] = (k & 1 ? 0.25 : -0.25) * reach;
            if (!(turn * winding_number(pair.corners, p + step) > 0.9)) return false;
        }
    }
    return true;
}

}  // namespace

EscapeTest::EscapeTest(const ShownCage& shown, const VerifySettings& settings, const TextureStore* textures,
                       VerifiedCage& report, std::size_t number, std::size_t size)
    : number_(number),
      settings_(settings),
      textures_(textures),
      report_(report),
      random_(settings.seed * 0x9E3779B97F4A7C15u + 1),
      scale_(scale_of(shown)),
      frame_from_object_(placed_by(scale_, shown.world_from_object)),
      subject_({shown.slot, shown.node, shown.skin, frame_from_object_, shown.segments}, textures, size)
{
}

bool EscapeTest::is_seen_at(float time) const
{
    const int segments = subject_.scene().shutter_segments();
    return segments == 0 || (!subject_.is_empty() && subject_.is_seen_in(lod::key_time(time, segments).key));
}

void EscapeTest::run(std::uint64_t rays)
{
    if (subject_.is_empty()) {
        report_.not_testable = "it has no limit surface";
        return;
    }
    const std::size_t starts = find_all_starts();
    report_.starts += starts;
    std::erase_if(instants_, [](const Instant& instant) { return instant.starts.empty(); });
    if (instants_.empty()) {
        if (report_.starts > 0) return;
        report_.not_testable =
            "no point inside was found: no winding number is 1, so the surface is open, its faces are turned inside out, or "
            "its inside is thinner than the edges at the largest rate";
        return;
    }
    report_.not_testable.clear();
    set_levels();
    const accel::Frame frame(subject_.scene(), subject_.topologies(), levels_, {.textures = textures_});
    accel::Tracer tracer(frame, std::size_t(1) << 30);
    std::vector<accel::Ray> batch(kRaysOfAView);
    std::vector<accel::SurfaceHit> hits(batch.size());
    while (report_.rays < rays) {
        const View view = next_view();
        for (accel::Ray& ray : batch) ray = next_ray(view);
        tracer.closest(batch, hits);
        for (std::size_t i = 0; i < batch.size(); ++i) judge(batch[i], hits[i]);
        report_.rays += batch.size();
    }
}

void EscapeTest::replay(const RayLine& line, std::ostream& out)
{
    if (subject_.is_empty()) throw error_without_file("the cage has no limit surface", "ray");
    find_all_starts();
    set_levels();
    accel::Ray ray;
    ray.origin = line.origin * scale_.to_frame();
    ray.direction = line.direction;
    ray.footprint = {static_cast<float>(line.width * scale_.to_frame()), line.spread};
    ray.time = line.time;
    const accel::Frame frame(subject_.scene(), subject_.topologies(), levels_, {.textures = textures_});
    accel::Tracer tracer(frame, std::size_t(1) << 30);
    const Precision digits(out, 9);
    out << "cage " << number_ << " '" << printable_line(report_.cage) << "' of node '" << printable_line(report_.node)
        << "'; lengths are in units of " << scale_.to_world() << '\n'
        << "ray: " << ray << '\n';
    accel::SurfaceHit hit;
    tracer.observe(ray, hit, &out);
    out << "  " << (hit.is_hit() ? "hit: " : "") << hit << '\n';
    judge(ray, hit);
    report_.rays = 1;
    if (report_.not_finite > 0) out << "The hit is not finite.\n";
    else if (report_.outside > 0) out << "The ray starts outside of the surface that it sees.\n";
    else if (report_.grazing > 0) out << "The ray passes between two levels, which overlap more where pictures are made.\n";
    else if (report_.silhouettes > 0) out << "The ray meets an outline of the surface, within rounding.\n";
    else if (report_.front_side > 0) out << "The ray hits a front side of the cage.\n";
    else out << (report_.escaped > 0 ? "The ray ESCAPES.\n" : "The ray hits the cage.\n");
}

void EscapeTest::set_levels()
{
    lod::LevelSettings levels;
    levels.eye = subject_.posed().anchor;
    levels.pixel = {lod::edge_length(finest_), 0};
    levels.shading_rate = 1 / lod::LevelSettings::kLongestEdge;  // footprints equal edge lengths
    levels.displaced = subject_.posed().displacement.reach;
    levels.edges = lod::LongestEdges(subject_.scene().contents().poles);
    levels.motion_edges = 0;
    engine_levels_ = levels;
    if (settings_.overlap_ulps > 0) {
        levels.overlap_edges = 0;
        levels.overlap_ulps = settings_.overlap_ulps;
        levels.least_coordinate = subject_.posed().radius;
    }
    levels_ = levels;
}

void EscapeTest::choose_instants()
{
    instants_.resize(1);
    const int segments = subject_.posed().segments;
    if (segments == 0) return;
    instants_.resize(kInstants);
    for (Instant& instant : instants_) instant.time = static_cast<float>(uniform(random_));
    const auto key = static_cast<int>(random_() % static_cast<unsigned>(segments + 1));
    instants_[0].time = static_cast<float>(key) / static_cast<float>(segments);
    // Where rays of a moment do not see the cage, or see it at another size, they have a moment of another segment.
    const int all = subject_.scene().shutter_segments();
    std::vector<int> seen;
    for (int segment = 0; segment < all; ++segment)
        if (subject_.is_seen_in(segment)) seen.push_back(segment);
    if (seen.empty()) instants_.clear();
    for (Instant& instant : instants_) {
        if (is_seen_at(instant.time)) continue;
        const double within = uniform(random_);
        instant.time = static_cast<float>((pick(seen, random_) + within) / all);
    }
}

std::size_t EscapeTest::find_all_starts()
{
    choose_instants();
    const int level_of_rate = subject_.level_of_rate(settings_.largest_rate);
    for (int finer = 0; finer < kFiner; ++finer) {
        finest_ = level_of_rate - finer;
        std::size_t starts = 0, corners = 0;
        for (Instant& instant : instants_) {
            instant.pairs.clear();
            for (int level = finest_; level < finest_ + kLevels; ++level)
                instant.pairs.push_back(subject_.dice(level, instant.time));
            corners += instant.pairs.front().corners.size();
            find_starts(instant);
            starts += instant.starts.size();
        }
        if (starts > 0) return starts;
        if (corners > kMostCorners) break;
    }
    return 0;
}

void EscapeTest::find_starts(Instant& instant)
{
    const std::vector<Subject::Pair>& pairs = instant.pairs;
    std::vector<Start>& starts = instant.starts;
    Box3d box;
    for (const Vec3f v : pairs.front().corners) box.add(Vec3d(v));
    const std::size_t triangles = pairs.front().corners.size() / 3;
    // A large mesh and several moments leave few points for each moment, but at least two are looked for.
    const auto share = static_cast<std::size_t>(std::clamp<double>(4e6 / double(triangles), 8, 256)) / instants_.size();
    const std::size_t most = std::max<std::size_t>(share, 8);
    const MeshPieces pieces(pairs.front());
    // A mirrored mesh winds the other way around.
    const int turn = subject_.is_mirrored_at(instant.time) ? -1 : 1;
    // A point needs so much room that coarser meshes do not pass by it.
    const double edge = longest_edge(pairs.front()), least_distance = 2 * edge;
    // Where no finer level will be looked at, more points are tried until one is inside.
    const std::size_t tries = pairs.front().corners.size() > kMostCorners ? 64 : 4;
    const auto try_at = [&](Vec3d p) {
        const double distance = pieces.distance(p, least_distance);
        if (distance < least_distance || turn * pieces.crossings_along_x(p) < 1) return;
        const double reach = std::min(distance, box.radius()) * 0.5;
        if (is_inside_at(pairs, p, reach, turn)) starts.push_back({p, reach});
    };
    for (std::size_t attempt = 0; attempt < (starts.empty() ? tries : 4) * most && starts.size() < most / 4; ++attempt) {
        // Half of the points lie anywhere, half near the surface.
        Vec3d p = box.lo + box.extent() * Vec3d(uniform(random_), uniform(random_), uniform(random_));
        if (attempt & 1)
            p = Vec3d(pick(pairs.front().corners, random_)) + any_direction(random_) * (edge * uniform(random_, 2, 6));
        try_at(p);
    }
    // Few such points are inside of wires and of long poles. So points are tried behind triangles, too.
    // Each takes time in proportion to the mesh.
    const double tries_behind = starts.empty() ? std::clamp<double>(4e8 / double(triangles), 256, kTriesBehind) : 0;
    const std::size_t behind = static_cast<std::size_t>(tries_behind) / instants_.size();
    for (std::size_t attempt = 0; attempt < behind && starts.size() < most / 4; ++attempt) {
        const Vec3f* const corner = &pairs.front().corners[random_() % triangles * 3];
        const Vec3d normal = glm::cross(Vec3d(corner[1] - corner[0]), Vec3d(corner[2] - corner[0]));
        const double length = glm::length(normal);
        if (length > 0) try_at(Vec3d(corner[0]) - normal * (turn / length * edge * uniform(random_, 2, 6)));
    }
}

EscapeTest::View EscapeTest::next_view()
{
    const Instant& instant = instants_.size() > 1 ? pick(instants_, random_) : instants_.front();
    const Start& start = pick(instant.starts, random_);
    const int coarsest = std::clamp(std::ilogb(start.reach), finest_ + 1, finest_ + kLevels);
    return {instant, start, coarsest, finest_ + static_cast<int>(random_() % static_cast<unsigned>(coarsest - finest_))};
}

accel::Ray EscapeTest::next_ray(const View& view)
{
    const auto& [instant, start, coarsest, level] = view;
    const Subject::Pair& pair = instant.pairs[static_cast<std::size_t>(level - finest_)];
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
    ray.time = instant.time;
    ray.origin = subject_.posed().anchor + start.at;
    ray.footprint = {static_cast<float>(a), static_cast<float>(b)};

    // The target moves with the blend, which depends on the direction: a few steps make both agree.
    Vec3d direction = uniform(random_) < 0.6 ? glm::normalize(rough - start.at) : any_direction(random_);
    for (int step = 0; step < 3; ++step) {
        lod::RayLevels<float> table;
        if (!make_table(ray, table) || level < table.finest || level > table.coarsest) break;
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

void EscapeTest::judge(const accel::Ray& ray, const accel::SurfaceHit& hit)
{
    if (hit.is_hit()) {
        const Vec3d all = hit.position + Vec3d(hit.normal_geometric) + Vec3d(hit.normal_shading);
        report_.not_finite += !std::isfinite(all.x + all.y + all.z + hit.t);
        if (!hit.back_side) judge_front_side(ray, hit);
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
    const RayLine line{number_,         ray.origin * scale_.to_world(),
                       ray.direction,   double(ray.footprint.a) * scale_.to_world(),
                       ray.footprint.b, ray.time};
    report_.replay.push_back(line.text());
}

void EscapeTest::judge_front_side(const accel::Ray& ray, const accel::SurfaceHit& hit)
{
    if (!silhouettes_)
        silhouettes_ = std::make_unique<Silhouettes>(subject_.scene(), subject_.topologies(), levels_, textures_,
                                                     subject_.posed().radius);
    if (silhouettes_->explain(ray)) {
        ++report_.silhouettes;
        return;
    }
    // A winding number takes as long as thousands of rays, and a cage that folds has many front sides.
    constexpr int kMostExamined = 16;
    if (front_sides_examined_ < kMostExamined) {
        ++front_sides_examined_;
        if (std::abs(winding_of(ray)) < 0.5) {
            ++report_.outside;
            return;
        }
    }
    ++report_.front_side;
    report_.worst_front = std::max(report_.worst_front, -double(glm::dot(hit.normal_geometric, ray.direction)));
}

bool EscapeTest::make_table(const accel::Ray& ray, lod::RayLevels<float>& table) const
{
    const auto far = static_cast<float>(4 * subject_.posed().radius);
    if (!table.set({ray.footprint.a, ray.footprint.b}, 0, far, far, levels_)) return false;
    table.make();
    return true;
}

bool EscapeTest::is_grazing(const accel::Ray& ray)
{
    if (!(settings_.overlap_ulps > 0)) return false;
    lod::RayLevels<float> table;
    if (!make_table(ray, table)) return false;
    if (!grazing_)
        grazing_ = std::make_unique<GrazingRays>(subject_.scene(), subject_.topologies(), engine_levels_, textures_,
                                                 subject_.posed().radius);
    return grazing_->explain(ray, table);
}

double EscapeTest::winding_of(const accel::Ray& ray)
{
    lod::RayLevels<float> table;
    if (!make_table(ray, table)) return 1;
    return winding_number_of_ray(ray.origin - subject_.posed().anchor, glm::normalize(Vec3d(ray.direction)), table, finest_,
                                 [&](int level) -> const std::vector<lod::LevelGrid>& {
                                     auto [at, is_new] = diced_.try_emplace({ray.time, level});
                                     if (is_new) at->second = subject_.dice(level, ray.time).grids;
                                     return at->second;
                                 });
}

}  // namespace occam
