// Motion blur: a cart rolls along a fence, a wooden figure runs beside it, and the camera flies along with them.
//
//     occam_motion [FOLDER] [FRAMES] [WIDTH HEIGHT]
#include <occam/occam.h>

#include <cmath>
#include <cstdio>
#include <string>

#include "arguments.h"
#include "cart.h"
#include "failure.h"
#include "runner.h"
#include "shapes.h"

using namespace occam;

namespace {

constexpr double kSpeed = 9, kFramesPerSecond = 24;
constexpr Shutter kShutter{-0.25, 0.25};

// A fence, and stripes on the road: they stand still, and it is the camera that blurs them.
void add_roadside(Scene& scene)
{
    const auto paint = [&](Vec3f color) {
        Material material;
        material.base_color = Vec4f(color, 1);
        material.roughness = 0.7f;
        return scene.add(material);
    };
    const MaterialId colors[] = {paint({0.8f, 0.78f, 0.7f}), paint({0.55f, 0.2f, 0.12f}), paint({0.25f, 0.4f, 0.2f})};
    CageId posts[3];
    for (int k = 0; k < 3; ++k) posts[k] = scene.add(sample::rounded_box({0.22f, 1.7f, 0.12f}, colors[k]));
    const CageId board = scene.add(sample::rounded_box({4, 0.14f, 0.06f}, colors[1]));
    const CageId stripe = scene.add(sample::rounded_box({1.2f, 0.02f, 0.16f}, colors[0]));
    for (int k = -30; k < 90; ++k)
        scene.add_node(scene.root(), {.name = "post",
                                      .place = {.translation = {0.7 * k, 0.8 + 0.12 * ((k * 7) % 3), -3}},
                                      .cages = {posts[std::size_t((k + 30) * 5 % 3)]}});
    for (int k = -5; k < 16; ++k) {
        scene.add_node(scene.root(), {.name = "board", .place = {.translation = {4.0 * k, 1.1, -2.9}}, .cages = {board}});
        scene.add_node(scene.root(), {.name = "stripe", .place = {.translation = {2.5 * k, 0.01, 2.1}}, .cages = {stripe}});
    }
}

}  // namespace

int main(int argc, char** argv)
try {
    sample::Arguments arguments(argc, argv);
    if (arguments.wants_help("occam_motion [FOLDER] [FRAMES] [WIDTH HEIGHT]")) return 0;
    const std::filesystem::path folder = arguments.path("pictures");
    const int frames = arguments.number("FRAMES", 1, 9999, 48);
    Settings settings{.width = 960, .height = 540, .spp = 64};
    settings.shutter = kShutter;
    settings.clamp = 4;  // no fireflies from the polished rims
    arguments.size(settings.width, settings.height);
    arguments.end();

    Scene scene;
    sample::add_surroundings(scene, 60);
    add_roadside(scene);
    const sample::Cart cart(scene);
    const sample::Runner runner(scene);
    const NodeId camera = scene.add_node(scene.root(), {.name = "camera", .camera = scene.add(CameraLens{.fov = 0.55f})});

    std::filesystem::create_directories(folder);
    Renderer renderer;
    for (int frame = 0; frame < frames; ++frame) {
        // Whatever moves is posed here, at any moment: the engine asks for as many moments as the motion needs.
        const auto pose = [&](double tau) {
            const double seconds = (frame + kShutter.open + tau * kShutter.length()) / kFramesPerSecond;
            const double x = kSpeed * seconds;
            cart.pose(scene, x, 0, seconds);
            runner.pose(scene, x - 2.1, 0.5, 1.6 * seconds + 0.1);
            const double angle = 0.35 - 0.12 * seconds;
            const Vec3d target(x - 0.5, 0.9, 0.3);
            scene.set_transform(
                camera, Camera::look_at(target + Vec3d(7 * std::sin(angle), 0.9 + 0.2 * seconds, 7 * std::cos(angle)),
                                        target, {0, 1, 0}, 0.55f)
                            .world_from_camera);
        };
        const Camera view = record_shutter(
            scene, pose, [&] { return scene.camera("camera").value(); }, settings.height);
        const std::string number = std::to_string(10000 + frame).substr(1);
        renderer.render(scene, view, settings).write(folder / ("motion." + number + ".png"), {.exposure_ev = 0});
        std::printf("frame %d: %.2f s, %d shutter segments\n", frame, renderer.stats().seconds.total,
                    renderer.stats().motion.segments);
    }
} catch (...) {
    return sample::exit_code_of_failure("occam_motion");
}
