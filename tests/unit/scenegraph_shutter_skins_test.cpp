// Tests of where a skin is in the shutter after edits of the nodes above.
#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <string>

#include "occam/occam.h"
#include "scenegraph/content_hash.h"
#include "scenegraph/scene.h"
#include "tests/support/bent_strip.h"

namespace occam {
namespace {

using namespace test;

// Keys of where a skin is follow those of the nodes above, whatever was edited after they were recorded.
TEST(Shutter, ASkinStaysWhereItsJointsAreAfterEdits)
{
    Bent bent;
    Scene& scene = bent.scene;
    const NodeId outer = scene.add_node(scene.root(), {}), inner = scene.add_node(outer, {});
    const NodeId body = scene.add_node(inner, {.cages = {bent.cage}, .skin = bent.skin, .morph_weights = {0.5f}});
    NodeId late;
    const auto expect_in_place = [&](const char* edit) {
        scene.refit();
        for (const NodeId id : {body, late}) {
            const Node* node = scene.find(id);
            for (int k = 0; node && k <= 4; ++k) {
                const auto keys = scene.world_from_node_keys(id);
                const Mat4d& world = keys.empty() ? scene.world_from_node(id) : keys[std::size_t(k)];
                const Mat4d& from_skin = node->keys.empty() ? node->node_from_skin
                                                            : node->keys[std::size_t(k)].node_from_skin;
                EXPECT_LT(glm::length(Vec3d((world * from_skin)[3])), 1e-9) << edit << ", key " << k;
            }
        }
    };
    const auto record = [&] {
        scene.record_shutter(4, [&](double tau) {
            scene.set_transform(outer, moved(2 * tau, 0, 0));
            scene.set_transform(inner, moved(0, tau, 0) * turned(tau));
            scene.set_morph_weights(body, {float(tau)});
        });
        scene.refit();
    };
    const std::pair<const char*, std::function<void()>> edits[] = {
        {"none", [] {}},
        {"the same weights", [&] { scene.set_morph_weights(body, {0.5f}); }},
        {"other weights", [&] { scene.set_morph_weights(body, {0.75f}); }},
        {"the node's own place", [&] { scene.set_transform(body, moved(3, 0, 0)); }},
        {"a node above is shown as before", [&] { scene.set_visible(inner, true); }},
        {"a node above stands still", [&] { scene.set_transform(inner, moved(0, 7, 0)); }},
        {"both nodes above stand still", [&] { scene.set_visible(inner, true), scene.set_visible(outer, true); }},
        {"a skin is put on", [&] { scene.set_skin(body, {}), scene.refit(), scene.set_skin(body, bent.skin); }},
        {"a skinned node is added", [&] { late = scene.add_node(inner, {.cages = {bent.cage}, .skin = bent.skin}); }},
        {"a joint is edited", [&] { scene.set_transform(bent.tip_joint, moved(2, 1, 0)); }},
    };
    for (const auto& [name, edit] : edits) {
        record();
        edit();
        expect_in_place(name);
        EXPECT_TRUE(scene.node(body).keys.empty() || scene.node(body).keys[4].visible);
    }
    record();
    scene.set_transform(inner, Mat4d(1));
    scene.refit();
    EXPECT_EQ(scene.node(body).keys.at(4).morph_weights, std::vector<float>{1}) << "only what is edited loses its keys";
    scene.clear_shutter();
    scene.refit();
    EXPECT_EQ(scene.shutter_segments(), 0);
    EXPECT_TRUE(scene.node(body).keys.empty());
}

// Keys that are all alike are no motion: what is around them would count as moving.
TEST(Shutter, ASkinnedNodeWithoutMotionHasNoKeys)
{
    Bent bent;
    Scene& scene = bent.scene;
    const NodeId above = scene.add_node(scene.root(), {});
    const NodeId body = scene.add_node(above, {.cages = {bent.cage}, .skin = bent.skin});
    scene.record_shutter(4, [&](double tau) { scene.set_transform(above, moved(2 * tau, 0, 0)); });
    scene.refit();
    EXPECT_EQ(scene.node(body).keys.size(), 5u);
    scene.set_transform(above, moved(1, 0, 0));
    scene.refit();
    EXPECT_TRUE(scene.node(body).keys.empty());
    EXPECT_EQ(scene.shutter_segments(), 0);
}

// What hangs on a joint and what its skin deforms lose their motion together.
TEST(Shutter, AnyEditOfAJointDropsTheKeysOfItsSkin)
{
    for (const bool is_morph : {false, true}) {
        Bent bent;
        Scene& scene = bent.scene;
        scene.add_node(scene.root(), {.cages = {bent.cage}, .skin = bent.skin});
        scene.record_shutter(2, [&](double tau) { scene.set_transform(bent.tip_joint, moved(0, tau, 0)); });
        scene.refit();
        ASSERT_FALSE(scene.find(bent.skin)->key_poses.empty());
        if (is_morph) scene.set_morph_weights(bent.tip_joint, {});
        else scene.set_visible(bent.tip_joint, true);
        scene.refit();
        EXPECT_TRUE(scene.node(bent.tip_joint).keys.empty());
        EXPECT_TRUE(scene.find(bent.skin)->key_poses.empty());
        EXPECT_EQ(scene.shutter_segments(), 0);
    }
}

// What is left of a recording moves what hangs on a joint and what its skin deforms alike.
TEST(Shutter, ASkinFollowsWhatIsLeftOfTheMotionOfItsJoints)
{
    Bent bent;
    Scene& scene = bent.scene;
    const auto record = [&](NodeId goes) {
        scene.record_shutter(2, [&](double tau) { scene.set_transform(goes, moved(0, tau, 0)); });
    };
    const auto expect_tip_at_its_joint = [&](SkinId skin, const char* edit) {
        scene.refit();
        ASSERT_EQ(scene.find(skin)->key_poses.size(), 3u) << edit;
        const std::vector<Mat4d> joint = scene.world_from_node_keys(bent.tip_joint);
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec4d origin(2, 0, 0, 1);  // of the tip joint, in the mesh's axes
            EXPECT_EQ(scene.find(skin)->key_poses[k][1] * origin, joint.at(k)[3]) << edit << ", key " << k;
        }
    };
    record(bent.root_joint);
    scene.set_transform(bent.tip_joint, moved(2, 1, 0));
    expect_tip_at_its_joint(bent.skin, "a joint below one that moves is edited");

