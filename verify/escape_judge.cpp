// Judges what the rays of an escape test do.
#include <algorithm>
#include <cmath>

#include "lod/ray_levels.h"
#include "verify/escape_test.h"
#include "verify/ray_surface.h"

namespace occam {

void EscapeTest::judge(const accel::Ray& ray, const accel::SurfaceHit& hit)
{
    if (hit.is_hit()) {
        const Vec3d all = hit.position + Vec3d(hit.normal_geometric) + Vec3d(hit.normal_shading);
        report_.not_finite += !std::isfinite(all.x + all.y + all.z + hit.t);
        is_met_[hit.face] = true;
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
    count_escape(ray);
}

void EscapeTest::count_escape(const accel::Ray& ray)
{
    ++report_.escaped;
    if (report_.replay.size() >= 5) return;
    const RayLine line{number_,         ray.origin * scale_.to_world(),
                       ray.direction,   double(ray.footprint.a) * scale_.to_world(),
                       ray.footprint.b, ray.time,
                       finest_};
    report_.replay.push_back(line.text());
}

void EscapeTest::judge_front_side(const accel::Ray& ray, const accel::SurfaceHit& hit)
{
    if (!silhouettes_)
        silhouettes_ = std::make_unique<Silhouettes>(subject_.scene(), subject_.topologies(), levels_, textures_,
                                                     subject_.posed().radius);
    const bool is_silhouette = silhouettes_->explain(ray);
    // A winding number takes as long as thousands of rays, and a cage that folds has many front sides.
    constexpr int kMostExamined = 8;
    int& examined = is_silhouette ? silhouettes_examined_ : front_sides_examined_;
    if (examined < kMostExamined) {
        ++examined;
        const bool begins_inside = std::abs(winding_of(ray)) >= 0.5;
        if (!begins_inside && !is_silhouette) {
            ++report_.outside;
            return;
        }
        if (begins_inside && was_out_before(ray, hit)) {
            if (is_grazing(ray)) ++report_.grazing;
            else count_escape(ray);
            return;
        }
    }
    if (is_silhouette) {
        ++report_.silhouettes;
        return;
    }
    ++report_.front_side;
    report_.worst_front = std::max(report_.worst_front, -double(glm::dot(hit.normal_geometric, ray.direction)));
}

bool EscapeTest::was_out_before(const accel::Ray& ray, const accel::SurfaceHit& hit)
{
    const Vec3d along = glm::normalize(Vec3d(ray.direction));
    const Vec3d aside = std::abs(along.x) < 0.5 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0);
    const Vec3d x = glm::normalize(glm::cross(along, aside)), y = glm::cross(along, x);
    const double step = 0x1p-18 * double(subject_.radius_at(ray.time));
    // Meshes finer than the finest of the test are not looked at, and displacement makes them another surface.
    const auto is_finer = [&](double t) {
        return double(ray.footprint.a) + double(ray.footprint.b) * t < double(lod::edge_length(finest_));
    };
    if (is_finer(double(hit.t))) return false;
    for (const double part : {0x1p-1, 0x1p-4, 0x1p-8}) {
        const double t = double(hit.t) * (1 - part);
        if (is_finer(t)) continue;
        const Vec3d before = along * t;
        const auto is_out = [&](Vec3d beside) { return std::abs(winding_of(ray, before + step * beside)) < 0.5; };
        if (is_out(Vec3d(0)) && is_out(x) && is_out(-x) && is_out(y) && is_out(-y)) return true;
    }
    return false;
}

bool EscapeTest::make_table(const accel::Ray& ray, lod::RayLevels<float>& table) const
{
    const float far = 4 * subject_.radius_at(ray.time);
    // The tree's frame is about the eye, which a cage may leave far behind.
    const float coordinate = std::max(far, static_cast<float>(glm::distance(ray.origin, levels_.eye)));
    if (!table.set({ray.footprint.a, ray.footprint.b}, 0, far, coordinate, levels_)) return false;
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

double EscapeTest::winding_of(const accel::Ray& ray, Vec3d from_start)
{
    lod::RayLevels<float> table;
    if (!make_table(ray, table)) return 1;
    const Vec3d from = ray.origin - subject_.anchor_at(ray.time);
    return winding_number_of_ray(from + from_start, from, glm::normalize(Vec3d(ray.direction)), table, finest_,
                                 [&](int level) -> const std::vector<lod::LevelGrid>& {
                                     auto [at, is_new] = diced_.try_emplace({ray.time, level});
                                     if (is_new) at->second = subject_.dice(level, ray.time).grids;
                                     return at->second;
                                 });
}

}  // namespace occam
