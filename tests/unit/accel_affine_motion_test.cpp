// Tests of cages that their nodes alone move: they are diced once, and rays are taken to them (lod/affine_motion.h). Those
// that become flat, or their mirror image, have vertices at keys instead.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>

#include "accel/frame.h"
#include "accel/tracer.h"
#include "lod/pose_cage.h"
#include "tests/support/campaign.h"
#include "tests/support/motions.h"
#include "tests/support/random_directions.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

constexpr std::size_t kMoreThanEnough = std::size_t(1) << 30;

Mat4d turned_about_y(double angle)
{
    Mat4d m(1);
    m[0] = Vec4d(std::cos(angle), 0, -std::sin(angle), 0);
    m[2] = Vec4d(std::sin(angle), 0, std::cos(angle), 0);
    return m;
}
struct PlacedMotion {
    const char* name;
    int segments;
    Mat4d (*matrix)(double tau);
    bool is_invertible;  ///< at all times
};
const PlacedMotion kPlacedMotions[] = {
    {"flies", 1, [](double tau) { return moved_by(Vec3d(3, 1, -2) * tau); }, true},
    {"turns by 20 degrees", 1, [](double tau) { return turned_about_y(0.35 * tau); }, true},
    {"turns by 170 degrees in one", 1, [](double tau) { return turned_about_y(2.967 * tau); }, true},
    {"turns by 180 degrees in one", 1, [](double tau) { return turned_about_y(3.14159265358979 * tau); }, false},
    {"turns by 360 degrees in eight", 8, [](double tau) { return turned_about_y(6.283 * tau); }, true},
    {"grows", 1, [](double tau) { return scaled_by(Vec3d(0.1 + 0.9 * tau)); }, true},
    {"shrinks along one axis", 2, [](double tau) { return scaled_by(Vec3d(1, 1, 1 - 0.9 * tau)); }, true},
    {"collapses", 1, [](double tau) { return scaled_by(Vec3d(1 - tau)); }, false},
    {"flattens", 1, [](double tau) { return scaled_by(Vec3d(1, 1 - tau, 1)); }, false},
    {"becomes its mirror image", 1, [](double tau) { return scaled_by(Vec3d(1, 1, 1 - 2 * tau)); }, false},
    {"collapses between two keys", 2, [](double tau) { return scaled_by(Vec3d(tau < 0.6 ? 1 : -1)); }, false},
};

// Returns a map that leans until its volume is a part of the product of its columns' lengths.
Mat4d leaning(double tau, double part)
{
    Mat4d m(1);
    m[1] = glm::mix(m[1], Vec4d(std::sqrt(1 - part * part), part, 0, 0), tau);
    return m;
}
// The least such part is 2^-10. A scaling has it where its last 256th begins at 1,024 times the size at which it ends.
const PlacedMotion kNearlyFlat[] = {
    {"leans to 2^-9", 1, [](double tau) { return leaning(tau, 0x1p-9); }, true},
    {"leans to 2^-11", 1, [](double tau) { return leaning(tau, 0x1p-11); }, false},
    {"flattens to 2^-17", 1, [](double tau) { return scaled_by(Vec3d(1, 1 - tau * (1 - 0x1p-17), 1)); }, true},
    {"flattens to 2^-19", 1, [](double tau) { return scaled_by(Vec3d(1, 1 - tau * (1 - 0x1p-19), 1)); }, false},
};

// A scene with one cage that moves, either by its node, or by its vertices, which are written at each key.
struct MovedStage {
    Scene scene;
    NodeId node;
    lod::TopologyCache topologies;
    accel::Frame frame;
    accel::Tracer tracer;

    static Motion motion_of(const PlacedMotion& of, bool is_written)
    {
        Motion motion{of.name, of.segments, {}, {}, {}, {}};
        if (is_written)
            motion.vertex = [&of](Vec3f p, double tau) { return Vec3f(Vec3d(of.matrix(tau) * Vec4d(Vec3d(p), 1))); };
        else motion.matrix = of.matrix;
        return motion;
    }
    MovedStage(const Cage& cage, const PlacedMotion& motion, bool is_written, const Mat4d& place,
               accel::TreeKind tree = accel::TreeKind::Auto)
        : node(add_moving(scene, cage, motion_of(motion, is_written), place)),
          frame((scene.refit(), scene), topologies,
                {.pixel = {1.0f / 64, 0}, .mode = lod::LevelMode::PerRay, .motion_edges = 0}, {.tree = tree}),
          tracer(frame, kMoreThanEnough)
    {
    }
    std::vector<accel::SurfaceHit> trace(std::span<const accel::Ray> rays)
    {
        std::vector<accel::SurfaceHit> hits(rays.size());
        tracer.closest(rays, hits);
        return hits;
    }
};

