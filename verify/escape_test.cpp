#include "verify/escape_test.h"

#include <algorithm>
#include <cmath>

#include "accel/frame.h"
#include "accel/print.h"
#include "base/error_without_file.h"
#include "base/printable.h"
#include "lod/ray_levels.h"

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
      subject_({shown.slot, shown.node, shown.skin, frame_from_object_, shown.segments}, textures, size),
      not_met_(subject_.faces()),
      is_met_(shown.slot.cage.face_count())
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
    choose_instants();
    if (find_first_level()) test_all_levels(rays);
    else if (report_.rays == 0)
        report_.not_testable =
            "no point inside was found: no winding number is 1, so the surface is open, its faces are turned inside out, or "
            "its inside is thinner than the edges at the largest rate";
    report_.faces_not_met = std::max<std::uint64_t>(report_.faces_not_met, not_met_.size());
    for (const Instant& instant : instants_) report_.moments_not_tested += !instant.has_inside;
}

std::size_t EscapeTest::moments_seen() const
{
    return static_cast<std::size_t>(std::ranges::count_if(instants_, &Instant::is_seen));
}

void EscapeTest::test_all_levels(std::uint64_t rays)
{
    report_.not_testable.clear();
    const int first = finest_;
    std::vector<std::vector<Start>> starts;
    for (const Instant& instant : instants_) starts.push_back(instant.starts);
    const auto return_to_first = [&] {
        if (finest_ != first) dice(first, Moments::All);
        for (std::size_t i = 0; i < instants_.size(); ++i) instants_[i].starts = starts[i];
    };
    test_thin_moments(rays);
    if (report_.rays >= rays) return;
    return_to_first();
    test_level(rays);
    // Behind faces that were not met the inside may be too thin for the first level.
    while (report_.rays < rays && !not_met_.empty() && has_finer_level(Moments::All)) {
        dice(finest_ - 1, Moments::All);
        if (find_starts_behind() > 0) test_level(rays);
    }
    if (report_.rays >= rays) return;
    return_to_first();
    send(rays);
}

void EscapeTest::test_thin_moments(std::uint64_t rays)
{
    const std::uint64_t share = (rays - std::min(rays, report_.rays)) / std::max<std::size_t>(instants_.size(), 1);
    const auto is_thin = [](const Instant& instant) { return is_among(instant, Moments::WithoutInside); };
    while (std::ranges::any_of(instants_, is_thin) && has_finer_level(Moments::WithoutInside)) {
        dice(finest_ - 1, Moments::WithoutInside);
        send(std::min(rays, report_.rays + share * find_starts()));
    }
}

void EscapeTest::test_level(std::uint64_t rays)
{
    while (report_.rays < rays) {
        const std::size_t before = not_met_.size();
        send(report_.rays + (rays - report_.rays + 1) / 2);
        if (not_met_.empty() || not_met_.size() == before || find_starts_behind() == 0) return;
    }
}

void EscapeTest::send(std::uint64_t rays)
{
    if (!has_starts() || report_.rays >= rays) return;
    if (!tracer_) {
        set_levels();
        frame_ = std::make_unique<accel::Frame>(subject_.scene(), subject_.topologies(), levels_,
                                                accel::FrameOptions{.textures = textures_});
        tracer_ = std::make_unique<accel::Tracer>(*frame_, std::size_t(1) << 30);
    }
    std::vector<accel::Ray> batch(kRaysOfAView);
    std::vector<accel::SurfaceHit> hits(batch.size());
    while (report_.rays < rays) {
        const View view = next_view();
        for (accel::Ray& ray : batch) ray = next_ray(view);
        tracer_->closest(batch, hits);
        for (std::size_t i = 0; i < batch.size(); ++i) judge(batch[i], hits[i]);
        report_.rays += batch.size();
    }
    std::erase_if(not_met_, [&](std::uint32_t face) { return bool(is_met_[face]); });
}

