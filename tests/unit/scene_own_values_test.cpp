// Values that a scene returns are given back to it.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include "tests/support/shape_builders.h"

namespace occam {
namespace {

// Announcing the edit drops the keys of the shutter, among them the positions that are written.
TEST(OwnValues, PositionsAtAKeyCanBeWritten)
{
    Scene scene;
    Cage ball = test::torus(40, 30);
    const std::vector<Vec3f> before = ball.positions;
    std::vector<Vec3f> after = before;
    for (Vec3f& p : after) p.y += 1;
    const CageId id = scene.add(std::move(ball));
    scene.add_node(scene.root(), {.cages = {id}});
    scene.record_shutter(1, [&](double tau) { scene.write_vertices(id, tau > 0 ? after : before); });
    ASSERT_EQ(scene.cage(id).key_positions.size(), 2u);
    scene.write_vertices(id, scene.cage(id).key_positions[0]);
    EXPECT_EQ(scene.cage(id).cage.positions, before);
    scene.write_vertices(id, scene.cage(id).cage.positions);
    EXPECT_EQ(scene.cage(id).cage.positions, before);
}

TEST(OwnValues, ASkinnedCageThatIsPutBackStaysAsItIs)
{
    Scene scene;
    Cage cage = test::torus(60, 40);
    cage.skin.sets = 1;
    for (std::size_t v = 0; v < cage.positions.size(); ++v) {
        const float w = 0.1f + 0.00037f * float(v);
        cage.skin.joints.push_back({0, 1, 2, 3});
        cage.skin.weights.push_back({w, 0.3f, 0.7f * w, 0.21f});
    }
    const CageId id = scene.add(std::move(cage));
    const std::vector<Vec4f> once = scene.cage(id).cage.skin.weights;
    scene.replace(id, scene.cage(id).cage);
    EXPECT_EQ(scene.cage(id).cage.skin.weights, once);
}

TEST(OwnValues, MaterialsRefuseCoordinatesThatAreNotShaded)
{
    Scene scene;
    Texture texture;
    texture.width = texture.height = 1;
    texture.pixels = {Vec4f(1)};
    Material material;
    material.base_color_texture.texture = scene.add(std::move(texture));
    for (const int set : {0, 1}) {
        material.base_color_texture.uv_set = set;
        EXPECT_NO_THROW(scene.add(material)) << set;
    }
    for (const int set : {-1, 2}) {
        material.base_color_texture.uv_set = set;
        EXPECT_THROW(scene.add(material), Error) << set;
    }
}

TEST(OwnValues, AJobWhosePictureIsTakenHasAnEmptyOne)
{
    Scene scene;
    scene.add_node(scene.root(), {.cages = {scene.add(test::torus())}});
    Renderer renderer;
    Job job = renderer.start(scene, Camera::framing(Box3d{Vec3d(-1), Vec3d(1)}), {.width = 8, .height = 8, .spp = 1});
    EXPECT_EQ(job.take_image().width, 8);
    EXPECT_EQ(job.image().width, 0);
    EXPECT_TRUE(job.image().layers().empty());
}

}  // namespace
}  // namespace occam
