// A scripted animation: worms crawl past each other while the camera circles them.
//
//     occam_animation [FOLDER] [FRAMES] [WIDTH HEIGHT]
#include <occam/occam.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "arguments.h"
#include "failure.h"
#include "worm.h"

using namespace occam;

int main(int argc, char** argv)
try {
    sample::Arguments arguments(argc, argv);
    if (arguments.wants_help("occam_animation [FOLDER] [FRAMES] [WIDTH HEIGHT]")) return 0;
    const std::filesystem::path folder = arguments.path("pictures");
    const int frames = arguments.number("FRAMES", 1, 9999, 96);
    Settings settings{.width = 640, .height = 360, .spp = 16};
    arguments.size(settings.width, settings.height);
    arguments.end();

    Scene scene;
    const sample::Worm worm = sample::add_worm(scene, {0.3f, 0.6f, 0.9f});
    sample::add_surroundings(scene, 12);
    std::vector<NodeId> worms;
    for (int i = 0; i < 5; ++i) worms.push_back(scene.copy(worm.node, scene.root()));
    scene.set_visible(worm.node, false);

    std::filesystem::create_directories(folder);
    Renderer renderer;  // keeps topology and textures from frame to frame
    for (int frame = 0; frame < frames; ++frame) {
        const double seconds = frame / 24.0;
        for (std::size_t i = 0; i < worms.size(); ++i) {
            const double way = i % 2 ? 1 : -1;
            Trs place;
            place.translation = {way * (seconds - 2), 0.34, 1.2 * (double(i) - 2)};
            scene.set_transform(worms[i], place);
            const ClipAt now{worm.crawl, looped({0, 1}, way * seconds + 0.2 * double(i))};
            scene.pose({&now, 1}, worms[i]);
        }
        const double angle = 0.3 + 0.15 * seconds;
        const Camera camera = Camera::look_at({7 * std::sin(angle), 3.5, 7 * std::cos(angle)}, {0, 0.3, 0}, {0, 1, 0}, 0.7f);
        const std::string number = std::to_string(10000 + frame).substr(1);
        renderer.render(scene, camera, settings).write(folder / ("worms." + number + ".png"), {.exposure_ev = 0});
        std::printf("frame %d: %.2f s\n", frame, renderer.stats().seconds.total);
    }
} catch (...) {
    return sample::exit_code_of_failure("occam_animation");
}
