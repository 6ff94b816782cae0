// Renders a picture in twenty lines that use nothing but the installed headers.
#include <occam/occam.h>

#include <cstdio>

int main(int, char** argv)
try {
    occam::Scene scene = occam::load(argv[1]);
    const occam::Camera camera = scene.camera().value_or(occam::framing(scene, 64.0f / 48.0f));

    occam::Renderer renderer({.threads = 2});
    const occam::Image image = renderer.render(scene, camera, {.width = 64, .height = 48, .spp = 1});
    image.write(argv[2]);
    std::printf("%016llx\n", static_cast<unsigned long long>(image.checksum()));
} catch (const occam::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
