// Memory flush: the same heavy scene under smaller and smaller budgets. Every picture has to be the unbudgeted one, bit for
// bit.
//
//     occam_flush [WORMS A SIDE] [WIDTH HEIGHT]
//
// Exit code 1 if a picture differs.
#include <occam/occam.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "worm.h"

using namespace occam;

int main(int argc, char** argv)
try {
    const int side = argc > 1 ? std::atoi(argv[1]) : 24;
    const Settings settings{
        .width = argc > 3 ? std::atoi(argv[2]) : 640, .height = argc > 3 ? std::atoi(argv[3]) : 360, .spp = 4};

    Scene scene;
    const sample::Worm worm = sample::add_worm(scene, {0.8f, 0.7f, 0.3f});
    sample::add_surroundings(scene, float(3 * side));
    for (int i = 0; i < side * side; ++i) {
        Trs place;
        place.translation = {2.4 * (i % side - (side - 1) * 0.5), 0.5, 1.2 * (i / side - (side - 1) * 0.5)};
        const NodeId copy = scene.copy(worm.node, scene.root());
        scene.set_transform(copy, place);
        const ClipAt now{worm.crawl, std::fmod(0.37 * i, 1.0)};
        scene.pose({&now, 1}, copy);
    }
    scene.set_visible(worm.node, false);
    const Camera camera = Camera::look_at({1.2 * side, 0.9 * side, 1.5 * side}, {0, 0, 0}, {0, 1, 0}, 0.7f);

    const auto render = [&](std::size_t budget, FrameStats& stats) {
        Renderer renderer({.memory_bytes = budget});
        const std::uint64_t checksum = renderer.render(scene, camera, settings).checksum();
        stats = renderer.stats();
        return checksum;
    };
    FrameStats stats;
    const std::uint64_t wanted = render(std::size_t(1) << 40, stats);
    const double seconds = stats.seconds.total;
    const std::uint64_t peak = stats.memory.arena_peak_bytes;
    std::printf("%12s %10s %8s\n%12llu %9.2fx %8llu   unbudgeted, %.2f s\n", "bytes", "time", "flushes",
                static_cast<unsigned long long>(peak), 1.0, static_cast<unsigned long long>(stats.memory.flushes), seconds);
    bool is_same = true;
    // Below the floor a budget is refused.
    const std::uint64_t floor = Renderer().memory_floor(scene);
    for (std::uint64_t budget = peak / 2; budget > std::max(peak / 32, floor); budget /= 2) {
        const bool equal = render(budget, stats) == wanted;
        is_same &= equal;
        std::printf("%12llu %9.2fx %8llu%s\n", static_cast<unsigned long long>(budget), stats.seconds.total / seconds,
                    static_cast<unsigned long long>(stats.memory.flushes), equal ? "" : "   DIFFERS");
    }
    return is_same ? 0 : 1;
} catch (const Error& error) {
    std::fprintf(stderr, "occam_flush: %s\n", error.what());
    return 2;
}