// spread   of the rays, in sizes of the box: those of a narrow beam travel in packets
std::vector<accel::Ray> rays_into(const Box3d& bounds, int count, double spread = 1)
{
    std::mt19937_64 bits(5);
    const auto random = [&] { return double(bits() >> 11) * 0x1p-53; };
    std::vector<accel::Ray> rays(static_cast<std::size_t>(count));
    for (accel::Ray& ray : rays) {
        ray.origin = bounds.centre() + Vec3d(0.3, 5, 6);
        const Vec3d aim(random(), random(), random());
        const Vec3d to = bounds.lo + bounds.extent() * (0.5 + (aim - 0.5) * spread + (1 - spread) * Vec3d(0.25, 0, 0));
        ray.direction = Vec3f(glm::normalize(to - ray.origin));
        ray.footprint = {0.01f, 0.01f};
        ray.time = random() < 0.3 ? static_cast<float>(std::round(random())) : static_cast<float>(random());
    }
    return rays;
}

void expect_use_where_invertible(std::span<const PlacedMotion> motions)
{
    for (const PlacedMotion& motion : motions) {
        const MovedStage stage(torus(), motion, false, Mat4d(1));
        const Node& node = stage.scene.node(stage.node);
        const CageSlot& slot = stage.scene.cage(node.cages.front());
        const std::vector<Mat4d> matrices = stage.scene.world_from_node_keys(stage.node);
        lod::TopologyCache topologies;
        Arena arena;
        lod::DeformCounters counters;
        lod::LevelSettings levels;
        levels.motion_edges = 0;
        const lod::PosedCage& posed = lod::pose_cage({slot, node, stage.node, nullptr, matrices, motion.segments}, levels,
                                                     {topologies.get(slot), nullptr, arena, counters});
        EXPECT_EQ(posed.still_pose != nullptr, motion.is_invertible) << motion.name;
    }
}

TEST(AffineMotion, IsUsedWhereMapsCanBeInvertedAtAllTimes)
{
    expect_use_where_invertible(kPlacedMotions);
    expect_use_where_invertible(kNearlyFlat);
}

// The same surface moves by its node, or by its vertices at keys: rays find the same but for rounding.
void expect_hits_of_written_vertices(const Cage& cage, const PlacedMotion& motion, const Mat4d& place)
{
    MovedStage placed(cage, motion, false, place), written(cage, motion, true, place);
    const auto rays = rays_into(placed.scene.bounds(), 4000);
    const auto ours = placed.trace(rays), others = written.trace(rays);
    int hits = 0, differ = 0, blended = 0, at_keys = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const accel::SurfaceHit &a = ours[i], &b = others[i];
        if (!a.is_hit() && !b.is_hit()) continue;
        const bool is_same = a.is_hit() == b.is_hit() && std::abs(a.t - b.t) < 1e-4f * b.t;
        differ += !is_same;
        if (!is_same || a.face != b.face || a.micropolygon != b.micropolygon) continue;
        ++hits;
        blended += a.blend > 0;
        ASSERT_LT(glm::distance(a.position, b.position), 1e-4 * double(b.t)) << motion.name;
        const Vec3d on_ray = rays[i].origin + Vec3d(rays[i].direction) * double(a.t);
        ASSERT_LT(glm::distance(a.position, on_ray), 1e-5 * double(b.t)) << motion.name;
        ASSERT_GT(glm::dot(a.normal_geometric, b.normal_geometric), 0.999f) << motion.name;
        ASSERT_EQ(a.back_side, b.back_side) << motion.name;
        ASSERT_LT(glm::length(a.velocity - b.velocity), 1e-3f * (1 + glm::length(b.velocity))) << motion.name;
        ASSERT_NEAR(a.blend, b.blend, 1e-3f) << motion.name;
        ASSERT_EQ(a.start_level, b.start_level) << motion.name;
        ASSERT_LT(glm::length(a.to_start - b.to_start), 1e-3f) << motion.name;
        // Between keys, the normals of written vertices are interpolated, which is not quite what the surface has. Means
        // of normals, which coarse levels have, change with the shape of a cage that is stretched.
        if ((rays[i].time > 0 && rays[i].time < 1) || a.blend > 0) continue;
        ++at_keys;
        ASSERT_GT(glm::dot(a.normal_shading, b.normal_shading), 0.9999f) << motion.name;
    }
    EXPECT_GT(hits, 400) << motion.name;
    EXPECT_GT(at_keys, 0) << motion.name;
    EXPECT_LE(differ, hits / 200) << motion.name;
    EXPECT_TRUE(blended > 50 || cage.scheme == Scheme::Triangles) << motion.name;
}

