// Tests of surfaces as rays with footprints see them: they converge, they do not pop, and little is built for them.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

#include "accel/frame.h"
#include "accel/tracer.h"
#include "render/camera_rays.h"
#include "tests/support/diced_mesh.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

struct World {
    explicit World(const Cage& cage)
    {
        place(scene, scene.add(cage), {0, 0, 0});
        scene.refit();
    }
    Scene scene;
    lod::TopologyCache topologies;
};

/// Returns lines that hit the torus, most of them not at grazing angles.
std::vector<accel::Ray> lines(int count)
{
    std::mt19937_64 random(5);
    const auto uniform = [&](double low, double high) { return low + (high - low) * double(random() >> 11) * 0x1p-53; };
    std::vector<accel::Ray> rays(static_cast<std::size_t>(count));
    for (accel::Ray& ray : rays) {
        const double a = uniform(0, 6.28318), r = uniform(0.85, 1.15);
        const Vec3d target{r * std::cos(a), 0, r * std::sin(a)};
        ray.direction = Vec3f(glm::normalize(Vec3d(uniform(-0.3, 0.3), -1, uniform(-0.3, 0.3))));
        ray.origin = target - Vec3d(ray.direction) * 3.0;
    }
    return rays;
}

TEST(Levels, ConvergeWithTheSquareOfTheWantedEdge)
{
    World world(torus(12, 8));
    const accel::Frame frame(world.scene, world.topologies, {.eye = {0, 3, 0}, .pixel = {1, 0}});
    accel::Tracer tracer(frame, std::size_t(1) << 30);
    std::vector<accel::Ray> rays = lines(1000);
    std::vector<accel::SurfaceHit> exact(rays.size()), hits(rays.size());
    for (accel::Ray& ray : rays) ray.footprint = {0x1p-11f, 0};
    tracer.closest(rays, exact);

    // The exponent comes from least squares of log2(error) over log2(edge), in steps of a third of a level.
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (double x = -7; x <= -2.9; x += 1.0 / 3) {
        for (accel::Ray& ray : rays) ray.footprint = {float(std::exp2(x)), 0};
        tracer.closest(rays, hits);
        double sum = 0;
        int count = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (!exact[i].is_hit() || !hits[i].is_hit()) continue;
            sum += (double(hits[i].t) - exact[i].t) * (double(hits[i].t) - exact[i].t);
            ++count;
        }
        ASSERT_GT(count, 900);
        const double y = 0.5 * std::log2(sum / count);
        n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y;
    }
    const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
    RecordProperty("slope", std::to_string(slope));
    EXPECT_NEAR(slope, 2, 0.2);
}

// Returns how far the vertices of each pair of levels move at most from fine to coarse.
std::map<int, double> largest_moves(const Cage& cage)
{
    std::map<int, double> moves;
    DicedCage diced(cage, 0);
    const int finest = diced.level_of_largest_exponent(6);
    for (int level = finest; level <= finest + 12; ++level) {
        diced.posed.level = level;
        for (const lod::TileRef& tile : diced.tiles()) {
            const lod::PatchScale scale = diced.dicer.scale(diced.posed, tile.patch);
            const lod::LevelGrid pair = diced.dicer.dice_pair(diced.posed, tile, scale.rates(level + 1), diced.arena);
            for (int j = 0; j <= tile.rows; ++j)
                for (int i = 0; i <= tile.columns; ++i)
                    moves[level] = std::max(moves[level],
                                            double(glm::distance(pair.vertex(i, j), pair.coarse_at(pair.index(i, j)))));
        }
        diced.arena.reset();
    }
    return moves;
}

