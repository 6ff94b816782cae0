// Tests of deformed cages: vertices beside the formulas of glTF 2.0 in their plainest form, and bounds that hold them.
#include <gtest/gtest.h>

#include <random>

#include "lod/pose_cage.h"
#include "lod/topology_cache.h"
#include "occam/occam.h"
#include "tests/support/shape_builders.h"
#include "tests/support/shared_data.h"

namespace occam {
namespace {

// Returns one vertex in world axes, as sec. 3.7.3.3 of the specification defines it: by global transforms of joints.
Vec3d skinned_vertex(const Scene& scene, const Node& node, NodeId id, const Cage& cage, std::uint32_t v)
{
    Vec3d p(cage.positions[v]);
    const auto& weights = node.morph_weights.empty() ? cage.morph_weights : node.morph_weights;
    for (std::size_t k = 0; k < cage.morph_targets.size(); ++k)
        if (!cage.morph_targets[k].positions.empty()) p += Vec3d(cage.morph_targets[k].positions[v]) * double(weights[k]);
    if (!node.skin || cage.skin.sets == 0) return transform_point(scene.world_from_node(id), p);
    const Skin& skin = scene.skin(node.skin);
    Vec3d sum(0);
    double total = 0;
    for (int set = 0; set < cage.skin.sets; ++set)
        for (int k = 0; k < 4; ++k) {
            const std::size_t at = std::size_t(set) * cage.positions.size() + v;
            const std::size_t joint = cage.skin.joints[at][k];
            const double w = cage.skin.weights[at][k];
            const Mat4d bind = skin.joint_from_mesh.empty() ? Mat4d(1) : skin.joint_from_mesh[joint];
            if (w > 0) sum += transform_point(scene.world_from_node(skin.joints[joint]) * bind, p) * w;
            total += w;
        }
    return sum / total;
}

bool holds(const Box3d& box, Vec3d p, double slack)
{
    return glm::all(glm::greaterThanEqual(p, box.lo - slack)) && glm::all(glm::lessThanEqual(p, box.hi + slack));
}

// Checks all deformed cages of a scene at this moment: they follow the formulas and lie inside their bounds.
void expect_true_to_formulas(Scene& scene, const char* what)
{
    scene.refit();
    lod::TopologyCache topologies;
    Arena arena;
    lod::DeformCounters counters;
    const Box3d whole = scene.bounds();
    scene.for_each_placement([&](NodeId id, const Node& node, const Mat4d& world) {
        for (const CageId c : node.cages) {
            const CageSlot& slot = scene.cage(c);
            const SkinSlot* skin = scene.find(node.skin);
            const lod::CageTables& tables = topologies.get(slot);
            const lod::PosedCage& posed = lod::pose_cage({slot, node, id, skin, {&world, 1}}, {},
                                                         {tables, nullptr, arena, counters});
            const Box3d box = transform_box(world, cage_bounds(node, slot, skin));
            // Vertices are rounded to float in a frame of the cage's size, and the formulas add in another order.
            const double slack = 1e-6 * double(posed.radius) + 1e-12 * whole.largest_coordinate();
            std::vector<Vec3d> vertices;
            for (std::uint32_t v = 0; v < slot.cage.positions.size(); ++v) {
                const Vec3d wanted = skinned_vertex(scene, node, id, slot.cage, v),
                            found = Vec3d(posed.vertex(v)) + posed.anchor;
                ASSERT_TRUE(std::isfinite(glm::dot(found, found))) << what << ' ' << node.name << ' ' << v;
                ASSERT_LE(glm::distance(found, wanted), 2 * slack) << what << ' ' << node.name << ' ' << v;
                ASSERT_TRUE(holds(box, wanted, 1e-9 * whole.radius())) << what << ' ' << node.name << ' ' << v;
                ASSERT_TRUE(holds(whole, wanted, 1e-9 * whole.radius())) << what << ' ' << node.name << ' ' << v;
                vertices.push_back(wanted);
            }
            for (std::uint32_t n = 0; n < posed.clusters->node_count(); ++n) {
                const Box3d cluster = posed.world_box(n);
                for (std::uint32_t k = posed.clusters->node(n).begin; k < posed.clusters->node(n).end; ++k) {
                    if (slot.cage.scheme != Scheme::Triangles) continue;
                    for (std::size_t corner = 0; corner < 3; ++corner)
                        ASSERT_TRUE(holds(
                            cluster, vertices[slot.cage.face_vertices[std::size_t(posed.clusters->face(k)) * 3 + corner]],
                            1e-9 * whole.radius()))
                            << what << " cluster " << n;
                }
            }
        }
    });
}

class Characters : public testing::TestWithParam<std::tuple<const char*, std::size_t>> {};

TEST_P(Characters, PlayAllTheirClipsInsideTheirBounds)
{
    // The characters are files of others, which the repository does not hold; Deformation tests poses of made ones.
    if (test::shared_data().empty()) GTEST_SKIP() << "the shared folder is absent: its characters are not tested";
    const auto [file, clips] = GetParam();
    Scene scene = load(test::shared_data() / "data/gltf" / file);
    ASSERT_EQ(scene.clips().size(), clips);
    for (const ClipId clip : scene.clips()) {
        const TimeRange range = time_range(scene.clip(clip));
        EXPECT_FALSE(scene.clip(clip).channels.empty());
        for (const double share : {0.0, 0.37, 0.81}) {
            scene.pose(clip, range.first + share * (range.last - range.first));
            expect_true_to_formulas(scene, scene.clip(clip).name.c_str());
            if (HasFatalFailure()) return;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Shared, Characters,
                         testing::Values(std::tuple("skinned/Knight/Knight.glb", 76u),
                                         std::tuple("skinned/Robot/robot.glb", 14u), std::tuple("skinned/Fox/Fox.gltf", 3u),
                                         std::tuple("skinned/CesiumMan/CesiumMan.glb", 1u),
                                         std::tuple("morph/MorphStressTest/MorphStressTest.gltf", 3u)));

// Holds a torus of three joints that turn about each other, with a bump that grows.
struct Eel {
    Scene scene;
    NodeId whole, body, joints[3];

    explicit Eel(Scheme scheme = Scheme::CatmullClark)
    {
        Cage cage = test::torus(24, 12, false);
        const std::size_t n = cage.positions.size();
        cage.scheme = scheme;
        cage.skin = {1, std::vector<glm::u16vec4>(n), std::vector<Vec4f>(n)};
        cage.morph_targets = {{"bump", std::vector<Vec3f>(n), {}}};
        cage.morph_weights = {0};
        for (std::size_t v = 0; v < n; ++v) {
            const float x = (cage.positions[v].x + 1.4f) / 2.8f;
            cage.skin.joints[v] = {0, 1, 2, 0};
            cage.skin.weights[v] = {(1 - x) * (1 - x), 2 * x * (1 - x), x * x, 0};
            cage.morph_targets[0].positions[v] = {0, x > 0.6f ? 0.5f : 0.0f, 0};
        }
        whole = scene.add_node(scene.root(), {});
        for (int j = 0; j < 3; ++j) {
            NodeDesc desc;
            desc.place.translation = {j == 0 ? 0.0 : 0.7, 0, 0};
            joints[j] = scene.add_node(j == 0 ? whole : joints[j - 1], desc);
        }
        Skin skin;
        skin.joints.assign(joints, joints + 3);
        for (int j = 0; j < 3; ++j) {
            Mat4d bind(1);
            bind[3] = Vec4d(-0.7 * j, 0, 0, 1);
            skin.joint_from_mesh.push_back(bind);
        }
        NodeDesc desc;
        // This transform has no effect, because the node is skinned.
        desc.place = {.translation = {3, 2, 1}, .rotation = {0, 0.6, 0, 0.8}, .scale = {1, 2, 3}};
        desc.cages = {scene.add(std::move(cage))};
        desc.skin = scene.add(std::move(skin));
        body = scene.add_node(whole, desc);
    }
    void bend(double angle)
    {
        for (int j = 1; j < 3; ++j)
            scene.set_transform(
                joints[j], Trs{.translation = {0.7, 0, 0}, .rotation = {0, 0, std::sin(angle / 2), std::cos(angle / 2)}});
    }
};

TEST(Deformation, FollowsJointsThatTheApplicationMoves)
{
    Eel eel;
    for (const double angle : {0.0, 0.4, -1.5}) {
        eel.bend(angle);
        eel.scene.set_morph_weights(eel.body, {float(angle)});
        expect_true_to_formulas(eel.scene, "eel");
    }
    eel.scene.set_transform(eel.body, Trs{.translation = {9, 9, 9}});
    expect_true_to_formulas(eel.scene, "its own place does not count");
    eel.scene.set_transform(eel.joints[0], Trs{.translation = {-4, 0, 0}, .scale = Vec3d(2)});
    expect_true_to_formulas(eel.scene, "moved as a whole");
    EXPECT_THROW(eel.scene.set_morph_weights(eel.body, {NAN}), Error);
}

// The surface of a deformed cage, with its rates and tiles, equals that of a cage into which the application wrote the
// deformed vertices.
TEST(Deformation, ShowsWhatWrittenVerticesWouldShow)
{
    const Camera camera = Camera::look_at({0.5, 2, 4}, {0.5, 0, 0}, {0, 1, 0}, 0.8f);
    const Settings settings{.width = 96, .height = 72, .spp = 1, .jitter = false, .aovs = Aov::Depth | Aov::Normal};
    for (const Scheme scheme : {Scheme::CatmullClark, Scheme::Bilinear}) {
        Eel eel(scheme);
        eel.bend(0.7);
        eel.scene.set_morph_weights(eel.body, {0.5f});
        const CageId id = eel.scene.node(eel.body).cages[0];
        Cage written = eel.scene.cage(id).cage;
        for (std::uint32_t v = 0; v < written.positions.size(); ++v)
            written.positions[v] = Vec3f(
                skinned_vertex(eel.scene, eel.scene.node(eel.body), eel.body, eel.scene.cage(id).cage, v));
        written.skin = {};
        written.morph_targets.clear();
        Scene plain;
        test::place(plain, plain.add(written), {0, 0, 0});
        Renderer renderer;
        const Image a = renderer.render(eel.scene, camera, settings);
        EXPECT_GT(renderer.stats().built.vertices_deformed, 0u);
        const Image b = renderer.render(plain, camera, settings);
        EXPECT_EQ(renderer.stats().built.vertices_deformed, 0u);
        // Positions are rounded twice here and once there, so levels and diagonals may differ at single pixels.
        std::size_t hits = 0, apart = 0;
        for (std::size_t i = 0; i < a.find("depth")->pixels.size(); ++i) {
            const float da = a.find("depth")->pixels[i], db = b.find("depth")->pixels[i];
            hits += std::isfinite(db);
            apart += std::isfinite(da) != std::isfinite(db) || (std::isfinite(da) && std::abs(da - db) > 1e-4f * db);
        }
        EXPECT_GT(hits, 500u);
        EXPECT_LE(apart, hits / 200);
    }
}

TEST(Deformation, CostsNothingBehindAWall)
{
    const Camera camera = Camera::look_at({0, 0, 20}, {0, 0, 0}, {0, 1, 0}, 0.3f);
    const Settings settings{.width = 64, .height = 48, .spp = 1};
    Eel eel;
    Renderer renderer;
    renderer.render(eel.scene, camera, settings);
    const std::uint64_t seen = renderer.stats().built.vertices_deformed;
    EXPECT_GT(seen, 0u);
    Cage wall;
    wall.scheme = Scheme::Triangles;
    wall.positions = {{-30, -30, 8}, {30, -30, 8}, {0, 60, 8}};
    wall.face_vertices = {0, 1, 2};
    test::place(eel.scene, eel.scene.add(wall), {0, 0, 0});
    for (const double angle : {0.1, 0.9}) {
        eel.bend(angle);
        renderer.render(eel.scene, camera, settings);
        EXPECT_EQ(renderer.stats().built.vertices_deformed, 0u);
    }
}

TEST(Deformation, GivesTheSameBitsForAnyThreadsAndBudget)
{
    Eel eel;
    eel.bend(0.8);
    const Camera camera = Camera::look_at({0.5, 2, 4}, {0.5, 0, 0}, {0, 1, 0}, 0.8f);
    std::vector<std::uint64_t> sums;
    const std::size_t floor = Renderer({.threads = 2}).memory_floor(eel.scene);
    for (const Resources& resources :
         {Resources{.threads = 1}, Resources{.threads = 3}, Resources{.threads = 2, .memory_bytes = floor}}) {
        Renderer renderer(resources);
        sums.push_back(renderer.render(eel.scene, camera, {.width = 96, .height = 72, .spp = 4}).checksum());
    }
    EXPECT_EQ(sums[0], sums[1]);
    EXPECT_EQ(sums[0], sums[2]);
}

TEST(Deformation, OfACopyIsItsOwn)
{
    Eel eel;
    Scene& scene = eel.scene;
    const NodeId copy = scene.copy(eel.whole, scene.root());
    scene.set_transform(copy, Trs{.translation = {10, 0, 0}});
    const auto width = [&](NodeId id) { return scene.node(id).bounds.extent().x; };
    expect_true_to_formulas(scene, "two eels");
    const double straight = width(copy);
    EXPECT_EQ(width(eel.whole), straight);
    eel.bend(1.5);
    expect_true_to_formulas(scene, "one bent");
    EXPECT_GT(std::abs(width(eel.whole) - straight), 0.1);
    EXPECT_EQ(width(copy), straight);
    const std::size_t skins = scene.counts().skins;
    scene.remove(copy);
    EXPECT_EQ(scene.counts().skins, skins - 1) << "a copy takes its skins with it";
}

TEST(Deformation, IsSeenThroughInstances)
{
    Eel eel;
    Scene& scene = eel.scene;
    eel.bend(0.9);
    const Box3d original = scene.bounds();
    NodeDesc instance;
    instance.place.translation = {0, 50, 0};
    instance.instance_of = eel.whole;
    scene.add_node(scene.root(), instance);
    scene.set_visible(eel.whole, false);
    const Box3d shown = scene.bounds();
    EXPECT_LT(glm::distance(shown.lo, original.lo + Vec3d(0, 50, 0)), 1e-9);
    EXPECT_LT(glm::distance(shown.hi, original.hi + Vec3d(0, 50, 0)), 1e-9);
    eel.bend(0.1);
    EXPECT_GT(std::abs(scene.bounds().hi.x - shown.hi.x), 0.1) << "and follows its joints";
}

TEST(Deformation, OutlivesItsJointsAndItsSkin)
{
    Eel eel;
    eel.scene.remove(eel.joints[2]);
    EXPECT_FALSE(eel.scene.bounds().is_empty());
    Renderer renderer;
    EXPECT_NO_THROW(renderer.render(eel.scene, Camera::framing(eel.scene.bounds()), {.width = 16, .height = 12, .spp = 1}));
    eel.scene.remove(eel.scene.node(eel.body).skin);
    const Box3d box = eel.scene.bounds();
    EXPECT_GT(box.hi.x, 3) << "without a skin the node's place counts";
    EXPECT_NO_THROW(renderer.render(eel.scene, Camera::framing(box), {.width = 16, .height = 12, .spp = 1}));
}

// The handle of a skin stays good when its joints go with the node above them.
TEST(Deformation, OfASkinThatLostItsSkeletonIsNone)
{
    Eel eel;
    Scene& scene = eel.scene;
    scene.remove(eel.body);
    const NodeId pool = scene.add_node(scene.root(), {});
    Cage cage = test::torus(8, 6, false);
    cage.skin = {1, std::vector<glm::u16vec4>(cage.positions.size()),
                 std::vector<Vec4f>(cage.positions.size(), Vec4f(1, 0, 0, 0))};
    const CageId torus = scene.add(std::move(cage));
    const SkinId skin = scene.add(Skin{"spine", {eel.joints[1], eel.joints[2]}, {}});
    const Trs place{.translation = {3, 0, 0}};
    const NodeId body = scene.add_node(pool, {.place = place, .cages = {torus}, .skin = skin});
    scene.remove(eel.whole);
    const NodeId plain = scene.add_node(scene.root(), {.place = place, .cages = {torus}});
    const auto box_of = [&](NodeId id) {
        scene.refit();
        return std::pair(scene.node(id).bounds.lo, scene.node(id).bounds.hi);
    };
    const auto wanted = box_of(plain);
    scene.set_skin(plain, skin);
    const NodeId late = scene.add_node(scene.root(), {.cages = {torus}, .skin = skin});
    const NodeId copy = scene.copy(pool, scene.root());
    scene.set_transform(pool, Trs{.translation = {0, 7, 0}});
    for (const NodeId id : {body, plain, late, scene.node(copy).children.at(0)}) EXPECT_EQ(box_of(id), wanted);
    EXPECT_EQ(scene.node(late).skin, skin);
}

TEST(Deformation, OfACopyDoesWithoutTheJointsThatWereRemoved)
{
    Eel eel;
    Scene& scene = eel.scene;
    scene.remove(eel.joints[1]);
    const NodeId copy = scene.copy(eel.whole, scene.root());
    scene.refit();
    EXPECT_EQ(scene.node(copy).bounds.lo, scene.node(eel.whole).bounds.lo);
    EXPECT_EQ(scene.node(copy).bounds.hi, scene.node(eel.whole).bounds.hi);
    EXPECT_NE(scene.node(scene.node(copy).children.back()).skin, scene.node(eel.body).skin);
    scene.remove(eel.joints[0]);
    EXPECT_NO_THROW(scene.copy(eel.whole, scene.root()));
    EXPECT_FALSE(scene.bounds().is_empty());
}

}  // namespace
}  // namespace occam
