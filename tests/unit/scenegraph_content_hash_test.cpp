// A hash of a scene is the same for scenes that show the same, and tells apart what differs in anything that is shown.
#include "scenegraph/content_hash.h"

#include <gtest/gtest.h>

#include <functional>

#include "tests/support/bent_strip.h"

namespace occam {
namespace {

using namespace test;

struct HashedScene : Bent {
    NodeId square, group, hidden, lit;
    MaterialId material;
    TextureId texture;
    LightId light;
    CageId mesh;

    HashedScene()
    {
        texture = scene.add(Texture{.name = {}, .path = {}, .encoded = {}, .pixels = {Vec4f(1)}, .width = 1, .height = 1});
        Material textured;
        textured.base_color_texture.texture = texture;
        material = scene.add(textured);
        Cage shape = unit_square();
        shape.materials = {material};
        shape.uv_sets = {{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {}}};
        shape.morph_targets = {{"up", std::vector<Vec3f>(4, Vec3f(0, 0, 1)), {}}};
        mesh = scene.add(shape);
        group = scene.add_node(scene.root(), {.name = "group"});
        square = scene.add_node(group, {.cages = {mesh}, .morph_weights = {0.5f}});
        hidden = scene.add_node(scene.root(), {.visible = false});
        scene.add_node(hidden, {.cages = {mesh}});
        light = scene.add(Light{{}, PointLight{}});
        lit = scene.add_node(scene.root(), {.light = light});
    }
    std::uint64_t hash()
    {
        scene.refit();
        return content_hash(scene);
    }
};

TEST(ContentHash, IsTheSameForScenesThatShowTheSame)
{
    HashedScene subject, other;
    EXPECT_EQ(subject.hash(), other.hash());
    const NodeId passing = other.scene.add_node(other.group, {.cages = {other.scene.add(unit_square())}});
    EXPECT_NE(subject.hash(), other.hash());
    other.scene.remove(passing);
    EXPECT_EQ(subject.hash(), other.hash());
    // Later objects then have other handles than in a scene without them.
    const TextureId passing_texture = other.scene.add(Texture{});
    const MaterialId passing_material = other.scene.add(Material{}),
                     same = other.scene.add(other.scene.material(other.material));
    other.scene.set_materials(other.square, {same});
    subject.scene.set_materials(subject.square, {subject.scene.add(subject.scene.material(subject.material))});
    other.scene.remove(passing_texture);
    other.scene.remove(passing_material);
    EXPECT_EQ(subject.hash(), other.hash());
    other.scene.set_transform(other.hidden, moved(1, 0, 0));
    EXPECT_EQ(subject.hash(), other.hash()) << "what is hidden does not count";
    other.scene.record_shutter(2, [&](double tau) { other.scene.set_transform(other.square, moved(tau, 0, 0)); });
    other.scene.set_transform(other.square, Mat4d(1));
    EXPECT_EQ(subject.hash(), other.hash()) << "nor do keys that were dropped";
}

TEST(ContentHash, CountsTheSlotsOfNodesOnlyWhereItIsToldTo)
{
    HashedScene subject, other, shifted;
    const auto slots_hash = [](HashedScene& of) {
        of.scene.refit();
        return content_and_slots_hash(of.scene);
    };
    EXPECT_EQ(slots_hash(subject), slots_hash(other));
    EXPECT_NE(slots_hash(subject), subject.hash());
    other.scene.add_node(other.hidden, {});
    EXPECT_EQ(slots_hash(subject), slots_hash(other)) << "what is hidden does not count";
    const NodeId passing = shifted.scene.add_node(shifted.group, {});
    for (HashedScene* of : {&subject, &shifted}) of->scene.add_node(of->scene.root(), {.cages = {of->mesh}});
    shifted.scene.remove(passing);
    EXPECT_EQ(subject.hash(), shifted.hash());
    EXPECT_NE(slots_hash(subject), slots_hash(shifted));
}

TEST(ContentHash, DoesNotCountCagesThatWereRemoved)
{
    HashedScene subject;
    const std::uint64_t before = subject.hash();
    const CageId passing = subject.scene.add(unit_square());
    subject.scene.set_cages(subject.square, {passing, subject.mesh});
    EXPECT_NE(subject.hash(), before);
    subject.scene.remove(passing);
    EXPECT_EQ(subject.hash(), before);
}

// A texture is filtered in another way if materials that cut out alone use it, also such as nothing shows.
TEST(ContentHash, KnowsWhetherATextureIsCutOut)
{
    HashedScene subject;
    Material mask = subject.scene.material(subject.material);
    mask.alpha_mode = AlphaMode::Mask;
    subject.scene.replace(subject.material, mask);
    const std::uint64_t before = subject.hash();
    Material plain;
    plain.base_color_texture.texture = subject.texture;
    const MaterialId unused = subject.scene.add(plain);
    EXPECT_NE(subject.hash(), before);
    subject.scene.remove(unused);
    EXPECT_EQ(subject.hash(), before);
}

TEST(ContentHash, TellsEditsApart)
{
    const std::function<void(HashedScene&)> edits[] = {
        [](HashedScene&) {},
        [](HashedScene& s) { s.scene.set_transform(s.group, moved(1, 0, 0)); },
        [](HashedScene& s) { s.scene.set_transform(s.square, moved(1, 0, 0)); },
        [](HashedScene& s) { s.scene.set_transform(s.tip_joint, moved(1, 0, 0)); },
        [](HashedScene& s) { s.scene.set_morph_weights(s.square, {1}); },
        [](HashedScene& s) { s.scene.set_visible(s.square, false); },
        [](HashedScene& s) { s.scene.set_visible(s.hidden, true); },
        [](HashedScene& s) { s.scene.set_seen_by(s.square, 1); },
        [](HashedScene& s) { s.scene.set_lit_by(s.square, 1); },
        [](HashedScene& s) { s.scene.add_node(s.group, {}); },  // also what holds nothing
        [](HashedScene& s) { s.scene.add_node(s.group, {.instance_of = s.hidden}); },
        [](HashedScene& s) { s.scene.add_node(s.square, {.instance_of = s.hidden}); },
        [](HashedScene& s) { s.scene.set_materials(s.square, {s.scene.add(Material{})}); },
        [](HashedScene& s) { s.scene.replace(s.material, Material{}); },
        [](HashedScene& s) {
            Material m = s.scene.material(s.material);
            m.base_color_texture.rotation = 1;
            s.scene.replace(s.material, m);
        },
        [](HashedScene& s) {
            s.scene.replace(s.light, Light{{}, SunLight{}});
        },
        [](HashedScene& s) {
            s.scene.replace(s.light, Light{{}, PointLight{Vec3f(2)}});
        },
        [](HashedScene& s) { s.scene.remove(s.light); },
        [](HashedScene& s) {
            Cage cage = s.scene.cage(s.mesh).cage;
            cage.uv_sets[0].values[2].x = 0.5f;
            s.scene.replace(s.mesh, cage);
        },
        [](HashedScene& s) {
            std::vector<Vec3f> positions = s.scene.cage(s.cage).cage.positions;
            positions[3].z += 1;
            s.scene.write_vertices(s.cage, positions);
        },
        [](HashedScene& s) { s.scene.environment.radiance = Vec3f(1); },
        [](HashedScene& s) { s.scene.environment.image = s.texture; },
        [](HashedScene& s) { s.scene.replace(s.texture, Texture{}); },
        [](HashedScene& s) {
            s.scene.record_shutter(1, [&](double t) { s.scene.set_transform(s.square, moved(t - 0.5, 0, 0)); });
        },
        [](HashedScene& s) {
            s.scene.record_shutter(2, [&](double t) { s.scene.set_transform(s.square, moved(t - 0.5, 0, 0)); });
        },
        [](HashedScene& s) {
            s.scene.record_shutter(2, [&](double t) { s.scene.set_transform(s.tip_joint, moved(2, t, 0)); });
        },
        [](HashedScene& s) { s.scene.record_shutter(2, [&](double t) { s.scene.set_visible(s.square, t < 1); }); },
    };
    std::vector<std::uint64_t> hashes;
    for (const auto& edit : edits) {
        HashedScene subject;
        edit(subject);
        const std::uint64_t hash = subject.hash();
        for (std::size_t i = 0; i < hashes.size(); ++i) EXPECT_NE(hash, hashes[i]) << hashes.size() << " and " << i;
        hashes.push_back(hash);
    }
}

// Lights are those of the middle of the shutter, although no segment of the shutter shows this one's node.
TEST(ContentHash, KnowsALightThatIsVisibleInTheMiddleOfTheShutterAlone)
{
    HashedScene subject;
    subject.scene.record_shutter(1, [&](double t) { subject.scene.set_visible(subject.lit, t >= 0.5); });
    const std::uint64_t before = subject.hash();
    subject.scene.replace(subject.light, Light{{}, SunLight{}});
    EXPECT_NE(subject.hash(), before);
}

}  // namespace
}  // namespace occam