    const SkinId late = scene.add(Skin{"late", {bent.root_joint, bent.tip_joint}, {Mat4d(1), moved(-2, 0, 0)}});
    scene.add_node(scene.root(), {.cages = {bent.cage}, .skin = late});
    expect_tip_at_its_joint(late, "a skin is added after the recording");

    const NodeId mover = scene.add_node(scene.root(), {});
    record(mover);
    scene.refit();
    EXPECT_TRUE(scene.find(bent.skin)->key_poses.empty());
    scene.set_parent(bent.tip_joint, mover);
    expect_tip_at_its_joint(bent.skin, "a joint hangs below what moves");
    scene.set_parent(bent.tip_joint, bent.root_joint);
    scene.refit();
    EXPECT_TRUE(scene.find(bent.skin)->key_poses.empty());
}

// What is recorded does not depend on what was refitted before, and what a joint's removal does not on when it was removed.
TEST(Shutter, KeysOfSkinsDoNotDependOnHistory)
{
    const auto boxes = [](Bent& bent) {
        Scene& scene = bent.scene;
        scene.refit();
        const Node& node = scene.node(bent.skinned);
        std::vector<Box3d> found;
        for (std::size_t k = 0; k <= std::size_t(scene.shutter_segments()); ++k)
            found.push_back(cage_bounds(node, scene.cage(bent.cage), scene.find(bent.skin), k));
        return found;
    };
    const auto expect_same = [](const std::vector<Box3d>& a, const std::vector<Box3d>& b, const char* what) {
        ASSERT_EQ(a.size(), b.size()) << what;
        for (std::size_t k = 0; k < a.size(); ++k) EXPECT_TRUE(a[k].lo == b[k].lo && a[k].hi == b[k].hi) << what << ' ' << k;
    };
    // The tip is elsewhere only between the two keys.
    const auto bend = [](Bent& bent) {
        bent.scene.record_shutter(1, [&](double tau) {
            bent.scene.set_transform(bent.root_joint, moved(tau, 0, 0));
            bent.scene.set_transform(bent.tip_joint, moved(2, 4 * tau * (1 - tau), 0));
        });
    };
    Bent fresh, known;
    known.scene.refit();
    bend(fresh);
    bend(known);
    expect_same(boxes(fresh), boxes(known), "refitted before");

    const auto slide = [](Bent& bent) {
        bent.scene.record_shutter(2, [&](double tau) { bent.scene.set_transform(bent.skinned, moved(tau, 0, 0)); });
        bent.scene.refit();
    };
    for (const bool keeps_tip : {false, true}) {
        Bent before, after;
        NodeId removed[2];
        for (Bent* bent : {&before, &after}) {
            Scene& scene = bent->scene;
            NodeId& extra = removed[bent == &after] = bent->root_joint;
            if (!keeps_tip) continue;
            extra = scene.add_node(scene.root(), {});  // the base of both joints is the root, and that of the tip lower
            bent->skin = scene.add(Skin{"", {extra, bent->tip_joint}, {}});
            scene.set_skin(bent->skinned, bent->skin);
            scene.set_transform(bent->root_joint, moved(0, 3, 0));
        }
        before.scene.remove(removed[0]);
        slide(before);
        slide(after);
        after.scene.remove(removed[1]);
        expect_same(boxes(before), boxes(after), keeps_tip ? "the tip is left" : "no joint is left");
    }
}

/// A strip whose tip bends, worn by a node that hangs below another one that moves, beside a square that stands still.
struct Worn {
    Bent bent;
    NodeId hero, above, body, other;
    SkinId other_skin;

