#include "render/tiles.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <map>

namespace occam::render {
namespace {

TEST(Tiles, CoverEveryPixelOnce)
{
    for (const PixelRect area :
         {PixelRect{0, 0, 1, 1}, PixelRect{0, 0, 64, 64}, PixelRect{13, 7, 150, 61}, PixelRect{5, 5, 22, 300}}) {
        std::map<std::pair<int, int>, int> times;
        for (const PixelRect& t : make_tiles(area))
            for (int y = t.y0; y < t.y1; ++y)
                for (int x = t.x0; x < t.x1; ++x) ++times[{x, y}];
        EXPECT_EQ(times.size(), std::size_t(area.width() * area.height()));
        for (const auto& [pixel, n] : times) {
            EXPECT_EQ(n, 1);
            EXPECT_TRUE(pixel.first >= area.x0 && pixel.first < area.x1 && pixel.second >= area.y0 &&
                        pixel.second < area.y1);
        }
    }
}

TEST(Tiles, ListTheirPixelsInBlocksOfEight)
{
    for (const PixelRect tile :
         {PixelRect{0, 0, 1, 1}, PixelRect{32, 16, 48, 32}, PixelRect{3, 5, 14, 8}, PixelRect{7, 0, 8, 16}}) {
        std::map<std::pair<int, int>, int> times;
        for (const Pixel p : pixels_of(tile)) ++times[{p.x, p.y}];
        EXPECT_EQ(times.size(), std::size_t(tile.width() * tile.height()));
        for (const auto& [pixel, n] : times)
            EXPECT_TRUE(n == 1 && pixel.first >= tile.x0 && pixel.first < tile.x1 && pixel.second >= tile.y0 &&
                        pixel.second < tile.y1);
    }
    const std::vector<Pixel> whole = pixels_of({0, 0, kTileSide, kTileSide});
    for (std::size_t first = 0; first < whole.size(); first += 8)
        for (std::size_t i = first; i < first + 8; ++i) {
            EXPECT_EQ(whole[i].x / 4, whole[first].x / 4);
            EXPECT_EQ(whole[i].y / 2, whole[first].y / 2);
        }
}

TEST(Tiles, FollowACurveWithoutJumps)
{
    const auto tiles = make_tiles({0, 0, 8 * kTileSide, 8 * kTileSide});
    for (std::size_t i = 1; i < tiles.size(); ++i)
        EXPECT_EQ(std::abs(tiles[i].x0 - tiles[i - 1].x0) + std::abs(tiles[i].y0 - tiles[i - 1].y0), kTileSide) << i;
}

TEST(Tiles, AreGivenOutOnceWhoeverAsks)
{
    for (int workers : {1, 2, 7, 100}) {
        TileQueue queue(make_tiles({0, 0, 160, 96}), workers);
        std::map<std::pair<int, int>, int> times;
        std::size_t given = 0;
        // The first worker asks most often, and the last one never asks.
        for (int turn = 0; given < queue.size(); ++turn) {
            const int worker = turn % 3 == 0 && workers > 2 ? 1 : 0;
            const auto tile = queue.next(worker);
            ASSERT_TRUE(tile.has_value());
            ++times[{tile->x0, tile->y0}];
            ++given;
        }
        EXPECT_EQ(times.size(), queue.size());
        for (int w = 0; w < workers; ++w) EXPECT_FALSE(queue.next(w).has_value());
    }
}

}  // namespace
}  // namespace occam::render