// A ray's origin moves towards its hit by a thousandth of the distance. The line stays the same, so the hit moves because of
// the level of detail alone. The target edge length e at the hit falls by a thousandth. With w = smoothstep(x), x = (e - d)
// / d and e < 2 d, x changes by at most 0.002 and w by 1.5 times that; margins make x steeper by (1 - 2 margin / length)^-1
// = 1.02 for this beam. A vertex moves by at most that share of delta, the grid's largest distance from fine to coarse, and
// the hit moves along the ray by as much over the cosine.
TEST(Levels, DoNotPop)
{
    World world(torus(12, 8));
    const accel::Frame frame(world.scene, world.topologies, {.eye = {0, 3, 0}, .pixel = {1, 0}});
    accel::Tracer tracer(frame, std::size_t(1) << 30);
    const std::vector<accel::Ray> start = lines(200);
    std::vector<accel::Ray> rays = start;
    std::vector<accel::SurfaceHit> before(rays.size()), hits(rays.size());
    const std::map<int, double> deltas = largest_moves(torus(12, 8));
    int changes = 0;
    double worst = 0;
    double distance = 512;
    for (; distance > 4; distance *= 0.999) {
        for (std::size_t i = 0; i < rays.size(); ++i) {
            rays[i].origin = start[i].origin + Vec3d(start[i].direction) * (3 - distance);
            rays[i].footprint = {0, 1.0f / 500};
        }
        tracer.closest(rays, hits);
        for (std::size_t i = 0; i < rays.size() && distance < 511.9; ++i) {
            ASSERT_TRUE(hits[i].is_hit());
            changes += i == 0 && hits[i].level != before[i].level;
            const double cosine = std::fabs(glm::dot(hits[i].normal_geometric, rays[i].direction));
            if (cosine < 0.3) continue;
            // The vertices of levels finer than those measured move by less.
            const double delta = deltas.lower_bound(std::max(hits[i].level, before[i].level))->second;
            const double bound = 1.5 * 0.002 * 1.02 * delta / cosine + 1e-5;
            const double moved = glm::distance(hits[i].position, before[i].position);
            worst = std::max(worst, moved / bound);
            ASSERT_LE(moved, bound) << "at distance " << distance << ", level " << before[i].level << " to "
                                    << hits[i].level;
        }
        before = hits;
    }
    EXPECT_GE(changes, 6);
    RecordProperty("worst_over_bound", std::to_string(worst));
}

// The test counts the quads built for each cell of a shading rate's size on the visible surface, over a range of distances.
// Powers of two in both directions and pairs of levels give 4.7 for a surface that is seen as a whole; tiles half out of
// sight add to it.
TEST(Levels, BuildFewMicropolygonsForWhatIsVisible)
{
    World world(torus(24, 12, false));
    double built = 0, cells = 0;
    for (double distance = 3.5; distance < 7; distance *= std::exp2(1.0 / 6)) {
        const Camera camera = Camera::look_at({0, distance, 0.01}, {0, 0, 0}, {0, 0, 1}, 0.8f);
        const render::CameraRays view(camera, 256, 256);
        const accel::Frame frame(world.scene, world.topologies, view.levels(1));
        accel::Tracer tracer(frame, std::size_t(1) << 30);
        std::vector<accel::Ray> rays;
        for (int y = 0; y < 256; ++y)
            for (int x = 0; x < 256; ++x) rays.push_back(view.ray(x + 0.5, y + 0.5));
        std::vector<accel::SurfaceHit> hits(rays.size());
        tracer.closest(rays, hits);
        for (std::size_t i = 0; i < rays.size(); ++i)
            if (hits[i].is_hit())
                cells += 1 / std::max(0.1f, std::fabs(glm::dot(hits[i].normal_shading, rays[i].direction)));
        built += double(tracer.counters().micropolygons) / 2;
    }
    RecordProperty("quads_per_cell", std::to_string(built / cells));
    EXPECT_LE(built / cells, 6);
}

// What lies far away must not make anything near the camera finer: neither a large cage nor the numbers of a large world.
TEST(Levels, BuildNoMoreInAMuchLargerWorld)
{
    const Camera camera = Camera::look_at({0.9, 0, 0.05}, {0.8, 0.1, -1}, {0, 1, 0}, 1.5f);
    const render::CameraRays view(camera, 32, 32);
    std::vector<accel::Ray> rays;
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x) rays.push_back(view.ray(x + 0.5, y + 0.5));
    struct Built {
        std::uint64_t micropolygons, grids;
    };
    const auto build = [&](double size, const Vec3d& place) {
        World world(torus(24, 12));
        NodeDesc far;
        far.cages = {world.scene.add(torus(6, 4))};
        far.place.translation = place;
        far.place.scale = Vec3d(size);
        world.scene.add_node(world.scene.root(), far);
        world.scene.refit();
        const accel::Frame frame(world.scene, world.topologies, view.levels(1));
        accel::Tracer tracer(frame, std::size_t(1) << 30);
        std::vector<accel::SurfaceHit> hits(rays.size());
        tracer.closest(rays, hits);
        for (const accel::SurfaceHit& hit : hits) EXPECT_TRUE(hit.is_hit());
        return Built{tracer.counters().micropolygons, tracer.counters().grids};
    };
    const Built alone = build(1, {4, 0, 0});
    for (const double size : {1.0, 1e6}) {
        const Built in_large = build(size, {4e7, 3e7, -2e7});
        EXPECT_LE(double(in_large.micropolygons), 1.1 * double(alone.micropolygons)) << "size " << size;
        EXPECT_LE(double(in_large.grids), 1.1 * double(alone.grids)) << "size " << size;
    }
}