    Worn()
    {
        Scene& scene = bent.scene;
        scene.remove(bent.skinned);
        scene.add_node(scene.root(), {.matrix = moved(0, -3, 0), .cages = {scene.add(unit_square())}});
        hero = scene.add_node(scene.root(), {});
        scene.set_parent(bent.root_joint, hero);
        above = scene.add_node(hero, {});
        body = scene.add_node(above, {.cages = {bent.cage}, .skin = bent.skin});
        other = scene.add_node(scene.root(), {.cages = {bent.cage}});
        other_skin = scene.add(Skin{"other", {above}, {}});
    }
    void pose(double tau)
    {
        Scene& scene = bent.scene;
        if (scene.find(above)) scene.set_transform(above, moved(0, tau, 0) * turned(tau));
        if (scene.find(bent.tip_joint)) scene.set_transform(bent.tip_joint, moved(2, 0, 0) * turned(2 * tau));
    }
    void record()
    {
        bent.scene.record_shutter(4, [&](double tau) { pose(tau); });
    }
    /// Gives all that moves its place in the middle of the shutter, where it stays.
    void stop() { pose(0.5); }
};

void expect_same_scene(Scene& a, Scene& b, const std::string& what)
{
    a.refit();
    b.refit();
    EXPECT_EQ(a.shutter_segments(), b.shutter_segments()) << what;
    EXPECT_EQ(content_hash(a), content_hash(b)) << what;
    EXPECT_EQ(a.contents().has(Contents::Moving), b.contents().has(Contents::Moving)) << what;
    const Camera camera = Camera::look_at({1, 1, 12}, {1, 1, 0}, {0, 1, 0}, 0.8f);
    const Settings settings{.width = 24, .height = 18, .spp = 2};
    Renderer renderer({.threads = 1});
    EXPECT_EQ(renderer.memory_floor(a), renderer.memory_floor(b)) << what;
    EXPECT_EQ(renderer.render(a, camera, settings).checksum(), renderer.render(b, camera, settings).checksum()) << what;
}

// Nothing of a recording is left where the nodes that moved stand still, whatever became of those that wear skins.
TEST(Shutter, AnEditedSceneMovesAsOneBuiltAnew)
{
    using Edit = std::function<void(Worn&)>;
    const std::pair<const char*, Edit> edits[] = {
        {"none", [](Worn&) {}},
        {"wearer removed", [](Worn& w) { w.bent.scene.remove(w.body); }},
        {"skin taken off", [](Worn& w) { w.bent.scene.set_skin(w.body, {}); }},
        {"another skin put on", [](Worn& w) { w.bent.scene.set_skin(w.body, w.other_skin); }},
        {"wearer added", [](Worn& w) { w.bent.scene.set_skin(w.other, w.bent.skin); }},
        {"wearer replaced", [](Worn& w) { w.bent.scene.remove(w.body), w.bent.scene.set_skin(w.other, w.bent.skin); }},
        {"wearer hidden", [](Worn& w) { w.bent.scene.set_visible(w.body, false); }},
        {"skin removed", [](Worn& w) { w.bent.scene.remove(w.bent.skin); }},
        {"joint removed", [](Worn& w) { w.bent.scene.remove(w.bent.tip_joint); }},
        {"joint and wearer removed", [](Worn& w) { w.bent.scene.remove(w.bent.tip_joint), w.bent.scene.remove(w.body); }},
        {"all joints removed", [](Worn& w) { w.bent.scene.remove(w.bent.root_joint); }},
        {"wearer and joints removed together", [](Worn& w) { w.bent.scene.remove(w.hero); }},
        {"wearer hung elsewhere", [](Worn& w) { w.bent.scene.set_parent(w.body, w.bent.scene.root()); }},
    };
    for (const auto& [name, edit] : edits)
        for (const bool refits : {false, true}) {
            const std::string what = std::string(name) + (refits ? ", refitted in between" : "");
            const auto apply = [&](Worn& to, std::initializer_list<Edit> steps) {
                for (const Edit& step : steps) {
                    step(to);
                    if (refits) to.bent.scene.refit();
                }
            };
            const Edit record = [](Worn&w) { w.record(); }, stop = [](Worn&w) { w.stop(); };
            Worn fresh, edited;
            apply(fresh, {edit, record});
            apply(edited, {record, edit});
            expect_same_scene(edited.bent.scene, fresh.bent.scene, what);
            Worn still, before, after;
            apply(still, {edit, stop});
            apply(before, {record, edit, stop});
            apply(after, {record, stop, edit});
            before.bent.scene.refit();
            EXPECT_EQ(before.bent.scene.shutter_segments(), 0) << what;
            expect_same_scene(before.bent.scene, still.bent.scene, what + ", then stopped");
            expect_same_scene(after.bent.scene, still.bent.scene, what + ", stopped before");
        }
}

TEST(Shutter, ASkinThatNobodyWearsHasNoKeysUntilANodeWearsIt)
{
    Worn worn;
    Scene& scene = worn.bent.scene;
    worn.record();
    EXPECT_FALSE(scene.find(worn.bent.skin)->key_poses.empty());
    scene.set_skin(worn.body, {});
    EXPECT_TRUE(scene.find(worn.bent.skin)->key_poses.empty());
    worn.record();
    EXPECT_TRUE(scene.find(worn.bent.skin)->key_poses.empty());
    EXPECT_EQ(scene.shutter_segments(), 4) << "the joint moves all the same";
    for (int times = 0; times < 3; ++times) {
        scene.set_skin(worn.body, worn.bent.skin);
        scene.refit();
        EXPECT_EQ(scene.find(worn.bent.skin)->key_poses.size(), 5u);
        scene.set_skin(worn.body, {});
        EXPECT_TRUE(scene.find(worn.bent.skin)->key_poses.empty());
    }
    worn.stop();
    EXPECT_EQ(scene.shutter_segments(), 0) << "no refit is needed";
}

// Whatever is edited, something has keys only if it is worn or placed, and if what it depends on moves.
TEST(Shutter, KeysOfSkinsNeedAJointThatMovesAndANodeThatWearsThem)
{
    std::mt19937 random(7);
    const auto pick = [&](std::size_t n) { return std::size_t(random() % n); };
    int moving = 0, still = 0;
    for (int world = 0; world < 60; ++world) {
        Worn worn;
        Scene& scene = worn.bent.scene;
        const SkinId skins[] = {worn.bent.skin, worn.other_skin, SkinId()};
        const NodeId nodes[] = {worn.above, worn.body, worn.other, worn.bent.tip_joint, worn.bent.root_joint};
        worn.record();
        for (int step = 0; step < 1 + world % 12; ++step) {
            const std::size_t kind = pick(10);
            const NodeId id = nodes[pick(5)];
            const SkinId skin = skins[pick(3)];
            if (!scene.find(id)) continue;
            if (kind < 3) scene.set_transform(id, moved(double(pick(3)), 0, 0));
            else if (kind < 6 && (!skin || scene.find(skin))) scene.set_skin(id, skin);
            else if (kind == 6) scene.set_visible(id, pick(2) == 0);
            else if (kind == 7 && pick(4) == 0) scene.remove(id);
            else if (kind == 8 && skin && scene.find(skin) && pick(4) == 0) scene.remove(skin);
            else if (kind == 9) worn.pose(0.5);
            if (pick(2) == 0) scene.refit();
        }
        scene.refit();
        bool has_keys = false, has_moving_node = false;
        for (const NodeId id : {worn.hero, worn.above, worn.body, worn.other, worn.bent.tip_joint, worn.bent.root_joint}) {
            if (!scene.find(id)) continue;
            has_keys |= !scene.node(id).keys.empty();
            const std::vector<NodeKey>& keys = scene.node(id).keys;
            for (const NodeKey& key : keys)
                has_moving_node |= key.parent_from_node != keys[0].parent_from_node || key.visible != keys[0].visible;
        }
        for (const SkinId skin : skins) {
            if (!scene.find(skin) || scene.find(skin)->key_poses.empty()) continue;
            bool is_worn = false;
            for (const NodeId id : nodes) is_worn |= scene.find(id) && scene.node(id).skin == skin;
            EXPECT_TRUE(is_worn && has_moving_node) << "world " << world;
            has_keys = true;
        }
        EXPECT_EQ(scene.shutter_segments() > 0, has_keys) << "world " << world;
        EXPECT_EQ(scene.shutter_segments() > 0, has_moving_node) << "world " << world;
        ++(has_moving_node ? moving : still);
    }
    EXPECT_GT(moving, 10);
    EXPECT_GT(still, 10);
}

}  // namespace
}  // namespace occam
