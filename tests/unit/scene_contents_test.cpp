// What a frame needs to know of all nodes is kept up to date by edits: it is what a walk over all of them finds.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "base/error.h"
#include "scenegraph/child_boxes.h"
#include "scenegraph/scene.h"
#include "tests/support/shape_builders.h"

namespace occam {
namespace {

using namespace test;

// What a node shows by itself, found anew.
Contents walked(const Scene& scene, const Node& node)
{
    Contents out;
    if (scene.find(node.light)) out.kinds |= Contents::Lights;
    for (const CageId id : node.cages) {
        const CageSlot* slot = scene.find(id);
        if (!slot) continue;
        if (slot->cage.is_displaced()) out.kinds |= Contents::Displaced;
        if (slot->is_on_demand() || slot->cage.scheme != Scheme::Triangles) out.kinds |= Contents::Subdivided;
        out.largest_face = std::max(out.largest_face, slot->largest_face);
        out.derived_points = std::max(out.derived_points, slot->derived_points);
        for (const MaterialId material : node.materials.empty() ? slot->cage.materials : node.materials)
            out.kinds |= kinds_of(scene.material(material));
    }
    return out;
}

struct Placement {
    NodeId id;
    Mat4d world;
    friend bool operator==(const Placement&, const Placement&) = default;
};

void expect_what_a_walk_finds(Scene& scene, int step)
{
    constexpr Contents::Kinds kMasks[] = {
        Contents::Lights,     Contents::Emitters, Contents::Passing,  Contents::OverLimit | Contents::Displaced,
        Contents::Subdivided, Contents::Masked,   Contents::Absorbing};
    scene.refit();
    Contents all;
    std::vector<Placement> expected[std::size(kMasks)];
    scene.for_each_placement([&](NodeId id, const Node& node, const Mat4d& world) {
        const Contents own = walked(scene, node);
        all.add(own);
        for (std::size_t m = 0; m < std::size(kMasks); ++m)
            if (own.has(kMasks[m])) expected[m].push_back({id, world});
    });
    const Contents found = scene.contents();
    ASSERT_EQ(found.kinds, all.kinds) << "step " << step;
    ASSERT_EQ(found.largest_face, all.largest_face) << "step " << step;
    ASSERT_EQ(found.derived_points, all.derived_points) << "step " << step;
    for (std::size_t m = 0; m < std::size(kMasks); ++m) {
        std::vector<Placement> placements;
        scene.for_placements_of(kMasks[m], [&](NodeId id, const Node&, const Mat4d& world) {
            placements.push_back({id, world});
        });
        ASSERT_EQ(placements, expected[m]) << "of mask " << int(kMasks[m]) << " in the order of a walk, step " << step;
    }
}

// A scene whose nodes, materials and cages are edited at random.
class EditedScene {
public:
    explicit EditedScene(unsigned seed) : random_(seed)
    {
        Material glowing, glass, white, leaf, water;
        glowing.emission = Vec3f(2);
        glass.alpha_mode = AlphaMode::Blend;
        white.base_color = Vec4f(1.5f);
        leaf.alpha_mode = AlphaMode::Mask;
        water.transmission = water.thickness = water.attenuation_distance = 1;
        water.attenuation_color = Vec3f(0.5f);
        for (const Material& m : {Material(), glowing, glass, white, leaf, water}) looks_.push_back(m);
        for (int i = 0; i < 6; ++i) materials_.push_back(scene.add(looks_[pick(looks_.size())]));
        for (int i = 0; i < 4; ++i) cages_.push_back(scene.add(cage(i)));
        light_ = scene.add(Light{{}, PointLight{}});
        nodes.push_back(scene.root());
    }

    std::size_t pick(std::size_t n) { return std::size_t(random_() % n); }

    void edit(std::size_t most_nodes, bool is_flat)
    {
        std::erase_if(nodes, [&](NodeId id) { return !scene.find(id); });
        const NodeId at = nodes[pick(nodes.size())], above = is_flat && nodes.size() > 1 ? nodes[1] : at;
        switch (pick(9)) {
            case 0:
            case 1:
                nodes.push_back(scene.add_node(above, desc()));
                break;
            case 2:
                scene.set_transform(at, place());
                break;
            case 3:
                scene.set_visible(at, pick(4) != 0 || at == scene.root());
                break;
            case 4:
                if (is_flat) break;
                try {
                    nodes.push_back(scene.add_node(nodes[pick(nodes.size())], {.matrix = place(), .instance_of = at}));
                } catch (const Error&) {
                }
                break;
            case 5:
                scene.replace(materials_[pick(materials_.size())], looks_[pick(looks_.size())]);
                break;
            case 6:
                scene.set_materials(at, override_of());
                break;
            case 7:
                if (pick(3) == 0) scene.replace(cages_[pick(cages_.size())], cage(int(pick(4))));
                break;
            default:
                if (at != scene.root() && pick(4) == 0) scene.remove(at);
        }
        if (const std::size_t oldest = is_flat ? 2 : 1; nodes.size() > most_nodes && scene.find(nodes[oldest]))
            scene.remove(nodes[oldest]);
        if (pick(400) == 0) {
            scene.remove(light_);
            light_ = scene.add(Light{{}, PointLight{}});
        }
    }

    Scene scene;
    std::vector<NodeId> nodes;

private:
    Mat4d place() { return moved(double(pick(20)), double(pick(20)), double(pick(20))); }
    std::vector<MaterialId> override_of()
    {
        if (pick(2) == 0) return {};
        return {materials_[pick(materials_.size())]};
    }
    NodeDesc desc()
    {
        NodeDesc d{.matrix = place(), .materials = override_of()};
        if (pick(2) == 0) d.cages = {cages_[pick(cages_.size())]};
        if (pick(5) == 0) d.light = light_;
        return d;
    }
    Cage cage(int which)
    {
        Cage c = test::prism(static_cast<std::uint32_t>(3 + which));
        c.materials = {materials_[pick(materials_.size())]};
        return c;
    }