TEST(AffineMotion, KeepsTheInverseOfAMapThatOnlySlides)
{
    const lod::AffinePose first{{{0, -2, 0}, {0.5, 0, 0.25}, {0, 0.125, 3}}, {7, -1, 4}};
    lod::AffinePose slid = first, turned = first;
    slid.anchor = {8, 2, -3};
    turned.columns[1].y = 0.001;
    const lod::AffinePose slides[] = {first, slid, first}, turns[] = {first, slid, turned};
    const lod::AffineMotion sliding(slides), turning(turns);
    EXPECT_EQ(turning.fixed_inverse(), nullptr);
    ASSERT_NE(sliding.fixed_inverse(), nullptr);
    for (const float tau : {0.0f, 0.3f, 0.5f, 0.9f, 1.0f}) {
        EXPECT_EQ(sliding.at(tau).columns[1], first.columns[1]);
        if (tau <= 0.5f) {
            EXPECT_EQ(sliding.at(tau).anchor, turning.at(tau).anchor);
        }
        EXPECT_EQ(sliding.fixed_inverse()->apply({3, 1, -2}), lod::AffineInverse(sliding.at(tau)).apply({3, 1, -2}));
    }
}

TEST(AffineMotion, FindsTheHitsOfACageWhoseVerticesMoveTheSameWay)
{
    const Mat4d places[] = {Mat4d(1), moved_by({1e5, -2e4, 3e4}) * turned_about_y(0.7), scaled_by({-1, 1.5, 0.8})};
    for (const PlacedMotion& motion : kPlacedMotions)
        if (motion.is_invertible)
            for (const Mat4d& place : places) expect_hits_of_written_vertices(torus(), motion, place);
}

TEST(AffineMotion, FindsTheHitsOfAMeshWhoseVerticesMoveTheSameWay)
{
    for (const PlacedMotion& motion : kPlacedMotions)
        if (motion.is_invertible) expect_hits_of_written_vertices(torus_mesh(20, 14), motion, scaled_by({-1, 1.5, 0.8}));
}

void expect_same_bits(const PlacedMotion& motion, double spread)
{
    for (const Cage& cage : {torus(), prism(7), torus_mesh(20, 14)}) {
        MovedStage boxes(cage, motion, false, moved_by({7, 0, 0}), accel::TreeKind::Bvh),
            planes(cage, motion, false, moved_by({7, 0, 0}), accel::TreeKind::Kd);
        const auto rays = rays_into(boxes.scene.bounds(), 4000, spread);
        const auto a = boxes.trace(rays), b = planes.trace(rays);
        int hits = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            accel::SurfaceHit alone;
            planes.tracer.closest({&rays[i], 1}, {&alone, 1});
            for (const accel::SurfaceHit& other : {b[i], alone}) {
                ASSERT_EQ(std::bit_cast<std::uint32_t>(a[i].t), std::bit_cast<std::uint32_t>(other.t)) << i;
                ASSERT_TRUE(!a[i].is_hit() || (a[i].position == other.position && a[i].velocity == other.velocity &&
                                               a[i].normal_shading == other.normal_shading))
                    << i;
            }
            hits += a[i].is_hit();
        }
        EXPECT_GT(hits, 100) << motion.name << ' ' << spread;
    }
}

