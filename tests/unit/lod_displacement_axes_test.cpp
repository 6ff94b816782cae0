// Tests of the direction of displacement vectors: in the object's axes, rotated as poses rotate the surface, or in the
// surface's own axes.
#include <gtest/gtest.h>
#include "verify/verify.h"

#include <cmath>

#include "scenegraph/foreign_texture.h"
#include "tests/support/campaign.h"
#include "tests/support/diced_mesh.h"
#include "tests/support/displaced_cages.h"

namespace occam::test {
namespace {

Mat4d mirrored_and_turned()
{
    Mat4d place(1);
    place[0] = {0, -2, 0, 0};
    place[1] = {-2, 0, 0, 0};
    place[2] = {0, 0, -2, 0};
    place[3] = {3, -2, 7, 1};
    return place;
}

// Calls compare(moved minus still, the undisplaced grid, its attributes, i, j) for vertices that are not on borders of
// tiles.
template <class Compare>
void for_moves(DicedCage& still, DicedCage& moved, Compare&& compare)
{
    still.posed.level = moved.level_of_largest_exponent(4);
    for (const lod::TileRef& tile : moved.tiles()) {
        const lod::LevelGrid after = moved.dicer.dice(moved.posed, tile, moved.arena),
                             before = still.dicer.dice(still.posed, tile, still.arena);
        const lod::GridAttributes made = still.dicer.shade(still.posed, tile, tile.rates, still.arena);
        for (int j = 1; j < tile.rows; ++j)
            for (int i = 1; i < tile.columns; ++i) compare(after.vertex(i, j) - before.vertex(i, j), before, made, i, j);
    }
}

TEST(DisplacementInTangentSpace, OfTheThirdChannelIsThatAlongNormals)
{
    for (const Mat4d& place : {Mat4d(1), mirrored_and_turned()}) {
        DisplacedCage by_tangents = displaced_case(8), by_normals = displaced_case(8);
        by_normals.cage.displacement->space = Displacement::Space::Normal;
        set_texel(by_tangents, {0.5f, 0.5f, 0.9f});
        set_texel(by_normals, {0.9f, 0, 0});
        DicedCage a(by_tangents.cage, 0, place, &by_tangents.textures), b(by_normals.cage, 0, place, &by_normals.textures);
        b.posed.level = a.level_of_largest_exponent(4);
        for (const lod::TileRef& tile : a.tiles()) {
            const lod::LevelGrid x = a.dicer.dice(a.posed, tile, a.arena), y = b.dicer.dice(b.posed, tile, b.arena);
            for (int k = 0; k < x.vertex_count; ++k) ASSERT_NEAR(glm::distance(x.at(k), y.at(k)), 0, 2e-6f);
        }
    }
}

TEST(DisplacementInTangentSpace, FollowsATransformAsItFollowsCoordinates)
{
    DisplacedCage transformed = displaced_case(8), baked = displaced_case(8);
    set_texel(transformed, {0.9f, 0.3f, 0.6f});
    set_texel(baked, {0.9f, 0.3f, 0.6f});
    TextureUse& use = transformed.cage.displacement->texture;
    use.rotation = 0.7f;
    use.scale = {2, -0.6f};
    for (Vec2f& uv : baked.cage.uv_sets[0].values) uv = scaled_and_rotated(use, uv);
    DicedCage a(transformed.cage, 0, mirrored_and_turned(), &transformed.textures),
        b(baked.cage, 0, mirrored_and_turned(), &baked.textures);
    b.posed.level = a.level_of_largest_exponent(4);
    for (const lod::TileRef& tile : a.tiles()) {
        const lod::LevelGrid x = a.dicer.dice(a.posed, tile, a.arena), y = b.dicer.dice(b.posed, tile, b.arena);
        for (int k = 0; k < x.vertex_count; ++k) ASSERT_NEAR(glm::distance(x.at(k), y.at(k)), 0, 1e-5f);
    }
}

TEST(DisplacementInTangentSpace, OfTheFirstTwoFollowsTheCoordinatesOverTheSurface)
{
    for (const Mat4d& place : {Mat4d(1), mirrored_and_turned()})
        for (const bool is_up : {false, true}) {
            DisplacedCage displaced = displaced_case(8);
            set_texel(displaced, is_up ? Vec3f(0.5f, 1, 0.5f) : Vec3f(1, 0.5f, 0.5f));
            const float far = displaced.cage.displacement->bound * (place == Mat4d(1) ? 1.0f : 2.0f);
            DicedCage still(displaced.cage, 0, place), moved(displaced.cage, 0, place, &displaced.textures);
            int compared = 0;
            for_moves(still, moved,
                      [&](Vec3f move, const lod::LevelGrid& grid, const lod::GridAttributes& made, int i, int j) {
                          const Vec3f di = grid.vertex(i + 1, j) - grid.vertex(i - 1, j),
                                      dj = grid.vertex(i, j + 1) - grid.vertex(i, j - 1);
                          const Vec2f ui = made.uv[0][grid.index(i + 1, j)] - made.uv[0][grid.index(i - 1, j)],
                                      uj = made.uv[0][grid.index(i, j + 1)] - made.uv[0][grid.index(i, j - 1)];
                          const float turn = ui.x * uj.y - ui.y * uj.x;
                          const Vec3f normal = made.normal[grid.index(i, j)],
                                      along_u = glm::normalize((di * uj.y - dj * ui.y) / turn);
                          const Vec3f along_v = (dj * ui.x - di * uj.x) / turn;
                          const Vec3f up = -glm::normalize(along_v - along_u * glm::dot(along_v, along_u));
                          ASSERT_NEAR(glm::length(move), far, 1e-3f * far);
                          ASSERT_NEAR(glm::dot(move, normal), 0, 0.02f * far);
                          // The difference spans two steps of an eighth of the tube's quadrant.
                          ASSERT_GT(glm::dot(move, is_up ? up : along_u), 0.98f * far);
                          ++compared;
                      });
            EXPECT_GT(compared, 500);
        }
}

TEST(DisplacementInTangentSpace, WithoutATangentKeepsTheNormalsPart)
{
    DisplacedCage displaced = displaced_case(8);
    set_texel(displaced, {1, 0.5f, 0.75f});
    for (Vec2f& uv : displaced.cage.uv_sets[0].values) uv.y = 0;
    DicedCage still(displaced.cage, 0), moved(displaced.cage, 0, Mat4d(1), &displaced.textures);
    const float height = displaced.cage.displacement->scale * 0.25f;
    for_moves(still, moved, [&](Vec3f move, const lod::LevelGrid& grid, const lod::GridAttributes& made, int i, int j) {
        // The bound first shortens the whole vector.
        ASSERT_GT(glm::dot(move, made.normal[grid.index(i, j)]), 0.8f * height);
        ASSERT_NEAR(glm::length(glm::cross(move, made.normal[grid.index(i, j)])), 0, 1e-4f);
    });
}

// A skin of one joint moves everything as a node does, including the vectors.
TEST(DisplacementByVectors, TurnsWithAJointAsWithANode)
{
    for (const Mat4d& joint : {bent_joints()[1], bent_joints()[1] * Mat4d(Vec4d(-1, 0, 0, 0), Vec4d(0, 1, 0, 0),
                                                                          Vec4d(0, 0, 1, 0), Vec4d(0, 0, 0, 1))})
        for (const int c : {6, 7}) {
            DisplacedCage displaced = displaced_case(c);
            DicedCage placed(displaced.cage, 0, joint, &displaced.textures);
            displaced.cage.skin.sets = 1;
            displaced.cage.skin.joints.assign(displaced.cage.positions.size(), {0, 0, 0, 0});
            displaced.cage.skin.weights.assign(displaced.cage.positions.size(), {1, 0, 0, 0});
            DicedCage posed(displaced.cage, 0, Mat4d(1), &displaced.textures, {&joint, 1});
            ASSERT_TRUE(posed.posed.displacement.turns);
            placed.posed.level = posed.level_of_largest_exponent(4);
            int compared = 0;
            for (const lod::TileRef& tile : posed.tiles()) {
                const lod::LevelGrid a = posed.dicer.dice(posed.posed, tile, posed.arena),
                                     b = placed.dicer.dice(placed.posed, tile, placed.arena);
                ASSERT_EQ(a.vertex_count, b.vertex_count);
                for (int k = 0; k < a.vertex_count; ++k) {
                    const Vec3d x = Vec3d(a.at(k)) + posed.posed.anchor, y = Vec3d(b.at(k)) + placed.posed.anchor;
                    ASSERT_NEAR(glm::distance(x, y), 0, 1e-5) << displaced.name;
                    ++compared;
                }
            }
            EXPECT_GT(compared, 500);
        }
}

// Where joints move differently, the surface between them is sheared and bent. The vectors of one texel then keep their
// length and turn smoothly.
TEST(DisplacementByVectors, GoesAsFarWhenPosedAndTurnsSmoothlyOverTheSurface)
{
    DisplacedCage displaced = displaced_case(6);
    displaced.cage.creases.clear();
    add_skin(displaced.cage);
    set_texel(displaced, {0.9f, 0.3f, 0.6f});
    const std::vector<Mat4d> joints = bent_joints();
    DicedCage still(displaced.cage, 0, Mat4d(1), nullptr, joints),
        moved(displaced.cage, 0, Mat4d(1), &displaced.textures, joints);
    const float far = displaced.cage.displacement->bound * glm::length(Vec3f(0.8f, -0.4f, 0.2f));
    still.posed.level = moved.level_of_largest_exponent(4);
    float sharpest = 0, turned = 0;
    for (const lod::TileRef& tile : moved.tiles()) {
        const lod::LevelGrid after = moved.dicer.dice(moved.posed, tile, moved.arena),
                             before = still.dicer.dice(still.posed, tile, still.arena);
        const auto move = [&](int i, int j) { return after.vertex(i, j) - before.vertex(i, j); };
        for (int j = 0; j < tile.rows; ++j)
            for (int i = 0; i < tile.columns; ++i) {
                ASSERT_NEAR(glm::length(move(i, j)), far, 2e-3f * far);
                sharpest = std::max({sharpest, glm::distance(move(i, j), move(i + 1, j)) / far,
                                     glm::distance(move(i, j), move(i, j + 1)) / far});
                turned = std::max(turned, glm::distance(move(i, j), glm::normalize(Vec3f(0.8f, -0.4f, 0.2f)) * far) / far);
            }
    }
    // Border points belong to the curves' owners, so a step that ends on a border shows how far neighbours disagree.
    EXPECT_LT(sharpest, 0.2f);
    EXPECT_GT(turned, 0.6f);
}

TEST(Verify, HoldsForDisplacedCagesAsTheyArePosed)
{
    for (const int c : {8, 6, 9}) {
        if (c != 8 && !is_long()) continue;
        DisplacedCage displaced = displaced_case(c);
        add_skin(displaced.cage);
        Scene& scene = displaced.scene;
        NodeDesc node{.name = "posed", .cages = {add_with_foreign_texture(scene, displaced.cage)}};
        Skin skin;
        for (const Mat4d& joint : bent_joints()) skin.joints.push_back(scene.add_node(scene.root(), {.matrix = joint}));
        node.skin = scene.add(std::move(skin));
        scene.add_node(scene.root(), node);
        const std::uint64_t rays = is_long() ? 40'000 : 6'000;
        const std::vector<VerifiedCage> reports = verify(scene, {.rays = rays, .largest_rate = 8});
        ASSERT_EQ(reports.size(), 1u);
        EXPECT_EQ(reports[0].not_testable, "");
        EXPECT_GE(reports[0].rays, rays);
        EXPECT_TRUE(reports[0].holds()) << displaced.name << ' ' << reports[0].escaped
                                        << (reports[0].replay.empty() ? "" : reports[0].replay[0]);
    }
}

}  // namespace
}  // namespace occam::test