// Nor must it make anything near coarser: a ray has a limited number of pairs of levels (RayLevels::kMostOfRay).
TEST(Levels, AreAsFineUnderADistantSkyOfTriangles)
{
    const Camera camera = Camera::look_at({0, 1.5, 2.5}, {0, 0, 0}, {0, 1, 0}, 0.8f);
    const render::CameraRays view(camera, 32, 32);
    std::vector<accel::Ray> rays;
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x) rays.push_back(view.ray(x + 0.5, y + 0.5));
    const auto hits_with = [&](double sky, int siblings) {
        World world(torus(24, 12));
        for (int k = 0; k < siblings; ++k) place(world.scene, world.scene.add(torus(6, 4)), {0.1 * k, -3, 0}, 0.05);
        if (sky > 0) place(world.scene, world.scene.add(torus_mesh(9, 5)), {0, 0, 0}, sky);
        world.scene.refit();
        const accel::Frame frame(world.scene, world.topologies, view.levels(1));
        accel::Tracer tracer(frame, std::size_t(1) << 30);
        std::vector<accel::SurfaceHit> hits(rays.size());
        tracer.closest(rays, hits);
        return hits;
    };
    for (const int siblings : {0, 40, 5000}) {
        const std::vector<accel::SurfaceHit> alone = hits_with(0, siblings);
        for (const double sky : {1e4, 1e6, 1e8}) {
            const std::vector<accel::SurfaceHit> under_sky = hits_with(sky, siblings);
            int both = 0;
            for (std::size_t i = 0; i < rays.size(); ++i) {
                if (!alone[i].is_hit() || !(under_sky[i].t < 10)) continue;
                ++both;
                EXPECT_NEAR(under_sky[i].t, alone[i].t, 1e-5) << "sky " << sky << ", ray " << i;
            }
            EXPECT_GT(both, 200);
        }
    }
}

// A tree that has grown for fine rays has cells that small things fill, beside which the parts of a smooth cage lie. At
// coarse pairs, whose chords are far inside the arc, the cage may be in those cells.
TEST(Levels, AreMetByWideRaysWhereFinerRaysHaveBeen)
{
    std::mt19937_64 random(3);
    const auto uniform = [&] { return double(random() >> 11) * 0x1p-53; };
    Scene scene;
    lod::TopologyCache topologies;
    place(scene, scene.add(creased_cube(0)), {0, 0, 0});
    const CageId small = scene.add(torus_mesh(60, 30));
    const Vec3d middle{0, 0, 0.55};
    const auto near_middle = [&] { return middle + Vec3d(uniform() - 0.5, uniform() - 0.5, uniform() - 0.5) * 0.3; };
    for (int k = 0; k < 12; ++k) place(scene, small, near_middle(), 0.02 + 0.03 * uniform());
    scene.refit();
    const auto rays_of_width = [&](float width) {
        std::vector<accel::Ray> rays(5000);
        for (accel::Ray& ray : rays) {
            ray.origin = near_middle();
            const double up = uniform() < 0.5 ? -1 : 1;
            ray.direction = Vec3f(glm::normalize(Vec3d(uniform() * 0.4 - 0.2, uniform() * 0.4 - 0.2, up)));
            if (uniform() < 0.5) ray.t_far = 0.1f;
            ray.footprint = {width, 0};
        }
        return rays;
    };
    const auto answers = [](accel::Tracer& tracer, std::span<const accel::Ray> rays) {
        std::vector<accel::SurfaceHit> hits(rays.size());
        tracer.closest(rays, hits);
        std::vector<float> t;
        for (const accel::SurfaceHit& hit : hits) t.push_back(hit.t);
        return t;
    };
    for (const accel::TreeKind tree : {accel::TreeKind::Kd, accel::TreeKind::Bvh}) {
        const accel::Frame frame(scene, topologies, {.pixel = {0x1p-9f, 0}}, {.tree = tree});
        accel::Tracer old(frame, std::size_t(1) << 30);
        answers(old, rays_of_width(0x1p-10f));
        for (const float width : {0.25f, 1.0f, 2.0f}) {
            const std::vector<accel::Ray> rays = rays_of_width(width);
            accel::Tracer fresh(frame, std::size_t(1) << 30);
            EXPECT_EQ(answers(old, rays), answers(fresh, rays)) << "width " << width;
        }
    }
}

}  // namespace
}  // namespace occam::test