TEST(AffineMotion, FindsTheSameBitsAloneAndInPacketsAndInBothTrees)
{
    EveryNth some(2);
    for (const double spread : {1.0, 0.05})
        for (const std::size_t which : {0, 1, 4})
            if (some.takes()) expect_same_bits(kPlacedMotions[which], spread);
}

TEST(AffineMotion, TakesTheMemoryOfACageThatStands)
{
    const PlacedMotion still{"stands", 1, [](double) { return Mat4d(1); }, true};
    for (const Cage& cage : {torus(), torus_mesh(20, 14)}) {
        MovedStage standing(cage, still, false, Mat4d(1)), turning(cage, kPlacedMotions[4], false, Mat4d(1)),
            written(cage, kPlacedMotions[4], true, Mat4d(1));
        const auto rays = rays_into(standing.scene.bounds(), 4000);
        for (MovedStage* stage : {&standing, &turning, &written}) stage->trace(rays);
        const auto bytes = [](const MovedStage& stage) { return double(stage.tracer.counters().peak_bytes); };
        EXPECT_LT(bytes(turning), 1.5 * bytes(standing));
        EXPECT_GT(bytes(written), 3 * bytes(standing));
    }
}

// A cage that a matrix moves, or that stands where the matrix has it at one moment.
struct ScaledStage {
    Scene scene;
    lod::TopologyCache topologies;
    accel::Frame frame;
    accel::Tracer tracer;

    ScaledStage(const Cage& cage, const Motion& motion)
        : frame((add_moving(scene, cage, motion), scene.refit(), scene), topologies, settings()),
          tracer(frame, kMoreThanEnough)
    {
    }
    ScaledStage(const Cage& cage, const Mat4d& place)
        : frame((scene.add_node(scene.root(), {.matrix = place, .cages = {scene.add(cage)}}), scene.refit(), scene),
                topologies, settings()),
          tracer(frame, kMoreThanEnough)
    {
    }
    static lod::LevelSettings settings()
    {
        return {.pixel = {1.0f / 64, 0}, .mode = lod::LevelMode::PerRay, .motion_edges = 0};
    }
    std::vector<accel::SurfaceHit> trace(std::span<const accel::Ray> rays)
    {
        std::vector<accel::SurfaceHit> hits(rays.size());
        tracer.closest(rays, hits);
        return hits;
    }
};

std::vector<accel::Ray> rays_at(float time, int count)
{
    Random random(7);
    std::vector<accel::Ray> rays(static_cast<std::size_t>(count));
    for (accel::Ray& ray : rays) {
        ray.origin = {0.5, 5, 6};
        const double x = random() - 0.5, y = random() - 0.5, z = random() - 0.5;
        ray.direction = Vec3f(glm::normalize(Vec3d(x, y, z) * Vec3d(3, 2, 3) - ray.origin));
        ray.footprint = {0.01f, 0};
        ray.time = time;
    }
    return rays;
}

struct Scaling {
    const char* name;
    int segments;
    Vec3d from, to;
};
const Scaling kScalings[] = {
    {"flattens", 1, {1, 1, 1}, {1, 0.01, 1}},
    {"becomes its mirror image", 1, {1, 1, 1}, {1, -1, 1}},
    {"becomes its mirror image late", 1, {1, 1, 1}, {1, 1, -0.2}},
    {"turns over by two mirrorings", 1, {1, 2, 1}, {-2, -1, 1}},
    {"has a flat key", 2, {1, 1, 1}, {1, -1, 1}},
    {"grows from a point", 1, {0, 0, 0}, {1.5, 0.5, 1}},
};
Motion motion_of(const Scaling& of)
{
    return {of.name, of.segments, [of](double tau) { return scaled_by(glm::mix(of.from, of.to, tau)); }, {}, {}, {}};
}

