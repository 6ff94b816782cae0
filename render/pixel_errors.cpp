#include "render/pixel_errors.h"

#include <algorithm>
#include <cmath>

namespace occam::render {

void errors_around(const PixelRect& tile, std::span<const Pixel> pixels, std::span<const PixelSums> sums,
                   std::span<float> errors)
{
    float squares[kTileSide][kTileSide] = {};
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        const float error = sums[i].relative_error();
        squares[pixels[i].y - tile.y0][pixels[i].x - tile.x0] = error * error;
    }
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        const int x = pixels[i].x - tile.x0, y = pixels[i].y - tile.y0;
        float sum = 0;
        int count = 0;
        for (int v = std::max(y - 1, 0); v < std::min(y + 2, tile.height()); ++v)
            for (int u = std::max(x - 1, 0); u < std::min(x + 2, tile.width()); ++u) {
                sum += squares[v][u];
                ++count;
            }
        errors[i] = std::sqrt(sum / static_cast<float>(count));
    }
}

}  // namespace occam::render
