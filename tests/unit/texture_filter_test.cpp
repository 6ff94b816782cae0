// A filter of a texture is as wide as it is asked to be: beside means of texels in double.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "io/texture/texture_store.h"
#include "scenegraph/scene.h"
#include "tests/support/statistics.h"

namespace occam {
namespace {

// A square image of one channel that repeats itself.
struct Grid {
    std::size_t size = 0;
    std::vector<double> values;

    double at(std::size_t x, std::size_t y) const { return values[y % size * size + x % size]; }
    // Returns an image whose values are means of two by two of these.
    Grid halved() const
    {
        Grid half{size / 2, {}};
        for (std::size_t y = 0; y < half.size; ++y)
            for (std::size_t x = 0; x < half.size; ++x)
                half.values.push_back(
                    (at(2 * x, 2 * y) + at(2 * x + 1, 2 * y) + at(2 * x, 2 * y + 1) + at(2 * x + 1, 2 * y + 1)) / 4);
        return half;
    }
    // Returns the value between the middles of four neighbours; u and v are from 0 to 1.
    double between(double u, double v) const
    {
        const double x = u * double(size) + double(size) - 0.5, y = v * double(size) + double(size) - 0.5;
        const auto left = static_cast<std::size_t>(x), top = static_cast<std::size_t>(y);
        const double right_share = x - double(left), low_share = y - double(top);
        return (at(left, top) * (1 - right_share) + at(left + 1, top) * right_share) * (1 - low_share) +
               (at(left, top + 1) * (1 - right_share) + at(left + 1, top + 1) * right_share) * low_share;
    }
};

// A filter of a power of two of texels takes means of as many; one between two powers lies between both, by its width.
// Levels are kept in half floats, which round values below 1 by up to 2^-12; the tolerance is twice that.
TEST(TextureFilters, AreAsWideAsTheyAreAskedToBe)
{
    test::Numbers numbers(3);
    std::vector<Grid> levels{{32, {}}};
    Texture texture;
    texture.width = texture.height = 32;
    texture.role = TextureRole::Data;
    for (int i = 0; i < 32 * 32; ++i) {
        levels[0].values.push_back(double(numbers.one()));
        texture.pixels.emplace_back(Vec3f(static_cast<float>(levels[0].values.back())), 1);
    }
    while (levels.back().size > 1) levels.push_back(levels.back().halved());
    Scene scene;
    TextureUse use;
    use.texture = scene.add(std::move(texture));
    TextureStore textures(std::size_t(1) << 24);
    textures.prepare(scene);
    double moved = 0;
    for (const double texels : {0.25, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0})
        for (int i = 0; i < 100; ++i) {
            const Vec2f uv = numbers.square();
            const auto finer = static_cast<std::size_t>(std::log2(std::max(texels, 1.0)));
            const double share = std::max(texels, 1.0) / std::exp2(double(finer)) - 1;
            const double u(uv.x), v(uv.y);
            const double wanted = levels[finer].between(u, v) * (1 - share) + levels[finer + 1].between(u, v) * share;
            EXPECT_NEAR(double(textures.sample(use, uv, static_cast<float>(texels / 32)).x), wanted, 5e-4)
                << texels << ' ' << uv.x << ' ' << uv.y;
            moved += std::fabs(wanted - levels[finer + 1].between(u, v)) / 800;
        }
    EXPECT_GT(moved, 0.03) << "a filter of twice the width gives other values";
}

}  // namespace
}  // namespace occam