// What a node alone moves has the shading normals of a cage that stands where it is at each moment. Before, unit normals
// were interpolated between keys.
TEST(MovingNormals, OfACageThatItsNodeAloneMovesAreThoseOfOneThatStandsThere)
{
    for (const Cage& cage : {torus(), torus_mesh(24, 16)})
        for (const Scaling& scaling : kScalings) {
            ScaledStage moving(cage, motion_of(scaling));
            int compared = 0;
            for (const float time : {0.05f, 0.2f, 0.35f, 0.6f, 0.85f, 1.0f}) {
                const auto rays = rays_at(time, 400);
                ScaledStage still(cage, scaled_by(glm::mix(scaling.from, scaling.to, double(time))));
                const auto a = moving.trace(rays), b = still.trace(rays);
                for (std::size_t i = 0; i < rays.size(); ++i) {
                    const bool is_same = a[i].is_hit() && b[i].is_hit() && std::abs(a[i].t - b[i].t) < 1e-3f &&
                                         glm::dot(a[i].normal_geometric, b[i].normal_geometric) > 0.99f;
                    if (!is_same) continue;
                    ++compared;
                    ASSERT_GT(glm::dot(a[i].normal_shading, b[i].normal_shading), 0.995f)
                        << scaling.name << " at " << time << (cage.scheme == Scheme::Triangles ? ", mesh" : "");
                    ASSERT_EQ(a[i].back_side, b[i].back_side) << scaling.name << " at " << time;
                }
            }
            EXPECT_GT(compared, 100) << scaling.name;
        }
}

TEST(MovingNormals, HaveTheSameBitsAloneAndInPackets)
{
    for (const Cage& cage : {torus(), torus_mesh(24, 16)}) {
        ScaledStage together(cage, motion_of(kScalings[1])), alone(cage, motion_of(kScalings[1]));
        const auto rays = rays_at(0.35f, 400);
        const auto hits = together.trace(rays);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const accel::SurfaceHit other = alone.trace({&rays[i], 1}).front();
            ASSERT_EQ(std::bit_cast<std::uint32_t>(hits[i].t), std::bit_cast<std::uint32_t>(other.t));
            ASSERT_TRUE(!other.is_hit() || hits[i].normal_shading == other.normal_shading);
        }
    }
}

// The cage is closed and its faces point outwards, so a ray from outside meets its outside first, also if a morph target
// deforms it, or a joint mirrors it.
TEST(MovingNormals, TheOutsideIsSeenWhileACageBecomesItsMirrorImage)
{
    for (const Scaling& scaling : kScalings)
        for (const int deformation : {0, 1, 2}) {
            Motion motion = motion_of(scaling);
            if (deformation == 1) motion.morph = [](double tau) { return 1e-4f * static_cast<float>(tau); };
            Scene scene;
            if (deformation == 2) {
                Cage skinned = torus();
                skinned.skin.sets = 1;
                skinned.skin.joints.assign(skinned.positions.size(), {0, 0, 0, 0});
                skinned.skin.weights.assign(skinned.positions.size(), {1, 0, 0, 0});
                Skin skin;
                const NodeId joint = scene.add_node(scene.root(), {});
                skin.joints = {joint};
                scene.add_node(scene.root(), {.cages = {scene.add(skinned)}, .skin = scene.add(std::move(skin))});
                scene.record_shutter(scaling.segments, [&](double tau) { scene.set_transform(joint, motion.matrix(tau)); });
            } else {
                add_moving(scene, torus(), motion);
            }
            scene.refit();
            lod::TopologyCache topologies;
            const accel::Frame frame(scene, topologies, ScaledStage::settings());
            accel::Tracer tracer(frame, kMoreThanEnough);
            int hits = 0, inside = 0;
            // A skin's sense is known at keys alone: it is asked for there, and near them.
            const std::vector<float> times = deformation == 2 ? std::vector{0.02f, 0.98f}
                                                              : std::vector{0.1f, 0.3f, 0.4f, 0.7f, 0.9f};
            for (const float time : times) {
                const auto rays = rays_at(time, 300);
                std::vector<accel::SurfaceHit> found(rays.size());
                tracer.closest(rays, found);
                for (const accel::SurfaceHit& hit : found) hits += hit.is_hit(), inside += hit.is_hit() && hit.back_side;
            }
            EXPECT_GT(hits, 30) << scaling.name;
            EXPECT_EQ(inside, 0) << scaling.name << ", deformation " << deformation << ", of " << hits;
        }
}

}  // namespace
}  // namespace occam::test
