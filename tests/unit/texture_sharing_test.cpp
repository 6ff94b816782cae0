// Pixels that a scene holds in memory are shared with the stores of its renderers, and what these hold is not changed by
// edits.
#include <gtest/gtest.h>

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "io/texture/texture_store.h"
#include "occam/occam.h"
#include "tests/support/resident_memory.h"
#include "tests/support/shape_builders.h"

namespace occam {
namespace {

Texture plain(int side, float grey)
{
    Texture texture;
    texture.name = "plain";
    texture.width = texture.height = side;
    texture.pixels.assign(std::size_t(side) * std::size_t(side), Vec4f(grey, grey, grey, 1));
    return texture;
}

// Adds a square that shows the texture.
void show(Scene& scene, TextureId texture)
{
    Material material;
    material.base_color_texture.texture = texture;
    Cage square = test::textured_square();
    square.materials = {scene.add(material)};
    test::place(scene, scene.add(std::move(square)), Vec3d(0));
}

TEST(TextureSharing, ARendererDoesNotCopyPixelsThatItNeverLooksUp)
{
    if (!test::can_measure_memory()) GTEST_SKIP() << "sanitizers have allocators of their own, or there is no /proc";
    constexpr int kSide = 2048;
    Scene scene;
    show(scene, scene.add(plain(kSide, 0.5f)));
    const Camera away = Camera::look_at({0, 0, 3}, {0, 0, 9}, {0, 1, 0}, 0.7f);
    const Settings settings{.width = 16, .height = 12, .spp = 1};
    const auto renderer = [] { return Renderer({.threads = 1, .texture_bytes = std::size_t(1) << 20}); };
    renderer().render(scene, away, settings);  // what the first frame of a process takes is there from then on
    Renderer first = renderer(), second = renderer();
    const std::size_t before = test::resident_bytes();
    first.render(scene, away, settings);
    second.render(scene, away, settings);
    constexpr std::size_t kPixels = std::size_t(kSide) * kSide * sizeof(Vec4f);
    EXPECT_LT(test::resident_bytes(), before + kPixels / 2);
}

TEST(TextureSharing, AStoreHoldsPixelsUntilTheyAreDecoded)
{
    Scene scene;
    const TextureId id = scene.add(plain(4, 0.5f));
    const std::weak_ptr<const Texture> known = scene.share(id);
    EXPECT_EQ(known.lock().get(), &scene.texture(id));
    TextureStore store(1 << 20);
    store.prepare(scene);
    EXPECT_EQ(known.use_count(), 2);
    scene.replace(id, plain(4, 0.25f));
    EXPECT_FALSE(known.expired());
    TextureUse use;
    use.texture = id;
    EXPECT_EQ(store.sample(use, Vec2f(0.5f), 0).x, 0.5f) << "the store knows the texture as it was at prepare()";
    EXPECT_TRUE(known.expired()) << "it has its own levels now";
    store.prepare(scene);
    EXPECT_EQ(store.sample(use, Vec2f(0.5f), 0).x, 0.25f);
    EXPECT_EQ(scene.share({}), nullptr);
}

// The renderer of a part knows its texture by the identity that it had before the part was added to another scene.
TEST(TextureSharing, APartThatIsAddedToASceneLeavesStoresWhatTheyHold)
{
    for (const bool is_shared : {false, true}) {
        Scene scene, part;
        const TextureId old = part.add(plain(4, 0.5f));
        show(part, old);
        const std::uint64_t identity = part.texture(old).identity;
        TextureStore store(1 << 20);
        if (is_shared) store.prepare(part);
        const Vec4f* const pixels = part.texture(old).pixels.data();
        const AddedScene added = scene.add(std::move(part), scene.root());
        ASSERT_EQ(added.textures.size(), 1u);
        const Texture& texture = scene.texture(added.textures[0]);
        EXPECT_NE(texture.identity, identity);
        EXPECT_EQ(texture.pixels.size(), 16u);
        EXPECT_EQ(texture.pixels.data() == pixels, !is_shared) << "they are moved unless a store holds them";
        if (!is_shared) continue;
        TextureUse use;
        use.texture = old;
        EXPECT_EQ(store.identity(use), identity);
        EXPECT_EQ(store.sample(use, Vec2f(0.5f), 0).x, 0.5f);
    }
}

}  // namespace
}  // namespace occam
