// Tests that rays pass the holes of alpha masks, and hidden backs, within their traversal: they hit what repeated rays from
// hole to hole would.
#include <gtest/gtest.h>

#include <sstream>

#include "accel/frame.h"
#include "lod/hit_filter.h"
#include "tests/support/textured_floor.h"
#include "tests/support/tracer_stage.h"

namespace occam::test {
namespace {

using accel::TreeKind;

// Cuts holes by the place, and everything where the vertex colour is clear. May hide the backs of single-sided materials.
class Checks final : public lod::HitFilter {
public:
    explicit Checks(bool hides_backs = false) : hides_backs_(hides_backs) {}
    bool is_hole(const Material&, const lod::VertexToShade& at, Vec4f color) const noexcept override
    {
        if (color.w < 0.5f) return true;
        EXPECT_EQ(at.uv_width[0], 0);
        return (int(std::floor(at.uv[0].x * 7)) + int(std::floor(at.uv[0].y * 5))) % 2 != 0;
    }
    bool hides_back(const Material& material) const noexcept override { return hides_backs_ && !material.double_sided; }

private:
    bool hides_backs_;
};

void add_uvs(Cage& cage)
{
    UvSet uv;
    for (const Vec3f p : cage.positions) uv.values.push_back(Vec2f(p.x, p.y + 0.3f * p.z));
    cage.uv_sets = {uv};
}

// Adds sheets and rings with holes, of meshes and of subdivision surfaces, with others that have none.
std::vector<NodeId> add_leaves(Scene& scene)
{
    Material leaf;
    leaf.alpha_mode = AlphaMode::Mask;
    leaf.base_color_texture.texture = scene.add(waves(0));
    Cage ring = torus();
    add_uvs(ring);
    ring.materials = {scene.add(leaf)};
    ring.colors.assign(ring.positions.size(), Vec4f(1));
    ring.colors.front() = Vec4f(0);
    std::vector<NodeId> nodes;
    const CageId holed = scene.add(ring), whole = scene.add(torus());
    const CageId mesh = scene.add(floor_of(ring.materials[0], Scheme::Triangles)),
                 smooth = scene.add(floor_of(ring.materials[0], Scheme::CatmullClark));
    for (int k = 0; k < 40; ++k) {
        const double at = k * 0.037;
        nodes.push_back(place(scene, k % 3 == 0 ? smooth : mesh, {at, -1.5 + at, 0.3 * at}, 0.5 + 0.01 * k));
    }
    nodes.push_back(place(scene, holed, {0, 0, 0}));
    nodes.push_back(place(scene, holed, {1, 0.4, -1}, 0.7));
    nodes.push_back(place(scene, whole, {0, -2.5, 0}));
    return nodes;
}

accel::Frame frame_of(Stage& stage, const lod::HitFilter* filter, TreeKind tree, lod::LevelMode mode, int level = -4)
{
    stage.scene.refit();
    return accel::Frame(stage.scene, stage.topologies,
                        {.eye = Vec3d(0), .pixel = {std::ldexp(1.0f, level), 0}, .mode = mode},
                        {.shading = {nullptr, 1, filter}, .tree = tree});
}

std::vector<accel::Ray> rays_at(const Box3d& bounds, bool moves)
{
    std::vector<accel::Ray> rays = rays_towards({0.3, 3, 4}, bounds, 900, 7),
                            other = rays_towards({0, 0, 0}, bounds, 500, 8);
    std::mt19937 random(3);
    for (accel::Ray& ray : other) {
        // The levels that a ray sees depend on where it starts if its footprint shrinks.
        ray.footprint = {std::ldexp(1.0f, -int(random() % 7)), 0};
        if (random() % 4 == 0) ray.t_far = 1.5f;
    }
    rays.insert(rays.end(), other.begin(), other.end());
    if (moves)
        for (accel::Ray& ray : rays) ray.time = float(random() % 1000) * 0.001f;
    return rays;
}

constexpr int kMost = 3;

struct Answers {
    explicit Answers(std::size_t count) : hits(count), some(count * kMost), counts(count), first(count), occluded(count) {}
    void ask(accel::Tracer& tracer, std::span<const accel::Ray> rays, std::size_t from, std::size_t count)
    {
        const auto asked = rays.subspan(from, count);
        tracer.closest(asked, {&hits[from], count});
        tracer.nearest(asked, kMost, {&some[from * kMost], count * kMost}, {&counts[from], count});
        tracer.first_hits(asked, {&first[from], count});
        tracer.occluded(asked, {&occluded[from], count});
    }
    std::vector<accel::SurfaceHit> hits, some;
    std::vector<accel::HitCount> counts;
    std::vector<accel::FirstHit> first;
    std::vector<std::uint8_t> occluded;
};

// Sends each ray on from hole to hole until it has `kMost` hits.
Answers answers_by_restarts(accel::Tracer& whole, std::span<const accel::Ray> rays, const Checks& checks)
{
    Answers out(rays.size());
    std::size_t holes = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        accel::Ray ray = rays[i];
        for (int n = 0; n < kMost;) {
            accel::SurfaceHit hit;
            whole.closest({&ray, 1}, {&hit, 1});
            if (!hit.is_hit()) break;
            const lod::VertexToShade at{{hit.uv[0], hit.uv[1]}, {}};
            const bool is_hole = (hit.back_side && checks.hides_back(*hit.material)) ||
                                 (hit.material->alpha_mode == AlphaMode::Mask &&
                                  checks.is_hole(*hit.material, at, hit.color));
            // Another surface may lie within rounding behind a hole, and counts.
            ray.t_near = is_hole ? hit.t : accel::behind(hit.t);
            holes += is_hole;
            if (is_hole) continue;
            if (n == 0) {
                out.hits[i] = hit;
                out.first[i] = {hit.t, hit.node, hit.cage, hit.face};
                out.occluded[i] = 1;
            }
            out.some[i * kMost + std::size_t(n)] = hit;
            out.counts[i].count = static_cast<std::int16_t>(++n);
        }
    }
    EXPECT_GT(holes, rays.size());
    return out;
}

void expect_same(const Answers& expected, const Answers& found, const std::string& what)
{
    for (std::size_t i = 0; i < expected.hits.size(); ++i) {
        ASSERT_TRUE(same(expected.hits[i], found.hits[i]))
            << what << ", ray " << i << ": " << expected.hits[i].t << ", " << found.hits[i].t;
        ASSERT_EQ(expected.first[i].t, found.first[i].t) << what << ", ray " << i;
        ASSERT_EQ(expected.first[i].cage, found.first[i].cage) << what << ", ray " << i;
        ASSERT_EQ(expected.first[i].face, found.first[i].face) << what << ", ray " << i;
        ASSERT_EQ(expected.occluded[i], found.occluded[i]) << what << ", ray " << i;
        ASSERT_EQ(expected.counts[i].count, found.counts[i].count) << what << ", ray " << i;
        for (int n = 0; n < expected.counts[i].count; ++n) {
            const std::size_t at = i * kMost + std::size_t(n);
            ASSERT_TRUE(same(expected.some[at], found.some[at])) << what << ", ray " << i << ", hit " << n;
        }
    }
}

void expect_restarts(Stage& stage, lod::LevelMode mode, bool moves, const Checks& checks = Checks())
{
    const accel::Frame whole = frame_of(stage, nullptr, TreeKind::Auto, mode);
    const std::vector<accel::Ray> rays = rays_at(stage.scene.bounds(), moves);
    accel::Tracer restarted(whole, kPlenty);
    const Answers expected = answers_by_restarts(restarted, rays, checks);
    for (const TreeKind kind : {TreeKind::Kd, TreeKind::Bvh}) {
        const std::string what = "mode " + std::to_string(int(mode)) + ", tree " + std::to_string(int(kind));
        const accel::Frame frame = frame_of(stage, &checks, kind, mode);
        accel::Tracer together(frame, kPlenty), alone(frame, kPlenty);
        Answers found(rays.size()), found_alone(rays.size());
        found.ask(together, rays, 0, rays.size());
        expect_same(expected, found, what);
        for (std::size_t i = 0; i < rays.size(); ++i) found_alone.ask(alone, rays, i, 1);
        expect_same(expected, found_alone, what + ", alone");
        accel::Tracer tight(frame, together.counters().peak_bytes / 4);
        Answers found_tight(rays.size());
        found_tight.ask(tight, rays, 0, rays.size());
        expect_same(expected, found_tight, what + ", a quarter of the memory");
        EXPECT_GT(tight.counters().flushes, 0u);

        accel::SharedTree tree(frame, kPlenty);
        Answers found_shared(rays.size());
        ask_in_threads(tree, rays, 200, found_shared);
        expect_same(expected, found_shared, what + ", shared");
    }
}

TEST(Holes, ArePassedAsIfTheRayWereShotAgainFromEach)
{
    for (const lod::LevelMode mode : {lod::LevelMode::PerRay, lod::LevelMode::PerInstance}) {
        Stage stage;
        add_leaves(stage.scene);
        expect_restarts(stage, mode, false);
    }
}

TEST(Holes, AreNamedWhereARayIsObserved)
{
    Stage stage;
    add_leaves(stage.scene);
    const Checks checks(true);
    const accel::Frame frame = frame_of(stage, &checks, TreeKind::Auto, lod::LevelMode::PerRay);
    const std::vector<accel::Ray> rays = rays_at(stage.scene.bounds(), false);
    accel::Tracer tracer(frame, kPlenty), observer(frame, kPlenty);
    std::vector<accel::SurfaceHit> hits(rays.size());
    tracer.closest(rays, hits);
    int named = 0, backs = 0;
    for (std::size_t i = 0; i < rays.size(); i += 17) {
        std::ostringstream out;
        accel::SurfaceHit hit;
        observer.observe(rays[i], hit, &out);
        ASSERT_TRUE(same(hits[i], hit)) << "ray " << i;
        ASSERT_EQ(out.str().find("WAS NOT TESTED"), std::string::npos) << out.str();
        named += out.str().find(": a hole at t ") != std::string::npos;
        backs += out.str().find(": a hidden back at t ") != std::string::npos;
    }
    EXPECT_GT(named, 0);
    EXPECT_GT(backs, 0);
}

// Lets the nodes move to and fro while the shutter is open.
void move_nodes(Scene& scene, const std::vector<NodeId>& nodes)
{
    std::vector<Mat4d> places;
    for (const NodeId id : nodes) places.push_back(scene.node(id).parent_from_node);
    scene.record_shutter(2, [&](double tau) {
        for (std::size_t k = 0; k < nodes.size(); ++k) {
            const Trs moves{.translation = {0.3 * tau * std::cos(double(k)), 0.2 * tau, 0.3 * tau * std::sin(double(k))}};
            scene.set_transform(nodes[k], moves.matrix() * places[k]);
        }
    });
}

TEST(Holes, ArePassedAtTheTimeOfEachRayWhereThingsMove)
{
    Stage stage;
    move_nodes(stage.scene, add_leaves(stage.scene));
    expect_restarts(stage, lod::LevelMode::PerRay, true);
}

// Adds a surface of two sides and mirrored surfaces to the leaves.
std::vector<NodeId> add_leaves_of_two_sides(Scene& scene)
{
    std::vector<NodeId> nodes = add_leaves(scene);
    Material thin;
    thin.double_sided = true;
    Cage of_two_sides = torus();
    of_two_sides.materials = {scene.add(thin)};
    nodes.push_back(place(scene, scene.add(of_two_sides), {0.5, 1.5, 0.5}, 0.6));
    const CageId sheet = scene.add(floor_of(scene.add(Material()), Scheme::Triangles)), ring = scene.add(torus(9, 5));
    for (const double mirror : {1.0, -1.0}) {
        const auto add = [&](CageId cage, Vec3d at, double size) {
            NodeDesc desc;
            desc.place.translation = at;
            desc.place.scale = Vec3d(mirror, 1, 1) * size;
            desc.cages = {cage};
            nodes.push_back(scene.add_node(scene.root(), desc));
        };
        add(sheet, {0, 0.9 + 0.1 * mirror, 0}, 0.8);
        add(ring, {-0.4, 0.8, mirror}, 0.9);
    }
    return nodes;
}

TEST(Holes, HiddenBacksArePassedLikeHoles)
{
    for (const lod::LevelMode mode : {lod::LevelMode::PerRay, lod::LevelMode::PerInstance}) {
        Stage stage;
        add_leaves_of_two_sides(stage.scene);
        expect_restarts(stage, mode, false, Checks(true));
    }
}

TEST(Holes, HiddenBacksArePassedAtTheTimeOfEachRayWhereThingsMove)
{
    Stage stage;
    move_nodes(stage.scene, add_leaves_of_two_sides(stage.scene));
    expect_restarts(stage, lod::LevelMode::PerRay, true, Checks(true));
}

// Sheets of which nothing is left change no picture, and no ray is shot again behind them.
TEST(Holes, CostNoRaysHoweverManySheetsHaveThem)
{
    TexturedFloor world(Scheme::Triangles, [](Scene&) { return Material(); });
    Material leaf;
    leaf.alpha_mode = AlphaMode::Mask;
    leaf.base_color.w = 0.25f;
    const MaterialId leaves = world.scene.add(leaf);
    std::vector<NodeId> sheets;
    for (const Scheme scheme : {Scheme::Triangles, Scheme::CatmullClark}) {
        const CageId sheet = world.scene.add(floor_of(leaves, scheme));
        for (int k = 0; k < 12; ++k) sheets.push_back(place(world.scene, sheet, {0, 0.02 * (k + 1), 0}));
    }
    const Image through = world.picture({});
    const FrameStats many = world.stats;
    for (const NodeId id : sheets) world.scene.set_visible(id, false);
    const Image without = world.picture({});
    EXPECT_EQ(through.checksum(), without.checksum());
    EXPECT_EQ(many.rays.primary, world.stats.rays.primary);
    EXPECT_EQ(many.rays.shadow, world.stats.rays.shadow);
}

}  // namespace
}  // namespace occam::test
