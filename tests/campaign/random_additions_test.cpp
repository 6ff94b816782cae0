// Tests that a scene which is added to another one shows what it showed, and is posed as it was, whatever was edited before.
//
// OCCAM_SEED=n tests that seed alone.
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/support/campaign.h"
#include "tests/support/random_world.h"

namespace occam::test {
namespace {

/// Lists the nodes of a subtree, parents first, in the order of the children.
std::vector<NodeId> subtree(const Scene& scene, NodeId top)
{
    std::vector<NodeId> found{top};
    for (std::size_t i = 0; i < found.size(); ++i)
        for (const NodeId child : scene.node(found[i]).children)
            if (child) found.push_back(child);
    return found;
}

/// Poses the subtree of `top` and each copy in it, every time by the clip that has its turn. Returns how many copies there
/// are.
/// of   a null handle if `top` is the root, else `top`, which was added
std::size_t pose_all(Scene& scene, const std::vector<ClipId>& clips, NodeId top, NodeId of)
{
    std::size_t turn = 0, copies = 0;
    const auto next = [&] {
        std::vector<ClipAt> at;
        if (!clips.empty()) at.push_back({clips[turn % clips.size()], 0.3 + 0.7 * double(turn % 4)});
        ++turn;
        return at;
    };
    scene.pose(next(), of);
    for (const NodeId id : subtree(scene, top)) {
        if (id == top) continue;
        try {
            scene.pose(next(), id);
            ++copies;
        } catch (const Error&) {  // the node is no copy
        }
    }
    return copies;
}

std::size_t expect_same_when_added(std::uint64_t seed, int edits)
{
    SCOPED_TRACE("OCCAM_SEED=" + std::to_string(seed));
    RandomWorld alone(seed), part(seed);
    for (int k = 0; k < edits; ++k) {
        alone.edit();
        part.edit();
    }
    const Settings settings = part.settings();
    alone.scene().clear_shutter();
    part.scene().clear_shutter();
    const Camera camera = part.camera();
    const Scene::Counts counts = part.scene().counts();

    Renderer renderer({.threads = 2, .memory_bytes = std::size_t(1) << 30});
    renderer.render(part.scene(), camera, settings);  // what it keeps of the part must not be taken for the whole
    Scene scene;
    const NodeId place = scene.add_node(scene.root(), {.name = "a place"});
    const AddedScene added = scene.add(std::move(part.scene()), place);
    scene.environment = added.environment;
    EXPECT_EQ(scene.counts().nodes, counts.nodes + 2);
    EXPECT_EQ(scene.counts().faces, counts.faces);
    EXPECT_EQ(scene.counts().skins, counts.skins);
    EXPECT_EQ(scene.counts().materials, counts.materials);

    const auto expect_same_picture = [&](const char* when) {
        EXPECT_EQ(renderer.render(scene, camera, settings).checksum(),
                  renderer.render(alone.scene(), camera, settings).checksum())
            << when;
    };
    expect_same_picture("as it was");
    const std::size_t copies = pose_all(scene, added.clips, added.node, added.node);
    EXPECT_EQ(pose_all(alone.scene(), alone.scene().clips(), alone.scene().root(), {}), copies);
    expect_same_picture("posed");
    scene.pose({}, added.node);
    alone.scene().pose({});
    expect_same_picture("at rest again");
    return copies;
}

TEST(RandomAdditions, ShowWhatTheSceneShowedBefore)
{
    if (const char* seed = std::getenv("OCCAM_SEED")) {
        expect_same_when_added(std::strtoull(seed, nullptr, 10), 40);
        return;
    }
    constexpr std::uint64_t kLargest = 4;  // its scene takes as long as those of all others
    std::size_t copies = 0;
    for (std::uint64_t seed = 1; seed <= (is_long() ? 60u : 8u) && !HasFailure(); ++seed)
        if (is_long() || seed != kLargest) copies += expect_same_when_added(seed, 40);
    EXPECT_GT(copies, is_long() ? 3u : 2u) << "too few copies to test anything";
}

}  // namespace
}  // namespace occam::test