void EscapeTest::replay(const RayLine& line, std::ostream& out)
{
    if (subject_.is_empty()) throw error_without_file("the cage has no limit surface", "ray");
    choose_instants();
    if (line.level) {
        const int coarsest = subject_.level_of_rate(settings_.largest_rate);
        // The test refines meshes of up to kMostCorners, which gives at most four times as many.
        const bool is_refined_so = *line.level > coarsest - kFiner && subject_.corner_count(*line.level) <= 4 * kMostCorners;
        if (*line.level > coarsest || (*line.level < coarsest && !is_refined_so))
            throw error_without_file("the test has no level " + std::to_string(*line.level), "ray");
        finest_ = *line.level;
    } else {
        find_first_level();
    }
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

void EscapeTest::dice(int finest, Moments those)
{
    finest_ = finest;
    grazing_.reset();
    silhouettes_.reset();
    tracer_.reset();
    frame_.reset();
    for (Instant& instant : instants_) {
        instant.starts.clear();
        instant.pairs.clear();
        for (int level = finest_; is_among(instant, those) && level < finest_ + kLevels; ++level)
            instant.pairs.push_back(subject_.dice(level, instant.time));
    }
}

bool EscapeTest::has_finer_level(Moments those) const
{
    std::size_t corners = 0;
    for (const Instant& instant : instants_)
        if (is_among(instant, those)) corners += subject_.corner_count(finest_);
    const int last = subject_.level_of_rate(settings_.largest_rate) - kFiner + 1;
    return finest_ > last && corners <= kMostCorners;
}

bool EscapeTest::has_starts() const
{
    return std::ranges::any_of(instants_, [](const Instant& instant) { return !instant.starts.empty(); });
}

std::size_t EscapeTest::find_starts()
{
    const bool is_last = !has_finer_level(Moments::WithoutInside);
    std::size_t found = 0;
    for (Instant& instant : instants_) {
        if (!is_among(instant, Moments::WithoutInside)) continue;
        StartSearch search(instant, subject_, instants_.size(), random_);
        search.anywhere(is_last);
        // In thin walls a point has less room than is looked for at first.
        if (instant.starts.empty() && is_last) search.behind(subject_.faces());
        report_.starts += instant.starts.size();
        found += instant.has_inside;
    }
    return found;
}

std::size_t EscapeTest::find_starts_behind()
{
    std::size_t found = 0;
    for (Instant& instant : instants_) {
        instant.starts.clear();
        found += StartSearch(instant, subject_, instants_.size(), random_).behind(not_met_);
    }
    report_.starts += found;
    return found;
}

bool EscapeTest::find_first_level()
{
    for (int level = subject_.level_of_rate(settings_.largest_rate);; --level) {
        dice(level, Moments::All);
        find_starts();
        if (has_starts()) return true;
        if (!has_finer_level(Moments::All)) return false;
    }
}

EscapeTest::View EscapeTest::next_view()
{
    // The first views go to each moment once, so that few rays see as many moments as they can.
    std::vector<Instant*> with_starts, unseen;
    for (Instant& instant : instants_) {
        if (instant.starts.empty()) continue;
        with_starts.push_back(&instant);
        if (!instant.is_seen) unseen.push_back(&instant);
    }
    const std::vector<Instant*>& of = unseen.empty() ? with_starts : unseen;
    Instant& instant = of.size() > 1 ? *pick(of, random_) : *of.front();
    instant.is_seen = true;
    const Start& start = pick(instant.starts, random_);
    const int coarsest = std::clamp(std::ilogb(start.reach), finest_ + 1, finest_ + kLevels);
    return {instant, start, coarsest, finest_ + static_cast<int>(random_() % static_cast<unsigned>(coarsest - finest_))};
}

accel::Ray EscapeTest::next_ray(const View& view)
{
    const auto& [instant, start, coarsest, level] = view;
    const Subject::Pair& pair = instant.pairs[static_cast<std::size_t>(level - finest_)];
    const bool is_at_face = start.face != kNoFace && (random_() & 1) != 0;
    const Target target = is_at_face ? any_target(Subject::Pair::of_face(pair.grids, start.face),
                                                  Subject::Pair::of_face(pair.hanging, start.face), random_)
                                     : any_target(pair.grids, pair.hanging, random_);
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
        a = std::max(0.0, at_hit - b * where);  // the difference may be rounded to less than nothing
    }
    accel::Ray ray;
    ray.time = instant.time;
    ray.origin = subject_.anchor_at(instant.time) + start.at;
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

}  // namespace occam
