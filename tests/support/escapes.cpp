#include "tests/support/escapes.h"

#include <random>
#include <sstream>

#include "accel/frame.h"
#include "verify/closed.h"

namespace occam::test {
namespace {

using Random = std::mt19937_64;
double uniform(Random& random) { return double(random() >> 11) * 0x1p-53; }

Vec3d any_direction(Random& random)
{
    while (true) {
        const Vec3d d{2 * uniform(random) - 1, 2 * uniform(random) - 1, 2 * uniform(random) - 1};
        const double l = glm::length(d);
        if (l > 0.1 && l <= 1) return d / l;
    }
}

/// Returns points inside: the winding number is above 0.9 there, and also at a thousandth of the cage's radius to all sides.
std::vector<Vec3d> inside_points(const std::vector<MeshTriangle>& mesh, std::size_t wanted, Random& random)
{
    Box3d box;
    std::vector<Vec3f> corners;
    for (const MeshTriangle& t : mesh)
        for (const Vec3f v : t.v) {
            box.add(Vec3d(v));
            if (!t.is_gap) corners.push_back(v);
        }
    std::vector<Vec3d> points;
    for (int attempt = 0; attempt < 400 && points.size() < wanted; ++attempt) {
        const Vec3d p = box.lo + box.extent() * Vec3d(uniform(random), uniform(random), uniform(random));
        // The points a little to all sides are tested too, so the point is not on a sheet that is folded onto itself.
        bool is_inside = true;
        for (int k = 0; k < 7 && is_inside; ++k) {
            Vec3d step(0);
            if (k > 0) step[(k - 1) / 2] = (k & 1 ? 1e-3 : -1e-3) * box.radius();
            is_inside = winding_number(corners, p + step) > 0.9;
        }
        if (is_inside) points.push_back(p);
    }
    return points;
}

// Returns a ray from a start to anywhere, to the middle of a gap triangle, to a vertex, or to a point of an edge. Aims are
// varied by an ulp.
accel::Ray aimed(Vec3d from, const std::vector<MeshTriangle>& mesh, const std::vector<const MeshTriangle*>& gaps,
                 Random& random)
{
    const double choice = uniform(random);
    Vec3d target = from + any_direction(random);
    if (choice < 0.3 && !gaps.empty()) {
        target = Vec3d(gaps[random() % gaps.size()]->v[1]);
    } else if (choice < 0.6) {
        const MeshTriangle& t = mesh[random() % mesh.size()];
        const Vec3d a(t.v[random() % 3]), b(t.v[random() % 3]);
        target = choice < 0.45 ? a : glm::mix(a, b, uniform(random));
    }
    accel::Ray ray;
    ray.origin = from;
    ray.direction = Vec3f(glm::normalize(target - from));
    // One component goes a step up or down, or stays.
    const auto axis = static_cast<int>(random() % 3);
    if (random() & 1) ray.direction[axis] = std::nextafterf(ray.direction[axis], random() & 1 ? 2.0f : -2.0f);
    return ray;
}

// Returns a line that says how to trace the ray again.
std::string replay_line(const accel::Ray& ray, int level)
{
    std::ostringstream out;
    out.precision(17);
    out << "origin " << ray.origin.x << ' ' << ray.origin.y << ' ' << ray.origin.z << " direction " << ray.direction.x << ' '
        << ray.direction.y << ' ' << ray.direction.z << " level " << level << '\n';
    return out.str();
}

/// Returns whether the ray was outside of the mesh before it met a front side: all winding numbers around one of the places
/// before the hit are low. Otherwise the surface folds there, or the ray grazes an outline.
/// corners   of the mesh, about `anchor`
bool was_out_before(const accel::Ray& ray, const accel::SurfaceHit& hit, const std::vector<Vec3f>& corners, Vec3d anchor,
                    double radius)
{
    const Vec3d along = glm::normalize(Vec3d(ray.direction));
    const Vec3d x = glm::normalize(glm::cross(along, std::abs(along.x) < 0.5 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)));
    const Vec3d y = glm::cross(along, x);
    for (const double part : {0x1p-1, 0x1p-4, 0x1p-8}) {
        const Vec3d before = ray.origin - anchor + along * (double(hit.t) * (1 - part));
        bool is_out = true;
        for (const Vec3d beside : {Vec3d(0), x, -x, y, -y})
            is_out = is_out && winding_number(corners, before + beside * (0x1p-18 * radius)) < 0.5;
        if (is_out) return true;
    }
    return false;
}

}  // namespace

EscapeCount count_escapes(const Cage& cage, const Mat4d& world_from_object, int exponent, std::uint64_t rays,
                          std::uint64_t seed, const TextureStore* textures)
{
    EscapeCount count;
    Random random(seed);
    DicedCage diced(cage, 0, world_from_object, textures);
    const int level = diced.level_of_largest_exponent(exponent);
    const std::vector<MeshTriangle> mesh = diced.triangles();
    const std::vector<Vec3d> starts = inside_points(mesh, mesh.size() > 100'000 ? 4 : 16, random);
    count.starts = starts.size();
    if (starts.empty()) return count;
    std::vector<const MeshTriangle*> gaps;
    for (const MeshTriangle& t : mesh)
        if (t.is_gap) gaps.push_back(&t);

    // The frame sees the cage at exactly that level, since the target edge length is constant.
    const accel::Frame frame(
        diced.scene(), diced.topologies(),
        {.eye = diced.posed.anchor, .pixel = {std::ldexp(1.0f, level), 0}, .mode = lod::LevelMode::PerInstance},
        {.textures = textures});
    accel::Tracer tracer(frame, std::size_t(1) << 30);

    std::vector<Vec3f> corners;
    Box3d box;
    for (const MeshTriangle& t : mesh)
        for (const Vec3f v : t.v) {
            box.add(Vec3d(v));
            if (!t.is_gap) corners.push_back(v);
        }
    int fronts_left = 8;  // a winding number takes as long as many rays, and a cage that folds has many front sides
    std::vector<accel::Ray> batch(2048);
    std::vector<accel::SurfaceHit> hits(batch.size());
    while (count.rays < rays) {
        for (accel::Ray& ray : batch) {
            ray = aimed(starts[random() % starts.size()], mesh, gaps, random);
            ray.origin += diced.posed.anchor;
        }
        tracer.closest(batch, hits);
        for (std::size_t i = 0; i < batch.size(); ++i) {
            const accel::SurfaceHit& hit = hits[i];
            if (hit.is_hit()) {
                const Vec3d all = hit.position + Vec3d(hit.normal_geometric) + Vec3d(hit.normal_shading);
                count.not_finite += !std::isfinite(all.x + all.y + all.z + hit.t);
                if (hit.back_side || fronts_left == 0) continue;
                --fronts_left;
                if (!was_out_before(batch[i], hit, corners, diced.posed.anchor, box.radius())) continue;
                ++count.met_again;
            }
            if (count.escaped++ < 5) count.replay += replay_line(batch[i], level);
        }
        count.rays += batch.size();
    }
    return count;
}

}  // namespace occam::test