    std::mt19937 random_;
    std::vector<Material> looks_;
    std::vector<MaterialId> materials_;
    std::vector<CageId> cages_;
    LightId light_;
};

TEST(Contents, AreWhatAWalkOverAllNodesFindsAfterAnyEdits)
{
    EditedScene of(3);
    for (int step = 0; step < 3000; ++step) {
        of.edit(50, false);
        if (step % 3 != 0) continue;
        ASSERT_NO_FATAL_FAILURE(expect_what_a_walk_finds(of.scene, step));
    }
}

// The same where one node has hundreds of children, which are found by a tree over them.
TEST(Contents, OfManySiblingsAreWhatAWalkFinds)
{
    EditedScene of(5);
    of.nodes.push_back(of.scene.add_node(of.scene.root(), {}));
    for (int step = 0; step < 6000; ++step) {
        of.edit(step / 1500 % 2 == 0 ? 600 : 60, true);
        if (step % 10 != 0) continue;
        ASSERT_NO_FATAL_FAILURE(expect_what_a_walk_finds(of.scene, step));
    }
}

TEST(Contents, CountsFacesByEdits)
{
    Scene scene;
    const CageId cage = scene.add(test::prism(5));
    const std::size_t faces = scene.counts().faces;
    EXPECT_EQ(faces, scene.cage(cage).cage.face_count());
    Cage triangle;
    triangle.scheme = Scheme::Triangles;
    triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    triangle.face_vertices = {0, 1, 2};
    const CageId mesh = scene.add(triangle);
    EXPECT_EQ(scene.counts().faces, faces + 1);
    EXPECT_EQ(scene.counts().mesh_triangles, 1u);
    scene.replace(cage, triangle);
    EXPECT_EQ(scene.counts().faces, 2u);
    EXPECT_EQ(scene.counts().mesh_triangles, 2u);
    scene.remove(mesh);
    EXPECT_EQ(scene.counts().faces, 1u);
    EXPECT_EQ(scene.counts().mesh_triangles, 1u);
}

// Children lie in blocks by where they are, also after all of them have moved.
TEST(ChildBoxes, KeepNeighboursTogether)
{
    constexpr std::size_t kSide = 32, kCount = kSide * kSide;
    std::vector<Box3d> boxes(kCount);
    std::mt19937 random(9);
    const auto shuffle = [&] {
        std::vector<std::size_t> places(kCount);
        for (std::size_t i = 0; i < kCount; ++i) places[i] = i;
        std::shuffle(places.begin(), places.end(), random);
        for (std::size_t i = 0; i < kCount; ++i) {
            const Vec3d at(double(places[i] % kSide), double(places[i] / kSide), 0);
            boxes[i] = {at, at + Vec3d(0.5)};
        }
    };
    ChildBoxes tree;
    const auto refit = [&] {
        tree.resize(kCount);
        tree.refit([&](std::size_t i) { return boxes[i]; }, [](std::size_t) { return Contents(); });
    };
    const auto area = [&] {
        double sum = 0;
        std::vector<bool> seen(kCount);
        for (std::uint32_t node = 1; node < 2 * kCount / ChildBoxes::kBlock; ++node) {
            if (!tree.is_block(node)) continue;
            sum += tree.box(node).half_area();
            for (const std::uint32_t child : tree.children(node)) {
                EXPECT_FALSE(seen[child]) << "a child lies in one block";
                seen[child] = true;
            }
        }
        EXPECT_EQ(std::count(seen.begin(), seen.end(), true), std::ptrdiff_t(kCount));
        return sum;
    };
    shuffle();
    refit();
    const double sorted = area();
    EXPECT_LT(sorted, 2.0 * kCount) << "a block of 4 x 4 covers 16 or so";
    for (int round = 0; round < 3; ++round) {
        shuffle();
        for (std::size_t i = 0; i < kCount; ++i) tree.touch(i);
        refit();
        refit();
        EXPECT_NEAR(area(), sorted, 0.01 * sorted) << "round " << round;
    }
}

// A cage whose vertices gather has the layers of the same cage built anew.
TEST(Contents, LayersFollowVerticesThatGather)
{
    constexpr int kFaces = 20'000;
    std::vector<Vec3f> spread, gathered;
    Cage cage;
    cage.scheme = Scheme::Triangles;
    for (std::uint32_t face = 0; face < kFaces; ++face)
        for (const Vec2f corner : {Vec2f(0, 0), Vec2f(1, 0), Vec2f(0, 1)}) {
            cage.face_vertices.push_back(static_cast<std::uint32_t>(spread.size()));
            spread.emplace_back(corner.x + float(face % 141), corner.y + float(face / 141), 0.1f * corner.x);
            gathered.emplace_back(corner.x, corner.y, 0.1f * corner.x);
        }
    cage.positions = spread;
    Scene scene, anew;
    const CageId id = scene.add(cage);
    scene.add_node(scene.root(), {.cages = {id}});
    scene.refit();
    EXPECT_LT(scene.contents().most_layers, 256);
    scene.write_vertices(id, gathered);
    scene.refit();
    cage.positions = gathered;
    anew.add_node(anew.root(), {.cages = {anew.add(cage)}});
    anew.refit();
    EXPECT_GT(anew.contents().most_layers, 256);
    EXPECT_EQ(scene.contents(), anew.contents());
}

}  // namespace
}  // namespace occam
