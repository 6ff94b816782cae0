// Memory flush: the same heavy scene is rendered under smaller and smaller budgets. Every picture has to equal the one
// without a budget, bit for bit.
//
//     occam_flush [WORMS A SIDE] [WIDTH HEIGHT]
//
// Writes flush.png. Exit code 1 if a picture differs.
#include <occam/occam.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "arguments.h"
#include "failure.h"
#include "worm.h"

using namespace occam;

int main(int argc, char** argv)
try {
    sample::Arguments arguments(argc, argv);
    if (arguments.wants_help("occam_flush [WORMS A SIDE] [WIDTH HEIGHT]")) return 0;
    const int side = arguments.number("WORMS A SIDE", 1, 1000, 24);
    Settings settings{.width = 640, .height = 360, .spp = 4};
    arguments.size(settings.width, settings.height);
    arguments.end();

    Scene scene;
    const sample::Worm worm = sample::add_worm(scene, {0.8f, 0.7f, 0.3f});
    sample::add_surroundings(scene, float(3 * side));
    for (int i = 0; i < side * side; ++i) {
        Trs place;
        place.translation = {2.4 * (i % side - (side - 1) * 0.5), 0.34, 1.2 * (i / side - (side - 1) * 0.5)};
        const NodeId copy = scene.copy(worm.node, scene.root());
        scene.set_transform(copy, place);
        const ClipAt now{worm.crawl, std::fmod(0.37 * i, 1.0)};
        scene.pose({&now, 1}, copy);
    }
    scene.set_visible(worm.node, false);
    const Camera camera = Camera::look_at({1.2 * side, 0.9 * side, 1.5 * side}, {0, 0, 0}, {0, 1, 0}, 0.7f);

    const auto render = [&](std::size_t memory_bytes, FrameStats& stats) {
        Renderer renderer({.memory_bytes = memory_bytes});
        Image image = renderer.render(scene, camera, settings);
        stats = renderer.stats();
        return image;
    };
    FrameStats stats;
    const Image unbudgeted = render(std::size_t(1) << 40, stats);
    unbudgeted.write("flush.png");
    const std::uint64_t wanted = unbudgeted.checksum();
    const double seconds = stats.seconds.total;
    const std::uint64_t peak = stats.memory.arena_peak_bytes;
    std::printf("%12s %10s %8s\n%12llu %9.2fx %8llu   unbudgeted, %.2f s\n", "bytes", "time", "flushes",
                static_cast<unsigned long long>(peak), 1.0, static_cast<unsigned long long>(stats.memory.flushes), seconds);
    bool is_same = true;
    // A budget below the minimum is refused.
    const std::uint64_t floor = Renderer().memory_floor(scene);
    for (std::uint64_t memory_bytes = peak / 2; memory_bytes > std::max(peak / 32, floor); memory_bytes /= 2) {
        const bool equal = render(memory_bytes, stats).checksum() == wanted;
        is_same &= equal;
        std::printf("%12llu %9.2fx %8llu%s\n", static_cast<unsigned long long>(memory_bytes), stats.seconds.total / seconds,
                    static_cast<unsigned long long>(stats.memory.flushes), equal ? "" : "   DIFFERS");
    }
    return is_same ? 0 : 1;
} catch (...) {
    return sample::exit_code_of_failure("occam_flush");
}
