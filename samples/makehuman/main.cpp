// MakeHuman's body and its walk: three people of one mesh, each with a pose of its own, walk past the camera.
//
//     occam_makehuman DATA [FOLDER] [FRAMES] [WIDTH HEIGHT]
//
// DATA holds base.obj, default.mhskel, default_weights.mhw, walk1.bvh and targets/. Exit code 77 if it is not there.
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <new>

#include "arguments.h"
#include "failure.h"
#include "walk.h"
#include "worm.h"

using namespace occam;

int main(int argc, char** argv)
try {
    sample::Arguments arguments(argc, argv);
    if (arguments.wants_help("occam_makehuman DATA [FOLDER] [FRAMES] [WIDTH HEIGHT]")) return 0;
    const std::filesystem::path data = arguments.required_path("DATA"), folder = arguments.path("pictures");
    const int frames = arguments.number("FRAMES", 1, 9999, 48);
    Settings settings{.width = 640, .height = 360, .spp = 16};
    arguments.size(settings.width, settings.height);
    arguments.end();
    if (!std::filesystem::exists(data / "base.obj")) {
        std::fprintf(stderr, "occam_makehuman: skipped, since there is no base.obj in %s\n", data.string().c_str());
        return 77;
    }

    Scene scene;
    const sample::Body body = sample::add_body(scene, data, "male-young-averagemuscle-averageweight-maxheight.target",
                                               {0.15f, 0.25f, 0.45f});
    const sample::Walk walk = sample::add_walk(scene, body, data / "walk1.bvh");
    sample::add_surroundings(scene, 80);
    std::vector<NodeId> people;
    for (int i = 0; i < 3; ++i) people.push_back(scene.copy(body.node, scene.root()));
    scene.set_visible(body.node, false);

    std::filesystem::create_directories(folder);
    Renderer renderer;
    for (int frame = 0; frame < frames; ++frame) {
        for (std::size_t i = 0; i < people.size(); ++i) {
            const double seconds = frame / 24.0 + 0.2 * double(i);
            Trs place;
            place.translation = {9 * (double(i) - 1), -walk.floor,
                                 walk.way / walk.period * seconds - 14 - 6 * std::abs(double(i) - 1)};
            scene.set_transform(people[i], place);
            const ClipAt now{walk.clip, std::fmod(seconds, walk.period)};
            scene.pose({&now, 1}, people[i]);
        }
        const Camera camera = Camera::look_at({18, 13, 46}, {0, 10, -4}, {0, 1, 0}, 0.52f);
        const std::string number = std::to_string(10000 + frame).substr(1);
        renderer.render(scene, camera, settings).write(folder / ("people." + number + ".png"), {.exposure_ev = 0});
        std::printf("frame %d: %.2f s, %llu vertices deformed\n", frame, renderer.stats().seconds.total,
                    static_cast<unsigned long long>(renderer.stats().built.vertices_deformed));
    }
} catch (const Error&) {
    return sample::exit_code_of_failure("occam_makehuman");
} catch (const std::filesystem::filesystem_error&) {
    return sample::exit_code_of_failure("occam_makehuman");
} catch (const std::bad_alloc&) {
    return sample::exit_code_of_failure("occam_makehuman");
} catch (const std::exception& error) {
    std::fprintf(stderr, "occam_makehuman: the data is not as expected: %s\n", error.what());
    return 2;
}
