#include <gtest/gtest.h>

#include <bit>
#include <random>

#include "base/error.h"
#include "scenegraph/child_boxes.h"
#include "scenegraph/scene.h"
#include "tests/support/campaign.h"
#include "tests/support/shape_builders.h"

namespace occam {
namespace {

using namespace test;

void expect_box(const Box3d& box, Vec3d lo, Vec3d hi)
{
    for (int k = 0; k < 3; ++k) {
        EXPECT_DOUBLE_EQ(box.lo[k], lo[k]);
        EXPECT_DOUBLE_EQ(box.hi[k], hi[k]);
    }
}

TEST(Scene, BoundsOfANodeHoldItsCagesAndItsChildren)
{
    Scene scene;
    const CageId square = scene.add(unit_square());
    const NodeId group = scene.add_node(scene.root(), {.matrix = moved(10, 0, 0)});
    scene.add_node(group, {.cages = {square}});
    scene.add_node(group, {.matrix = moved(0, 5, 0), .cages = {square}});
    expect_box(scene.bounds(), {10, 0, 0}, {11, 6, 0});
    expect_box(scene.node(group).bounds, {0, 0, 0}, {1, 6, 0});
}

TEST(Scene, AnEditMarksThePathToTheRootAndNothingElse)
{
    Scene scene;
    const CageId square = scene.add(unit_square());
    const NodeId left = scene.add_node(scene.root(), {}), right = scene.add_node(scene.root(), {});
    const NodeId leaf = scene.add_node(left, {.cages = {square}});
    scene.add_node(right, {.cages = {square}});
    scene.refit();
    scene.set_transform(leaf, moved(3, 0, 0));
    EXPECT_TRUE(scene.node(left).dirty);
    EXPECT_TRUE(scene.node(scene.root()).dirty);
    EXPECT_FALSE(scene.node(right).dirty);
    EXPECT_FALSE(scene.node(leaf).dirty) << "the box of a node is in its own axes";
    scene.refit();
    EXPECT_FALSE(scene.node(scene.root()).dirty);
    expect_box(scene.bounds(), {0, 0, 0}, {4, 1, 0});
}

// The bound holds for a tree of any size: an edit visits the path from the edited node to the root, and the nodes beside it.
TEST(Scene, AnEditLooksAtItsPathsToTheRootAlone)
{
    constexpr std::size_t kFanOut = 8;
    for (const int depth : {2, 4}) {
        Scene scene;
        const CageId square = scene.add(unit_square());
        std::vector<NodeId> row{scene.root()};
        for (int d = 0; d < depth; ++d) {
            std::vector<NodeId> below;
            for (const NodeId parent : row)
                for (std::size_t c = 0; c < kFanOut; ++c) below.push_back(scene.add_node(parent, {.cages = {square}}));
            row = std::move(below);
        }
        EXPECT_GE(scene.refit(), row.size());
        EXPECT_EQ(scene.refit(), 1u) << "nothing to do";
        for (const std::size_t edits : {1u, 3u, 7u}) {
            for (std::size_t e = 0; e < edits; ++e) scene.set_transform(row[e * row.size() / edits], moved(double(e), 0, 1));
            EXPECT_LE(scene.refit(), 1 + edits * kFanOut * std::size_t(depth)) << "depth " << depth;
        }
    }
}

// However many siblings there are, an edit visits 16 beside each, and two boxes for each level of the tree above them.
TEST(Scene, AnEditOfOneOfManySiblingsLooksAtFewOfThem)
{
    for (const std::size_t siblings : {std::size_t(100), std::size_t(10'000), std::size_t(is_long() ? 100'000 : 1000)}) {
        Scene scene;
        const CageId square = scene.add(unit_square());
        std::vector<NodeId> nodes;
        for (std::size_t i = 0; i < siblings; ++i)
            nodes.push_back(scene.add_node(scene.root(), {.matrix = moved(double(i), 0, 0), .cages = {square}}));
        EXPECT_GE(scene.refit(), siblings);
        EXPECT_EQ(scene.refit(), 1u) << "nothing to do";
        const std::size_t levels = std::bit_width(siblings / ChildBoxes::kBlock);
        const auto allowed = [&](std::size_t edits) { return 1 + edits * 2 * (ChildBoxes::kBlock + levels); };
        for (const std::size_t edits : {1u, 3u, 7u}) {
            for (std::size_t e = 0; e < edits; ++e) scene.set_transform(nodes[e * siblings / edits], moved(0, double(e), 1));
            EXPECT_LE(scene.refit(), allowed(edits)) << siblings << " siblings, moved";
            for (std::size_t e = 0; e < edits; ++e) scene.set_visible(nodes[e * siblings / edits], e % 2 != 0);
            EXPECT_LE(scene.refit(), allowed(edits)) << siblings << " siblings, hidden";
            for (std::size_t e = 0; e < edits; ++e) {
                scene.remove(nodes.back());
                nodes.pop_back();
            }
            EXPECT_LE(scene.refit(), allowed(edits)) << siblings << " siblings, removed";
            scene.add_node(scene.root(), {.cages = {square}});
            EXPECT_LE(scene.refit(), allowed(1)) << siblings << " siblings, added";
        }
    }
}

TEST(Scene, WrittenVerticesReachEveryNodeThatShowsTheCage)
{
    Scene scene;
    const CageId square = scene.add(unit_square());
    scene.add_node(scene.root(), {.cages = {square}});
    scene.add_node(scene.root(), {.matrix = moved(5, 0, 0), .cages = {square}});
    scene.refit();
    const std::uint64_t identity = scene.cage(square).identity;
    const std::vector<Vec3f> taller = {{0, 0, 0}, {1, 0, 0}, {1, 9, 0}, {0, 9, 0}};
    scene.write_vertices(square, taller);
    EXPECT_EQ(scene.cage(square).positions_version, 1u);
    EXPECT_EQ(scene.cage(square).identity, identity);
    expect_box(scene.bounds(), {0, 0, 0}, {6, 9, 0});
    EXPECT_THROW(scene.write_vertices(square, std::vector<Vec3f>(3)), Error);
    EXPECT_THROW(scene.write_vertices(square, std::vector<Vec3f>(4, Vec3f(NAN))), Error);
    scene.replace(square, unit_square());
    EXPECT_NE(scene.cage(square).identity, identity);
    expect_box(scene.bounds(), {0, 0, 0}, {6, 1, 0});
}

TEST(Scene, AnInstanceFollowsEditsBelowItsTarget)
{
    Scene scene;
    const CageId square = scene.add(unit_square());
    const NodeId original = scene.add_node(scene.root(), {.matrix = moved(100, 0, 0), .visible = false});
    const NodeId leaf = scene.add_node(original, {.cages = {square}});
    const NodeId group = scene.add_node(scene.root(), {});
    const NodeId instance = scene.add_node(group, {.matrix = moved(0, 0, 7), .instance_of = original});
    expect_box(scene.bounds(), {0, 0, 7}, {1, 1, 7});  // neither the place nor the visibility of the original matters
    scene.set_transform(leaf, moved(2, 0, 0));
    EXPECT_TRUE(scene.node(instance).dirty);
    EXPECT_TRUE(scene.node(group).dirty);
    expect_box(scene.bounds(), {2, 0, 7}, {3, 1, 7});
    scene.remove(original);
    EXPECT_TRUE(scene.bounds().is_empty());
}

TEST(Scene, PlacementsComeParentsFirstAndThroughInstances)
{
    Scene scene;
    const NodeId a = scene.add_node(scene.root(), {.name = "a", .matrix = moved(1, 0, 0)});
    scene.add_node(a, {.name = "b", .matrix = moved(1, 0, 0)});
    scene.add_node(scene.root(), {.name = "c", .matrix = moved(0, 5, 0), .instance_of = a});
    scene.add_node(scene.root(), {.name = "hidden", .visible = false});
    std::vector<std::string> names;
    std::vector<Vec3d> places;
    scene.for_each_placement([&](NodeId, const Node& node, const Mat4d& world) {
        names.push_back(node.name);
        places.push_back(Vec3d(world[3]));
    });
    EXPECT_EQ(names, (std::vector<std::string>{"", "a", "b", "c", "a", "b"}));
    EXPECT_EQ(places[2], Vec3d(2, 0, 0));
    EXPECT_EQ(places[4], Vec3d(0, 5, 0)) << "the target's own place does not count";
    EXPECT_EQ(places[5], Vec3d(1, 5, 0));
}

TEST(Scene, RefusesANodeThatWouldShowItself)
{
    Scene scene;
    const NodeId a = scene.add_node(scene.root(), {});
    const NodeId b = scene.add_node(scene.root(), {});
    EXPECT_THROW(scene.add_node(a, {.instance_of = a}), Error);
    EXPECT_THROW(scene.add_node(a, {.instance_of = scene.root()}), Error);
    scene.add_node(a, {.instance_of = b});
    EXPECT_THROW(scene.add_node(b, {.instance_of = a}), Error) << "by way of another instance";
    EXPECT_EQ(scene.counts().nodes, 4u) << "a refused edit changes nothing";
}

TEST(Scene, DeadHandlesSaySo)
{
    Scene scene;
    const CageId square = scene.add(unit_square());
    const NodeId parent = scene.add_node(scene.root(), {});
    const NodeId child = scene.add_node(parent, {.cages = {square}});
    scene.remove(parent);
    EXPECT_THROW(scene.node(child), Error);
    EXPECT_THROW(scene.set_transform(parent, Mat4d(1)), Error);
    EXPECT_THROW(scene.add_node(parent, {}), Error);
    EXPECT_EQ(scene.find(child), nullptr);
    const NodeId reused = scene.add_node(scene.root(), {});
    EXPECT_THROW(scene.node(child), Error) << "also when its slot is taken again";
    EXPECT_NO_THROW(scene.node(reused));
    scene.remove(square);
    EXPECT_THROW(scene.add_node(scene.root(), {.cages = {square}}), Error);
    EXPECT_THROW(scene.remove(scene.root()), Error);
    EXPECT_THROW(scene.node({}), Error);
}

TEST(Scene, RemovedCagesAreSimplyNotThere)
{
    Scene scene;
    const CageId square = scene.add(unit_square());
    scene.add_node(scene.root(), {.cages = {square}});
    EXPECT_FALSE(scene.bounds().is_empty());
    scene.remove(square);
    EXPECT_TRUE(scene.bounds().is_empty());
    EXPECT_EQ(scene.placed_faces(), 0u);
}

TEST(Scene, EditsWaitWhileAFrameRenders)
{
    Scene scene;
    const NodeId node = scene.add_node(scene.root(), {});
    {
        const Scene::FrameLock lock(scene);
        EXPECT_THROW(scene.set_visible(node, false), Error);
        EXPECT_THROW(scene.add(unit_square()), Error);
        EXPECT_NO_THROW(scene.refit());
    }
    EXPECT_NO_THROW(scene.set_visible(node, false));
}

TEST(Scene, RefusesTransformsThatAreNotFinite)
{
    Scene scene;
    const NodeId node = scene.add_node(scene.root(), {});
    EXPECT_THROW(scene.set_transform(node, moved(NAN, 0, 0)), Error);
    EXPECT_THROW(scene.add_node(scene.root(), {.matrix = moved(INFINITY, 0, 0)}), Error);
}

TEST(Scene, ADeepTreeNeedsNoStack)
{
    Scene scene;
    const CageId square = scene.add(unit_square());
    NodeId node = scene.root();
    const std::size_t depth = is_long() ? 200'000 : 100'000;
    for (std::size_t i = 0; i < depth; ++i) node = scene.add_node(node, {});
    scene.add_node(node, {.cages = {square}});
    expect_box(scene.bounds(), {0, 0, 0}, {1, 1, 0});
    std::size_t placements = 0;
    scene.for_each_placement([&](NodeId, const Node&, const Mat4d&) { ++placements; });
    EXPECT_EQ(placements, depth + 2);
}

// Any sequence of edits with refits between them leads to the boxes that a scene built anew would have.
TEST(Scene, RefitAfterRandomEditsAgreesWithARefitOfEverything)
{
    std::mt19937 random(7);
    const auto pick = [&](std::size_t n) { return std::size_t(random() % n); };
    Scene scene;
    const CageId square = scene.add(unit_square());
    std::vector<NodeId> nodes{scene.root()};
    for (int step = 0; step < 3000; ++step) {
        std::erase_if(nodes, [&](NodeId id) { return !scene.find(id); });
        const NodeId at = nodes[pick(nodes.size())];
        const Mat4d place = moved(double(pick(20)), double(pick(20)), double(pick(20)));
        switch (pick(8)) {
            case 0:
            case 1:
                nodes.push_back(scene.add_node(at, {.matrix = place, .cages = {square}}));
                break;
            case 2:
                scene.set_transform(at, place);
                break;
            case 3:
                scene.set_visible(at, pick(4) != 0 || at == scene.root());
                break;
            case 4:
                try {
                    nodes.push_back(scene.add_node(nodes[pick(nodes.size())], {.matrix = place, .instance_of = at}));
                } catch (const Error&) {
                }
                break;
            case 5:
            case 6:
                try {
                    if (pick(2) == 0) scene.set_parent(at, nodes[pick(nodes.size())]);
                    else scene.set_instance_of(at, pick(2) == 0 ? NodeId() : nodes[pick(nodes.size())]);
                } catch (const Error&) {
                }
                break;
            default:
                if (at != scene.root() && pick(4) == 0) scene.remove(at);
        }
        // Instances of instances would make the reference below too large.
        if (nodes.size() > 60 && nodes.size() > 1) scene.remove(nodes[1]);
        if (step % 3 != 0) continue;
        Box3d expected;
        scene.for_each_placement([&](NodeId, const Node& node, const Mat4d& world) {
            for (CageId id : node.cages) expected.add(transform_box(world, scene.cage(id).bounds));
        });
        const Box3d found = scene.bounds();
        ASSERT_EQ(found.is_empty(), expected.is_empty()) << "step " << step;
        if (found.is_empty()) continue;
        ASSERT_TRUE(found.lo == expected.lo && found.hi == expected.hi) << "step " << step;
    }
}

// One node has about a hundred children, which are removed and added until all of them are new, several times over.
TEST(Scene, RefitOfManySiblingsAgreesWithARefitOfEverything)
{
    std::mt19937 random(11);
    const auto pick = [&](std::size_t n) { return std::size_t(random() % n); };
    Scene scene;
    const CageId square = scene.add(unit_square());
    const NodeId crowd = scene.add_node(scene.root(), {});
    std::vector<NodeId> nodes;
    for (int step = 0; step < 6000; ++step) {
        const Mat4d place = moved(double(pick(1000)), double(pick(1000)), double(pick(1000)));
        // The number of children grows to about 200, shrinks to about 20, and so on.
        const bool grows = step / 1000 % 2 == 0;
        const std::size_t i = nodes.empty() ? 0 : pick(nodes.size());
        const std::size_t choice = pick(5);
        if (nodes.empty() || (choice == 0 && (grows ? nodes.size() < 200 : nodes.size() < 20))) {
            nodes.push_back(scene.add_node(crowd, {.matrix = place, .cages = {square}}));
        } else if (choice == 1 && (grows ? pick(4) == 0 : nodes.size() > 20)) {
            scene.remove(nodes[i]);
            nodes.erase(nodes.begin() + std::ptrdiff_t(i));
        } else if (choice == 2) {
            scene.set_transform(nodes[i], place);
        } else if (choice == 3) {
            if (pick(2) == 0) scene.set_parent(nodes[i], scene.root());
            scene.set_parent(nodes[i], crowd);  // as the last of the children
            std::rotate(nodes.begin() + std::ptrdiff_t(i), nodes.begin() + std::ptrdiff_t(i) + 1, nodes.end());
        } else {
            scene.set_visible(nodes[i], pick(3) != 0);
        }
        if (step % 3 != 0) continue;
        Box3d expected;
        std::vector<NodeId> met;
        scene.for_each_placement([&](NodeId id, const Node& node, const Mat4d& world) {
            for (CageId cage : node.cages) expected.add(transform_box(world, scene.cage(cage).bounds));
            if (id != scene.root() && id != crowd) met.push_back(id);
        });
        std::vector<NodeId> visible;
        for (const NodeId id : nodes)
            if (scene.node(id).visible) visible.push_back(id);
        ASSERT_EQ(met, visible) << "in the order they were added, step " << step;
        const Box3d found = scene.bounds();
        ASSERT_EQ(found.is_empty(), expected.is_empty()) << "step " << step;
        if (found.is_empty()) continue;
        ASSERT_TRUE(found.lo == expected.lo && found.hi == expected.hi) << "step " << step;
    }
}

TEST(Scene, CamerasArePlacedWithoutScale)
{
    Scene scene;
    Mat4d place = moved(1, 2, 3);
    place[0] *= 5.0, place[1] *= 5.0, place[2] *= 5.0;
    const CameraId lens = scene.add(CameraLens{.fov = 1});
    scene.add_node(scene.root(), {.name = "main", .matrix = place, .camera = lens});
    const auto camera = scene.camera("main");
    ASSERT_TRUE(camera);
    EXPECT_EQ(camera->world_from_camera, moved(1, 2, 3));
    EXPECT_TRUE(scene.camera());
    EXPECT_FALSE(scene.camera("other"));
    EXPECT_EQ(scene.camera_names(), std::vector<std::string>{"main"});
}

TEST(Trs, ComposesScaleThenRotationThenTranslation)
{
    const double h = std::sqrt(0.5);
    const Trs trs{{1, 2, 3}, {0, 0, h, h}, {2, 1, 1}};  // a quarter turn about z
    const Vec3d p = transform_point(trs.matrix(), {1, 0, 0});
    EXPECT_NEAR(p.x, 1, 1e-15);
    EXPECT_NEAR(p.y, 4, 1e-15);
    EXPECT_NEAR(p.z, 3, 1e-15);
}

TEST(Camera, FramingSeesEveryCornerOfABox)
{
    const Box3d box{{-1, 2, 5}, {4, 3, 25}};
    for (float aspect : {0.5f, 1.0f, 2.0f}) {
        const Camera camera = Camera::framing(box, aspect);
        const double k = std::tan(double(camera.lens.fov) / 2);
        for (int c = 0; c < 8; ++c) {
            const Vec3d p(c & 1 ? box.hi.x : box.lo.x, c & 2 ? box.hi.y : box.lo.y, c & 4 ? box.hi.z : box.lo.z);
            const Vec3d d = p - camera.eye();
            const double x = glm::dot(d, Vec3d(camera.world_from_camera[0])),
                         y = glm::dot(d, Vec3d(camera.world_from_camera[1]));
            const double depth = -glm::dot(d, Vec3d(camera.world_from_camera[2]));
            EXPECT_GT(depth, 0);
            EXPECT_LE(std::abs(x), depth * k * double(aspect));
            EXPECT_LE(std::abs(y), depth * k);
        }
    }
    EXPECT_NO_THROW(Camera::framing(Box3d()));
}

TEST(Camera, LookAtIsRigidAlsoAlongUp)
{
    for (const Vec3d eye : {Vec3d(0, 5, 0), Vec3d(1, 2, 3), Vec3d(0, -1e6, 0)}) {
        const Camera camera = Camera::look_at(eye, {0, 0, 0}, {0, 1, 0}, 1);
        const Vec3d right(camera.world_from_camera[0]), up(camera.world_from_camera[1]), back(camera.world_from_camera[2]);
        EXPECT_NEAR(glm::dot(right, up), 0, 1e-12);
        EXPECT_NEAR(glm::dot(glm::cross(right, up), back), 1, 1e-12);
        EXPECT_NEAR(glm::dot(back, eye), std::sqrt(glm::dot(eye, eye)), 1e-6);
    }
    EXPECT_THROW(Camera::look_at({1, 1, 1}, {1, 1, 1}, {0, 1, 0}, 1), Error);
    EXPECT_THROW(Camera::look_at({1, 1, 1}, {0, 0, 0}, {0, 1, 0}, 4), Error);
}

}  // namespace
}  // namespace occam
