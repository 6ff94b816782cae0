// How the time of camera rays grows with the amount of motion blur and of defocus (Hou et al. 2010 find it almost flat).
//
// 16 x 16 tori move together while the shutter is open, by up to 190 pixels, or stand still behind a lens whose circles of
// confusion at the nearest and the farthest tori are up to 95 pixels wide. Rays have the places, moments and points of the
// lens that a frame of 16 samples has. Trees are built before; the ratio is over the first row.

#include <cmath>

#include "tests/bench/subjects.h"
#include "tests/bench/suites.h"

namespace occam::bench {
namespace {

constexpr int kRuns = 3, kWidth = 240, kHeight = 135, kSide = 16, kSamples = 16;
constexpr std::size_t kMemoryBytes = std::size_t(2) << 30;
constexpr double kDistance = 50;  // of the middle of the scene from the eye

struct Blur {
    const char* name;
    double pixels;     ///< moved while the shutter is open
    double confusion;  ///< pixels, at the nearest and the farthest tori
};
constexpr Blur kBlurs[] = {{"flat, still and sharp", 0, 0},
                           {"flat, 19 pixels of motion", 19, 0},
                           {"flat, 95 pixels of motion", 95, 0},
                           {"flat, 190 pixels of motion", 190, 0},
                           {"flat, defocus of 9.5", 0, 9.5},
                           {"flat, defocus of 95", 0, 95},
                           {"flat, both", 190, 95}};

Camera camera_of(const Blur& blur)
{
    Camera camera = Camera::look_at({0, 30, 40}, {0, 0, 0}, {0, 1, 0}, 0.7f);
    if (blur.confusion == 0) return camera;
    // At a quarter of the distance from the focus, a circle of confusion is a quarter of the lens's width, seen there.
    const double pixel = 2 * std::tan(0.35) * kDistance / kHeight;
    camera.lens.focus = static_cast<float>(kDistance);
    camera.lens.radius = static_cast<float>(0.5 * blur.confusion * pixel * 4);
    return camera;
}

void add_tori(Scene& scene, const Blur& blur)
{
    const CageId cage = scene.add(torus(12, 8));
    const NodeId all = scene.add_node(scene.root(), {});
    for (int k = 0; k < kSide * kSide; ++k) {
        NodeDesc desc;
        desc.place.translation = {3.0 * (k % kSide - kSide / 2), 0, 3.0 * (k / kSide - kSide / 2)};
        desc.cages = {cage};
        scene.add_node(all, std::move(desc));
    }
    if (blur.pixels > 0)
        scene.record_shutter(1, [&](double tau) {
            Trs moved;
            moved.translation = {(tau - 0.5) * blur.pixels * 2 * std::tan(0.35) * kDistance / kHeight, 0, 0};
            scene.set_transform(all, moved);
        });
    scene.refit();
}

// Traces rays up to the focus of a lens, and those that hit nothing from there on, as a frame does.
std::size_t trace(accel::Tracer& tracer, const render::CameraRays& camera, std::span<const accel::Ray> rays)
{
    std::vector<accel::SurfaceHit> hits(kBatch);
    std::vector<accel::Ray> behind;
    std::size_t met = 0;
    for (std::size_t i = 0; i < rays.size(); i += kBatch) {
        const std::span<const accel::Ray> batch = rays.subspan(i, std::min(kBatch, rays.size() - i));
        tracer.closest(batch, std::span(hits).first(batch.size()));
        behind.clear();
        for (std::size_t k = 0; k < batch.size(); ++k) {
            met += hits[k].is_hit();
            if (camera.ends_at_focus() && !hits[k].is_hit()) behind.push_back(camera.behind_focus(batch[k]));
        }
        tracer.closest(behind, std::span(hits).first(behind.size()));
        for (std::size_t k = 0; k < behind.size(); ++k) met += hits[k].is_hit();
    }
    return met;
}

}  // namespace

void run_motion_flat(Report& report)
{
    double sharp = 0;
    for (const Blur& blur : kBlurs) {
        if (!report.wants(blur.name)) continue;
        Scene scene;
        add_tori(scene, blur);
        const render::CameraRays camera(camera_of(blur), kWidth, kHeight, kSamples);
        const std::vector<accel::Ray> rays = rays_of_a_frame(camera, kWidth, kHeight, kSamples);
        lod::TopologyCache topologies;
        lod::LevelSettings levels = camera.levels(1);
        levels.strata = kSamples;
        const accel::Frame frame(scene, topologies, levels);
        accel::Tracer tracer(frame, kMemoryBytes);
        const double cold = repeat(1, [&] { trace(tracer, camera, rays); }).front();
        std::size_t met = 0;
        const std::vector<double> seconds = repeat(kRuns, [&] { met = trace(tracer, camera, rays); });
        Row row{"motion", blur.name};
        row.add("rays", double(rays.size())).add("hits", double(met));
        row.add("ns_a_ray", times(seconds, 1e9 / double(rays.size()))).add("cold_s", cold);
        if (sharp == 0) sharp = *std::min_element(seconds.begin(), seconds.end());
        row.add("over_first_row", times(seconds, 1 / sharp));
        report.add(row.add("mb", 1e-6 * double(tracer.counters().peak_bytes)));
    }
}

}  // namespace occam::bench
